//! The calls into the solver, in one place.

use bladeoff_core::engine::{self, StartError, TimeStep};
use bladeoff_core::modal::{self, Basis, BasisError, ModesError, ModesReport, SpeedModes, UnstableRange};
use bladeoff_core::record::{Follower, NoHistory};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_model::outcome::{Column, Outcome};
use bladeoff_text::document::units::format_digits;

/// Why the solver refuses a machine before the first step.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// Matrices or modes.
    #[error("the model of the machine cannot be built")]
    Build(#[source] BasisError),
    /// The run's settings do not fit the model.
    #[error("{}", start_in_words(.0))]
    Start(StartError),
    /// Whirl frequencies.
    #[error("the modes cannot be computed")]
    Modes(#[source] ModesError),
}

/// A speed without a basis in the unit of all output, and its condition where it has one; all else as the solver says it.
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
/// A mode problem failed.
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
/// The step is too large, or the like.
pub fn time_step(machine: &Machine, structure: &Structure) -> Result<TimeStep, EngineError> {
    TimeStep::new(machine, structure).map_err(EngineError::Start)
}

/// Sets the step that resolves the impacts of a run, so that a follower can be made for it. Simulates the run, unless its step is given; the follower
/// only sees how far that is.
///
/// # Errors
/// The step is too large, or the like.
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

/// One transient.
///
/// # Errors
/// The step is too large, or the like.
pub fn simulate(machine: &Machine, structure: &Structure) -> Result<Outcome, EngineError> {
    engine::simulate(machine, structure, &mut NoHistory).map_err(EngineError::Start)
}

/// One transient, followed.
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

/// Whether a run can start: everything before its first step.
///
/// # Errors
/// The step is too large, the rotor begins inside the diaphragm, or the like.
pub fn try_start(machine: &Machine, structure: &Structure) -> Result<(), EngineError> {
    let mut machine = machine.clone();
    machine.run.step_limit = Some(0);
    simulate(&machine, structure).map(drop)
}

/// Whirl, critical speeds and ring frequencies.
///
/// # Errors
/// An eigenvalue problem failed, or the modes cannot be followed.
pub fn modes(machine: &Machine, speeds: &[f64]) -> Result<ModesReport, EngineError> {
    modal::report(machine, speeds).map_err(EngineError::Modes)
}

/// Modes at speeds \[rad/s\], followed from rest by their shapes.
///
/// # Errors
/// An eigenvalue problem failed, or the modes cannot be followed.
pub fn followed_modes(machine: &Machine, speeds: &[f64]) -> Result<Vec<SpeedModes>, EngineError> {
    modal::followed_modes(machine, speeds).map_err(EngineError::Modes)
}

/// Ranges of speeds \[rad/s\] in which a whirl mode is unstable, between two speeds.
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

/// Which of an outcome's values is its number of steps.
#[must_use]
pub fn place_of_steps(machine: &Machine) -> usize {
    bladeoff_core::record::place_of_steps(machine)
}

/// Word of the contact detection that all diaphragms have; `None` without one, or where they differ.
#[must_use]
pub fn detection(machine: &Machine) -> Option<&'static str> {
    let mut words = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.detection.word());
    let first = words.next()?;
    words.all(|word| word == first).then_some(first)
}
