//! Braking torque over a step: how it slows, stops and holds the rotor.
//!
//! ```text
//! d0 = s . d without braking,  C = s . A^-1 s,  T(W): braking torque, c0: its part at rest
//! stop    d- d0 > 0 and |d0| <= C |T(d-/(2 dt))|:  T = -d0/C            the rotor stops within the step               (1)
//! else    c0 part = -(d0 + C T_viscous)/C cut to [-c0, c0]              Coulomb's law at rest                           (2)
//!         T_viscous += [T_viscous(W) - T_viscous]/(1 + x),  x = -C dT/dW/(2 dt) >= 0, in each round                     (3)
//! start   |T| <= 2 dt W0/C                                              stops in the first step, no more                (4)
//! ```
//! A rotor that keeps turning has `T = T(W)`. In its last step, and while no torque above c0 acts on a rotor at rest, (2) leaves it without spin
//! after the step. The law with sign(W) alone has no solution there: either sign of the centred W gives a torque that reverses W. (1) treats the
//! whole brake in the same way: centred, `c1 W` with `x > 1` would not stop a rotor but reverse its spin at the same speed. (3) is Newton's method
//! for the braking alone, so that the rounds of a step converge for every x, to `T = T(W)`.
//! Source: Coulomb friction as for sticking contact, in the increments of docs/theory/04-time-integration.md.
//! Limits: contact torques act after the brake, so c0 balances them one step late. A rotor that stops within its first step has at t = 0 the kinetic
//! energy of the fictitious step before, up to four times its own.
//! Verified by `tests/rotor/outside.rs`: `a_braked_rotor_stops_*`, `a_rotor_at_rest_*`; `tests/runs/stepping.rs`:
//! `brakes_that_stop_a_rotor_within_a_step_*`.

use bladeoff_model::machine::Braking;
use bladeoff_numerics::linalg::{axpy, dot};

/// Largest spin increment that counts as zero, as a share of the increment by the braking torque.
const ROUNDING: f64 = 1e-9;

/// Brake of a run.
#[derive(Debug, Clone)]
pub(crate) struct Brake {
    /// Braking torque over the speed.
    law: Braking,
    /// Whether the brake can hold the rotor; false for a prescribed speed.
    holds: bool,
    /// Time step \[s\].
    dt: f64,
    /// A^-1 s: increments of the torsional coordinates per unit torque distributed like the inertia [rad/(N m)].
    direction: Vec<f64>,
    /// C = s . A^-1 s: increment of the mean spin angle per unit torque [rad/(N m)].
    compliance: f64,
    /// Viscous and constant part of T in the last round \[N m\], of opposite sign to the spin.
    viscous: f64,
    constant: f64,
    /// Torque by (1) or (2) that replaced T(W) in the last round \[N m\].
    instead: Option<f64>,
}

impl Brake {
    pub fn new(law: Braking, driven: bool, spin_row: &[f64], direction: Vec<f64>, dt: f64) -> Self {
        let compliance = dot(spin_row, &direction);
        Self { law, holds: !driven, dt, direction, compliance, viscous: 0.0, constant: 0.0, instead: None }
    }

    fn viscous_torque(&self, speed: f64) -> f64 {
        self.law.torque(speed) - self.law.constant_torque(speed)
    }

    /// T of the next round by (3), from the centred spin of the last round \[rad/s\]; \[N m\].
    pub fn torque(&mut self, spin: f64) -> f64 {
        self.constant = self.law.constant_torque(spin);
        let wanted = self.viscous_torque(spin);
        let slope = self.law.slope(spin).max(0.0);
        let x = if self.holds { self.compliance * slope / (2.0 * self.dt) } else { 0.0 };
        self.viscous += (wanted - self.viscous) / (1.0 + x);
        self.viscous + self.constant
    }

    /// Replaces the torque of the round in a response by the one that stops or holds the rotor; `before` is s . d- \[rad\].
    pub fn settle(&mut self, spin_row: &[f64], before: f64, response: &mut [f64]) {
        self.instead = None;
        if !self.holds {
            return;
        }
        let applied = self.viscous + self.constant;
        let turn = dot(spin_row, response);
        let stop = -(turn - self.compliance * applied) / self.compliance;
        let most = self.law.torque(before / (2.0 * self.dt)).abs();
        let torque = if before * stop < 0.0 && stop.abs() <= most {
            stop
        } else {
            let held = -(turn - self.compliance * self.constant) / self.compliance;
            self.viscous + held.clamp(-self.law.at_rest(), self.law.at_rest())
        };
        if (torque - applied).abs() > 0.0 {
            axpy(torque - applied, &self.direction, response);
            self.instead = Some(torque);
        }
    }

    /// T at t = 0 by (4) \[N m\].
    pub fn at_start(&self, spin: f64) -> f64 {
        let torque = self.law.torque(spin);
        let most = 2.0 * self.dt * spin.abs() / self.compliance;
        if self.holds { torque.min(most).max(-most) } else { torque }
    }

    /// Applies T to a rotor at rest with the initial angular accelerations `start`; `direction` is A^-1 s, angular accelerations per unit torque.
    pub fn hold_start(&self, spin_row: &[f64], direction: &[f64], start: &mut [f64]) {
        if self.holds {
            let torque = -dot(spin_row, start) / dot(spin_row, direction);
            axpy(torque.clamp(-self.law.at_rest(), self.law.at_rest()), direction, start);
        }
    }

    /// T of a converged step with the centred spin `spin` \[N m\].
    pub fn acted(&self, spin: f64) -> f64 {
        self.instead.unwrap_or_else(|| self.law.torque(spin))
    }

    /// Increment of the mean spin angle, with the rounding of a held rotor removed \[rad\].
    pub fn spin(&self, increment: f64) -> f64 {
        let took = if self.holds { self.law.at_rest().max(self.instead.map_or(0.0, f64::abs)) } else { 0.0 };
        if increment.abs() <= ROUNDING * took * self.compliance { 0.0 } else { increment }
    }

    /// Norm of the increments due to c0 in a step: the scale of torsional increments of a rotor at rest.
    pub fn scale(&self) -> f64 {
        if self.holds { self.law.at_rest() * dot(&self.direction, &self.direction).sqrt() } else { 0.0 }
    }
}
