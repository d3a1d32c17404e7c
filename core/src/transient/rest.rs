//! The constant part c0 of the braking torque near rest: Coulomb's law, which holds a rotor that it can stop.
//!
//! ```text
//! d0 = s . d without c0,  C = s . A^-1 s,  T = -d0/C cut to [-c0, c0]
//! ```
//! A rotor that turns on has `|d0| > C c0` and T = -c0 sign(W), as ever. In its last step, and as long as nothing stronger
//! than c0 turns a rotor at rest, T leaves it without spin after the step. The law with sign(W) alone has no solution there:
//! either sign of the centred W makes a torque that gives W the other one, and the iteration goes round.
//! Source: Coulomb friction as in the contact's own stick, in the increments of physics.md section 4. Deviation: torques of a
//! contact act after it, so c0 holds them one step late. Verified by `tests/outside.rs`: `a_braked_rotor_stops_*`,
//! `a_rotor_at_rest_*`.

use crate::linalg::{axpy, dot};

/// A spin increment within this part of what c0 can take in a step is none.
const ROUNDING: f64 = 1e-9;

/// The constant braking torque of a run.
#[derive(Debug, Clone)]
pub(crate) struct Rest {
    /// c0 \[N m\]; 0 where there is none, or where the speed is prescribed.
    limit: f64,
    /// A^-1 s: increments per unit of a torque that is spread like the inertia [rad/(N m)].
    direction: Vec<f64>,
    compliance: f64,
    /// The torque that took the place of `-c0 sign(W)` in the last response \[N m\].
    held: Option<f64>,
}

impl Rest {
    pub fn new(limit: f64, spin_row: &[f64], direction: Vec<f64>) -> Self {
        let compliance = dot(spin_row, &direction);
        Self { limit, direction, compliance, held: None }
    }

    /// Puts T in place of the constant torque `applied` in a response.
    pub fn settle(&mut self, spin_row: &[f64], applied: f64, response: &mut [f64]) {
        self.held = None;
        if self.limit > 0.0 {
            let free = dot(spin_row, response) - self.compliance * applied;
            let torque = (-free / self.compliance).clamp(-self.limit, self.limit);
            if (torque - applied).abs() > 0.0 {
                axpy(torque - applied, &self.direction, response);
                self.held = Some(torque);
            }
        }
    }

    /// T of a rotor at rest that would start with the angular accelerations `start`; `direction` is theirs per unit torque.
    pub fn hold_start(&self, spin_row: &[f64], direction: &[f64], start: &mut [f64]) {
        let torque = -dot(spin_row, start) / dot(spin_row, direction);
        axpy(torque.clamp(-self.limit, self.limit), direction, start);
    }

    /// What took the place of `-c0 sign(W)` in the last response \[N m\].
    pub fn held(&self) -> Option<f64> {
        self.held
    }

    /// The increment of the mean spin angle, freed from the rounding of a rotor that is held.
    pub fn spin(&self, increment: f64) -> f64 {
        if increment.abs() <= ROUNDING * self.limit * self.compliance { 0.0 } else { increment }
    }

    /// Size of the increments that c0 makes in a step: what twist increments of a rotor at rest are measured by.
    pub fn scale(&self) -> f64 {
        self.limit * dot(&self.direction, &self.direction).sqrt()
    }
}
