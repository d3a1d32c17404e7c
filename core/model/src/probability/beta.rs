//! Regularised incomplete beta function and its inverse.
//!
//! ```text
//! I_x(a, b) = 1/B(a, b) integral of t^(a-1) (1-t)^(b-1), t = 0 .. x
//!           = x^a y^b/(a B(a, b)) 1/(1 + d1/(1 + d2/(1 + ...))),  y = 1 - x,  x < (a + 1)/(a + b + 2)
//! d_2m      = m (b - m) x/((a + 2m - 1)(a + 2m)),  d_2m+1 = -(a + m)(a + b + m) x/((a + 2m)(a + 2m + 1))
//! ```
//! Source: Abramowitz and Stegun 26.5.8. Both tails are carried, so that neither loses digits.

use super::root::{Tail, solve};
use super::saddle::ln_binomial;

/// The fraction settles in about `sqrt(a + b)` rounds.
const ROUNDS: u32 = 1_000_000;

/// ln I_x(a, b), from x and y = 1 - x, and ln of its complement: whichever was computed, the other from it.
fn ln_tails(a: f64, b: f64, x: f64, y: f64) -> (f64, f64) {
    let scale = ln_binomial(a, b, x, y);
    if x < (a + 1.0) / (a + b + 2.0) {
        let ln = scale - libm::log(a) + libm::log(fraction(a, b, x));
        (ln, other(ln))
    } else {
        let ln = scale - libm::log(b) + libm::log(fraction(b, a, y));
        (other(ln), ln)
    }
}

/// ln(1 - e^ln).
pub(super) fn other(ln: f64) -> f64 {
    if ln > -core::f64::consts::LN_2 { libm::log(-libm::expm1(ln)) } else { libm::log1p(-libm::exp(ln)) }
}

fn fraction(a: f64, b: f64, x: f64) -> f64 {
    // Lentz's method as changed by Thompson and Barnett
    const TINY: f64 = 1e-300;
    let kept = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / kept(1.0 - (a + b) * x / (a + 1.0));
    let mut result = d;
    for round in 1..ROUNDS {
        let m = f64::from(round);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / kept(1.0 + even * d);
        c = kept(1.0 + even / c);
        result *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / kept(1.0 + odd * d);
        c = kept(1.0 + odd / c);
        let change = d * c;
        result *= change;
        if (change - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    result
}

/// I_x(a, b), a, b > 0, and its complement.
#[must_use]
pub fn beta_tails(a: f64, b: f64, x: f64) -> (f64, f64) {
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    if x >= 1.0 {
        return (1.0, 0.0);
    }
    let (lower, upper) = ln_tails(a, b, x, 1.0 - x);
    (libm::exp(lower), libm::exp(upper))
}

/// The x with I_x(a, b) = p, and 1 - x, from p and q = 1 - p.
#[must_use]
pub fn beta_quantile(a: f64, b: f64, p: f64, q: f64) -> (f64, f64) {
    if p <= 0.0 || q <= 0.0 {
        return if p <= 0.0 { (0.0, 1.0) } else { (1.0, 0.0) };
    }
    let (half, _) = ln_tails(a, b, 0.5, 0.5);
    if libm::log(p) > half {
        let (y, x) = lower_half(b, a, q, p);
        return (x, y);
    }
    lower_half(a, b, p, q)
}

/// The same where x is at most 1/2, by ln x.
fn lower_half(a: f64, b: f64, p: f64, q: f64) -> (f64, f64) {
    let tail = Tail::smaller(p, q);
    // x^a/(a B) = p, as x goes to 0: B from (4) of the saddle point at x = 1/2
    let ln_beta = -core::f64::consts::LN_2 * (a + b) - ln_binomial(a, b, 0.5, 0.5);
    let first = (libm::log(p) + libm::log(a) + ln_beta) / a;
    let top = -core::f64::consts::LN_2;
    let t = solve(tail, first, top, |t| {
        let x = libm::exp(t);
        let y = -libm::expm1(t);
        let (lower, upper) = ln_tails(a, b, x, y);
        // x times the density
        (lower, upper, ln_binomial(a, b, x, y) - libm::log(y))
    });
    let x = libm::exp(t);
    (x, 1.0 - x)
}
