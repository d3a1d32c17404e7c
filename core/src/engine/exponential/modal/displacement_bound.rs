//! Displacement bound: how far a node of the rotor may deviate, during a step, from a straight motion with its velocity at n.
//!
//! ```text
//! x = sum over planes of O y,   y' = B y + l f,   |y'| <= D = |B| g (|y| + h |l| f) + |l| f,   g = exp(h max(0, mu(B)))
//! |x(t) - x - t x'|  <=  sum over planes of |O| [ |B| D min(h^2/2, 2h/|B|) + |l| f W h^2 ],    0 <= t <= h              (1)
//! |x + t x'|  <=  max(|x|, |x + h x'|)
//! ```
//! `x`: displacement of the node \[m\]; `O`, `B`, `l`, `y`: output rows, block, input vector and modal state of a plane at n, `|B|` the Frobenius norm; `h`: length of the step \[s\];
//! `f`: forces of the unbalances \[N\], with a margin for the change of spin and torsion within the step. The forces rotate with W and change by `2 W t f` at most:
//! half of this is the rotation, as much again is left for torsion and braking.
//! `mu(B)`: logarithmic norm, the largest eigenvalue of the symmetric part of a block, which bounds its exponential (Dahlquist 1958).
//!
//! (1) is a rigorous bound, not an estimate. A rotor that moves away from its ring, or along it, may therefore take a long step where its speed alone would forbid it.
//! (1) is linear in |y| and f, so a speed interval computes one list of weights per step length, once.
//! Verified by `the_bound_of_the_way_is_one` (`stepping::transient`).

use super::interval_model::IntervalModel;
use crate::engine::exponential::plane::length;
use bladeoff_numerics::linalg::lanes::{Lane, kernel, lanes_of, sum};

/// Factor by which the forces of the unbalances may grow within a step.
const FORCE_GROWTH: f64 = 1.05;

/// Weights of (1) for one node in one speed interval, for steps of one length.
#[derive(Debug, Clone)]
pub(crate) struct DisplacementBound {
    /// Weight of |y| of each plane.
    amplitudes: Vec<Lane>,
    /// Weights of f and of W f for each unbalance.
    forces: Vec<[f64; 2]>,
    /// Contribution of the weight \[m\].
    weight: f64,
}

impl DisplacementBound {
    /// Bound for the node whose output rows begin at `row`, for steps of `h` \[s\].
    pub fn new(interval: &IntervalModel, row: usize, unbalances: usize, h: f64) -> Self {
        let planes = interval.blocks.len();
        let plane_norm = |v: &[f64], k: usize| length([v[k], v[planes + k]]);
        let mut amplitudes = vec![0.0; planes];
        let (mut forces, mut weight) = (vec![[0.0; 2]; unbalances], 0.0);
        for (k, b) in interval.blocks.iter().enumerate() {
            let row_norm =
                length([plane_norm(&interval.output_rows[row], k), plane_norm(&interval.output_rows[row + 1], k)]);
            let block_norm = b.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            let log_norm = 0.5 * (b[0] + b[3]) + length([0.5 * (b[0] - b[3]), 0.5 * (b[1] + b[2])]);
            let growth_factor = if log_norm > 0.0 { libm::exp(h * log_norm) } else { 1.0 };
            let acceleration_weight = row_norm * block_norm * (0.5 * h * h).min(2.0 * h / block_norm);
            amplitudes[k] = acceleration_weight * block_norm * growth_factor;
            let force_weight = acceleration_weight * (block_norm * growth_factor * h + 1.0);
            for (s, force) in forces.iter_mut().enumerate() {
                let input_norm = FORCE_GROWTH
                    * length([
                        plane_norm(&interval.input_vectors[2 * s], k),
                        plane_norm(&interval.input_vectors[2 * s + 1], k),
                    ]);
                force[0] += input_norm * force_weight;
                force[1] += input_norm * row_norm * h * h;
            }
            weight += force_weight * plane_norm(&interval.input_vectors[2 * unbalances], k);
        }
        Self { amplitudes: lanes_of(&amplitudes), forces, weight }
    }

    /// Largest deviation \[m\] by (1), from the amplitudes |y| of all planes and the forces of the unbalances at n \[N\], at a spin \[rad/s\].
    pub fn max_deviation(&self, amplitudes: &[Lane], forces: &[f64], spin: f64) -> f64 {
        let force_weight = self.forces.iter().zip(forces).map(|([acceleration_weight, rotation_weight], f)| {
            (acceleration_weight + spin.abs() * rotation_weight) * f
        });
        weighted(&self.amplitudes, amplitudes) + force_weight.sum::<f64>() + self.weight
    }
}

kernel! {
    /// Weighted sum of values.
    pub(crate) fn weighted(weights: &[Lane], values: &[Lane]) -> f64 {
        let mut sums = Lane::default();
        for (weight, value) in weights.iter().zip(values) {
            for k in 0..sums.0.len() {
                sums.0[k] += weight.0[k] * value.0[k];
            }
        }
        sum(sums.0)
    }
}
