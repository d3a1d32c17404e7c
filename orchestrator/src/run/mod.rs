//! One study from its validated form to the result directory, or from where an earlier run left it.
//!
//! ```text
//! basis (frozen or new) -> lock -> record: new, continued or taken over -> inputs, plan
//!   -> workers through dispatch -> ledger -> tables, manifest
//! ```

mod budget;
mod change;
mod checksums;
mod columns;
pub mod directory;
mod events;
mod interrupt;
mod kept;
mod lock;
mod manifest;
pub mod order;
mod parts;
mod prepare;
mod provenance;
pub mod rehearsal;
mod resume;
mod reuse;
mod sink;
mod stamp;
mod status;
mod tables;
mod trust;
mod upkeep;
mod work;

pub use change::Change;
pub use checksums::{Verified, refuse_changed, refuse_changed_timings, verify};
pub use columns::own_columns;
pub use directory::STATUS;
pub use kept::Lost;
pub use lock::{Holder, Keeper, LockError, Look, look};
pub use resume::Rerun;
pub use status::{RunState, Seen, TRUST, go_on, see};
pub use trust::Untrusted;

use crate::dispatch::{self, DispatchOptions, DispatchReport, Domain, Ended};
use crate::engine::EngineError;
use crate::ledger::LedgerError;
use crate::report::{Progress, Tally};
use bladeoff_answers::report::{are, counted};
use bladeoff_answers::tables::{TableError, start_threads};
use bladeoff_model::document::Problems;
use bladeoff_study::Samples;
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::folder::Folder;
use bladeoff_worker::fault::{At, Faults, Who};
use bladeoff_worker::plan::PlanFileError;
use bladeoff_worker::process::build_id;
use directory::{LEDGER, LOCK, MANIFEST, PARTS, RESULTS, RunDirectory, TIMINGS, WORKER_LOG, row_files};
use events::EventStream;
use kept::Guard;
use manifest::{Checksums, Course, manifest};
use prepare::Prepared;
use resume::Opened;
use sink::{LedgerSink, ProgressObserver, Watched};
use status::StatusWriter;
use std::cell::RefCell;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant, SystemTime};

pub use budget::Budget;
pub use events::EVENTS_VERSION;

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// Result directory; a run that is there is continued.
    pub out: PathBuf,
    /// Work there even if others could write in it.
    pub trusts: bool,
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
    /// The table, or the folder of the parts of one that is incomplete; `None` before there is a row.
    pub table: Option<PathBuf>,
}

