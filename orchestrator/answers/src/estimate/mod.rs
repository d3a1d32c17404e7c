//! Estimates for studies with random points, with intervals that suit the design.
//!
//! ```text
//! columns in sample order --known--> per row: a truth or a value, or bounds (bad runs)
//!   --proportion, quantile, mean, difference--> figures with bad runs harmless and harmful, an interval
//!   --exceedance, fragility--> curves of such figures
//! ```
//! No row is dropped: a bad run (failed, invalid, quarantined, beyond the model) has bounds instead of values, and every figure is given for both bounds.

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
