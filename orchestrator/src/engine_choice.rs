//! Engine of `run.engine = "auto"` if the file alone does not determine it: the exponential engine cannot start the machine, or a result
//! directory has been begun.

use crate::engine::{self, EngineError};
use crate::start_check::{StartError as NoStart, check_starts};
use bladeoff_core::engine::StartError;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, EngineChoice, EngineReason, Machine, MachineDef};
use bladeoff_study::{Samples, Study};
use bladeoff_system::folder::Folder;
use bladeoff_text::document::units::format_digits;
use bladeoff_worker::job_spec::planned_engine;
use std::path::Path;

/// `reduced`, if `auto` chose the exponential engine and only that engine cannot start this machine; otherwise `None`.
#[must_use]
pub fn instead(choice: &EngineChoice, machine: &Machine, structure: &Structure) -> Option<EngineChoice> {
    if !may_be_another(choice) {
        return None;
    }
    let why = unable(&engine::try_start(machine, structure).err()?)?;
    Some(EngineChoice { engine: Engine::Reduced, reason: EngineReason::NoStart(why) })
}

/// Whether `auto` chose the exponential engine because the engine covers the model; not if a contact step requires it.
fn may_be_another(choice: &EngineChoice) -> bool {
    choice.is_auto() && choice.engine == Engine::Exponential && choice.reason == EngineReason::Covered
}

/// Reason why the exponential engine cannot start, if it does not apply to the other engines.
fn unable(error: &EngineError) -> Option<String> {
    match error {
        EngineError::Start(StartError::NotCovered { what }) => Some(format!("it does not cover {what}")),
        EngineError::Start(StartError::NoBasis { speed, .. }) => {
            Some(format!("the whirl modes at {} have no basis that it can use", format_digits(*speed, "rad/s", 4)))
        }
        _ => None,
    }
}

/// Settles the engine of a study by the starts that [`check_starts`] tries, for the whole study even if only a part is computed. If the
/// exponential engine cannot start one of them, all samples use the reduced engine. Returns whether all of the starts succeeded.
/// has all samples computed by the reduced one. Gives whether all of these have begun.
pub fn by_starts(samples: &mut Samples) -> bool {
    let Some(choice) = samples.study().engine().filter(|choice| may_be_another(choice)).cloned() else { return false };
    let machine = samples.study().machine().and_then(|machine| machine.def.build().ok());
    let alone = machine.and_then(|machine| instead(&choice, &machine, &engine::build(&machine).ok()?));
    if let Some(other) = alone {
        samples.settle(other);
        return false;
    }
    let checked = if samples.scale().is_none() && samples.limit().is_none() {
        check_starts(samples)
    } else {
        let Ok(whole) = Samples::new(samples.study().clone(), None, None) else { return false };
        check_starts(&whole)
    };
    match checked {
        Ok(()) => true,
        Err(NoStart::Start { shown, source }) => {
            if let Some(why) = unable(&source) {
                let reason = EngineReason::NoStart(format!("{why} in the run with {shown}"));
                samples.settle(EngineChoice { engine: Engine::Reduced, reason });
            }
            false
        }
        Err(_) => false,
    }
}

/// Settles the engine of a single machine. Returns the matrices and modes, and the engine if it was changed.
///
/// # Errors
/// A mode problem failed.
pub fn machine_alone(
    definition: &mut MachineDef,
    machine: &mut Machine,
) -> Result<(Structure, Option<EngineChoice>), EngineError> {
    let structure = engine::build(machine)?;
    let choice = definition.engine();
    match choice.as_ref().and_then(|choice| instead(choice, machine, &structure)) {
        Some(other) => {
            definition.settle(other.engine);
            machine.run.engine = other.engine;
            Ok((engine::build(machine)?, Some(other)))
        }
        None => Ok((structure, choice)),
    }
}

/// Settles a study to the engine of the plan that was frozen in its directory.
pub fn as_planned(study: &mut Study, directory: &Path) {
    if let Some(engine) = Folder::open(directory).ok().and_then(|folder| planned_engine(&folder)) {
        study.settle(EngineChoice { engine, reason: EngineReason::Begun });
    }
}
