//! Engines that simulate one blade-off from release to end: the full and the reduced engine, which advance step by step, and
//! the [`exponential`] engine.
//!
//! Main path: [`simulate`] determines a stable step (`time_step`) that resolves the impacts (`impact_resolution`), and the machine's engine runs it (`choice`). A `run` of the full or the reduced
//! engine starts from its `beginning` and repeats: predict without contact, correct with contact, record, advance (`motion`). The moving parts are
//! the `shaft_line` and each ring with its contact, a `rub`. [`crate::record`] records quantities of the run; `bearing_loads` and `works` compute
//! loads and energies for it.
//!
//! Scheme: central differences with forward-increment Lagrange multipliers (paper, section 3; docs/theory/04-time-integration.md). Non-linear terms
//! are centred and iterated, over finite elements or over modes ([`crate::structure`]).

mod bearing_loads;
mod beginning;
mod choice;
mod damping;
pub mod exponential;
mod impact_resolution;
mod motion;
mod predictor;
mod release;
mod rub;
mod run;
mod shaft_line;
mod stability;
mod time_step;
mod together;
mod torques;
mod twin;
mod works;

pub use damping::{UnresolvedDamping, unresolved_damping};
pub use impact_resolution::resolved_time_step;
pub use stability::{speeds_of_run, unstable_speeds};
pub use time_step::{LEAST_STEP, StartError, TimeStep};

use crate::record::Follower;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Outcome;
use impact_resolution::Resolved;

/// Simulates one run, and its twin if `run.twin` requests one. The follower observes only the first run, but may end both.
///
/// A run whose impacts are shorter than its default step resolves is repeated with a finer one ([`resolved_time_step`]).
///
/// `structure` must fit the machine ([`Structure::fits`]). Failures of the simulation (divergence, loss of uniqueness, step
/// limit) are outcomes with a cause, not errors.
///
/// # Errors
/// [`StartError`] for a run that cannot be started.
pub fn simulate(machine: &Machine, structure: &Structure, follower: &mut dyn Follower) -> Result<Outcome, StartError> {
    let Resolved { plan, recorders, end } = impact_resolution::run(machine, structure, follower)?;
    let twin = twin::of(&recorders, &end, machine, structure, &plan, follower);
    Ok(recorders.outcome(machine, structure, &end, twin.as_ref()))
}
