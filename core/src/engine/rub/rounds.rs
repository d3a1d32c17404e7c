//! The rounds of a contact step.

use crate::engine::shaft_line::Increments;

/// Convergence of increments, relative.
pub(super) const TOLERANCE: f64 = 1e-11;
/// Rounds of a contact step before it counts as one without fixed point.
const CONTACT_ITERATIONS: usize = 40;
/// Rounds at most of one that still gains: the spin under an unbalance that outweighs its inertia takes as many without contact.
const MOST_ITERATIONS: usize = 600;
/// A round gains that changes less than this part of what the one before changed.
const GAIN: f64 = 0.98;

/// Counts the rounds of a contact step.
#[derive(Default)]
pub(super) struct Rounds {
    pub done: usize,
    last: f64,
}

impl Rounds {
    /// Whether another round is worth its while after one that changed the increments by so much.
    pub fn another(&mut self, change: f64) -> bool {
        self.done += 1;
        let gains = change < GAIN * self.last;
        self.last = change;
        self.done < CONTACT_ITERATIONS || gains && self.done < MOST_ITERATIONS
    }
}

/// What the rounds of all steps share.
#[derive(Default)]
pub(super) struct Work {
    /// Increments of the round.
    pub free: Increments,
    /// Rounds of the run.
    pub iterations: u64,
}
