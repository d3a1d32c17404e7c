//! Gates: a probability must be below a bound with the required confidence.
//!
//! ```text
//! 0   the upper limit, bad runs harmful, is below the bound: passed
//! 4   the lower limit, bad runs harmless, is at or above it: failed
//! 5   neither: more points are needed, or bad runs prevent a decision
//! ```
//! Limits are one-sided and exact (C. J. Clopper, E. S. Pearson, 1934): the probability of a false pass, and of a false failure, is at most
//! 1 - confidence each. Every group has to pass; with several verdicts, 4 takes precedence over 5.

mod judge;
mod junit;
mod look;
mod require;

pub use judge::{Decision, GateError, Verdict, verdict};
pub use junit::junit;
pub use look::{FIRST_LOOK, MOST_POINTS, last_look};
pub use require::Gate;
