//! The standard normal distribution and its inverse, on the error function of `libm`.

use core::f64::consts::{FRAC_1_SQRT_2, LN_2, PI, SQRT_2};

/// Phi(x) and 1 - Phi(x).
#[must_use]
pub fn normal_tails(x: f64) -> (f64, f64) {
    (0.5 * libm::erfc(-x * FRAC_1_SQRT_2), 0.5 * libm::erfc(x * FRAC_1_SQRT_2))
}

/// The x with Phi(x) = p, from p and q = 1 - p.
#[must_use]
pub fn normal_quantile(p: f64, q: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if q <= 0.0 {
        return f64::INFINITY;
    }
    let smaller = p.min(q);
    let magnitude = if smaller > 0.25 { middle(if p <= q { 0.5 - p } else { 0.5 - q }) } else { tail(smaller) };
    if p <= q { -magnitude } else { magnitude }
}

/// `erf(x/sqrt 2) = 2 d`, 0 <= d <= 1/4: relative to d, so that x keeps its digits next to 0.
fn middle(d: f64) -> f64 {
    let mut x = d * libm::sqrt(2.0 * PI);
    for _ in 0..20 {
        let error = 0.5 * libm::erf(x * FRAC_1_SQRT_2) - d;
        let step = error * libm::sqrt(2.0 * PI) * libm::exp(0.5 * x * x);
        x -= step;
        if step.abs() <= 1e-16 * x {
            break;
        }
    }
    x
}

/// `1 - Phi(x) = p`, p <= 1/4, by Newton's method on the logarithm, which is concave.
fn tail(p: f64) -> f64 {
    let ln = libm::log(p);
    // x^2/2 + ln x + ln sqrt(2 pi) = -ln p
    let mut x = libm::sqrt((-2.0 * (ln + LN_2)).max(0.2));
    for _ in 0..50 {
        let upper = 0.5 * libm::erfc(x * FRAC_1_SQRT_2);
        let slope = libm::exp(-0.5 * x * x) / (SQRT_2 * libm::sqrt(PI)) / upper;
        let step = (libm::log(upper) - ln) / slope;
        x += step;
        if step.abs() <= 1e-16 * x {
            break;
        }
    }
    x
}
