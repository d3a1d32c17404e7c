//! Verification on the user's machine: reference cases from outside, recomputed, ours beside theirs.
//!
//! Every reference number comes from the literature, a closed form or another program, never from this one. The cases go
//! through the machine format and the same code as any run. The full ladder is in `core/tests`; this is its summary that
//! ships with the program: `bladeoff verify`.

mod jeffcott;
mod linear;
mod ring;
mod rub;

use crate::engine::simulate;
use crate::record::{Follower, Frame};
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef};

/// One number of a reference case.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// The case.
    pub case: &'static str,
    /// What is compared.
    pub quantity: String,
    /// Computed here; `None` if the case could not be computed.
    pub ours: Option<f64>,
    /// Reference.
    pub reference: f64,
    /// Largest relative difference that the source supports.
    pub tolerance: f64,
    /// Unit of both, "" for a pure number.
    pub unit: &'static str,
    /// Where the reference comes from.
    pub source: &'static str,
}

impl Check {
    /// Relative difference; `None` if there is no number to compare.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        let ours = self.ours.filter(|value| value.is_finite())?;
        Some((ours - self.reference).abs() / self.reference.abs())
    }

    /// Whether ours agrees with the reference.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.error().is_some_and(|error| error <= self.tolerance)
    }
}

/// Recomputes every reference case; well under a minute on one core.
#[must_use]
pub fn verify() -> Vec<Check> {
    let mut checks = Vec::new();
    linear::add(&mut checks);
    ring::add(&mut checks);
    jeffcott::add(&mut checks);
    rub::add(&mut checks);
    checks
}

/// Name, unit, source and tolerance that the numbers of one case share.
#[derive(Debug, Clone, Copy)]
struct Case {
    name: &'static str,
    unit: &'static str,
    source: &'static str,
    tolerance: f64,
}

impl Case {
    /// Adds one number.
    fn check(&self, checks: &mut Vec<Check>, quantity: impl Into<String>, ours: Option<f64>, reference: f64) {
        let Case { name: case, unit, source, tolerance } = *self;
        checks.push(Check { case, quantity: quantity.into(), ours, reference, tolerance, unit, source });
    }
}

/// The machine of a reference case; `None` only if the format no longer reads it.
fn machine(text: &str) -> Option<Machine> {
    MachineDef::parse("reference case", text).ok()?.build().ok()
}

/// Runs a machine and shows each instant to a closure; `None` if it cannot be run.
fn watch(text: &str, see: impl FnMut(&Frame<'_>)) -> Option<()> {
    struct Watch<F>(F);
    impl<F: FnMut(&Frame<'_>)> Follower for Watch<F> {
        fn wants(&mut self, _step: u64, _time: f64) -> bool {
            true
        }
        fn see(&mut self, frame: &Frame<'_>) {
            (self.0)(frame);
        }
    }
    let machine = machine(text)?;
    let structure = Structure::build(&machine, None).ok()?;
    simulate(&machine, &structure, &mut Watch(see)).ok().map(|_| ())
}

/// Vertex of the parabola through three equally spaced samples around a maximum: (offset in steps, value).
fn vertex(before: f64, middle: f64, after: f64) -> (f64, f64) {
    let (curvature, slope) = (before - 2.0 * middle + after, 0.5 * (after - before));
    let offset = -slope / curvature;
    (offset, middle + 0.5 * slope * offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_off_or_missing_does_not_hold() {
        let check = |ours| Check {
            case: "c",
            quantity: "q".into(),
            ours,
            reference: 2.0,
            tolerance: 1e-3,
            unit: "",
            source: "s",
        };
        assert!(check(Some(2.001)).holds() && !check(Some(2.01)).holds());
        assert!(!check(None).holds() && !check(Some(f64::NAN)).holds());
    }
}
