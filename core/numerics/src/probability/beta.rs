//! Regularised incomplete beta function and its inverse.
//!
//! ```text
//! I_x(a, b) = 1/B(a, b) integral of t^(a-1) (1-t)^(b-1), t = 0 .. x
//!           = x^a y^b/(a B(a, b)) 1/(1 + d1/(1 + d2/(1 + ...))),  y = 1 - x,  x < (a + 1)/(a + b + 2)
//! d_2m      = m (b - m) x/((a + 2m - 1)(a + 2m)),  d_2m+1 = -(a + m)(a + b + m) x/((a + 2m)(a + 2m + 1))
//! ```
//! Source: Abramowitz and Stegun 26.5.8. Both tails are carried, so that neither loses digits.

use super::root::{Tail, solve};
use super::saddle::Binomial;

/// Most rounds of the continued fraction, which converges in about `sqrt(a + b)`.
const ROUNDS: u32 = 1_000_000;

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
    let (lower, upper, _) = Side::new(a, b).ln_tails(x, 1.0 - x);
    (libm::exp(lower), libm::exp(upper))
}

/// The x with I_x(a, b) = p, and 1 - x, from p and q = 1 - p.
#[must_use]
pub fn beta_quantile(a: f64, b: f64, p: f64, q: f64) -> (f64, f64) {
    Beta::new(a, b).quantile(p, q)
}

/// A beta distribution on 0 .. 1, with the terms of its quantiles that depend on a and b alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beta {
    lower: Side,
    upper: Side,
    /// ln I_x(a, b) at x = 1/2.
    half: f64,
}

impl Beta {
    /// A distribution with parameters above 0.
    #[must_use]
    pub fn new(a: f64, b: f64) -> Self {
        let lower = Side::new(a, b);
        Self { lower, upper: Side::new(b, a), half: lower.ln_tails(0.5, 0.5).0 }
    }

    /// Parameters a and b.
    #[must_use]
    pub fn parameters(&self) -> (f64, f64) {
        (self.lower.a, self.lower.b)
    }

    /// The x with I_x(a, b) = p, and 1 - x, from p and q = 1 - p.
    #[must_use]
    pub fn quantile(&self, p: f64, q: f64) -> (f64, f64) {
        if p <= 0.0 || q <= 0.0 {
            return if p <= 0.0 { (0.0, 1.0) } else { (1.0, 0.0) };
        }
        if libm::log(p) > self.half {
            let (y, x) = self.upper.lower_half(q, p);
            return (x, y);
        }
        self.lower.lower_half(p, q)
    }
}

/// Terms of the distribution for one of its tails.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    a: f64,
    b: f64,
    binomial: Binomial,
    ln_beta: f64,
}

impl Side {
    fn new(a: f64, b: f64) -> Self {
        let binomial = Binomial::new(a, b);
        // B from (4) of the saddle point at x = 1/2
        let ln_beta = -core::f64::consts::LN_2 * (a + b) - binomial.ln(0.5, 0.5);
        Self { a, b, binomial, ln_beta }
    }

    /// ln I_x(a, b) from x and y = 1 - x, ln of its complement (one is computed, the other follows from it), and ln of (4).
    fn ln_tails(&self, x: f64, y: f64) -> (f64, f64, f64) {
        let (a, b) = (self.a, self.b);
        let scale = self.binomial.ln(x, y);
        if x < (a + 1.0) / (a + b + 2.0) {
            let ln = scale - libm::log(a) + libm::log(fraction(a, b, x));
            (ln, other(ln), scale)
        } else {
            let ln = scale - libm::log(b) + libm::log(fraction(b, a, y));
            (other(ln), ln, scale)
        }
    }

    /// The quantile for x of at most 1/2, solved in ln x.
    fn lower_half(&self, p: f64, q: f64) -> (f64, f64) {
        let tail = Tail::smaller(p, q);
        // x^a/(a B) = p, as x goes to 0
        let first = (libm::log(p) + libm::log(self.a) + self.ln_beta) / self.a;
        let top = -core::f64::consts::LN_2;
        let t = solve(tail, first, top, |t| {
            let x = libm::exp(t);
            let y = -libm::expm1(t);
            let (lower, upper, scale) = self.ln_tails(x, y);
            // x times the density
            (lower, upper, scale - libm::log(y))
        });
        let x = libm::exp(t);
        (x, 1.0 - x)
    }
}
