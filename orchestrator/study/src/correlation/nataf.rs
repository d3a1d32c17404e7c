//! The correlation of normal numbers that gives two parameters a required linear correlation.
//!
//! ```text
//! rho(r) = Corr(x1(z1), x2(z2)) = sum of a_k b_k r^k;  rho'(r) = E[x1'(z1) x2'(z2)]/(sd1 sd2) > 0:  one r for each rho
//! ```
//! Source: A. Nataf (1962); P.-L. Liu, A. Der Kiureghian, "Multivariate distribution models with prescribed marginals and
//! covariances" (1986). Their fitted formulas are off by up to a few per cent; here the series is summed (hermite.rs).

use super::hermite::{Expansion, Series};
use crate::uncertain::Uncertain;

/// Largest error of the linear correlation that is reached.
pub const ACCURACY: f64 = 1e-8;
/// Largest r: closer to 1, the two parameters would be dependent.
const LARGEST: f64 = 1.0 - 1e-9;
const ROUNDS: usize = 200;

/// Expansions of parameters, each computed on first use.
pub(super) struct Nataf<'a> {
    laws: &'a [Uncertain],
    expansions: Vec<Option<Option<Expansion>>>,
}

/// Reason for an impossible correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Refused {
    /// Outside the range of the distributions.
    Unreachable { low: f64, high: f64 },
    /// The accuracy was not reached.
    Unresolved { bound: f64, reason: &'static str },
}

impl<'a> Nataf<'a> {
    pub fn new(laws: &'a [Uncertain]) -> Self {
        Self { laws, expansions: vec![None; laws.len()] }
    }

    fn series(&mut self, a: usize, b: usize) -> Option<Series> {
        for i in [a, b] {
            if self.expansions[i].is_none() {
                self.expansions[i] = Some(Expansion::new(&self.laws[i]));
            }
        }
        let of =
            |i: usize| self.expansions[i].as_ref().and_then(|made| made.as_ref()).map(|made| (&self.laws[i], made));
        Some(Series::new(of(a)?, of(b)?))
    }

    /// Correlation r of the normal numbers of two different continuous parameters for the linear correlation `rho`.
    pub fn normal(&mut self, a: usize, b: usize, rho: f64) -> Result<f64, Refused> {
        let heavy = Refused::Unresolved {
            bound: f64::INFINITY,
            reason: "the tails of a distribution are too heavy, or it is nearly a step",
        };
        let Some(series) = self.series(a, b) else { return Err(heavy) };
        let [low, high] = series.ends();
        if rho <= low || rho >= high {
            return Err(Refused::Unreachable { low, high });
        }
        let r = solve(&series, rho);
        let (reached, bound) = series.at(r);
        let error = bound + (reached - rho).abs();
        if r.abs() > LARGEST || error > ACCURACY {
            let reason = "a distribution has corners, and the correlation is almost the largest possible";
            return Err(Refused::Unresolved { bound: error, reason });
        }
        Ok(r)
    }

    /// The linear correlation of two parameters whose normal numbers have the correlation r; NaN if it cannot be computed.
    pub fn linear(&mut self, a: usize, b: usize, r: f64) -> f64 {
        self.series(a, b).map_or(f64::NAN, |series| series.at(r).0)
    }
}

/// Solves for the r of a rho between the ends by the Illinois variant of the method of false position, within a bracket.
fn solve(series: &Series, rho: f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    let (mut at_low, mut at_high) = (series.ends()[0] - rho, series.ends()[1] - rho);
    let mut last_was_low = None;
    let mut r = 0.0;
    for round in 0..ROUNDS {
        // a bisection in every fourth round, so that the bracket always shrinks
        r = if round % 4 == 3 { 0.5 * (low + high) } else { (low * at_high - high * at_low) / (at_high - at_low) };
        if !(r > low && r < high) {
            r = 0.5 * (low + high);
        }
        let error = series.at(r).0 - rho;
        if error == 0.0 || high - low < 1e-15 {
            return r;
        }
        if error < 0.0 {
            (low, at_low) = (r, error);
            at_high *= if last_was_low == Some(true) { 0.5 } else { 1.0 };
            last_was_low = Some(true);
        } else {
            (high, at_high) = (r, error);
            at_low *= if last_was_low == Some(false) { 0.5 } else { 1.0 };
            last_was_low = Some(false);
        }
    }
    r
}
