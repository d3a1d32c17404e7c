//! Unbalance: a mass m at the radius d on a node of the shaft line, at the angle psi.
//!
//! ```text
//! f = m d (psi'^2 - i psi'') e^{i psi}                            force on the lateral motion                                   (1)
//! D -> -i m d D e^{i psi}                                         impulse on the lateral motion of a jump D of psi'            (2)
//! r = m d Im(z' e^{-i psi}) + sum_t Q_st psi_t'                   angular momentum that the torsional modes do not have         (3)
//! k = -m d psi' Re(z' e^{-i psi}) + m d (g_y cos psi - g_x sin psi)   torque on the spin                                       (4)
//! ```
//! z = u + i v: displacement of the node \[m\]; g: gravity \[m/s2\]; Q: compliance inertia \[kg m2\] ([`super::loaded_modes`]).
//! Source: the Lagrangian of docs/theory/01-shaft-line.md.

use super::phasor::Phasor;
use nalgebra::Complex;

/// State of an unbalance at n.
#[derive(Debug, Clone)]
pub(super) struct Unbalance {
    /// m d \[kg m\].
    pub(super) moment: f64,
    /// Angle beside the mean angle of the shaft line \[rad\].
    pub(super) phase: f64,
    /// psi \[rad\] and psi' \[rad/s\] at n.
    pub(super) angle: f64,
    pub(super) rate: f64,
    /// e^{i psi} of the predicted angle at n+1; at n+1 it stays that of the prediction.
    pub(super) phasor: Phasor,
    /// r of (3) \[kg m2/s\] and k of (4) \[N m\] at n.
    pub(super) momentum: f64,
    pub(super) torque: f64,
    /// Predicted psi' at n+1 \[rad/s\].
    pub(super) next_rate: f64,
    /// e^{i psi} at n, after the prediction of n+1.
    pub(super) unit: Complex<f64>,
    /// Impulse (2) at n+1 of the error of the predicted psi' \[N s\]; force (1) in the middle of the step and at n \[N\].
    pub(super) correction_impulse: Complex<f64>,
    pub(super) mid_step_force: Complex<f64>,
    pub(super) force: Complex<f64>,
    /// Jump of psi' per angular impulse on each diaphragm's node \[1/(kg m2)\].
    pub(super) compliance: Vec<f64>,
    /// Jump of psi' by all contact impulses at n \[rad/s\].
    pub(super) jump: f64,
    /// Impulses on the lateral motion at n and n+1 by the last contact impulse at n \[N s\].
    pub(super) response_impulses: [Complex<f64>; 2],
}

impl Unbalance {
    /// Force (1) in a direction, at a rate and its derivative \[N\].
    #[inline(always)]
    pub(super) fn force(&self, unit: Complex<f64>, rate: f64, rate_dot: f64) -> Complex<f64> {
        let (turn, square) = (unit * self.moment, rate * rate);
        Complex::new(square * turn.re + rate_dot * turn.im, square * turn.im - rate_dot * turn.re)
    }

    /// Impulse (2) of a jump of psi' in a direction \[N s\].
    #[inline(always)]
    pub(super) fn rate_jump_impulse(&self, unit: Complex<f64>, jump: f64) -> Complex<f64> {
        let turn = unit * self.moment;
        Complex::new(jump * turn.im, -jump * turn.re)
    }

    /// Takes a jump of psi' into the torque (4) at n, whose node has its velocity after the impulse.
    pub(super) fn jump_torque(&mut self, jump: f64, gravity: [f64; 2]) {
        let weight = self.moment * (gravity[1] * self.unit.re - gravity[0] * self.unit.im);
        self.torque = weight + (self.torque - weight) * (1.0 + jump / self.rate);
    }

    /// First term of (3) and torque (4), for a unit vector, a rate and the node's velocity.
    #[inline(always)]
    pub(super) fn exchange(&self, unit: Complex<f64>, rate: f64, velocity: [f64; 2], gravity: [f64; 2]) -> [f64; 2] {
        let along = Complex::new(velocity[0], velocity[1]) * unit.conj();
        let weight = gravity[1] * unit.re - gravity[0] * unit.im;
        [self.moment * along.im, self.moment * (weight - rate * along.re)]
    }
}
