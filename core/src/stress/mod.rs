//! Internal moments and nominal stresses of shaft and blades, recovered from displacements.
//!
//! Beam theory at the outer fibre: no notch or fillet factors, no residual or thermal stress, no blade centrifugal stress.
//! A user multiplies by the stress concentration factor of his own geometry.

mod blades;
mod shaft;

pub use blades::BladeStresses;
pub use shaft::{SectionModuli, ShaftStresses};
