//! Figures of a study whose points are random, with intervals that are proper to its design.
//!
//! ```text
//! columns in sample order --known--> per row: a truth or a value, as far as it is known (bad runs: bounds)
//!   --proportion, quantile, mean, difference--> figures with bad runs harmless and harmful, an interval
//!   --exceedance, fragility--> curves of such figures
//! ```
//! No row drops out: a bad run (failed, invalid, quarantined, beyond the model) has bounds instead of values, and every figure is given for both ends.

pub mod along;
pub mod bad;
pub mod curve;
pub mod difference;
pub mod exceedance;
pub mod figures;
pub mod formula;
pub mod fragility;
pub mod input;
pub mod known;
pub mod limits;
pub mod mean;
pub mod order;
pub mod proportion;
pub mod quantile;
pub mod reach;
pub mod scheme;
pub mod span;
pub mod truth;
pub mod undecided;
