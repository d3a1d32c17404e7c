//! When a study is precise enough, as a pure function of its rows: whoever looks, and how often, finds the same end.
//!
//! ```text
//! [stop]   half_width, relative   what the interval of every question in every group is to come down to
//!          samples                points that are not exceeded
//! look k = 0, 1, ...   at the first 256 2^k points, at level alpha/2^(k+1); the last at the end of the design or at `samples`, at what
//!                      is left of alpha: all levels together are alpha, so all intervals of all looks hold with 1 - alpha
//! ```
//! The first look whose intervals are narrow enough decides; the table ends there, whatever was computed beyond. Between looks nothing
//! is decided, so the end depends neither on which run finished first nor on when somebody looked.

mod forecast;
mod look;
mod rule;

pub use forecast::{expected, half_width};
pub use look::{Look, looks};
pub use rule::{Precision, StopRule};
