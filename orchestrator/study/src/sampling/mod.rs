//! The samples of a study, before their values are computed.
//!
//! ```text
//! [[vary]]     combinations   axis lengths, --scale, --limit -> a position on each axis, by number
//! [design]     layout         index -> a coordinate in (0, 1) for each uncertain parameter
//! sequence       the point sequences used by layouts
//! ```

pub mod combinations;
pub mod layout;
pub mod sequence;
mod shuffle;

pub use shuffle::Shuffle;
