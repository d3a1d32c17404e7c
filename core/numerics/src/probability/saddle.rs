//! Terms of the gamma and beta densities without cancellation, however large their parameters are.
//!
//! ```text
//! delta(a) = ln Gamma(a + 1) - (a + 1/2) ln a + a - ln sqrt(2 pi)                      (1)
//! D(x, m)  = x ln(x/m) + m - x >= 0                                                    (2)
//! x^a e^-x / Gamma(a + 1)           = exp(-delta(a) - D(a, x)) / sqrt(2 pi a)           (3)
//! x^a y^b / B(a, b), x + y = 1      = sqrt(a b n/(2 pi)) / n exp(delta(n) - delta(a) - delta(b) - D(a, n x) - D(b, n y)),
//!                                     n = a + b                                         (4)
//! ```
//! With logarithms of the gamma function, the relative error of (4) would be 1e-9 at n = 1e6.
//! Source: C. Loader, "Fast and accurate computation of binomial probabilities" (2000). Verified by the quantiles in `tests.rs`.

/// ln sqrt(2 pi).
const LN_ROOT_TWO_PI: f64 = 0.918_938_533_204_672_8;
/// Smallest a for which the series of (1) is exact to rounding.
const LARGE: f64 = 16.0;

/// (1) for a > 0: the remainder of Stirling's formula.
fn stirling_rest(a: f64) -> f64 {
    if a < LARGE {
        // the error of the logarithms of the gamma function is below 1e-14 here
        return libm::lgamma(a + 1.0) - (a + 0.5) * libm::log(a) + a - LN_ROOT_TWO_PI;
    }
    let square = a * a;
    let series = [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0, -691.0 / 360_360.0, 1.0 / 156.0];
    series.iter().rev().fold(0.0, |sum, term| sum / square + term) / a
}

/// (2) for x > 0, m > 0: the distance of x from its mean.
fn deviance(x: f64, mean: f64) -> f64 {
    let difference = x - mean;
    if difference.abs() < 0.1 * (x + mean) {
        // x ln((1 + v)/(1 - v)) with v = (x - m)/(x + m)
        let v = difference / (x + mean);
        let mut sum = difference * v;
        let mut term = 2.0 * x * v;
        for j in 1..1000 {
            term *= v * v;
            let next = sum + term / f64::from(2 * j + 1);
            if next == sum {
                return sum;
            }
            sum = next;
        }
    }
    x * libm::log(x / mean) + mean - x
}

/// Logarithm of (3).
pub(super) fn ln_poisson(a: f64, x: f64) -> f64 {
    -stirling_rest(a) - deviance(a, x) - LN_ROOT_TWO_PI - 0.5 * libm::log(a)
}

/// Density (4) for fixed a and b; the terms without x are computed once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Binomial {
    a: f64,
    b: f64,
    rest: f64,
    scale: f64,
}

impl Binomial {
    /// The terms for parameters above 0.
    pub(super) fn new(a: f64, b: f64) -> Self {
        let n = a + b;
        let rest = stirling_rest(n) - stirling_rest(a) - stirling_rest(b);
        Self { a, b, rest, scale: 0.5 * (libm::log(a / n) + libm::log(b)) }
    }

    /// Logarithm of (4), from x and y = 1 - x.
    pub(super) fn ln(&self, x: f64, y: f64) -> f64 {
        let n = self.a + self.b;
        self.rest - deviance(self.a, n * x) - deviance(self.b, n * y) - LN_ROOT_TWO_PI + self.scale
    }
}
