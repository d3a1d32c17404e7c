//! The rotor at one diaphragm: how its section follows forces over a step.

use super::axes::{Axes, bilinear};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_numerics::linalg::{axpy, dot, norm};

/// Rows and responses `A^-1` of the node that touches, in the stator's frame.
pub(super) struct Section {
    pub node: usize,
    /// Of the rotor \[m\].
    pub radius: f64,
    /// Lateral coordinates along the stator's axes, and A^-1 of them.
    rows: [Vec<f64>; 2],
    responses: [Vec<f64>; 2],
    /// Displacement by a force over the step \[m/N\].
    pub compliance: [[f64; 2]; 2],
    twist_row: Vec<f64>,
    twist_response: Vec<f64>,
    twist_compliance: f64,
    /// Torque that a prescribed speed's drive adds per torque on the node.
    drive_lever: f64,
}

impl Section {
    pub fn new(line: &ShaftLine<'_>, node: usize, radius: f64, axes: &Axes) -> Self {
        let (rows, twist_row) = line.rows(node);
        let rows = axes.rows(&rows);
        let responses: [Vec<f64>; 2] = std::array::from_fn(|axis| {
            let mut response = vec![0.0; rows[axis].len()];
            line.lateral.stepper.compliance(&rows[axis], &mut response);
            response
        });
        let compliance = std::array::from_fn(|i| std::array::from_fn(|j| dot(&rows[i], &responses[j])));
        let mut twist_response = vec![0.0; twist_row.len()];
        line.twist.stepper.compliance(&twist_row, &mut twist_response);
        let drive_lever = line.spin.hold_response(&mut twist_response);
        let twist_compliance = dot(&twist_row, &twist_response);
        Self { node, radius, rows, responses, compliance, twist_row, twist_response, twist_compliance, drive_lever }
    }

    /// Displacement over a step.
    pub fn increment(&self, lateral: &[f64]) -> [f64; 2] {
        [dot(&self.rows[0], lateral), dot(&self.rows[1], lateral)]
    }

    /// Displacement over the step at n, centred.
    pub fn centred_step(&self, line: &ShaftLine<'_>, d: &Increments) -> [f64; 2] {
        let (dx, before) = (self.increment(&d.lateral), self.increment(&line.lateral.stepper.previous));
        [0.5 * (dx[0] + before[0]), 0.5 * (dx[1] + before[1])]
    }

    /// Turn over a step.
    pub fn turn(&self, twist: &[f64]) -> f64 {
        dot(&self.twist_row, twist)
    }

    /// A place moved by a force over the step.
    pub fn moved_by(&self, force: [f64; 2], from: [f64; 2]) -> [f64; 2] {
        let w = &self.compliance;
        std::array::from_fn(|axis| from[axis] + w[axis][0] * force[0] + w[axis][1] * force[1])
    }

    /// Displacement along one direction by a unit force along another \[m/N\].
    pub fn along(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        bilinear(&self.compliance, a, b)
    }

    /// Way of the surface by a unit friction force, from the turn alone \[m/N\].
    pub fn rolling(&self) -> f64 {
        self.radius * self.radius * self.twist_compliance
    }

    /// Adds the response to a force \[N\], and to the torque of its friction.
    pub fn push(&self, force: [f64; 2], tangential: f64, d: &mut Increments) {
        for (f, response) in force.into_iter().zip(&self.responses) {
            axpy(f, response, &mut d.lateral);
        }
        axpy(-tangential * self.radius, &self.twist_response, &mut d.twist);
    }

    /// Torque of the drive of a prescribed speed against a friction torque.
    pub fn drive_torque(&self, torque: f64) -> f64 {
        self.drive_lever * torque
    }

    /// Size of the lateral increments by a unit force.
    pub fn reach(&self) -> f64 {
        norm(&self.responses[0]) + norm(&self.responses[1])
    }

    /// Size of the twist increments by a unit torque.
    pub fn twist_reach(&self) -> f64 {
        norm(&self.twist_response)
    }
}
