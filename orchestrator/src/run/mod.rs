//! One study from its validated form to the result directory, or from where an earlier run left it.
//!
//! ```text
//! basis (frozen or new) -> lock -> record: new, continued or taken over -> inputs, plan
//!   -> workers through dispatch -> ledger -> tables, manifest
//! ```

mod budget;
mod change;
pub mod directory;
mod events;
mod interrupt;
mod keys;
mod lock;
mod manifest;
pub mod order;
mod parts;
mod prepare;
mod provenance;
pub mod rehearsal;
mod resume;
mod sink;
mod status;
mod tables;

pub use change::Change;
pub use keys::SampleKeys;
pub use lock::{Holder, LockError, Look, look};
pub use resume::Rerun;
pub use status::{RunState, STATUS, Seen, go_on, see};

use crate::dispatch::{self, DispatchOptions, DispatchReport, Ended, Signal};
use crate::engine::EngineError;
use crate::files::{FileError, write_whole};
use crate::ledger::LedgerError;
use crate::report::{Progress, Tally};
use crate::results::TableError;
use crate::study::Samples;
use bladeoff_core::document::Problems;
use bladeoff_worker::fault::{At, Faults, Who};
use bladeoff_worker::plan::PlanFileError;
use bladeoff_worker::process::build_id;
use directory::{MANIFEST, PARTS, RESULTS, RunDirectory, TIMINGS};
use events::EventStream;
use manifest::{Course, manifest};
use prepare::Prepared;
use resume::Opened;
use sink::{LedgerSink, ProgressObserver, Watched};
use status::StatusWriter;
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Duration, Instant, SystemTime};

pub use budget::Budget;
pub use events::EVENTS_VERSION;

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// Result directory; a run that is there is continued.
    pub out: PathBuf,
    /// Worker processes.
    pub workers: usize,
    /// What it may take.
    pub budget: Budget,
    /// Say what happens on standard output, for programs.
    pub json_events: bool,
    /// Finished samples that are computed again.
    pub rerun: Option<Rerun>,
    /// Time between two parts of finished rows; zero: only when there are many.
    pub refresh: Duration,
}

/// How a study ended.
#[derive(Debug)]
pub struct Finished {
    /// Counts of the samples, those that were there before included.
    pub tally: Tally,
    /// Samples that were there before.
    pub reused: u64,
    /// Why it ended.
    pub ended: Ended,
    /// The table, or the folder of the parts of one that is incomplete.
    pub table: PathBuf,
}

/// Why a study could not be run to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The directory holds something else.
    #[error(
        "{} is not a result directory: it holds {file} and no record of a run; choose another --out",
        path.display()
    )]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// The first file that no run begins with.
        file: String,
    },
    /// A file stands where the directory should be.
    #[error("{} is not a directory; choose another --out", path.display())]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// The directory was computed with another study or machine.
    #[error(
        "{} was computed with another study: {lost} of its {total} finished samples are not in this one\n{}\n\
         A study that only grows (more points, a larger --limit, other [limits]) is continued. For this one choose \
         another --out, or remove the directory",
        path.display(),
        changes.iter().map(|change| format!("  {change}")).collect::<Vec<_>>().join("\n")
    )]
    Changed {
        /// The directory.
        path: PathBuf,
        /// Finished samples that the present study does not have.
        lost: u64,
        /// Finished samples.
        total: u64,
        /// What differs.
        changes: Vec<Change>,
    },
    /// There is no run whose samples could be computed again.
    #[error("{} has no finished samples to be computed again", path.display())]
    NothingToRerun {
        /// The directory.
        path: PathBuf,
    },
    /// Another run works in the directory, or that cannot be found out.
    #[error(transparent)]
    Lock(#[from] LockError),
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

impl RunError {
    /// Whether the run was refused before anything of it was done: the same command will not do better.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Foreign { .. }
                | Self::NotADirectory { .. }
                | Self::Changed { .. }
                | Self::NothingToRerun { .. }
                | Self::Lock(LockError::Held { .. })
                | Self::Ledger(LedgerError::Version { .. })
                | Self::Machine(_)
                | Self::Engine(_)
        )
    }
}

/// Runs the samples that have no result yet and writes the result directory. `note` is told what the user should know;
/// progress goes to standard error.
///
/// # Errors
/// See [`RunError`]; what was finished before is in the directory's ledger.
pub fn run(request: &Request, samples: &Samples, note: &dyn Fn(&str)) -> Result<Finished, RunError> {
    let events = if request.json_events { EventStream::start(std::io::stdout()) } else { None };
    let watched = Rc::new(RefCell::new(Watched { events, ..Watched::default() }));
    let result = open_and_compute(request, samples, note, &watched);
    if let Some(events) = watched.borrow_mut().events.take() {
        match &result {
            Ok(done) => events.finished(done.ended, done.tally.done(), samples.count(), &done.table.to_string_lossy()),
            Err(error) => events.failed(error),
        }
    }
    result
}

