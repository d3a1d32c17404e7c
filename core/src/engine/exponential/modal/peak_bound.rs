//! Peak bound: how far a bearing load or a displacement may exceed, between the two ends of a step, its values at the ends.
//!
//! ```text
//! v = sum over planes of O y + constant,   w' = v' - W (e_z x v)        rate of v in axes that rotate with the spin; |v| is the same in them       (1)
//! beyond the chord        at most  sum over planes |w'| min((|B| + W) h^2/8, 2/w_k),     w_k = |B|/sqrt(2) - W, where positive                  (2)
//! beyond the value at n   at most  sum over planes |w'| min(h, 2/w_k)                                                                             (3)
//! ```
//! `v`: watched quantity (two components along u and v); `O`, `y`, `B`: output rows, modal state and block of a plane, `|B|` the Frobenius norm; `h`: length of the step \[s\].
//!
//! A motion leaves its chord by h^2/8 times its second derivative at most, and an oscillating one by twice its amplitude. A step is as long as one of two conditions holds: (2) is below a
//! thousandth of the largest value so far, or v with (3) stays below that value. The step may miss this much of a peak. A quantity that rotates with the unbalance has no w' and does not shorten the step.
//! Limit: w' is that at n. Verified by `peaks_of_free_motion_are_those_of_contact_steps` (`tests/exponential/exponential_rub.rs`).

use super::displacement_bound::weighted;
use super::interval_model::IntervalModel;
use crate::engine::exponential::plane::length;
use bladeoff_numerics::linalg::lanes::{Lane, lanes_of};

/// Share of the largest value so far by which a peak may be missed.
const MISSED_SHARE: f64 = 1e-3;

/// Weights of (2) and (3) in one speed interval, for steps of one length.
#[derive(Debug, Clone)]
pub(crate) struct PeakBound {
    /// Length of the step \[s\].
    h: f64,
    /// W \[rad/s\].
    spin: f64,
    /// Weights of |w'| in (2), per plane.
    chord_weights: Vec<Lane>,
    /// Weights of |w'| in (3), per plane.
    value_weights: Vec<Lane>,
}

/// Watched quantity v with two components: a bearing load \[N\] or a displacement \[m\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct WatchedPeak {
    /// Length of its constant part.
    constant: f64,
    /// |v|^2 at n.
    square: f64,
    /// Largest |v|^2 at all instants so far.
    largest: f64,
    /// Square of the limit whose first exceedance is located to a contact step; infinite without a limit.
    limit: f64,
    /// Whether the run ends at the first exceedance.
    ends: bool,
    /// Whether the peaks of this quantity limit the step.
    pub limits_step: bool,
}

impl WatchedPeak {
    /// Watched quantity with this constant part, before the first value.
    pub fn new(constant: [f64; 2]) -> Self {
        Self {
            constant: length(constant),
            square: 0.0,
            largest: 0.0,
            limit: f64::INFINITY,
            ends: false,
            limits_step: true,
        }
    }

    /// Replaces the constant part.
    pub fn set_constant(&mut self, constant: [f64; 2]) {
        self.constant = length(constant);
    }

    /// Adds a limit whose first exceedance is to be located to a contact step; `ends`: the run ends there.
    pub fn limited(self, limit: f64, ends: bool) -> Self {
        Self { limit: limit * limit, ends, ..self }
    }

    /// Square of the largest value so far.
    pub fn largest_square(&self) -> f64 {
        self.largest
    }

    /// Records the value at n.
    pub fn update(&mut self, [x, y]: [f64; 2]) {
        self.square = x * x + y * y;
        if self.square > self.largest {
            self.largest = self.square;
        }
    }
}

impl PeakBound {
    /// Bound for steps of `h` \[s\] in a speed interval.
    pub fn new(interval: &IntervalModel, h: f64) -> Self {
        let spin = interval.speed.abs();
        let weights = |weight: &dyn Fn(f64, f64) -> f64| -> Vec<Lane> {
            let block_norm = |b: &[f64; 4]| b.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            let plane_weight = |block_norm: f64| {
                weight(block_norm, 2.0 / (block_norm * std::f64::consts::FRAC_1_SQRT_2 - spin).max(1e-300))
            };
            lanes_of(&interval.blocks.iter().map(|b| plane_weight(block_norm(b))).collect::<Vec<f64>>())
        };
        Self {
            h,
            spin,
            chord_weights: weights(&|block_norm, oscillation| (0.125 * h * h * (block_norm + spin)).min(oscillation)),
            value_weights: weights(&|_, oscillation| oscillation.min(h)),
        }
    }

    /// Whether a step misses no peak of a watched quantity by more than the allowed share; `rates`: |w'| of each plane.
    pub fn is_resolved(&self, watched: &WatchedPeak, rates: &[Lane]) -> bool {
        let (h, constant_rate, largest) = (self.h, self.spin * watched.constant, watched.largest.sqrt());
        let largest_possible = || watched.square.sqrt() + weighted(&self.value_weights, rates) + h * constant_rate;
        // after the first exceedance of a limit there is no further one to locate
        let searched = watched.limit.is_finite() && (watched.ends || watched.largest <= watched.limit);
        if searched && largest_possible() > watched.limit.sqrt() {
            return false;
        }
        weighted(&self.chord_weights, rates) + 0.125 * h * h * self.spin * constant_rate <= MISSED_SHARE * largest
            || largest_possible() <= largest
    }
}
