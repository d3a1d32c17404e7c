//! How far a node of the rotor can come during a step, whatever its whirl states do.
//!
//! ```text
//! x = sum over pairs of rows y,   y' = B y + l f,   |y'| <= D = |B| g (|y| + h |l| f) + |l| f,   g = exp(h max(0, mu(B)))
//! |x(t) - x - t x'|  <=  sum over pairs of |rows| [ |B| D min(h^2/2, 2h/|B|) + |l| f W h^2 ],    0 <= t <= h              (1)
//! |x + t x'|  <=  max(|x|, |x + h x'|)
//! ```
//! mu(B) is the largest eigenvalue of the symmetric part of a block, its logarithmic norm, which bounds its exponential (Dahlquist 1958); f the unbalances'
//! forces with a margin for the change of spin and twist in the step, in which they change by `2 W t f` at most: they turn with W, and as much again is left for twist and braking.
//! (1) is a bound, not an estimate: a rotor that moves away, or along its ring, may fly on where its velocity alone would not let it.
//! It is linear in |y| and f: one list of weights for each length of step, which a cell makes once.
//! Verified by `the_bound_of_the_way_is_one`.

use super::interval_model::IntervalModel;
use crate::linalg::lanes::{Lane, kernel, lanes_of, sum};

/// What the unbalances' forces may grow by in a step.
const GROWING: f64 = 1.05;

/// (1) of a cell's node for steps of one length.
#[derive(Debug, Clone)]
pub(crate) struct DisplacementBound {
    /// Per |y| of each pair.
    amplitudes: Vec<Lane>,
    /// Per f of each unbalance, and per W f.
    forces: Vec<[f64; 2]>,
    /// Of the weight as it stands.
    weight: f64,
}

impl DisplacementBound {
    /// Of the node whose rows begin at a place, in a cell under so many unbalances, for steps of `h` \[s\].
    pub fn new(cell: &IntervalModel, row: usize, unbalances: usize, h: f64) -> Self {
        let pairs = cell.blocks.len();
        let of = |v: &[f64], k: usize| length([v[k], v[pairs + k]]);
        let mut amplitudes = vec![0.0; pairs];
        let (mut forces, mut weight) = (vec![[0.0; 2]; unbalances], 0.0);
        for (k, b) in cell.blocks.iter().enumerate() {
            let rows = length([of(&cell.output_rows[row], k), of(&cell.output_rows[row + 1], k)]);
            let block = b.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            let growth = 0.5 * (b[0] + b[3]) + length([0.5 * (b[0] - b[3]), 0.5 * (b[1] + b[2])]);
            let grown = if growth > 0.0 { libm::exp(h * growth) } else { 1.0 };
            let way = rows * block * (0.5 * h * h).min(2.0 * h / block);
            amplitudes[k] = way * block * grown;
            let pushed = way * (block * grown * h + 1.0);
            for (s, force) in forces.iter_mut().enumerate() {
                let push = GROWING * length([of(&cell.input_vectors[2 * s], k), of(&cell.input_vectors[2 * s + 1], k)]);
                force[0] += push * pushed;
                force[1] += push * rows * h * h;
            }
            weight += pushed * of(&cell.input_vectors[2 * unbalances], k);
        }
        Self { amplitudes: lanes_of(&amplitudes), forces, weight }
    }

    /// (1) at a spin, of the amplitudes of all pairs under unbalances of these forces at n \[N\].
    pub fn max_deviation(&self, amplitudes: &[Lane], forces: &[f64], spin: f64) -> f64 {
        let pushed = self.forces.iter().zip(forces).map(|([way, turned], f)| (way + spin.abs() * turned) * f);
        weighted(&self.amplitudes, amplitudes) + pushed.sum::<f64>() + self.weight
    }
}

kernel! {
    /// Sum of products.
    pub(crate) fn weighted(weights: &[Lane], sizes: &[Lane]) -> f64 {
        let mut sums = Lane::default();
        for (weight, size) in weights.iter().zip(sizes) {
            for k in 0..sums.0.len() {
                sums.0[k] += weight.0[k] * size.0[k];
            }
        }
        sum(sums.0)
    }
}

/// Length of a vector: one root, the same on every machine.
#[inline(always)]
pub(crate) fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}
