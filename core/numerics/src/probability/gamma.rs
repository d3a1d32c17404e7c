//! Regularised incomplete gamma function and its inverse.
//!
//! ```text
//! P(a, x) = 1/Gamma(a) integral of t^(a-1) e^-t, t = 0 .. x = x^a e^-x/Gamma(a + 1) (1 + x/(a+1) + x^2/((a+1)(a+2)) + ...)
//! Q(a, x) = 1 - P = x^a e^-x/Gamma(a) 1/(x + 1 - a - 1 (1-a)/(x + 3 - a - 2 (2-a)/(x + 5 - a - ...)))
//! ```
//! the series below x = a + 1, the fraction above. Source: Abramowitz and Stegun 6.5.29, 6.5.31.

use super::beta::other;
use super::root::{Tail, solve};
use super::saddle::ln_poisson;

const ROUNDS: u32 = 1_000_000;

/// ln P, ln Q.
fn ln_tails(a: f64, x: f64) -> (f64, f64) {
    let scale = ln_poisson(a, x);
    if x < a + 1.0 {
        let (mut sum, mut term) = (1.0, 1.0);
        for round in 1..ROUNDS {
            term *= x / (a + f64::from(round));
            sum += term;
            if term <= f64::EPSILON * 0.25 * sum {
                break;
            }
        }
        let ln = scale + libm::log(sum);
        (ln, other(ln))
    } else {
        const TINY: f64 = 1e-300;
        let kept = |value: f64| if value.abs() < TINY { TINY } else { value };
        let mut b = x + 1.0 - a;
        let mut c = 1.0 / TINY;
        let mut d = 1.0 / kept(b);
        let mut result = d;
        for round in 1..ROUNDS {
            let m = f64::from(round);
            let numerator = m * (a - m);
            b += 2.0;
            d = 1.0 / kept(numerator * d + b);
            c = kept(b + numerator / c);
            let change = d * c;
            result *= change;
            if (change - 1.0).abs() <= f64::EPSILON {
                break;
            }
        }
        let ln = scale + libm::log(a) + libm::log(result);
        (other(ln), ln)
    }
}

/// P(a, x) and Q(a, x), for a > 0.
#[must_use]
pub fn gamma_tails(a: f64, x: f64) -> (f64, f64) {
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    let (lower, upper) = ln_tails(a, x);
    (libm::exp(lower), libm::exp(upper))
}

/// The x with P(a, x) = p, from p and q = 1 - p.
#[must_use]
pub fn gamma_quantile(a: f64, p: f64, q: f64) -> f64 {
    if p <= 0.0 || q <= 0.0 {
        return if p <= 0.0 { 0.0 } else { f64::INFINITY };
    }
    // x^a/Gamma(a + 1) = p, as x goes to 0
    let first = (libm::log(p) + libm::lgamma(a + 1.0)) / a;
    let top = libm::log(a + 50.0) + 10.0;
    let t = solve(Tail::smaller(p, q), first, top, |t| {
        let x = libm::exp(t);
        let (lower, upper) = ln_tails(a, x);
        (lower, upper, ln_poisson(a, x) + libm::log(a))
    });
    libm::exp(t)
}
