//! All calls of the orchestrator into the solver.

use bladeoff_core::engine::{self, StartError, TimeStep};
use bladeoff_core::modal::{self, Basis, BasisError, ModesError, ModesReport, SpeedModes, UnstableRange};
use bladeoff_core::record::{Follower, NoHistory};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_model::outcome::{Column, Outcome};
use bladeoff_text::document::units::format_digits;

/// Reason why the solver rejects a machine before the first step.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The matrices or modes of the machine cannot be computed.
    #[error("the model of the machine cannot be built")]
    Build(#[source] BasisError),
    /// The settings of the run do not fit the model.
    #[error("{}", start_in_words(.0))]
    Start(StartError),
    /// The whirl frequencies cannot be computed.
    #[error("the modes cannot be computed")]
    Modes(#[source] ModesError),
}

/// Message for a run that cannot start. A speed without a basis is given in the unit of all output, with the condition number if it has one; other
/// messages are those of the solver.
fn start_in_words(error: &StartError) -> String {
    let StartError::NoBasis { speed, condition, limit } = error else { return error.to_string() };
    let condition = condition.is_finite().then(|| format!(" (condition {condition:.1e}, at most {limit:.0e})"));
    format!(
        "the whirl modes at {} have no basis that the exponential engine can use{}. Two motions are nearly identical: \
         by cross stiffness on one side, or by very strong bearing damping. Use run.engine = \"reduced\"",
        format_digits(*speed, "rad/s", 4),
        condition.unwrap_or_default()
    )
}

/// The structure of a machine: matrices and modes.
///
/// # Errors
/// An eigenvalue problem failed.
pub fn build(machine: &Machine) -> Result<Structure, EngineError> {
    Structure::build(machine, None).map_err(EngineError::Build)
}

/// The structure of a machine with a frozen basis.
///
/// # Errors
/// The basis belongs to another structure.
pub fn build_with(machine: &Machine, basis: &Basis) -> Result<Structure, EngineError> {
    Structure::build(machine, Some(basis)).map_err(EngineError::Build)
}

/// Time step and its limit.
///
/// # Errors
/// The step is too large, or another setting of the run does not fit.
pub fn time_step(machine: &Machine, structure: &Structure) -> Result<TimeStep, EngineError> {
    TimeStep::new(machine, structure).map_err(EngineError::Start)
}

/// Sets the step that resolves the impacts of a run, so that an observer can be made for it. Unless the step is given, this simulates the run; the
/// observer then only receives the progress.
///
/// # Errors
/// The step is too large, or another setting of the run does not fit.
pub fn resolve_step(
    machine: &mut Machine,
    structure: &Structure,
    follower: &mut dyn Follower,
) -> Result<TimeStep, EngineError> {
    let time_step = engine::resolved_time_step(machine, structure, follower).map_err(EngineError::Start)?;
    if machine.run.engine == Engine::Exponential {
        machine.run.contact_step = Some(time_step.step);
    }
    Ok(time_step)
}

/// Simulates one transient.
///
/// # Errors
/// The step is too large, or another setting of the run does not fit.
pub fn simulate(machine: &Machine, structure: &Structure) -> Result<Outcome, EngineError> {
    engine::simulate(machine, structure, &mut NoHistory).map_err(EngineError::Start)
}

/// Simulates one transient with an observer.
///
/// # Errors
/// The step is too large, or the like.
pub fn simulate_watched(
    machine: &Machine,
    structure: &Structure,
    follower: &mut dyn Follower,
) -> Result<Outcome, EngineError> {
    engine::simulate(machine, structure, follower).map_err(EngineError::Start)
}

/// Checks whether a run can start: does everything that precedes its first step.
///
/// # Errors
/// The step is too large, the rotor begins inside the diaphragm, or another setting does not fit.
pub fn try_start(machine: &Machine, structure: &Structure) -> Result<(), EngineError> {
    let mut machine = machine.clone();
    machine.run.step_limit = Some(0);
    simulate(&machine, structure).map(drop)
}

/// Whirl modes, critical speeds and ring frequencies.
///
/// # Errors
/// An eigenvalue problem failed, or the modes cannot be followed.
pub fn modes(machine: &Machine, speeds: &[f64]) -> Result<ModesReport, EngineError> {
    modal::report(machine, speeds).map_err(EngineError::Modes)
}

/// Modes at speeds \[rad/s\], followed from rest by their mode shapes.
///
/// # Errors
/// An eigenvalue problem failed, or the modes cannot be followed.
pub fn followed_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<SpeedModes>, EngineError> {
    modal::followed_modes(machine, speeds).map_err(EngineError::Modes)
}

/// Ranges of speeds \[rad/s\] between two speeds in which a whirl mode is unstable.
///
/// # Errors
/// An eigenvalue problem failed.
pub fn unstable_speeds(
    machine: &Machine,
    structure: &Structure,
    speeds: [f64; 2],
) -> Result<Vec<UnstableRange>, EngineError> {
    engine::unstable_speeds(machine, structure, speeds).map_err(|error| EngineError::Modes(error.into()))
}

/// The numeric columns of a machine's outcome.
#[must_use]
pub fn columns(machine: &Machine) -> Vec<Column> {
    bladeoff_core::record::columns(machine)
}

/// Index of the number of steps among an outcome's values.
#[must_use]
pub fn place_of_steps(machine: &Machine) -> usize {
    bladeoff_core::record::place_of_steps(machine)
}

/// Word for the contact detection that all diaphragms use; `None` without a diaphragm, or if they use different ones.
#[must_use]
pub fn detection(machine: &Machine) -> Option<&'static str> {
    let mut words = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.detection.word());
    let first = words.next()?;
    words.all(|word| word == first).then_some(first)
}
