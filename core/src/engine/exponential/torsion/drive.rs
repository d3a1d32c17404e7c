//! Drive of a prescribed speed.
//!
//! ```text
//! W = W(t), Phi = Phi(t)                                  mean spin and mean angle of the shaft line, by the law                 (1)
//! P = J W + sum_s a_s psi_s' + sum_s r_s + q'^T G q/2     angular momentum; J: shaft line alone, a_s = sum_t A_st                (2)
//! I = P(n+1) - P(n) - h (T(W) + sum_s k_s) - tau          angular impulse of the drive over the step                             (3)
//! I W                                                     its work, with the mean spin of the step; against tau with that of n   (4)
//! ```
//! Symbols of [`super::spin`] and [`super::loaded_modes`]. Nothing moves the mean spin: the loaded modes are those of a shaft line
//! whose mean angle is held, and its inertia is infinite for all forces. The part a_s W' of the unbalances' inertia is a torque on
//! the torsional modes.
//!
//! Source: docs/theory/01-shaft-line.md, with the mean angle as a constraint. Verified by `tests/exponential/prescribed_speed.rs`.

use crate::engine::shaft_line::{angle_of, speed_of};
use bladeoff_model::machine::SpeedLaw;

/// Drive that keeps the mean spin on its law.
#[derive(Debug, Clone)]
pub(super) struct Drive {
    law: SpeedLaw,
    /// Mean angle at t = 0 \[rad\].
    initial_angle: f64,
    /// J and a_s of (2) \[kg m2\].
    inertia: f64,
    unbalance_inertias: Vec<f64>,
    /// Time at n \[s\].
    time: f64,
    /// Work of the drive so far, (4) \[J\].
    pub work: f64,
}

impl Drive {
    /// Creates the drive of a law, from a mean angle at t = 0.
    pub fn new(law: SpeedLaw, initial_angle: f64, inertia: f64, unbalance_inertias: Vec<f64>) -> Self {
        Self { law, initial_angle, inertia, unbalance_inertias, time: 0.0, work: 0.0 }
    }

    /// Takes over time and work of another drive of the same law.
    pub fn take_over(&mut self, other: &Self) {
        (self.time, self.work) = (other.time, other.work);
    }

    /// Mean angle \[rad\] and spin \[rad/s\] after a step of `h` \[s\].
    pub fn after(&self, h: f64) -> [f64; 2] {
        let time = self.time + h;
        [self.initial_angle + angle_of(&self.law, time), speed_of(&self.law, time)]
    }

    /// First two terms of (2), for a spin and the rates psi_s' of the unbalances \[rad/s\].
    pub fn momentum(&self, speed: f64, rates: impl Iterator<Item = f64>) -> f64 {
        self.inertia * speed
            + self.unbalance_inertias.iter().zip(rates).map(|(inertia, rate)| inertia * rate).sum::<f64>()
    }

    /// a_s of (2).
    pub fn unbalance_inertia(&self, s: usize) -> f64 {
        self.unbalance_inertias[s]
    }

    /// Kinetic energy of the mean rotation and of the part A of the unbalances' inertia that the torsional modes do not have \[J\].
    pub fn energy(&self, speed: f64, rates: impl Iterator<Item = f64>) -> f64 {
        let parts = self.unbalance_inertias.iter().zip(rates).map(|(inertia, rate)| inertia * (rate - 0.5 * speed));
        speed * (0.5 * self.inertia * speed + parts.sum::<f64>())
    }

    /// Ends a step of `h` \[s\] with the angular impulse of the drive and that of the contact at n \[N m s\]; spin at n and turn
    /// over the step \[rad/s, rad\].
    pub fn finish_step(&mut self, h: f64, [impulse, contact]: [f64; 2], [speed, turn]: [f64; 2]) {
        self.work += (impulse + contact) * turn / h - contact * speed;
        self.time += h;
    }
}
