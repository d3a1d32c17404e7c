//! Rounds of the iteration in a contact step.

use crate::engine::shaft_line::Increments;

/// Relative convergence tolerance of the increments.
pub(super) const TOLERANCE: f64 = 1e-11;
/// Number of rounds after which a contact step without further progress counts as one without fixed point.
const CONTACT_ITERATIONS: usize = 40;
/// Maximum number of rounds with progress. The spin under an unbalance that outweighs its inertia takes as many without contact.
const MOST_ITERATIONS: usize = 600;
/// Progress of a round: its change is below this fraction of the change in the previous round.
const GAIN: f64 = 0.98;

/// Counter of the rounds of a contact step.
#[derive(Default)]
pub(super) struct Rounds {
    /// Number of completed rounds.
    pub done: usize,
    /// Relative change of the increments in the last round.
    last: f64,
}

impl Rounds {
    /// Whether another round is worthwhile after a relative change of the increments by `change`.
    pub fn another(&mut self, change: f64) -> bool {
        self.done += 1;
        let gains = change < GAIN * self.last;
        self.last = change;
        self.done < CONTACT_ITERATIONS || gains && self.done < MOST_ITERATIONS
    }
}

/// Scratch and counter that the rounds of all steps share.
#[derive(Default)]
pub(super) struct Work {
    /// Increments of the round.
    pub free: Increments,
    /// Rounds of the run.
    pub iterations: u64,
}
