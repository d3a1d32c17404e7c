//! Opening of a result directory: takes over finished samples, rejects a request that would lose some, and repairs a complete
//! directory.

use super::checksums::{changed_inputs, refuse_changed};
use super::chosen::{Chosen, chosen_of_table};
use super::curves::forget_answers;
use super::directory::{LEDGER, LOCK, LOOK, RESULTS, RunDirectory, TIMINGS};
use super::end::{TableEnd, end_of_table};
use super::error::RunError;
use super::lock::{LockError, LockKeeper, LockState, foreign_lock, lock_state};
use super::prepare::{Prepared, frozen_basis, new_basis};
use super::request::{Finished, Request};
use super::resume::{self, Again, Opened};
use super::{repair, tables};
use crate::dispatch;
use crate::terminal::Tally;
use bladeoff_answers::summary::{are, counted};
use bladeoff_answers::tables::start_threads;
use bladeoff_study::Samples;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::shown;

/// Result of opening a directory.
pub(super) enum Opening<'a> {
    /// Every sample and the table exist.
    Complete(Finished),
    /// Samples are missing, or at least the tables.
    Session(Box<Session<'a>>),
}

/// Open directory of a run, with its record.
pub(super) struct Session<'a> {
    pub request: &'a Request,
    pub prepared: Prepared<'a>,
    /// Record, missing samples and counts of the finished ones.
    pub opened: Opened,
    /// Dropped last: no other run may start before the record is closed.
    pub directory: RunDirectory,
}

/// Opens the directory of a request and creates it if necessary. All checks come before its creation.
///
/// # Errors
/// Rejected requests and file errors.
pub(super) fn open<'a>(
    request: &'a Request,
    samples: &'a Samples,
    note: &dyn Fn(&str),
) -> Result<Opening<'a>, RunError> {
    start_threads()?;
    let new_basis = if request.out.exists() { None } else { Some(new_basis(samples)?) };
    dispatch::preflight(request.workers)?;
    let directory = match RunDirectory::claim(&request.out, request.trusts, Some(samples.study())) {
        Err(error) if error.is_write_protection() => {
            return look_only(request, samples, note, error).map(Opening::Complete);
        }
        claimed => claimed?,
    };
    if let Some(holder) = directory.left_by() {
        note(&format!("the last run here ({holder}) did not end in order; resuming from its record"));
    }
    let basis = new_basis.map_or_else(|| frozen_basis(samples, directory.open(), note), Ok)?;
    let prepared = Prepared::new(samples, basis)?;
    let again = |suspects| Again { rerun: request.rerun.as_ref(), suspects };
    let mut compared = resume::compare(directory.open(), &prepared, again(true))?;
    if request.limits.are_too_many(compared.failed()) {
        // No sample will be computed, so none is selected for a retry.
        compared = resume::compare(directory.open(), &prepared, again(false))?;
    }
    compared.notes().iter().for_each(|text| note(text));
    for name in changed_inputs(directory.open()) {
        note(&format!(
            "{name} in {} was changed after it was written: it is written again from the study, no result depends on the change",
            shown(directory.path())
        ));
    }
    let (end, chosen) = (end_told(request), chosen_told(request, samples));
    let which = (end.as_ref(), chosen.as_ref());
    if tables::is_current(&request.out, RESULTS, &prepared.provenance)
        && let Some((record, tally)) = compared.complete(&prepared, which)
    {
        dispatch::nothing_to_compute();
        note(there_already(end.as_ref()));
        repair::put_in_order(request, &directory, &prepared, (record, tally), (end, chosen.as_ref()), note)?;
        // counts of its rows, without further samples of the record
        let tally = if end.is_some() { &tables::tally(&request.out)? } else { tally };
        return Ok(Opening::Complete(Finished::nothing_computed(&request.out, tally, end)));
    }
    if compared.complete(&prepared, which).is_some() && refuse_changed(directory.path()).is_err() {
        note(&format!("{RESULTS} is damaged: rewriting it from the record"));
    }
    let opened = compared.go_on(&directory, &prepared, request.faults)?;
    opened.notes.iter().for_each(|text| note(text));
    let reused = opened.tally.done();
    if reused > 0 {
        note(&format!(
            "{reused} of {} {} already finished, {}{} {} computed",
            counted(samples.count(), "sample"),
            are(reused),
            if request.looking.is_some() || request.refining.is_some() { "at most " } else { "" },
            opened.todo.total(),
            are(opened.todo.total())
        ));
    }
    // An old table would look like that of the whole study, and so would its answers.
    directory.remove(RESULTS)?;
    directory.remove(TIMINGS)?;
    directory.remove(LOOK)?;
    forget_answers(directory.open())?;
    Ok(Opening::Session(Box::new(Session { request, prepared, opened, directory })))
}

