//! Quantities with units: "8 mm", "1500 rpm", "6.5e-4 kg m2", "600 N s/m" to SI and back.
//!
//! Our own small table: `uom` parses the first two spellings but not "8mm", "kg/m3", "N s/m" or "N/mm", and another crate that was tried
//! silently read "1500 rpm" as 25 1/s. Only units in the table are accepted; any other unit is an error with its name. A unit is never
//! inferred from the name of a key.

mod error;
mod format;
mod parse;
mod symbols;

pub use error::QuantityError;
pub use format::{format_digits, format_quantity};
pub use parse::{nearest_unit, parse_any_quantity, parse_bare_or_quantity, parse_quantity, unit_of};
pub use symbols::{Dimension, examples};
