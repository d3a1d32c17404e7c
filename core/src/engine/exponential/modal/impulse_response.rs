//! Response of the lateral motion to impulses at n: displacements, loads and modal states at n+1, in one speed interval and for one contact step.
//!
//! ```text
//! unit impulse                 y = exp(B h) l,   X = O exp(B h) l                                             displacement per impulse
//! steady train J = F h         O (1 - exp(B h))^-1 exp(B h) l h F                                             at n, just before each impulse
//! constant force F             -O B^-1 l F                                                                                          (1)
//! static correction            (constant force - steady train)/(h F)
//! ```
//! `l`: input vector of the node, `B`: plane blocks, `O`: output rows, `h`: contact step \[s\], `J`: impulse \[N s\].
//!
//! A steady train of impulses deflects the shaft less at n than the constant force of the same mean. The static correction is the difference of the two in (1) per impulse.
//! The correction is added to displacements and bearing loads, as for the ring (`contact::impulsed_ring`). Verified by `tests/exponential/exponential_rub.rs`.

use super::interval_model::IntervalModel;
use super::plane_block::PlaneBlock;
use super::propagator::Propagator;
use bladeoff_numerics::linalg::dot;

/// Response to unit impulses along the axes u and v on the node of one diaphragm; matrices are indexed \[output axis\]\[impulse axis\].
#[derive(Debug, Clone)]
pub(crate) struct ImpulseResponse {
    /// Modal states at n+1, per axis of the impulse.
    pub states: [Vec<f64>; 2],
    /// All outputs at n+1, per axis of the impulse.
    pub outputs: [Vec<f64>; 2],
    /// X: displacement of the node at n+1 \[m/(N s)\].
    pub displacement: [[f64; 2]; 2],
    /// Static correction of the displacement of the node \[m/(N s)\].
    pub static_correction: [[f64; 2]; 2],
    /// Velocity jump of the node at n \[m/s/(N s)\].
    pub velocity_jump: [[f64; 2]; 2],
    /// Velocity jumps of the nodes of the unbalances at n \[m/s/(N s)\].
    pub at_unbalances: Vec<[[f64; 2]; 2]>,
    /// Modal states and outputs at n+1 of unit impulses on the node of each unbalance, per axis of the impulse.
    pub of_unbalances: Vec<[[Vec<f64>; 2]; 2]>,
    /// Response at each diaphragm, in the machine's order; empty where there is no other.
    pub at_diaphragms: Vec<Coupling>,
    /// Static correction of each bearing load \[N/(N s)\].
    ///
    /// Nearly half of the load's jump, except for planes that decay within the step: there a mean of the loads before and after the impulse may have any size.
    pub loads: Vec<[[f64; 2]; 2]>,
}

/// Response of one diaphragm's node to unit impulses on another's.
#[derive(Debug, Clone)]
pub(crate) struct Coupling {
    /// Displacement at n+1 \[m/(N s)\].
    pub displacement: [[f64; 2]; 2],
    /// Static correction of the displacement \[m/(N s)\].
    pub static_correction: [[f64; 2]; 2],
    /// Velocity jump at n \[m/s/(N s)\].
    pub velocity_jump: [[f64; 2]; 2],
}

impl ImpulseResponse {
    /// Response to impulses on a diaphragm's node for contact steps of `h` \[s\].
    ///
    /// `contacts`: first output row and first input vector of each diaphragm's node; `loads`: first output row of each bearing load.
    pub fn new(
        interval: &IntervalModel,
        propagator: &Propagator,
        h: f64,
        (contacts, diaphragm): (&[[usize; 2]], usize),
        loads: &[usize],
    ) -> Self {
        let [row, input] = contacts[diaphragm];
        let input_vectors = [&interval.input_vectors[input], &interval.input_vectors[input + 1]];
        let states = input_vectors.map(|l| propagator.free(l));
        let planes = interval.blocks.len();
        let correction = [0, 1].map(|axis| {
            let mut y = vec![0.0; 2 * planes];
            for k in 0..planes {
                let e = propagator.free_block(k);
                let train = solve(&[1.0 - e[0], -e[1], -e[2], 1.0 - e[3]], [states[axis][k], states[axis][planes + k]]);
                let constant = solve(&interval.blocks[k], [input_vectors[axis][k], input_vectors[axis][planes + k]]);
                y[k] = -constant[0] / h - train[0];
                y[planes + k] = -constant[1] / h - train[1];
            }
            y
        });
        let pair_of_outputs = |first: usize, y: &[Vec<f64>; 2]| -> [[f64; 2]; 2] {
            [0, 1].map(|i| [dot(&interval.output_rows[first + i], &y[0]), dot(&interval.output_rows[first + i], &y[1])])
        };
        let jumps = input_vectors.map(Clone::clone);
        let coupling = |&[row, _]: &[usize; 2]| Coupling {
            displacement: pair_of_outputs(row, &states),
            static_correction: pair_of_outputs(row, &correction),
            velocity_jump: pair_of_outputs(row + 2, &jumps),
        };
        Self {
            at_diaphragms: contacts.iter().filter(|_| contacts.len() > 1).map(coupling).collect(),
            displacement: pair_of_outputs(row, &states),
            static_correction: pair_of_outputs(row, &correction),
            velocity_jump: pair_of_outputs(row + 2, &jumps),
            at_unbalances: (0..interval.outputs_of_impulses.len() / 2)
                .map(|s| pair_of_outputs(2 * s, &jumps))
                .collect(),
            loads: loads.iter().map(|&first| pair_of_outputs(first, &correction)).collect(),
            of_unbalances: interval.input_vectors.as_chunks::<2>().0[..interval.outputs_of_impulses.len() / 2]
                .iter()
                .map(|input_vectors| {
                    let states = input_vectors.each_ref().map(|l| propagator.free(l));
                    let outputs = states.each_ref().map(|y| outputs_of(interval, y));
                    [states, outputs]
                })
                .collect(),
            outputs: states.each_ref().map(|y| outputs_of(interval, y)),
            states,
        }
    }
}

/// All outputs of a modal state.
fn outputs_of(interval: &IntervalModel, y: &[f64]) -> Vec<f64> {
    let mut outputs = Vec::new();
    interval.output_matrix.multiply(y, &mut outputs);
    outputs
}

/// Solution `m^-1 v` of a 2 x 2 system.
fn solve(m: &PlaneBlock, v: [f64; 2]) -> [f64; 2] {
    let determinant = m[0] * m[3] - m[1] * m[2];
    [(m[3] * v[0] - m[1] * v[1]) / determinant, (m[0] * v[1] - m[2] * v[0]) / determinant]
}
