//! The braking torque in a step: what it takes from a spin, and what it holds.
//!
//! ```text
//! d0 = s . d without braking,  C = s . A^-1 s,  T = -(c0 sign(W) + c1 W + c2 W|W|)
//! stop    d- d0 > 0 and |d0| <= C |T(d-/(2 dt))|:  T = -d0/C            the rotor stops within the step               (1)
//! else    c0 part = -(d0 + C T_viscous)/C cut to [-c0, c0]              Coulomb's law at rest                           (2)
//!         T_viscous += [T_viscous(W) - T_viscous]/(1 + x),  x = C (c1 + 2 c2 |W|)/(2 dt), in each round                 (3)
//! start   |T| <= 2 dt W0/C                                              stops in the first step, no more                (4)
//! ```
//! A rotor that turns on has `T = T(W)`, as ever. In its last step, and as long as nothing stronger than c0 turns a rotor at
//! rest, (2) leaves it without spin after the step: the law with sign(W) alone has no solution there, either sign of the centred
//! W makes a torque that gives W the other one. (1) says the same of the whole brake: centred, `c1 W` with `x > 1` would not stop a
//! rotor but send it back as fast as it came. (3) is Newton's method for the braking alone, so that the rounds of a step settle
//! whatever x is; they settle where `T = T(W)`.
//! Source: Coulomb friction as in the contact's own stick, in the increments of docs/theory/04-time-integration.md. Limits: torques of a
//! contact act after it, so c0 holds them one step late; a rotor that stops within its first step has at t = 0 the kinetic
//! energy of the fictitious step before, up to four times its own. Verified by `tests/rotor/outside.rs`: `a_braked_rotor_stops_*`,
//! `a_rotor_at_rest_*`, `brakes_that_stop_a_rotor_within_a_step_*`.

use crate::rotor::{braking_torque, constant_torque};
use bladeoff_model::machine::Braking;
use bladeoff_numerics::linalg::{axpy, dot};

/// A spin increment within this part of what the brake took in a step is none.
const ROUNDING: f64 = 1e-9;

/// The brake of a run.
#[derive(Debug, Clone)]
pub(crate) struct Brake {
    law: Braking,
    /// Whether it can hold a rotor: not where the speed is prescribed.
    holds: bool,
    dt: f64,
    /// A^-1 s: increments per unit of a torque that is spread like the inertia [rad/(N m)].
    direction: Vec<f64>,
    compliance: f64,
    /// The two parts of T in the last round \[N m\].
    viscous: f64,
    constant: f64,
    /// What (1) or (2) put in the place of T(W) in the last round \[N m\].
    instead: Option<f64>,
}

impl Brake {
    pub fn new(law: Braking, driven: bool, spin_row: &[f64], direction: Vec<f64>, dt: f64) -> Self {
        let compliance = dot(spin_row, &direction);
        Self { law, holds: !driven, dt, direction, compliance, viscous: 0.0, constant: 0.0, instead: None }
    }

    fn viscous_torque(&self, speed: f64) -> f64 {
        braking_torque(&self.law, speed) - constant_torque(&self.law, speed)
    }

    /// T of the next round, by (3), from the centred spin of the last \[N m\].
    pub fn torque(&mut self, spin: f64) -> f64 {
        self.constant = constant_torque(&self.law, spin);
        let wanted = self.viscous_torque(spin);
        let slope = self.law.linear + 2.0 * self.law.quadratic * spin.abs();
        let x = if self.holds { self.compliance * slope / (2.0 * self.dt) } else { 0.0 };
        self.viscous += (wanted - self.viscous) / (1.0 + x);
        self.viscous + self.constant
    }

    /// Puts what stops or holds the rotor in place of the torque of the round in a response; `before` is s . d-.
    pub fn settle(&mut self, spin_row: &[f64], before: f64, response: &mut [f64]) {
        self.instead = None;
        if !self.holds {
            return;
        }
        let applied = self.viscous + self.constant;
        let turn = dot(spin_row, response);
        let stop = -(turn - self.compliance * applied) / self.compliance;
        let most = braking_torque(&self.law, before / (2.0 * self.dt)).abs();
        let torque = if before * stop < 0.0 && stop.abs() <= most {
            stop
        } else {
            let held = -(turn - self.compliance * self.constant) / self.compliance;
            self.viscous + held.clamp(-self.law.constant, self.law.constant)
        };
        if (torque - applied).abs() > 0.0 {
            axpy(torque - applied, &self.direction, response);
            self.instead = Some(torque);
        }
    }

    /// T in the instant of the start, by (4) \[N m\].
    pub fn at_start(&self, spin: f64) -> f64 {
        let torque = braking_torque(&self.law, spin);
        let most = 2.0 * self.dt * spin.abs() / self.compliance;
        if self.holds { torque.min(most).max(-most) } else { torque }
    }

    /// T of a rotor at rest that would start with the angular accelerations `start`; `direction` is theirs per unit torque.
    pub fn hold_start(&self, spin_row: &[f64], direction: &[f64], start: &mut [f64]) {
        if self.holds {
            let torque = -dot(spin_row, start) / dot(spin_row, direction);
            axpy(torque.clamp(-self.law.constant, self.law.constant), direction, start);
        }
    }

    /// T of a converged step with its centred spin \[N m\].
    pub fn acted(&self, spin: f64) -> f64 {
        self.instead.unwrap_or_else(|| braking_torque(&self.law, spin))
    }

    /// The increment of the mean spin angle, freed from the rounding of a rotor that is held.
    pub fn spin(&self, increment: f64) -> f64 {
        let took = if self.holds { self.law.constant.max(self.instead.map_or(0.0, f64::abs)) } else { 0.0 };
        if increment.abs() <= ROUNDING * took * self.compliance { 0.0 } else { increment }
    }

    /// Size of the increments that c0 makes in a step: what twist increments of a rotor at rest are measured by.
    pub fn scale(&self) -> f64 {
        if self.holds { self.law.constant * dot(&self.direction, &self.direction).sqrt() } else { 0.0 }
    }
}
