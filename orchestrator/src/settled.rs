//! What `run.engine = "auto"` comes to where the file alone cannot say it: the exponential engine cannot start the machine, or a result directory has
//! been begun.

use crate::engine::{self, EngineError};
use bladeoff_core::engine::StartError;
use bladeoff_core::structure::Structure;
use bladeoff_model::document::units::format_digits;
use bladeoff_model::machine::{Engine, EngineChoice, EngineReason, Machine, MachineDef};
use bladeoff_study::{Samples, Study};
use bladeoff_system::folder::Folder;
use bladeoff_worker::plan::planned_engine;
use std::path::Path;

/// `reduced` instead of what `auto` came to, where that cannot start this machine; `None`: it can, or what keeps it keeps every engine.
#[must_use]
pub fn instead(choice: &EngineChoice, machine: &Machine, structure: &Structure) -> Option<EngineChoice> {
    // a contact step asks for it
    if choice.engine != Engine::Exponential || choice.reason != EngineReason::Covered {
        return None;
    }
    let why = match engine::try_start(machine, structure) {
        Err(EngineError::Start(StartError::NotCovered { what })) => format!("it does not cover {what}"),
        Err(EngineError::Start(StartError::NoBasis { speed, .. })) => {
            format!("the whirl states at {} have no basis that it can use", format_digits(speed, "rad/s", 4))
        }
        _ => return None,
    };
    Some(EngineChoice { engine: Engine::Reduced, reason: EngineReason::NoStart(why) })
}

/// Settles a study by the start of its machine without what varies, which is the same machine whatever part of the study is computed.
pub fn by_start(samples: &mut Samples) {
    let Some(choice) = samples.study().engine() else { return };
    let Some(machine) = samples.study().machine().and_then(|machine| machine.def.build().ok()) else { return };
    let structure = if choice.is_auto() { engine::build(&machine).ok() } else { None };
    let other = structure.and_then(|structure| instead(choice, &machine, &structure));
    if let Some(other) = other {
        samples.settle(other);
    }
}

/// The same of a machine alone; gives what it came to, with matrices and modes of an engine that can start.
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

/// Settles a study as it is frozen in a directory: by the engine that the plan there has.
pub fn as_planned(study: &mut Study, directory: &Path) {
    if let Some(engine) = Folder::open(directory).ok().and_then(|folder| planned_engine(&folder)) {
        study.settle(EngineChoice { engine, reason: EngineReason::Begun });
    }
}

/// Settles a study that is to go on in a directory of a program that had no choice yet: by `reduced`; whether that is another engine than it would have.
/// Every other one is compared with what the directory holds, and refused where it is another.
pub fn as_begun(samples: &mut Samples, directory: &Path) -> bool {
    let is_other = samples.study().engine().is_some_and(|choice| choice.is_auto() && choice.engine != Engine::Reduced);
    let planned = || Folder::open(directory).ok().and_then(|folder| planned_engine(&folder));
    if !is_other || planned() != Some(Engine::Reduced) {
        return false;
    }
    samples.settle(EngineChoice { engine: Engine::Reduced, reason: EngineReason::Begun });
    true
}
