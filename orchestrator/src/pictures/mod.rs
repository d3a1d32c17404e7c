//! Modes of a machine as pictures: what the solver knows of it, in the lines and rings that `bladeoff_answers::figures` draws.
//!
//! ```text
//! machine, modes -> a function of campbell, response, shapes -> points with captions -> figures -> Figure
//! ```
//! Which lines there are is decided here; how they look, there.

mod campbell;
mod response;
mod shapes;

pub use campbell::{campbell, campbell_speeds};
pub use response::unbalance_response;
pub use shapes::{ring_shapes, rotor_shapes};
