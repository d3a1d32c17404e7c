//! Figures of the modes of a machine, drawn with the lines and circles of `bladeoff_answers::figures`.
//!
//! ```text
//! machine, modes -> a function of campbell, response, shapes -> points with captions -> figures -> Figure
//! ```
//! This module determines the lines of a figure; `bladeoff_answers::figures` determines their appearance.

mod campbell;
mod response;
mod shapes;

pub use campbell::{campbell, campbell_speeds};
pub use response::unbalance_response;
pub use shapes::{ring_shapes, rotor_shapes};
