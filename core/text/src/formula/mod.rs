//! Formulas in study files: `cold_gap - growth`, `max_bearing_load_N > 1.2 MN and end_speed_rad_s < 50`.
//!
//! ```text
//! text --tokens--> words with positions --parse--> program for a stack machine --value--> number; true is 1, false is 0
//! ```
//! The language is our own: none of the maintained expression libraries reads `-2^2` as -4 and `2^3^2` as 512, supports units, reports
//! positions and computes identical bytes everywhere. Angles are in radians, as in SI units.

mod measure;
mod parse;
mod program;
#[cfg(test)]
mod tests;
mod token;

pub use measure::Measure;
pub use parse::{is_reserved, parse, parse_measured};
pub use program::{Function, Instruction, Kind, Program, call};

use std::ops::Range;

/// A mistake in a formula and its position.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct FormulaError {
    /// Byte range in the formula.
    pub place: Range<usize>,
    /// Description.
    pub message: String,
}
