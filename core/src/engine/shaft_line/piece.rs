//! Release of a mass: motion before the release, jump of the accelerations, and energy of the mass.
//!
//! A release adds the mass m of an unbalance to the rotor at a time t_r; a negative m is removed. Positions and velocities are continuous, because no
//! impulse acts. From then on mass matrix, weight and unbalance force are those of a machine with the unbalance.
//!
//! ```text
//! p      = z + d e^{i psi}                        place of the mass: node and arm
//! lambda = -m (p'' - g)                           its force on the rotor
//! (1 + m B M^-1 B^T) lambda = -m (p0'' - g)       p0'': acceleration of that place just before the release                              (1)
//! Da     = M^-1 B^T lambda                        jump of the accelerations                                                             (2)
//! v(t_n) = v0(t_n) + (t_n - t_r) Da               t_n: first instant of a step at or after t_r, where the run changes its matrices      (3)
//! E      = m |p'|^2/2 - m g.p   at t_r            energy of the mass, a term of its own in the energy balance                           (4)
//! ```
//! M: mass matrix before the release; B: velocity of p per velocity of the coordinates; v0: velocity without the release. A release within a step is
//! therefore second order in the step, as the scheme is.
//! Limits: (3) neglects the displacement `(t_n - t_r)^2 Da/2`, and the contact force's share of p0'' in the exponential engine.
//! Source: the Lagrangian of docs/theory/01-shaft-line.md with a variable mass.
//! Verified by `core/tests/runs/releases.rs`.

use super::masses::{masses, sites};
use crate::rotor::UnbalanceSite;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{Matrix, axpy, dot, inverse, mul_vec};

/// Motion of the position of a mass just before its release.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PieceMotion {
    /// Displacement, velocity and acceleration of the node \[m, m/s, m/s2\].
    pub node: [[f64; 2]; 3],
    /// Angle psi of the arm, its first and second derivative \[rad, rad/s, rad/s2\].
    pub angle: [f64; 3],
}

impl PieceMotion {
    /// Motion at an instant earlier by `time` \[s\].
    fn earlier(&self, time: f64) -> Self {
        let back = |[x, v, a]: [f64; 3]| [x - time * (v - 0.5 * time * a), v - time * a, a];
        let [x, v, a] = self.node;
        let axes = [0, 1].map(|i| back([x[i], v[i], a[i]]));
        Self { node: [0, 1, 2].map(|part| axes.map(|axis| axis[part])), angle: back(self.angle) }
    }

    /// Energy (4) of the mass at an instant earlier by `late` \[s\], with the acceleration of gravity `gravity` \[m/s2\]; \[J\].
    pub fn energy(&self, site: &UnbalanceSite, gravity: [f64; 2], late: f64) -> f64 {
        let PieceMotion { node: [x, v, _], angle: [psi, rate, _] } = self.earlier(late);
        let (sin, cos) = libm::sincos(psi);
        let velocity = [v[0] - site.radius * rate * sin, v[1] + site.radius * rate * cos];
        let place = [x[0] + site.radius * cos, x[1] + site.radius * sin];
        site.mass * (0.5 * (velocity[0] * velocity[0] + velocity[1] * velocity[1]) - dot(&gravity, &place))
    }

    /// Jump of the accelerations (2); `before` is the machine without the mass. `None` if a mass matrix is singular.
    pub fn jump(&self, site: &UnbalanceSite, before: &Machine, structure: &Structure) -> Option<Jump> {
        let (lateral_mass, torsional_mass) = masses(structure, &sites(before));
        let (lateral_inverse, torsional_inverse) = (inverse(&lateral_mass)?, inverse(&torsional_mass)?);
        let respond = |matrix: &Matrix, force: &[f64]| {
            let mut response = vec![0.0; force.len()];
            mul_vec(matrix, force, &mut response);
            response
        };
        let rows = structure.rotor.plane_places(site.node).map(|dof| structure.lateral.coordinates.row(dof));
        let responses = [0, 1].map(|axis| respond(&lateral_inverse, &rows[axis]));
        let torsional_row = structure.torsion.coordinates.row(site.torsional_node);
        let mut torsional_response = respond(&torsional_inverse, &torsional_row);
        if before.rotor.speed_law.is_some() {
            // a drive keeps the mean spin at its prescribed value
            let mut mean = vec![0.0; torsional_row.len()];
            structure.torsion.coordinates.project(&structure.rotor.spin_weights, &mut mean);
            let direction = respond(&torsional_inverse, &mean);
            axpy(-dot(&mean, &torsional_response) / dot(&mean, &direction), &direction, &mut torsional_response);
        }
        let PieceMotion { node: [_, _, a], angle: [psi, rate, rate_dot] } = *self;
        let (sin, cos) = libm::sincos(psi);
        let d = site.radius;
        let arm = [-d * sin, d * cos];
        let turning = dot(&torsional_row, &torsional_response);
        let wanted = [
            -site.mass * (a[0] + arm[0] * rate_dot - d * rate * rate * cos - before.rotor.gravity[0]),
            -site.mass * (a[1] + arm[1] * rate_dot - d * rate * rate * sin - before.rotor.gravity[1]),
        ];
        // (1) in two components
        let entry = |i: usize, j: usize| {
            let unit = if i == j { 1.0 } else { 0.0 };
            unit + site.mass * (dot(&rows[i], &responses[j]) + arm[i] * turning * arm[j])
        };
        let [[e, f], [g, h]] = [0, 1].map(|i| [0, 1].map(|j| entry(i, j)));
        let determinant = e * h - f * g;
        let force = [(h * wanted[0] - f * wanted[1]) / determinant, (e * wanted[1] - g * wanted[0]) / determinant];
        let mut lateral = vec![0.0; rows[0].len()];
        (0..2).for_each(|axis| axpy(force[axis], &responses[axis], &mut lateral));
        let torque = dot(&arm, &force);
        let torsion = torsional_response.iter().map(|part| torque * part).collect();
        (determinant != 0.0).then_some(Jump { lateral, torsion })
    }
}

/// Jump of the accelerations at a release, in the coordinates of a structure.
#[derive(Debug, Clone)]
pub(crate) struct Jump {
    /// Jump of the lateral accelerations.
    pub lateral: Vec<f64>,
    /// Jump of the torsional accelerations.
    pub torsion: Vec<f64>,
}

impl Jump {
    /// The jump times a factor.
    pub fn times(mut self, factor: f64) -> Self {
        self.lateral.iter_mut().chain(&mut self.torsion).for_each(|part| *part *= factor);
        self
    }
}