/// Reads the end of the table of a study with `[stop]`. An unreadable table is written again.
fn end_told(request: &Request) -> Option<TableEnd> {
    end_of_table(&request.out.join(RESULTS)).ok().flatten()
}

/// Reads the combinations of the table of a study with `[refine]`. An unreadable table is written again.
fn chosen_told(request: &Request, samples: &Samples) -> Option<Chosen> {
    chosen_of_table(&request.out.join(RESULTS), samples).ok().flatten()
}

fn there_already(end: Option<&TableEnd>) -> &'static str {
    match end {
        Some(end) if end.is_chosen() => "every sample that [refine] has chosen is already finished: nothing to compute",
        Some(end) if end.is_early() => "every sample up to the end by [stop] is already finished: nothing to compute",
        _ => "every sample is already finished: nothing to compute",
    }
}

/// Opens a directory that cannot be written, which suffices if everything is finished. `error`: error of writing.
fn look_only(request: &Request, samples: &Samples, note: &dyn Fn(&str), error: RunError) -> Result<Finished, RunError> {
    let look = || -> Result<Option<Finished>, RunError> {
        let folder = Folder::open(&request.out).map_err(FileError::at("open", &request.out))?;
        let held = match lock_state(&folder, LOCK)? {
            LockState::Held(by) => Some(by),
            LockState::Unreadable { holder: Some(by), .. } => Some(LockKeeper::Process(by)),
            LockState::Unreadable { .. } | LockState::Abandoned(_) | LockState::Free => None,
        };
        if let Some(by) = held {
            return Err(LockError::Held { directory: request.out.clone(), by }.into());
        }
        if !folder.place(LEDGER).exists() {
            return Ok(None);
        }
        let prepared = Prepared::new(samples, frozen_basis(samples, &folder, note)?)?;
        if folder.place(LEDGER).open().is_err()
            && let Some(theirs) = foreign_lock(&folder, &folder.place(LOCK))
        {
            // The record of another user cannot be read. That of a complete study is not needed.
            let is_current = tables::is_current(&request.out, RESULTS, &prepared.provenance);
            let tally = if is_current { tables::tally(&request.out)? } else { Tally::default() };
            let end = end_told(request);
            if tally.done() < end.map_or(samples.count(), |end| end.samples) {
                return Err(theirs.into());
            }
            note("every sample is already finished: nothing to compute (the directory belongs to another user)");
            return Ok(Some(Finished::nothing_computed(&request.out, &tally, end)));
        }
        let again = Again { rerun: request.rerun.as_ref(), suspects: false };
        let compared = resume::compare(&folder, &prepared, again)?;
        if tables::is_current(&request.out, RESULTS, &prepared.provenance)
            && let (end, chosen) = (end_told(request), chosen_told(request, samples))
            && let Some((_, tally)) = compared.complete(&prepared, (end.as_ref(), chosen.as_ref()))
        {
            if let Err(damage) = refuse_changed(&request.out) {
                note(&damage.to_string());
                return Ok(None);
            }
            note("every sample is already finished: nothing to compute (the directory is read-only)");
            let tally = if end.is_some() { &tables::tally(&request.out)? } else { tally };
            return Ok(Some(Finished::nothing_computed(&request.out, tally, end)));
        }
        note(&format!(
            "{} of {} {} already finished; the rest cannot be computed here",
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