fn open_and_compute(
    request: &Request,
    samples: &Samples,
    note: &dyn Fn(&str),
    watched: &Rc<RefCell<Watched>>,
) -> Result<Finished, RunError> {
    // Whatever can be refused is refused before the directory is made.
    let new_basis = if request.out.exists() { None } else { Some(prepare::new_basis(samples)?) };
    dispatch::preflight(request.workers)?;
    let directory = RunDirectory::claim(&request.out)?;
    if let Some(holder) = directory.left_by() {
        note(&format!("the last run here ({holder}) did not end in order; going on from its record"));
    }
    let basis = new_basis.map_or_else(|| prepare::frozen_basis(samples, &directory), Ok)?;
    let prepared = Prepared::new(samples, basis)?;
    let opened = resume::open(&directory, &prepared, request.rerun.as_ref())?;
    opened.notes.iter().for_each(|text| note(text));
    let reused = opened.tally.done();
    if opened.todo.left() == 0 && tables::is_current(&directory, RESULTS, &prepared.provenance) {
        note("every sample is there already: nothing is computed");
        directory.remove_parts()?;
        let (tally, table) = (opened.tally, directory.file(RESULTS));
        return Ok(Finished { tally, reused, ended: Ended::Complete, table });
    }
    if reused > 0 {
        note(&format!(
            "{reused} of {} samples are there already, {} are computed",
            samples.count(),
            opened.todo.left()
        ));
    }
    // A table of what was there would look like that of the whole.
    directory.remove(RESULTS)?;
    directory.remove(TIMINGS)?;
    compute(request, &directory, &prepared, opened, watched)
}

/// Has the rest computed and writes the tables.
fn compute(
    request: &Request,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    opened: Opened,
    watched: &Rc<RefCell<Watched>>,
) -> Result<Finished, RunError> {
    let samples = prepared.samples;
    let Opened { mut ledger, todo, tally, .. } = opened;
    let reused = tally.done();
    let started = SystemTime::now();
    let course = |state, finished, done, deaths, dropped| Course {
        state,
        started,
        finished,
        done,
        reused,
        worker_deaths: deaths,
        dropped_messages: dropped,
    };
    let write_manifest = |course: &Course<'_>| {
        write_whole(&directory.file(MANIFEST), manifest(request, samples, &prepared.provenance, course).as_bytes())
    };
    write_manifest(&course("running", None, reused, 0, 0))?;

    let tally = Rc::new(RefCell::new(tally));
    let mut options = DispatchOptions::new(
        request.workers,
        dispatch::self_command()?,
        directory.path().to_path_buf(),
        prepared.plan_hash.clone(),
    );
    // Another build may compute other numbers.
    options.build = Some(build_id());
    let failed_before = tally.borrow().failed();
    request.budget.apply(failed_before, &mut options);
    options.keys = true;
    let mut observer = ProgressObserver {
        progress: Progress::start(samples.count(), reused, Instant::now()),
        status: StatusWriter::new(directory.path(), samples, reused),
        tally: Rc::clone(&tally),
        watched: Rc::clone(watched),
    };
    if let Some(events) = &mut watched.borrow_mut().events {
        let directory = directory.path().to_string_lossy();
        events.started(&samples.study().name, &directory, samples.count(), reused, request.workers);
    }
    let record = ledger.reader().clone();
    let faults = Faults::from_environment(Who::Orchestrator).map_err(dispatch::DispatchError::from)?;
    let there = if reused > 0 && todo.left() > 0 { Some(record.state()?) } else { None };
    let durable = tally.borrow().clone();
    let place = (directory, prepared, &record);
    let ((report, committed, durable), parts) = parts::kept(request.refresh, place, there, &faults, |parts| {
        let mut sink = LedgerSink {
            ledger: &mut ledger,
            keys: &prepared.keys,
            tally: Rc::clone(&tally),
            durable,
            watched: Rc::clone(watched),
            gathered: Vec::new(),
            parts,
        };
        let report = if todo.left() > 0 && request.budget.is_exceeded(failed_before) {
            Ok(DispatchReport::nothing(Ended::TooManyFailures))
        } else {
            dispatch::run(&options, samples, order::shuffled(todo), &mut sink, &mut observer)
        };
        let (committed, durable) = sink.close();
        if let Ok(report) = &report {
            interrupt::end_at_once_when_told(matches!(report.ended, Ended::Signalled(_)), &faults);
        }
        if durable.done() < samples.count() {
            parts.write_rest();
        }
        (report, committed, durable)
    });
    // Taken but not recorded is computed again: it does not count.
    let tally = durable;
    observer.progress.finish(&tally, Instant::now());
    let written = report.map_err(RunError::from).and_then(|report| {
        // After a failure the first error is the one that says why.
        committed?;
        let table = if tally.done() == samples.count() {
            let table = tables::write_tables(directory, prepared, &record)?;
            faults.reached(At::Retiring, 0, None);
            directory.remove_parts()?;
            table
        } else {
            parts?;
            directory.file(PARTS)
        };
        let (state, finished) = (state_word(&report), Some(SystemTime::now()));
        write_manifest(&course(state, finished, tally.done(), report.worker_deaths, report.dropped_messages))?;
        Ok((report, table))
    });
    match &written {
        Ok((report, _)) => observer.status.finish(state_word(report), None, &tally),
        Err(error) => observer.status.finish("failed", Some(&error.to_string()), &tally),
    }
    let (report, table) = written?;
    Ok(Finished { tally, reused, ended: report.ended, table })
}

fn state_word(report: &DispatchReport) -> &'static str {
    match report.ended {
        Ended::Complete => "complete",
        Ended::Signalled(Signal::Interrupt) => "interrupted",
        Ended::Signalled(Signal::Terminate) => "terminated",
        Ended::Wall | Ended::Until | Ended::TooManyFailures => "stopped",
    }
}
