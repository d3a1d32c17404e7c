//! Internal moments and nominal stresses of shaft, ring and blades, recovered from displacements.
//!
//! Beam theory at the outer fibre: no notch or fillet factors, no residual or thermal stress, no centrifugal stress of the blades. Users
//! multiply by the stress concentration factors of their own geometry.

mod blades;
mod fibres;
mod force_average;
mod force_columns;
mod ring;
mod shaft;

pub(crate) use force_average::ForceAverage;
pub(crate) use ring::{Known, RingStresses};
pub use shaft::{LargestMoments, SectionModuli, ShaftStresses, equivalent_square};
