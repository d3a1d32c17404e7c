//! Formulas in study files: `cold_gap - growth`, `max_bearing_load_N > 1.2 MN and end_speed_rad_s < 50`.
//!
//! ```text
//! text --tokens--> words with places --parse--> program for a stack --value--> number; a truth is 1 or 0
//! ```
//! A small language of ours: of the kept expression libraries none reads `-2^2` as -4 and `2^3^2` as 512, knows units, gives places and
//! computes the same bytes everywhere. Angles are in radians, as all of SI here is.

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

/// What is wrong with a formula, and where in it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct FormulaError {
    /// Bytes of the formula.
    pub place: Range<usize>,
    /// In words.
    pub message: String,
}