/// Why a study could not be run to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The directory holds something else.
    #[error("{path:?} is not a result directory: it holds {file:?} and no record of a run; choose another --out")]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// The first file that no run begins with.
        file: OsString,
    },
    /// Others could write in the directory.
    #[error(transparent)]
    Untrusted(#[from] Untrusted),
    /// The directory was taken from the run.
    #[error(transparent)]
    Lost(#[from] Lost),
    /// A file stands where the directory should be.
    #[error("{path:?} is not a directory; choose another --out")]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// The directory was computed with another study or machine.
    #[error(
        "{} was computed with another study: {lost} of its {} {} not in this one\n{}\n\
         A study that only grows (more points, a larger --limit or run.step_limit, other [limits]) is continued. For this \
         one choose another --out, or remove the directory",
        path.display(),
        counted(*total, "finished sample"),
        are(*lost),
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
    /// Whether the directory is there and may not be written.
    fn is_write_protection(&self) -> bool {
        let (Self::File(error) | Self::Lock(LockError::File(error))) = self else { return false };
        matches!(error.source.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
    }

    /// Whether the run was refused before anything of it was done: the same command will not do better.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Foreign { .. }
                | Self::Untrusted(_)
                | Self::NotADirectory { .. }
                | Self::Changed { .. }
                | Self::NothingToRerun { .. }
                | Self::Lock(LockError::Held { .. } | LockError::Theirs { .. })
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
    let events = request.json_events.then(|| EventStream::start(std::io::stdout())).transpose();
    let events =
        events.map_err(|source| dispatch::DispatchError::System { doing: "starting the thread for events", source })?;
    let watched = Rc::new(RefCell::new(Watched { events, ..Watched::default() }));
    let result = open_and_compute(request, samples, note, &watched);
    if let Some(events) = watched.borrow_mut().events.take() {
        match &result {
            Ok(done) => {
                let table = done.table.as_deref().unwrap_or(Path::new("")).to_string_lossy();
                events.finished(done.ended, done.tally.done(), samples.count(), &table);
            }
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
    start_threads()?;
    let new_basis = if request.out.exists() { None } else { Some(prepare::new_basis(samples)?) };
    dispatch::preflight(request.workers)?;
    let directory = match RunDirectory::claim(&request.out, request.trusts) {
        Err(error) if error.is_write_protection() => return look_only(request, samples, note, error),
        claimed => claimed?,
    };
    if let Some(holder) = directory.left_by() {
        note(&format!("the last run here ({holder}) did not end in order; going on from its record"));
    }
    let basis = new_basis.map_or_else(|| prepare::frozen_basis(samples, directory.open(), note), Ok)?;
    let prepared = Prepared::new(samples, basis)?;
    let again = |suspects| resume::Again { rerun: request.rerun.as_ref(), suspects };
    let mut compared = resume::compare(directory.open(), &prepared, again(true))?;
    if request.budget.is_exceeded(compared.failed()) {
        // Nothing will be computed: then nothing is taken out to be tried.
        compared = resume::compare(directory.open(), &prepared, again(false))?;
    }
    compared.notes().iter().for_each(|text| note(text));
    if tables::is_current(&request.out, RESULTS, &prepared.provenance)
        && let Some((record, tally)) = compared.complete(&prepared)
    {
        note("every sample is there already: nothing is computed");
        upkeep::put_in_order(request, &directory, &prepared, (record, tally), note)?;
        return Ok(Finished::nothing_computed(&request.out, tally));
    }
    if compared.complete(&prepared).is_some() && refuse_changed(directory.path()).is_err() {
        note(&format!("{RESULTS} is damaged: it is made again from the record"));
    }
    let opened = compared.go_on(&directory, &prepared)?;
    opened.notes.iter().for_each(|text| note(text));
    let reused = opened.tally.done();
    if reused > 0 {
        note(&format!(
            "{reused} of {} {} there already, {} {} computed",
            counted(samples.count(), "sample"),
            are(reused),
            opened.todo.total(),
            are(opened.todo.total())
        ));
    }
    // A table of what was there would look like that of the whole.
    directory.remove(RESULTS)?;
    directory.remove(TIMINGS)?;
    compute(request, &directory, &prepared, opened, watched)
}

/// What can be said of a directory that cannot be written: nothing has to be when everything is there. `error`: of writing.
fn look_only(request: &Request, samples: &Samples, note: &dyn Fn(&str), error: RunError) -> Result<Finished, RunError> {
    let look = || -> Result<Option<Finished>, RunError> {
        let folder = Folder::open(&request.out).map_err(FileError::at("open", &request.out))?;
        let held = match look(&folder, LOCK)? {
            Look::Held(by) => Some(by),
            Look::Closed { by: Some(by), .. } => Some(Keeper::Process(by)),
            Look::Closed { .. } | Look::Abandoned(_) | Look::Free => None,
        };
        if let Some(by) = held {
            return Err(LockError::Held { directory: request.out.clone(), by }.into());
        }
        if !folder.place(LEDGER).exists() {
            return Ok(None);
        }
        let prepared = Prepared::new(samples, prepare::frozen_basis(samples, &folder, note)?)?;
        let again = resume::Again { rerun: request.rerun.as_ref(), suspects: false };
        let compared = resume::compare(&folder, &prepared, again)?;
        if tables::is_current(&request.out, RESULTS, &prepared.provenance)
            && let Some((_, tally)) = compared.complete(&prepared)
        {
            if let Err(damage) = refuse_changed(&request.out) {
                note(&damage.to_string());
                return Ok(None);
            }
            note(
                "every sample is there already: nothing is computed (the directory cannot be written, and need not be)",
            );
            return Ok(Some(Finished::nothing_computed(&request.out, tally)));
        }
        note(&format!(
            "{} of {} {} there already; the rest cannot be computed here",
            compared.done(),
            counted(samples.count(), "sample"),
            are(compared.done())
        ));
        Ok(None)
    };
    match look() {
        Ok(Some(finished)) => Ok(finished),
        Err(refused) if refused.is_refusal() => Err(refused),
        Ok(None) | Err(_) => Err(error),
    }
}

/// Has the rest computed and writes the tables; whatever happens, the status tells of it.
fn compute(
    request: &Request,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    opened: Opened,
    watched: &Rc<RefCell<Watched>>,
) -> Result<Finished, RunError> {
    let samples = prepared.samples;
    let reused = opened.tally.done();
    let durable = Rc::new(RefCell::new(opened.tally.clone()));
    let mut observer = ProgressObserver {
        progress: Progress::start(samples.count(), reused, Instant::now()),
        status: StatusWriter::new(directory.open(), samples, reused).trusting(request.trusts),
        tally: Rc::new(RefCell::new(opened.tally.clone())),
        durable: Rc::clone(&durable),
        watched: Rc::clone(watched),
    };
    observer.status.begin(&durable.borrow());
    let computed = compute_watched(request, directory, prepared, opened, &mut observer);
    let tally = durable.borrow().clone();
    match &computed {
        Ok((report, _)) => observer.status.finish(report.ended.word(), None, &tally),
        Err(error) => observer.status.finish("failed", Some(error), &tally),
    }
    let (report, table) = computed?;
    Ok(Finished { tally, reused, ended: report.ended, table })
}

fn compute_watched(
    request: &Request,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    opened: Opened,
    observer: &mut ProgressObserver,
) -> Result<(DispatchReport, Option<PathBuf>), RunError> {
    let samples = prepared.samples;
    let Opened { mut ledger, todo, tally, .. } = opened;
    let (reused, failed_before) = (tally.done(), tally.failed());
    let started = SystemTime::now();
    let course = |state, finished, done, deaths, dropped| Course {
        state,
        started,
        finished,
        done,
        reused,
        worker_deaths: deaths,
        dropped_messages: dropped,
        tables: Checksums::default(),
    };
    let manifest = |course: &Course<'_>| manifest(request, samples, &prepared.provenance, course);
    let write_manifest = |course: &Course<'_>| write_whole(directory.file(MANIFEST), manifest(course).as_bytes());
    write_manifest(&course("running", None, reused, 0, 0))?;

    let mut options = DispatchOptions::new(
        request.workers,
        dispatch::self_command()?,
        directory.path().to_path_buf(),
        prepared.plan_hash.clone(),
    );
    // Another build may compute other numbers.
    options.build = Some(build_id());
    request.budget.apply(failed_before, &mut options);
    options.keys = true;
    if observer.progress.is_on_terminal() && io::stdin().is_terminal() {
        observer.progress.note("s and Enter: what each worker does; Ctrl-C: ends in order");
    }
    options.worker_log = directory.file(WORKER_LOG);
    if let Some(events) = &mut observer.watched.borrow_mut().events {
        let directory = directory.path().to_string_lossy();
        events.started(&samples.study().name, &directory, samples.count(), reused, request.workers);
    }
    let record = ledger.reader().clone();
    let faults = Faults::from_environment(Who::Orchestrator).map_err(dispatch::DispatchError::from)?;
    let there = if reused > 0 && todo.total() > 0 { Some(record.state()?) } else { None };
    let place = (directory, prepared, &record);
    // Shared memory is given back when everything is written: nothing about it is a matter of the results.
    let mut memory = None;
    let ((report, committed), parts) = parts::kept(request.refresh, place, there, &faults, |parts| {
        let mut sink = LedgerSink {
            ledger: &mut ledger,
            keys: &prepared.keys,
            tally: Rc::clone(&observer.tally),
            durable: Rc::clone(&observer.durable),
            watched: Rc::clone(&observer.watched),
            gathered: Vec::new(),
            parts,
            guard: Guard::new(directory),
        };
        let report = if todo.total() > 0 && request.budget.is_exceeded(failed_before) {
            Ok(DispatchReport::nothing(Ended::TooManyFailures))
        } else {
            dispatch::run_keeping(&options, samples, order::shuffled(todo), &mut sink, observer, &mut memory)
        };
        let committed = sink.close();
        observer.progress.clear();
        if let Ok(report) = &report {
            let memory = memory.as_ref().map(|domain: &Domain| domain.address().clone());
            interrupt::end_at_once_when_told(matches!(report.ended, Ended::Signalled(_)), &faults, memory);
        }
        if observer.durable.borrow().done() < samples.count() {
            parts.write_rest();
        }
        (report, committed)
    })?;
    // Taken but not recorded is computed again: it does not count.
    let durable = observer.durable.borrow().clone();
    observer.progress.finish(&durable, Instant::now());
    let finish = || {
        let report = report?;
        // After a failure the first error is the one that says why.
        committed?;
        let (table, tables) = if durable.done() == samples.count() {
            let tables = tables::write_tables(directory, prepared, &record)?;
            faults.reached(At::Retiring, 0, None);
            directory.remove_parts()?;
            (Some(directory.file(RESULTS).to_path_buf()), tables)
        } else {
            parts?;
            let has_rows = !row_files(directory.path()).is_empty();
            (has_rows.then(|| directory.file(PARTS).to_path_buf()), Checksums::default())
        };
        let (state, finished) = (report.ended.word(), Some(SystemTime::now()));
        let course = course(state, finished, durable.done(), report.worker_deaths, report.dropped_messages);
        write_manifest(&Course { tables, ..course })?;
        Ok((report, table))
    };
    let lost = |loss| {
        let manifest = manifest(&course("failed", Some(SystemTime::now()), durable.done(), 0, 0));
        RunError::from(kept::keep(loss, directory, prepared, &ledger, &durable, &manifest))
    };
    let finished = match kept::loss(directory, &ledger) {
        Some(loss) => Err(lost(loss)),
        // It may be lost while the tables are written.
        None => finish().map_err(|error| match kept::loss(directory, &ledger) {
            Some(loss) => lost(loss),
            None if kept::is_closed(directory) => {
                let (path, done) = (directory.path().to_path_buf(), durable.done());
                Lost::Closed { path, done, source: Box::new(error) }.into()
            }
            None => error,
        }),
    };
    dispatch::give_back(memory, observer);
    finished
}

impl Finished {
    /// Of a directory in which everything is.
    fn nothing_computed(directory: &Path, tally: &Tally) -> Self {
        let (tally, table) = (tally.clone(), Some(directory.join(RESULTS)));
        Self { reused: tally.done(), tally, ended: Ended::Complete, table }
    }
}
