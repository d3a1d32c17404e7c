//! Exact limits of a probability and of a quantile from independent samples of any distribution.
//!
//! ```text
//! Clopper-Pearson   lower: I_p(k, n - k + 1) = alpha (0 for k = 0),  upper: 1 - I_p(k + 1, n - k) = alpha (1 for k = n)
//! order statistics  P(x_(j) <= x_u) = P(at least j of n below) = I_u(j, n - j + 1):  of the u-quantile
//! order statistics  P(x_(j) <= x_u) = P(at least j of n below) = I_u(j, n - j + 1):  for the u-quantile
//! DKW               |F_n - F| <= sqrt(ln(2/alpha)/(2 n)) everywhere (P. Massart 1990)
//! ```
//! Sources: C. J. Clopper, E. S. Pearson (1934); S. S. Wilks (1941); W. J. Conover, "Practical nonparametric statistics".
//! Verified by the tests of `tests/uncertainty/limits.rs`.

use bladeoff_numerics::probability::{beta_quantile, beta_tails};

/// Lower confidence limit, at level 1 - alpha, of a probability with k events in n points.
#[must_use]
pub fn lower_limit(k: u64, n: u64, alpha: f64) -> f64 {
    if k == 0 {
        return 0.0;
    }
    beta_quantile(k as f64, (n - k + 1) as f64, alpha, 1.0 - alpha).0
}

/// Upper confidence limit, at level 1 - alpha, of a probability with k events in n points.
#[must_use]
pub fn upper_limit(k: u64, n: u64, alpha: f64) -> f64 {
    if k >= n {
        return 1.0;
    }
    if k == 0 {
        // 1 - alpha^(1/n)
        return -libm::expm1(libm::log(alpha) / n as f64);
    }
    beta_quantile((k + 1) as f64, (n - k) as f64, 1.0 - alpha, alpha).0
}

/// Rank (from 1) of the largest order statistic that is a lower limit of the u-quantile at level 1 - alpha; `None` if no order statistic is.
#[must_use]
pub fn lower_order(u: f64, n: u64, alpha: f64) -> Option<u64> {
    // P(x_(j) > x_u) = P(fewer than j of n below) = 1 - I_u(j, n - j + 1), which grows with j
    let (mut low, mut high) = (0, n + 1);
    while high - low > 1 {
        let j = low + (high - low) / 2;
        if beta_tails(j as f64, (n - j + 1) as f64, u).1 <= alpha { low = j } else { high = j }
    }
    (low > 0).then_some(low)
}

/// Rank of the smallest order statistic that is an upper limit of the u-quantile at level 1 - alpha; `None` if no order statistic is.
#[must_use]
pub fn upper_order(u: f64, n: u64, alpha: f64) -> Option<u64> {
    lower_order(1.0 - u, n, alpha).map(|j| n + 1 - j)
}

/// Number of samples whose largest value is an upper limit of a quantile at level 1 - alpha; `beyond`: probability of a sample beyond the quantile.
/// Above 2^53 the nearest representable number.
#[must_use]
pub fn wilks(beyond: f64, alpha: f64) -> f64 {
    // log1p(-beyond) keeps small probabilities, which ln(1 - beyond) would lose
    let (all, each) = (libm::log(alpha), libm::log1p(-beyond));
    let n = libm::ceil(all / each).max(1.0);
    // corrects the rounding of the quotient
    if n > 1.0 && (n - 1.0) * each <= all { n - 1.0 } else { n }
}

/// Half width of the band of Dvoretzky, Kiefer and Wolfowitz.
#[must_use]
pub fn band(n: u64, alpha: f64) -> f64 {
    libm::sqrt(libm::log(2.0 / alpha) / (2.0 * n as f64)).min(1.0)
}
