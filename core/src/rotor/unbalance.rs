//! Unbalance: a mass on the rotor away from its axis, added or lost.
//!
//! ```text
//! psi = phi + beta_k + a
//! 2T  = m [(u' - d psi' sin psi)^2 + (v' + d psi' cos psi)^2]                       (1)
//! u row    m (u'' - d psi'' sin psi - d psi'^2 cos psi)                              (2)
//! v row    m (v'' + d psi'' cos psi - d psi'^2 sin psi)
//! twist    m d^2 psi'' + m d (-u'' sin psi + v'' cos psi)
//! gravity  twist + m d (-g_x sin psi + g_y cos psi)                                   (3)
//! ```
//! Source: physics.md section 1. `m` is negative for a lost mass. The terms with constant coefficients (`m u''`, `m v''`,
//! `m d^2 psi''`) are part of the mass matrices of a run; the rest are forces, evaluated here.
//! Verified by `forces_are_the_derivative_of_the_lagrangian` (`transient/lagrangian_tests.rs`) and the Jeffcott cases.

use crate::machine::{Unbalance, UnbalanceKind};

/// One unbalance at its node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalanceSite {
    /// Node.
    pub node: usize,
    /// Mass \[kg\], negative for a lost mass.
    pub mass: f64,
    /// Eccentricity d \[m\].
    pub radius: f64,
    /// Phase a \[rad\].
    pub phase: f64,
}

/// Force of the terms that are not part of the mass matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnbalanceForce {
    /// On u and v \[N\].
    pub force: [f64; 2],
    /// On the twist row [N m].
    pub torque: f64,
}

impl UnbalanceSite {
    /// From the machine.
    #[must_use]
    pub fn new(unbalance: &Unbalance) -> Self {
        let sign = match unbalance.kind {
            UnbalanceKind::Added => 1.0,
            UnbalanceKind::Lost => -1.0,
        };
        Self { node: unbalance.node, mass: sign * unbalance.mass, radius: unbalance.radius, phase: unbalance.phase }
    }

    /// Forces (2), (3) at sine and cosine of `psi`, spin rate `rate` = psi', its derivative `rate_dot`, the node's
    /// acceleration [m/s2] and gravity [m/s2].
    #[inline]
    #[must_use]
    pub fn force(
        &self,
        (sin, cos): (f64, f64),
        rate: f64,
        rate_dot: f64,
        acceleration: [f64; 2],
        gravity: [f64; 2],
    ) -> UnbalanceForce {
        let md = self.mass * self.radius;
        let (square, [ax, ay], [gx, gy]) = (rate * rate, acceleration, gravity);
        UnbalanceForce {
            force: [md * (rate_dot * sin + square * cos), md * (square * sin - rate_dot * cos)],
            torque: md * ((ax - gx) * sin - (ay - gy) * cos),
        }
    }

    /// Kinetic energy (1) less its constant-coefficient part \[J\].
    #[inline]
    #[must_use]
    pub fn coupling_energy(&self, (sin, cos): (f64, f64), rate: f64, velocity: [f64; 2]) -> f64 {
        self.mass * self.radius * rate * (velocity[1] * cos - velocity[0] * sin)
    }

    /// Potential energy of the eccentricity in gravity \[J\]; the part of the node itself is in the weight vector.
    #[inline]
    #[must_use]
    pub fn gravity_energy(&self, (sin, cos): (f64, f64), gravity: [f64; 2]) -> f64 {
        -self.mass * self.radius * (gravity[0] * cos + gravity[1] * sin)
    }
}
