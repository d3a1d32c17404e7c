//! One study from its validated form to the result directory, or from where an earlier run left it.
//!
//! ```text
//! open:     basis (frozen or new) -> lock -> record: new, continued or taken over -> inputs, plan
//! run:        -> workers through dispatch -> record, parts beside it
//! ending:       -> tables, manifest
//! ```
//! [`run`] shows the sequence; separate modules contain the request (`request`), the messages (`telling`) and the errors (`error`).

mod answer_sums;
mod change;
mod checksums;
mod chosen;
mod columns;
mod curves;
pub mod directory;
mod directory_lost;
mod end;
mod ending;
mod error;
mod event_table;
mod events;
mod interrupt;
mod lock;
mod manifest;
mod open;
pub mod order;
mod partial_tables;
mod prepare;
mod provenance;
mod questions;
mod refined;
pub mod rehearsal;
mod repair;
mod request;
mod rescued;
mod resume;
mod reuse;
pub mod shards;
mod sink;
mod so_far;
mod stages;
mod staging;
mod stamp;
mod status;
mod tables;
mod telling;
mod trust;
mod work;

pub(crate) use answer_sums::{are_kept, forget_sums, keep_sums};
pub use change::study_changes;
pub use checksums::{Verified, refuse_changed, refuse_changed_timings, verify};
pub use chosen::{Chosen, Refining, chosen_of_table};
pub use columns::{Availability, TableColumn, columns_of, columns_without, function_columns, own_columns};
#[cfg(test)]
pub(crate) use curves::forget_answers;
pub(crate) use curves::{curve_file, remove_curves};
pub use directory::STATUS;
pub use end::{EndWhy, PrecisionCheck, PrecisionError, PrecisionResult, STOP, Stage, TableEnd, end_of_table};
pub use error::{Change, Lost, RunError};
pub use event_table::{EVENTS, EventKind};
pub use events::EVENTS_VERSION;
pub use lock::{Holder, LockError, LockKeeper, LockState, give_back, lock_state};
pub use provenance::is_of_formulas;
pub use request::{Finished, Request};
pub use resume::Rerun;
pub use so_far::Watched;
pub(crate) use stamp::timestamp;
pub use status::{DirectoryStatus, RunState, TRUST, directory_status, resume_command};
pub use trust::Untrusted;
pub(crate) use trust::check as check_trust;

use crate::dispatch::{self, DispatchOptions, Ended};
use bladeoff_study::Samples;
use bladeoff_system::files::write_whole;
use bladeoff_worker::process::build_id;
use directory::{MANIFEST, WORKER_LOG};
use directory_lost::DirectoryWatch;
use ending::{Computed, conclude};
use manifest::{Course, manifest};
use open::{Opening, Session, open};
use partial_tables::PartsHandle;
use refined::Refined;
use sink::RecordSink;
use stages::Staged;
use std::cell::RefCell;
use std::rc::Rc;
use telling::{Known, Telling};

/// Runs the samples that have no result yet and writes the result directory. `note` receives messages for the user; progress is printed on
/// standard error.
///
/// # Errors
/// See [`RunError`]; samples finished before the error are in the directory's record.
pub fn run(request: &Request, samples: &Samples, note: &dyn Fn(&str)) -> Result<Finished, RunError> {
    let known = Known::begin(request)?;
    let finished = open(request, samples, note).and_then(|opening| match opening {
        Opening::Complete(finished) => Ok(finished),
        Opening::Session(session) => complete(*session, &known),
    });
    // the lock is released: another run may use the directory
    known.borrow_mut().end(finished, samples.count())
}

/// From an owned directory to its tables. The outcome is recorded in the directory before the lock is released.
fn complete(mut session: Session<'_>, known: &Rc<RefCell<Known>>) -> Result<Finished, RunError> {
    let mut telling = Telling::begin(&session, known);
    let course = Course::begun(session.opened.tally.done());
    let computed = compute(&mut session, &course, &mut telling);
    let finished = computed.and_then(|computed| conclude(&session, computed, &course, &mut telling));
    telling.end(&finished);
    finished
}

/// Computes the missing samples, and writes parts of the table at the same time.
fn compute(session: &mut Session<'_>, course: &Course, telling: &mut Telling) -> Result<Computed, RunError> {
    let (options, there) = begin(session, course, telling)?;
    let Session { request, prepared, opened, directory } = session;
    let faults = request.faults;
    let (samples, known) = (prepared.samples, Rc::clone(&telling.known));
    let todo = order::ordered(std::mem::take(&mut opened.todo), samples);
    let record = opened.record.reader().clone();
    let work = |parts: &PartsHandle<'_>| {
        let mut sink =
            RecordSink::new(&mut opened.record, &prepared.keys, &known, parts, DirectoryWatch::new(directory));
        let mut chosen = None;
        let (report, end) = match (&request.looking, &request.refining) {
            (_, Some(refining)) => {
                let refined = Refined { refining: &**refining, directory, prepared, record: &record, faults };
                let (course, cells) = refined.compute(options, todo, &mut sink, telling);
                chosen = Some(cells);
                course
            }
            (Some(looking), None) => {
                let staged = Staged { looking: &**looking, directory, prepared, record: &record, faults };
                staged.compute(options, todo, &mut sink, telling)
            }
            (None, None) => (dispatch::run(&options, samples, todo, &mut sink, telling), Ok(None)),
        };
        let committed = sink.close();
        telling.progress.clear();
        if let Ok(report) = &report {
            let memory = report.memory.as_ref().map(|domain| domain.address().clone());
            interrupt::end_at_once_when_told(matches!(report.ended, Ended::Signalled(_)), faults, memory);
        }
        if telling.durable().done() < samples.count() && !matches!(end, Ok(Some(_))) {
            parts.write_rest();
        }
        (report, end, chosen, committed)
    };
    let written = partial_tables::written_beside(request.refresh, (directory, prepared, &record), there, faults, work);
    let ((report, end, chosen, committed), parts) = written?;
    Ok(Computed { report, end, chosen, committed, parts })
}

/// Options for the computation of a session's samples.
fn options(session: &Session<'_>) -> Result<DispatchOptions, RunError> {
    let Session { request, prepared, opened, directory } = session;
    let (command, plan) = (dispatch::self_command()?, prepared.plan_hash.clone());
    let mut options = DispatchOptions::new(request.workers, command, directory.path().to_path_buf(), plan);
    // another build may give different numbers
    options.build = Some(build_id());
    options.schedule.sample = request.sample;
    options.schedule.run = request.limits.after(request.begun.elapsed());
    options.schedule.failed_before = opened.tally.failed();
    options.keyboard = true;
    options.worker_log = directory.file(WORKER_LOG);
    options.faults = request.faults;
    Ok(options)
}

/// Reports the begin of the run. Returns the options of the computation, and the existing rows, which become parts.
fn begin(
    session: &Session<'_>,
    course: &Course,
    telling: &mut Telling,
) -> Result<(DispatchOptions, Option<bladeoff_record::View>), RunError> {
    let Session { request, prepared, opened, directory } = session;
    let manifest = manifest(request, prepared.samples, &prepared.provenance, course);
    write_whole(directory.file(MANIFEST), manifest.as_bytes())?;
    let options = options(session)?;
    telling.started(session);
    let has_both = opened.tally.done() > 0 && opened.todo.total() > 0;
    let there = if has_both { Some(opened.record.reader().view()?) } else { None };
    Ok((options, there))
}
