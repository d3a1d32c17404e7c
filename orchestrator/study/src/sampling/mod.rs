//! Which samples a study consists of, before any of them has values.
//!
//! ```text
//! [[vary]]     combinations   axis lengths, --scale, --limit -> a position on each axis, by number
//! [design]     layout         index -> a coordinate in (0, 1) for each uncertain parameter
//!              sequence       the points that layouts are made of
//! ```

pub mod combinations;
pub mod layout;
pub mod sequence;
mod shuffle;

pub use shuffle::Shuffle;
