//! What a load, or the rotor's place, can be between two looks in flight beyond what it is at them.
//!
//! ```text
//! v = sum over pairs of r y + constant,   w' = v' - W (e_z x v)     its rate for one who turns with the spin: |v| is that of v as he sees it      (1)
//! beyond its chord   at most  sum over pairs |w'| min((|B| + W) h^2/8, 2/w_k)     w_k = |B|/sqrt(2) - W, where that is positive                  (2)
//! from what it is    at most  sum over pairs |w'| min(h, 2/w_k)                                                                                   (3)
//! ```
//! A motion leaves its chord by h^2/8 of its second derivative, and one that rings by twice its amplitude. A step of flight is as long as (2) is below a
//! thousandth of the largest value so far, or as v and (3) are below that value: so far a peak may be missed. What turns with the unbalance has no w' and shortens nothing.
//! Limits: w' is that at n. Verified by `peaks_in_flight_are_those_of_contact_steps` (`tests/exponential_rub.rs`).

use super::displacement_bound::{length, weighted};
use super::interval_model::IntervalModel;
use crate::linalg::lanes::{Lane, lanes_of};

/// Part of the largest value so far that may be missed.
const PART: f64 = 1e-3;

/// The parts of (2) and (3) that a cell fixes, for steps of one length.
#[derive(Debug, Clone)]
pub(crate) struct PeakBound {
    h: f64,
    /// W \[rad/s\].
    spin: f64,
    /// Weights of the pairs in (2) and (3).
    beyond: Vec<Lane>,
    from: Vec<Lane>,
}

/// A quantity at n: the size of its constant part, the square of its size, and the largest of all instants before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WatchedPeak {
    constant: f64,
    square: f64,
    largest: f64,
    /// Square of the value whose first excess is found to a contact step; infinite without one.
    limit: f64,
    /// The run ends there.
    ends: bool,
}

impl WatchedPeak {
    /// With this constant part, before anything is seen.
    pub fn new(constant: [f64; 2]) -> Self {
        Self { constant: length(constant), square: 0.0, largest: 0.0, limit: f64::INFINITY, ends: false }
    }

    /// Watch with a value whose first excess is to be found to a contact step; `ends`: the run ends there.
    pub fn limited(self, limit: f64, ends: bool) -> Self {
        Self { limit: limit * limit, ends, ..self }
    }

    /// Takes its value at n.
    pub fn update(&mut self, [x, y]: [f64; 2]) {
        self.square = x * x + y * y;
        self.largest = self.largest.max(self.square);
    }
}

impl PeakBound {
    /// For steps of `h` \[s\] in a cell.
    pub fn new(cell: &IntervalModel, h: f64) -> Self {
        let spin = cell.speed.abs();
        let weights = |of: &dyn Fn(f64, f64) -> f64| -> Vec<Lane> {
            let block = |b: &[f64; 4]| b.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            let pair = |block: f64| of(block, 2.0 / (block * std::f64::consts::FRAC_1_SQRT_2 - spin).max(1e-300));
            lanes_of(&cell.blocks.iter().map(|b| pair(block(b))).collect::<Vec<f64>>())
        };
        Self {
            h,
            spin,
            beyond: weights(&|block, twice| (0.125 * h * h * (block + spin)).min(twice)),
            from: weights(&|_, twice| twice.min(h)),
        }
    }

    /// Whether no peak of a quantity is missed, of which |w'| of each pair is given.
    pub fn is_resolved(&self, watched: &WatchedPeak, in_turn: &[Lane]) -> bool {
        let (h, still, largest) = (self.h, self.spin * watched.constant, watched.largest.sqrt());
        let most = || watched.square.sqrt() + weighted(&self.from, in_turn) + h * still;
        // one that has exceeded its limit has no first excess left to find
        let searched = watched.limit.is_finite() && (watched.ends || watched.largest <= watched.limit);
        if searched && most() > watched.limit.sqrt() {
            return false;
        }
        weighted(&self.beyond, in_turn) + 0.125 * h * h * self.spin * still <= PART * largest || most() <= largest
    }
}
