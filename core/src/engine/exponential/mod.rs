//! The exponential engine: exact propagation of modal states, free steps of 2^k contact steps, contact by impulses.
//!
//! ```text
//! observe  <-  stepping  <-  contact  <-  torsion  <-  modal          each room uses only those to its right
//! ```
//! - `modal`: the lateral motion. The gyroscopic system in first-order form is transformed to its whirl modes at the speeds of a grid; between two grid speeds the modal matrices are
//!   interpolated over speed. A step is then a 2 x 2 matrix per whirl mode, exact for a constant speed.
//! - `torsion`: the spin, from its angular momentum, and the torsional modes, in closed form. Their angle turns the unbalances.
//! - `contact`: the ring's modes, the search for the places where the gap may close, and the impulses that keep it open, with Coulomb friction.
//! - `stepping`: a step is free, of 2^k contact steps, as long as bounds exclude contact and missed peaks; otherwise it is a contact step.
//! - `observe`: the loop of a run, and what is recorded of it. It never changes the motion.
//!
//! Theory, measurements and limits: docs/theory/08-exponential-engine.md. Terms: docs/glossary.md.

mod contact;
mod error;
mod modal;
mod observe;
mod plane;
mod settings;
mod stepping;
mod torsion;

/// Revision of the results of this engine, raised with every change of a bit of these results. It is part of the identity of
/// the machines that this engine computes, and so of the keys of their samples.
pub const EXPONENTIAL_REVISION: u8 = 22;

pub use error::ExponentialError;
pub use settings::StepSettings;
pub use stepping::free_motion::FreeMotion;
pub use stepping::rubbing_run::{RubbingRun, rubbing_run};
pub use stepping::shared_model::same_bases;

pub(super) use modal::grid_spacing::GridSpacing;
pub(super) use modal::modal_basis::MOST_CONDITION;
pub(super) use observe::run::run;
