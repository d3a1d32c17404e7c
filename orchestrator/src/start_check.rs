//! Detection of runs that cannot start (a step beyond the stability limit, a rotor that begins inside its diaphragm) before the study
//! begins.
//!
//! The solver runs up to its first step, for every sample of a small study, and for corners and edges of a larger one. Other runs that
//! cannot start get the status failed in their rows.

use crate::engine::{self, EngineError};
use crate::terminal::with_word;
use bladeoff_answers::summary::counted;
use bladeoff_core::engine::StartError as NoStart;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{CONTACT_STEP, Machine, MachineDef, STEP};
use bladeoff_study::{Chosen, Samples, at_its_axis};
use bladeoff_system::threads::in_parallel;
use bladeoff_text::document::Problems;
use bladeoff_text::document::units::format_digits;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Largest number of runs that are started.
const MOST_STARTS: u64 = 300;
/// Largest number of structures that are built; samples that share a structure need no further one.
const MOST_STRUCTURES: usize = 16;

/// Reason why the samples of a study cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// A machine that cannot be built, or whose rotor begins outside its ring.
    #[error(transparent)]
    Machine(#[from] Problems),
    /// A sample whose run cannot start.
    #[error("the run with {shown} cannot start")]
    Start {
        /// Values of the varied parameters of the sample.
        shown: String,
        /// Error of the solver.
        #[source]
        source: EngineError,
    },
    /// Samples whose tables would have different columns.
    #[error("the run with {shown} has result columns that differ from those of the first: {column}")]
    Columns {
        /// Values of the varied parameters of the sample.
        shown: String,
        /// The first column that only one of the samples has.
        column: String,
    },
}

/// Starts runs of the study, each up to its first step.
///
/// # Errors
/// The first run that cannot start, or that has different result columns.
pub fn check_starts(samples: &Samples) -> Result<(), StartError> {
    let built = AtomicUsize::new(0);
    let what = || match built.load(Ordering::Relaxed) {
        0 => "checking that runs can start, which takes matrices and modes".to_owned(),
        built => format!("checking that runs can start, with {} computed", counted(built as u64, "structure")),
    };
    with_word(what, || start_all(samples, &built))
}

/// A run to be started, with the index of its structure.
struct Candidate {
    definition: MachineDef,
    machine: Machine,
    shown: String,
    structure: usize,
}

fn start_all(samples: &Samples, built: &AtomicUsize) -> Result<(), StartError> {
    let mut structures = Vec::new();
    let mut listed = Vec::new();
    // runs listed before an error come first, whatever the error is
    let whole = list(samples, built, &mut structures, &mut listed);
    let refused = |one: &Candidate| {
        let error = engine::try_start(&one.machine, &structures[one.structure]).err()?;
        Some(refusal(samples, (&one.definition, &one.machine, &one.shown), error))
    };
    let first = || listed.par_iter().find_map_first(refused);
    let found = in_parallel(first).unwrap_or_else(|_| listed.iter().find_map(refused));
    found.map_or(whole, Err)
}

/// Lists the runs to be started and builds their structures, up to the first run without a structure.
fn list(
    samples: &Samples,
    built: &AtomicUsize,
    structures: &mut Vec<Structure>,
    listed: &mut Vec<Candidate>,
) -> Result<(), StartError> {
    let mut columns = None;
    for (definition, shown) in candidates(samples) {
        let machine = definition.build()?;
        let mut own = engine::columns(&machine);
        // samples may differ in the columns their machines lack: a twin run, a detection
        own.iter_mut().for_each(|column| column.lacks = None);
        let first = columns.get_or_insert_with(|| own.clone());
        if *first != own {
            let differing = first.iter().chain(&own).find(|column| !(first.contains(column) && own.contains(column)));
            let column = differing.map_or_else(String::new, |column| column.name.clone());
            return Err(StartError::Columns { shown, column });
        }
        let structure = match structures.iter().position(|structure| structure.fits(&machine)) {
            Some(at) => at,
            None if structures.len() == MOST_STRUCTURES => continue,
            None => {
                let failed = |error| refusal(samples, (&definition, &machine, &shown), error);
                structures.push(engine::build(&machine).map_err(failed)?);
                built.store(structures.len(), Ordering::Relaxed);
                structures.len() - 1
            }
        };
        listed.push(Candidate { definition, machine, shown, structure });
    }
    Ok(())
}

