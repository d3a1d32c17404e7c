//! Prediction of a step without contact, by fixed-point iteration to convergence.

use super::shaft_line::{Increments, ShaftLine};
use bladeoff_model::outcome::Cause;
use bladeoff_numerics::linalg::{distance, norm};

/// Relative convergence tolerance of the increments.
pub(super) const TOLERANCE: f64 = 1e-12;
/// Maximum number of iterations. One iteration contracts by about `Omega dt`, or by `m e^2/(J + m e^2)` if an unbalance outweighs the spin's inertia.
const ITERATIONS: usize = 600;
/// Smallest contraction assumed for a round: two rounds that agree by chance do not predict the contraction of the next step.
const CONTRACTION: f64 = 1e-3;

/// State of the iteration that is carried from step to step.
pub(super) struct Predictor {
    /// Increments of the steps before the last one: two lateral ones, one torsional.
    before: [Vec<f64>; 2],
    torsion_before: Vec<f64>,
    /// Contraction of the iteration, last measured value.
    contraction: f64,
    /// Increments of the next round.
    next: Increments,
    /// Number of rounds of all steps.
    pub iterations: u64,
}

impl Predictor {
    /// Predictor at the start of a shaft line: all earlier increments equal the last ones.
    pub fn new(line: &ShaftLine<'_>) -> Self {
        let (lateral, torsion) = (&line.lateral.stepper.previous, &line.torsion.stepper.previous);
        Self {
            before: [lateral.clone(), lateral.clone()],
            torsion_before: torsion.clone(),
            contraction: 1.0,
            next: Increments::zeros(lateral.len(), torsion.len()),
            iterations: 0,
        }
    }

    /// Restarts from other increments of the step before t = 0.
    pub fn restart(&mut self, line: &ShaftLine<'_>) {
        let lateral = &line.lateral.stepper.previous;
        self.before = [lateral.clone(), lateral.clone()];
        self.torsion_before.clone_from(&line.torsion.stepper.previous);
        self.iterations = 0;
    }

    /// Solves the step from n at `time` without contact, in `d`. The remaining error, estimated by the measured contraction, is below the tolerance.
    pub fn predict(&mut self, line: &mut ShaftLine<'_>, time: f64, d: &mut Increments) -> Result<(), Cause> {
        self.extrapolate(line, d);
        let mut last_change: Option<f64> = None;
        for _ in 0..ITERATIONS {
            self.iterations += 1;
            let driven = line.spin.driven();
            line.respond(time, d, &mut self.next);
            let scale = line.lateral_scale(norm(&self.next.lateral));
            let torsional_scale = norm(&self.next.torsion).max(line.torsional_scale());
            let drive_change = (line.spin.driven() - driven).abs();
            let change = (distance(&self.next.lateral, &d.lateral) / scale)
                .max((distance(&self.next.torsion, &d.torsion) + drive_change) / (torsional_scale + f64::MIN_POSITIVE));
            std::mem::swap(d, &mut self.next);
            if let Some(last) = last_change {
                self.contraction = (change / last).clamp(CONTRACTION, 1.0);
            }
            // the second round is not done yet: take the last measured contraction, with a margin
            let contraction = if last_change.is_some() { self.contraction } else { (4.0 * self.contraction).min(1.0) };
            if change * contraction <= TOLERANCE {
                return Ok(());
            }
            if !(scale.is_finite() && torsional_scale.is_finite()) {
                return Err(Cause::NonFinite);
            }
            last_change = Some(change);
        }
        Err(Cause::Diverged)
    }

    /// First guess by extrapolation from the last three steps.
    fn extrapolate(&self, line: &ShaftLine<'_>, d: &mut Increments) {
        let (lateral, torsion) = (&line.lateral.stepper.previous, &line.torsion.stepper.previous);
        for (i, d) in d.lateral.iter_mut().enumerate() {
            let (last, before, first) = (lateral[i], self.before[0][i], self.before[1][i]);
            *d = 3.0 * (last - before) + first;
        }
        for (i, d) in d.torsion.iter_mut().enumerate() {
            *d = 2.0 * torsion[i] - self.torsion_before[i];
        }
    }

    /// Stores the increments of the previous step, before [`ShaftLine::advance`] replaces them.
    pub fn keep(&mut self, line: &ShaftLine<'_>) {
        self.before.swap(0, 1);
        self.before[0].copy_from_slice(&line.lateral.stepper.previous);
        self.torsion_before.copy_from_slice(&line.torsion.stepper.previous);
    }
}
