//! A distribution with a density, truncated or not.
//!
//! ```text
//! truncated to lower .. upper:  P = F(lower) + p Z,  Q = (1 - F(upper)) + q Z,  Z = F(upper) - F(lower),  p + q = 1
//! ```
//! Both sums have positive terms only; Z is computed in the tail where both of its terms are small.

use super::law::Law;
use super::panels;
use bladeoff_numerics::probability::normal_tails;

/// A continuous distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Continuous {
    law: Law,
    lower: Option<f64>,
    upper: Option<f64>,
    /// F(lower), 1 - F(upper), and Z between them.
    cut_below: f64,
    cut_above: f64,
    left: f64,
    said: String,
}

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;
/// Smallest probability that truncation may leave: below, a tail loses digits.
const LEAST_LEFT: f64 = 1e-290;

impl Continuous {
    /// A truncated distribution; `said` has its name and keys in words. `Err`: the remaining probability, if it is too small.
    pub(super) fn new(law: Law, lower: Option<f64>, upper: Option<f64>, said: String) -> Result<Self, f64> {
        let left = between(&law, lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY));
        // comparisons with NaN are false
        if left >= LEAST_LEFT {
            let cut_below = lower.map_or(0.0, |lower| law.tails(lower).0);
            let cut_above = upper.map_or(0.0, |upper| law.tails(upper).1);
            Ok(Self { law, lower, upper, cut_below, cut_above, left, said })
        } else {
            Err(left)
        }
    }

    /// The distribution before truncation.
    pub(super) fn law(&self) -> &Law {
        &self.law
    }

    /// Limits of the truncation.
    pub(super) fn cut(&self) -> [Option<f64>; 2] {
        [self.lower, self.upper]
    }

    /// Name and keys in words.
    pub(super) fn said(&self) -> &str {
        &self.said
    }

    pub(super) fn quantile(&self, p: f64, q: f64) -> f64 {
        // far in a tail, the remainder of p or q may underflow, which is not the end of the distribution
        let part = |cut: f64, part: f64| if part > 0.0 { (cut + part * self.left).max(f64::MIN_POSITIVE) } else { cut };
        let x = self.law.quantile(part(self.cut_below, p), part(self.cut_above, q));
        x.clamp(self.lower.unwrap_or(f64::NEG_INFINITY), self.upper.unwrap_or(f64::INFINITY))
    }

    /// Mean and standard deviation after truncation; a mean within rounding errors of 0 is 0.
    pub(super) fn moments(&self) -> (f64, f64) {
        if self.lower.is_none()
            && self.upper.is_none()
            && let Some(exact) = exact_moments(&self.law)
        {
            return exact;
        }
        let (mean, sd) = panels::moments(|z| {
            let (p, q) = normal_tails(z);
            self.quantile(p, q)
        });
        (if mean.abs() < 1e-12 * sd { 0.0 } else { mean }, sd)
    }

    /// P(x < value).
    pub(super) fn below(&self, value: f64) -> f64 {
        let lower = self.lower.unwrap_or(f64::NEG_INFINITY);
        if value <= lower { 0.0 } else { (between(&self.law, lower, value) / self.left).min(1.0) }
    }

    /// P(x > value).
    pub(super) fn above(&self, value: f64) -> f64 {
        let upper = self.upper.unwrap_or(f64::INFINITY);
        if value >= upper { 0.0 } else { (between(&self.law, value, upper) / self.left).min(1.0) }
    }

    /// The probability at which the second derivative of the quantile function jumps.
    pub(super) fn kink(&self) -> Option<f64> {
        let Law::Triangular(from, mode, to) = self.law else { return None };
        (from < mode && mode < to).then(|| (mode - from) / (to - from))
    }
}

/// Mean and standard deviation in closed form, if that loses no digits; quadrature would fail for a distribution that is almost two values
/// (beta with small a, b).
fn exact_moments(law: &Law) -> Option<(f64, f64)> {
    Some(match *law {
        Law::Normal(mean, sd) => (mean, sd),
        Law::LogNormal(mu, sigma) => {
            let mean = libm::exp(mu + 0.5 * sigma * sigma);
            (mean, mean * libm::sqrt(libm::expm1(sigma * sigma)))
        }
        Law::Uniform(from, to) => (0.5 * from + 0.5 * to, (to - from) / libm::sqrt(12.0)),
        Law::Triangular(from, mode, to) => {
            let (left, right) = (mode - from, to - mode);
            (mode + (right - left) / 3.0, libm::sqrt((left * left + left * right + right * right) / 18.0))
        }
        Law::Beta(beta, from, to) => {
            let (a, b) = beta.parameters();
            let n = a + b;
            (from + (to - from) * a / n, (to - from) / n * libm::sqrt(a * b / (n + 1.0)))
        }
        Law::Gamma(shape, scale) => (shape * scale, libm::sqrt(shape) * scale),
        Law::Exponential(mean) => (mean, mean),
        Law::Gumbel(location, scale) => (location + EULER * scale, core::f64::consts::PI / libm::sqrt(6.0) * scale),
        _ => return None,
    })
}

/// P(from < x < to), computed in the tail where both ends are small.
fn between(law: &Law, from: f64, to: f64) -> f64 {
    let tails = |x: f64| match x {
        f64::NEG_INFINITY => (0.0, 1.0),
        f64::INFINITY => (1.0, 0.0),
        x => law.tails(x),
    };
    let ((p0, q0), (p1, q1)) = (tails(from), tails(to));
    let part = if p1 <= 0.5 {
        p1 - p0
    } else if q0 <= 0.5 {
        q0 - q1
    } else {
        1.0 - p0 - q1
    };
    part.max(0.0)
}