/// Error for a sample that cannot start: reported as a problem of one of its values, if possible.
fn refusal(
    samples: &Samples,
    (definition, machine, shown): (&MachineDef, &Machine, &String),
    source: EngineError,
) -> StartError {
    let varies = !samples.parameters().is_empty();
    let is_varied = |path: &str| samples.parameters().iter().any(|varied| varied.info.path == path);
    match placed(&source, definition, machine, is_varied) {
        Some(problems) => StartError::Machine(at_its_axis(samples, with(problems, varies.then_some(shown)))),
        None => StartError::Start { shown: shown.clone(), source },
    }
}

/// Adds the sample that cannot start to the messages.
fn with(mut problems: Problems, shown: Option<&String>) -> Problems {
    if let Some(shown) = shown {
        problems
            .list
            .iter_mut()
            .for_each(|problem| problem.message.push_str(&format!("; the run with {shown} cannot start")));
    }
    problems
}

/// Reports a step that is too large as a problem of its value, and a rotor that begins inside its diaphragm as a problem of the value that
/// places it there: of a varied value, if one of them is varied.
#[must_use]
pub fn placed(
    error: &EngineError,
    definition: &MachineDef,
    machine: &Machine,
    is_varied: impl Fn(&str) -> bool,
) -> Option<Problems> {
    let EngineError::Start(refusal) = error else { return None };
    let step = match refusal {
        NoStart::StepTooLarge { .. } => Some(STEP),
        NoStart::ContactStepTooLarge { .. } => Some(CONTACT_STEP),
        _ => None,
    };
    if let Some(path) = step {
        let allowed = format!("at most the largest allowed step; without {path} the program chooses the step");
        return Some(definition.refused(path, refusal.to_string(), allowed));
    }
    let (NoStart::StartsInContact { diaphragm, .. } | NoStart::StartsOutside { diaphragm, .. }) = refusal else {
        return None;
    };
    let contact = &machine.diaphragms.iter().find(|known| known.name == *diaphragm)?.contact;
    let largest = |vector: [f64; 2]| usize::from(vector[1].abs() > vector[0].abs());
    let displacement = machine.rotor.initial.displacement;
    // A displacement larger than the gap is the error; otherwise all of them together may be.
    let beyond = |vector: [f64; 2]| vector[0].hypot(vector[1]) >= contact.gap;
    let gap = format!("diaphragms.{diaphragm}.contact.gap");
    let offset = format!("diaphragms.{diaphragm}.contact.offset[{}]", largest(contact.offset));
    let start = format!("rotor.initial.displacement[{}]", largest(displacement));
    let path = match [&gap, &offset, &start].into_iter().find(|path| is_varied(path)) {
        Some(varied) => varied,
        None if beyond(contact.offset) => &offset,
        None if beyond(displacement) => &start,
        None => &gap,
    };
    let off = match *refusal {
        NoStart::StartsOutside { eccentricity, .. } => eccentricity,
        NoStart::StartsInContact { gap, .. } => contact.gap - gap,
        _ => return None,
    };
    let metres = |value: f64| format_digits(value, "m", 4);
    let allowed = format!(
        "at t = 0 the centres of rotor and ring closer than the gap of {}; they are {} apart (contact.offset ({}, {}), \
         rotor.initial.displacement ({}, {}), and what gravity and unbalances bend)",
        metres(contact.gap),
        metres(off),
        metres(contact.offset[0]),
        metres(contact.offset[1]),
        metres(displacement[0]),
        metres(displacement[1])
    );
    Some(definition.refused(path, refusal.to_string(), allowed))
}

fn candidates(samples: &Samples) -> Vec<(MachineDef, String)> {
    if samples.count() <= MOST_STARTS {
        return (0..samples.count()).map(|sample| (samples.machine(sample), samples.describe(sample))).collect();
    }
    let chosen = Chosen::new(samples, MOST_STARTS);
    // the corners are last: surplus samples along the first axes are dropped
    let begin = chosen.count().saturating_sub(MOST_STARTS);
    (begin..chosen.count()).map(|at| (chosen.machine(at), chosen.describe(at))).collect()
}
