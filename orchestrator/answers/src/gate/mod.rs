//! A gate: whether a probability is below a bound for certain enough.
//!
//! ```text
//! 0   the upper limit, bad runs harmful, is below the bound: passed
//! 4   the lower limit, bad runs harmless, is at or above it: failed
//! 5   neither: more points would decide, or bad runs prevent it
//! ```
//! Limits are one-sided and exact (C. J. Clopper, E. S. Pearson, 1934): a gate that passes though the probability is at or above the
//! bound, or fails though it is below, does so with at most 1 - confidence each. Every group has to pass; of several, 4 goes before 5.

mod judge;
mod junit;
mod look;
mod require;

pub use judge::{Decision, GateError, Verdict, verdict};
pub use junit::junit;
pub use look::{FIRST_LOOK, MOST_POINTS, last_look};
pub use require::Gate;
