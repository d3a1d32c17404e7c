//! Rotor section at one diaphragm: response to forces over a step.

use super::axes::{Axes, bilinear};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_numerics::linalg::{axpy, dot, norm};

/// Rows of the contact node and responses `A^-1` to unit forces there, in the stator's frame.
pub(super) struct Section {
    /// Node in contact.
    pub node: usize,
    /// Radius R_r of the rotor section \[m\].
    pub radius: f64,
    /// Rows of the lateral coordinates along the stator's axes, and A^-1 times these rows.
    rows: [Vec<f64>; 2],
    responses: [Vec<f64>; 2],
    /// Displacement per unit force over the step \[m/N\].
    pub compliance: [[f64; 2]; 2],
    /// Row of the torsional coordinates for the node's angle.
    torsional_row: Vec<f64>,
    /// Torsional increments per unit torque on the node.
    torsional_response: Vec<f64>,
    /// Angle of the node per unit torque over the step [rad/(N m)].
    torsional_compliance: f64,
    /// Torque of the drive of a prescribed speed per unit torque on the node.
    drive_lever: f64,
}

impl Section {
    pub fn new(line: &ShaftLine<'_>, node: usize, radius: f64, axes: &Axes) -> Self {
        let (rows, torsional_row) = line.rows(node);
        let rows = axes.rows(&rows);
        let responses: [Vec<f64>; 2] = std::array::from_fn(|axis| {
            let mut response = vec![0.0; rows[axis].len()];
            line.lateral.stepper.compliance(&rows[axis], &mut response);
            response
        });
        let compliance = std::array::from_fn(|i| std::array::from_fn(|j| dot(&rows[i], &responses[j])));
        let mut torsional_response = vec![0.0; torsional_row.len()];
        line.torsion.stepper.compliance(&torsional_row, &mut torsional_response);
        let drive_lever = line.spin.hold_response(&mut torsional_response);
        let torsional_compliance = dot(&torsional_row, &torsional_response);
        Self {
            node,
            radius,
            rows,
            responses,
            compliance,
            torsional_row,
            torsional_response,
            torsional_compliance,
            drive_lever,
        }
    }

    /// Displacement over a step \[m\].
    pub fn increment(&self, lateral: &[f64]) -> [f64; 2] {
        [dot(&self.rows[0], lateral), dot(&self.rows[1], lateral)]
    }

    /// Centred displacement over the step at n \[m\].
    pub fn centred_step(&self, line: &ShaftLine<'_>, d: &Increments) -> [f64; 2] {
        let (dx, before) = (self.increment(&d.lateral), self.increment(&line.lateral.stepper.previous));
        [0.5 * (dx[0] + before[0]), 0.5 * (dx[1] + before[1])]
    }

    /// Angle of rotation over a step \[rad\].
    pub fn turn(&self, torsion: &[f64]) -> f64 {
        dot(&self.torsional_row, torsion)
    }

    /// Position `from` after the displacement by a force over the step.
    pub fn moved_by(&self, force: [f64; 2], from: [f64; 2]) -> [f64; 2] {
        let w = &self.compliance;
        std::array::from_fn(|axis| from[axis] + w[axis][0] * force[0] + w[axis][1] * force[1])
    }

    /// Displacement along direction `a` due to a unit force along direction `b` \[m/N\].
    pub fn along(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        bilinear(&self.compliance, a, b)
    }

    /// Tangential displacement of the surface due to a unit friction force, from the rotation alone \[m/N\].
    pub fn rolling(&self) -> f64 {
        self.radius * self.radius * self.torsional_compliance
    }

    /// Adds the response to a force \[N\] and to the torque of its friction part.
    pub fn push(&self, force: [f64; 2], tangential: f64, d: &mut Increments) {
        for (f, response) in force.into_iter().zip(&self.responses) {
            axpy(f, response, &mut d.lateral);
        }
        axpy(-tangential * self.radius, &self.torsional_response, &mut d.torsion);
    }

    /// Torque of the drive of a prescribed speed in response to a friction torque \[N m\].
    pub fn drive_torque(&self, torque: f64) -> f64 {
        self.drive_lever * torque
    }

    /// Norm of the lateral increments per unit force.
    pub fn reach(&self) -> f64 {
        norm(&self.responses[0]) + norm(&self.responses[1])
    }

    /// Norm of the torsional increments per unit torque.
    pub fn torsional_reach(&self) -> f64 {
        norm(&self.torsional_response)
    }
}
