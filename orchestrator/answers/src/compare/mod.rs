//! Compares two result tables: differences from A to B, and tolerances on them.
//!
//! ```text
//! heads --names--> inputs to match by, results in both, tolerances          every wrong name at once
//! inputs --side--> a key and a verdict of each row --matching--> pairs, rows without partner
//! results, some columns at a time --paired--> differences B - A, largest differences; --tolerance--> exceeded tolerances
//!                                 --apart--> of rows without partner: differences of means and quantiles
//!   --told--> words     (serde) --> JSON
//! ```
//! Rows match where all inputs are the same numbers (bit by bit; 0 and -0 are equal) and the same words. A row that is not ok has no value
//! to compare. If only one row of a pair is bad, or the causes differ, this is reported as a change of status, never as a difference of zero.
//!
//! An interval is given only where a whole study was drawn at random, as everywhere in this package ([`crate::estimate::scheme`]).

mod apart;
mod asked;
mod circle;
mod draw;
mod error;
mod found;
mod inputs;
mod load;
mod matching;
mod names;
mod notes;
mod paired;
mod side;
mod sources;
#[cfg(test)]
mod tests;
mod to_text;
mod tolerance;
mod whole;

pub use crate::ask::CONFIDENCE;
pub use asked::{Asked, Source};
pub use draw::Draw;
pub use error::CompareError;
pub use found::{
    Apart, Change, Compared, Difference, Differs, Inputs, Interval, Judged, Matched, Pair, PairChange, QuantileApart,
    SCHEMA, Sided, Statuses, WordChange,
};
pub use to_text::told;
pub use whole::compare;
