//! One study from its validated form to the result directory.
//!
//! ```text
//! structure (basis) -> directory, frozen inputs, plan -> workers through dispatch -> ledger -> tables, manifest
//! ```

mod budget;
pub mod directory;
mod events;
mod interrupt;
mod manifest;
mod provenance;
mod sink;
mod tables;

use crate::dispatch::{self, DispatchOptions, Ended, Signal};
use crate::engine::{self, EngineError};
use crate::files::{FileError, write_whole};
use crate::ledger::{Ledger, LedgerError};
use crate::report::{Progress, Tally};
use crate::results::TableError;
use crate::study::Samples;
use bladeoff_core::document::Problems;
use bladeoff_worker::plan::PlanFileError;
use directory::{LEDGER, MANIFEST, RunDirectory};
use events::EventStream;
use manifest::{Course, manifest};
use sink::{LedgerSink, ProgressObserver, Watched};
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Instant, SystemTime};

pub use budget::Budget;
pub use events::EVENTS_VERSION;

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// Result directory; must not be there yet.
    pub out: PathBuf,
    /// Worker processes.
    pub workers: usize,
    /// What it may take.
    pub budget: Budget,
    /// Say what happens on standard output, for programs.
    pub json_events: bool,
}

/// How a study ended.
#[derive(Debug)]
pub struct Finished {
    /// Counts of the samples.
    pub tally: Tally,
    /// Why it ended.
    pub ended: Ended,
    /// The table.
    pub table: PathBuf,
}

/// Why a study could not be run to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The result directory is there already.
    #[error("{} is already there; a study is not continued or overwritten: choose another --out or remove it", path.display())]
    Exists {
        /// The directory.
        path: PathBuf,
    },
    /// The machine of the study.
    #[error(transparent)]
    Machine(#[from] Problems),
    /// The solver refused the machine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
    /// The record of finished samples.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// A table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The plan that workers read.
    #[error(transparent)]
    Plan(#[from] PlanFileError),
    /// Workers, shared memory, messages.
    #[error(transparent)]
    Dispatch(#[from] dispatch::DispatchError),
}

/// Runs the samples and writes the result directory. Progress goes to standard error.
///
/// # Errors
/// See [`RunError`]; what was finished before is in the directory's ledger.
pub fn run(request: &Request, samples: &Samples) -> Result<Finished, RunError> {
    let events = if request.json_events { EventStream::start(std::io::stdout()) } else { None };
    let watched = Rc::new(RefCell::new(Watched { events, ..Watched::default() }));
    let result = compute(request, samples, &watched);
    if let Some(events) = watched.borrow_mut().events.take() {
        match &result {
            Ok(done) => events.finished(done.ended, done.tally.done(), samples.count(), &done.table.to_string_lossy()),
            Err(error) => events.failed(error),
        }
    }
    result
}

fn compute(request: &Request, samples: &Samples, watched: &Rc<RefCell<Watched>>) -> Result<Finished, RunError> {
    // Whatever can be refused is refused before the directory is made.
    // The first sample stands for all: their columns are the same, and its basis serves whoever has its structure.
    let machine = samples.machine(0).build()?;
    let structure = engine::build(&machine)?;
    dispatch::preflight(request.workers)?;
    let plan = samples.plan(Some(structure.basis().to_bytes()));
    let directory = RunDirectory::create(&request.out, samples.study())?;
    let plan_hash = plan.write(directory.path())?;
    let provenance = provenance::provenance(samples, &plan_hash, plan.basis.as_deref());
    let mut ledger = Ledger::create(&directory.file(LEDGER), &provenance)?;

    let started = SystemTime::now();
    let course = |state, finished, done, deaths, dropped| Course {
        state,
        started,
        finished,
        done,
        worker_deaths: deaths,
        dropped_messages: dropped,
    };
    let write_manifest = |course: &Course<'_>| {
        write_whole(&directory.file(MANIFEST), manifest(request, samples, &provenance, course).as_bytes())
    };
    write_manifest(&course("running", None, 0, 0, 0))?;

    let tally = Rc::new(RefCell::new(Tally::default()));
    let mut options =
        DispatchOptions::new(request.workers, dispatch::self_command()?, directory.path().to_path_buf(), plan_hash);
    request.budget.apply(&mut options);
    options.keys = true;
    let mut observer = ProgressObserver {
        progress: Progress::start(samples.count(), Instant::now()),
        tally: Rc::clone(&tally),
        watched: Rc::clone(watched),
    };
    if let Some(events) = &mut watched.borrow_mut().events {
        let directory = directory.path().to_string_lossy();
        events.started(&samples.study().name, &directory, samples.count(), 0, request.workers);
    }
    let mut sink = LedgerSink { ledger: &mut ledger, tally: Rc::clone(&tally), watched: Rc::clone(watched) };
    let report = dispatch::run(&options, samples, samples.count(), &mut sink, &mut observer);
    let tally = tally.borrow().clone();
    observer.progress.finish(&tally, Instant::now());
    ledger.commit()?;
    let report = report?;
    interrupt::end_at_once_when_told(matches!(report.ended, Ended::Signalled(_)));

    let table = tables::write_tables(&directory, samples, &machine, &ledger, &provenance)?;
    let state = match report.ended {
        Ended::Complete => "complete",
        Ended::Signalled(Signal::Interrupt) => "interrupted",
        Ended::Signalled(Signal::Terminate) => "terminated",
        Ended::Wall | Ended::Until | Ended::TooManyFailures => "stopped",
    };
    let finished = Some(SystemTime::now());
    write_manifest(&course(state, finished, tally.done(), report.worker_deaths, report.dropped_messages))?;
    Ok(Finished { tally, ended: report.ended, table })
}
