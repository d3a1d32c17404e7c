//! What an impulse on the rotor at n is at n+1, in one cell and for one step.
//!
//! ```text
//! y      exp(B h) l                             X = rows exp(B h) l                                  displacement per impulse
//! steady train J = F h at n:   rows (1 - exp(B h))^-1 exp(B h) l h F;    constant force:  -rows B^-1 l F                       (1)
//! ```
//! The difference of (1), per impulse, is what a train of impulses lacks at n (as [`super::kicked_ring`] has it of the ring): of displacements, and of the bearings' loads.

use super::interval_model::IntervalModel;
use super::plane_block::PlaneBlock;
use super::propagator::Propagator;
use crate::linalg::dot;

/// Impulses along the axes of one diaphragm's node.
#[derive(Debug, Clone)]
pub(crate) struct ImpulseResponse {
    /// Whirl states at n+1 of a unit impulse along each axis.
    pub states: [Vec<f64>; 2],
    /// Outputs of those.
    pub outputs: [Vec<f64>; 2],
    /// X, and what trains lack \[m/(N s)\].
    pub displacement: [[f64; 2]; 2],
    pub static_correction: [[f64; 2]; 2],
    /// Jump of the node's velocity at n \[m/s/(N s)\].
    pub velocity_jump: [[f64; 2]; 2],
    /// Jumps of the velocities of the unbalances' nodes \[m/s/(N s)\].
    pub at_unbalances: Vec<[[f64; 2]; 2]>,
    /// Whirl states at n+1 of a unit impulse along each axis of each unbalance's node, and their outputs.
    pub of_unbalances: Vec<[[Vec<f64>; 2]; 2]>,
    /// What each bearing's load lacks \[N/(N s)\]: nearly half of its jump, but not of pairs that come to rest within the step, of which a mean of before and after may have any size.
    pub loads: Vec<[[f64; 2]; 2]>,
}

impl ImpulseResponse {
    /// Of the node whose rows and pushes begin at these places; `loads`: first row of each bearing's load.
    pub fn new(
        cell: &IntervalModel,
        propagator: &Propagator,
        h: f64,
        row: usize,
        push: usize,
        loads: &[usize],
    ) -> Self {
        let pushes = [&cell.input_vectors[push], &cell.input_vectors[push + 1]];
        let states = pushes.map(|l| propagator.free(l));
        let pairs = cell.blocks.len();
        let rest = [0, 1].map(|axis| {
            let mut y = vec![0.0; 2 * pairs];
            for k in 0..pairs {
                let e = propagator.of_pair(k);
                let train = solve(&[1.0 - e[0], -e[1], -e[2], 1.0 - e[3]], [states[axis][k], states[axis][pairs + k]]);
                let still = solve(&cell.blocks[k], [pushes[axis][k], pushes[axis][pairs + k]]);
                y[k] = -still[0] / h - train[0];
                y[pairs + k] = -still[1] / h - train[1];
            }
            y
        });
        let of = |first: usize, y: &[Vec<f64>; 2]| -> [[f64; 2]; 2] {
            [0, 1].map(|i| [dot(&cell.output_rows[first + i], &y[0]), dot(&cell.output_rows[first + i], &y[1])])
        };
        let whole = pushes.map(Clone::clone);
        Self {
            displacement: of(row, &states),
            static_correction: of(row, &rest),
            velocity_jump: of(row + 2, &whole),
            at_unbalances: (0..cell.outputs_of_impulses.len() / 2).map(|s| of(2 * s, &whole)).collect(),
            loads: loads.iter().map(|&first| of(first, &rest)).collect(),
            of_unbalances: cell.input_vectors.as_chunks::<2>().0[..cell.outputs_of_impulses.len() / 2]
                .iter()
                .map(|pushes| {
                    let states = pushes.each_ref().map(|l| propagator.free(l));
                    let outputs = states.each_ref().map(|y| outputs_of(cell, y));
                    [states, outputs]
                })
                .collect(),
            outputs: states.each_ref().map(|y| outputs_of(cell, y)),
            states,
        }
    }
}

/// Outputs of whirl states.
fn outputs_of(cell: &IntervalModel, y: &[f64]) -> Vec<f64> {
    let mut outputs = Vec::new();
    cell.output_matrix.multiply(y, &mut outputs);
    outputs
}

/// `m^-1 v`.
fn solve(m: &PlaneBlock, v: [f64; 2]) -> [f64; 2] {
    let determinant = m[0] * m[3] - m[1] * m[2];
    [(m[3] * v[0] - m[1] * v[1]) / determinant, (m[0] * v[1] - m[2] * v[0]) / determinant]
}
