//! Contact points: positions on the ring where impulses act in a contact step.

use super::gap_minimum::GapMinimum;
use crate::contact::ContactReaction;
use crate::contact::complementarity::Block;

/// Contact point of a step, with its conditions and its impulse.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    /// Position at n+1, whose gap is constrained.
    pub position: GapMinimum,
    /// Position at n, where the impulse acts: that of the last step for a point that pressed then, otherwise `position`.
    pub acting: GapMinimum,
    /// Slot of the rows of `acting` among those of the last step; `None` where they are the point's own.
    pub acting_slot: Option<usize>,
    /// Slot of the rows of `position`.
    pub slot: usize,
    /// Gap and slip at the point per normal and tangential impulse at it.
    pub self_coupling: Block,
    /// Gap at n+1 and slip over the step without impulses \[m\].
    pub free: [f64; 2],
    /// Normal and tangential impulse \[N s\].
    pub force: ContactReaction,
}

/// Contact point of the last step whose impulse was not zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PressedPoint {
    /// Position, now at n.
    pub position: GapMinimum,
    pub force: ContactReaction,
    /// Slot of its rows.
    pub slot: usize,
}
