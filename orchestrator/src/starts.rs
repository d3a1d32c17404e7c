//! Runs that cannot start (a step beyond the stability limit, a rotor that begins inside its diaphragm) are found before
//! the study does.
//!
//! The solver is asked up to its first step, for every sample of a small study, for the corners and edges of a larger
//! one. What that misses ends in its row with status failed.

use crate::engine::{self, EngineError};
use bladeoff_core::structure::Structure;
use bladeoff_model::document::Problems;
use bladeoff_model::machine::MachineDef;
use bladeoff_study::{Chosen, Samples};

/// Most runs that are started.
const MOST_STARTS: u64 = 300;
/// Most structures that are built for it: samples that share one cost nothing more.
const MOST_STRUCTURES: usize = 16;

/// Why the samples of a study cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// A machine that cannot be built.
    #[error(transparent)]
    Machine(#[from] Problems),
    /// A sample whose run cannot start.
    #[error("the run with {shown} cannot start")]
    Start {
        /// What varies in it.
        shown: String,
        /// Why.
        #[source]
        source: EngineError,
    },
    /// Samples whose tables would have different columns.
    #[error("the run with {shown} has other result columns than the first: {column}")]
    Columns {
        /// What varies in it.
        shown: String,
        /// The first column that only one of them has.
        column: String,
    },
}

/// Starts runs of the study, each up to its first step.
///
/// # Errors
/// The first run that cannot start, or whose result would have other columns.
pub fn check_starts(samples: &Samples) -> Result<(), StartError> {
    let mut structures: Vec<Structure> = Vec::new();
    let mut columns = None;
    for (definition, shown) in candidates(samples) {
        let machine = definition.build()?;
        let own = engine::columns(&machine);
        let first = columns.get_or_insert_with(|| own.clone());
        if *first != own {
            let differing = first.iter().chain(&own).find(|column| !(first.contains(column) && own.contains(column)));
            let column = differing.map_or_else(String::new, |column| column.name.clone());
            return Err(StartError::Columns { shown, column });
        }
        let failed = |source| StartError::Start { shown: shown.clone(), source };
        let at = match structures.iter().position(|structure| structure.fits(&machine)) {
            Some(at) => at,
            None if structures.len() == MOST_STRUCTURES => continue,
            None => {
                structures.push(engine::build(&machine).map_err(failed)?);
                structures.len() - 1
            }
        };
        engine::try_start(&machine, &structures[at]).map_err(failed)?;
    }
    Ok(())
}

fn candidates(samples: &Samples) -> Vec<(MachineDef, String)> {
    if samples.count() <= MOST_STARTS {
        return (0..samples.count()).map(|sample| (samples.machine(sample), samples.describe(sample))).collect();
    }
    let chosen = Chosen::new(samples);
    // The corners stand at the end: a surplus is taken from the values along the first axes.
    let begin = chosen.count().saturating_sub(MOST_STARTS);
    (begin..chosen.count()).map(|at| (chosen.machine(at), chosen.describe(at))).collect()
}
