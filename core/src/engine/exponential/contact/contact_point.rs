//! Places that may press in a step, and those that pressed in the last.

use super::broad_phase::GapMinimum;
use crate::contact::ContactForce;
use crate::contact::complementarity::Block;

/// A place that may press.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    /// At n+1, where the gap is to stay open, and at n, where the impulse acts.
    pub place: GapMinimum,
    pub acting: GapMinimum,
    /// Slot of the rows at n among those of the last step; `None` where they are its own.
    pub acts: Option<usize>,
    /// Slot of its own rows.
    pub slot: usize,
    /// What its own impulses do to gap and slip.
    pub own: Block,
    /// Gap and slip without impulses.
    pub start: [f64; 2],
    pub force: ContactForce,
}

/// A place that pressed in the last step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PressedPoint {
    /// At n now.
    pub place: GapMinimum,
    pub force: ContactForce,
    /// Slot of its rows.
    pub slot: usize,
}

/// Ring and rotor at an instant with the statics of the impulses that led there.
pub(crate) struct SettledRing {
    /// Of the ring's modes.
    pub amplitudes: Vec<f64>,
    /// Where it is pressed: angles \[rad\], and normal forces in polar axes \[N\].
    pub pressed: Vec<(f64, [f64; 2])>,
    /// The rotor's centre, in the stator's axes \[m\].
    pub rotor: [f64; 2],
}
