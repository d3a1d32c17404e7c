//! Choice of the engine for a machine.

use super::exponential::{self, ExponentialError, StepSettings};
use super::run;
use super::time_step::{StartError, TimeStep};
use crate::record::{End, Follower, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};

/// Runs a machine with its engine from start to end: recorded quantities, and the end of the run.
///
/// # Errors
/// [`StartError`] for a run that cannot be started.
pub(super) fn run(
    machine: &Machine,
    structure: &Structure,
    plan: &TimeStep,
    follower: &mut dyn Follower,
) -> Result<(Recorders, End), StartError> {
    match machine.run.engine {
        Engine::Reduced | Engine::Full => run::run(machine, structure, plan, follower),
        Engine::Exponential => {
            let settings = StepSettings::of_step(plan.step);
            exponential::run(machine, structure, settings, follower).map_err(refused)
        }
    }
}

fn refused(error: ExponentialError) -> StartError {
    match error {
        ExponentialError::Start(error) => error,
        ExponentialError::Eigen(error) => StartError::Eigen(error),
        ExponentialError::Singular { part } => StartError::Singular { what: "mass", part },
        ExponentialError::NotCovered { what } => StartError::NotCovered { what },
        ExponentialError::IllConditioned { speed, condition, limit } => StartError::NoBasis { speed, condition, limit },
        ExponentialError::NotInvariant { speed } | ExponentialError::NoBasis { speed } => {
            StartError::NoBasis { speed, condition: f64::INFINITY, limit: exponential::MOST_CONDITION }
        }
        ExponentialError::StaticCompliance { diaphragm, found, expected } => {
            StartError::StaticCompliance { diaphragm, found, expected }
        }
        ExponentialError::NoImpulses => StartError::NotCovered { what: "contact at t = 0" },
    }
}
