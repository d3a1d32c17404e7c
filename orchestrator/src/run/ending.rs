//! End of a run: tables if every sample is finished, otherwise parts; and rescue of the finished samples of a lost directory.

use super::chosen::Chosen;
use super::directory::{MANIFEST, PARTS, RESULTS, row_files};
use super::end::TableEnd;
use super::error::{Lost, RunError};
use super::manifest::{Checksums, Course, manifest};
use super::open::Session;
use super::request::Finished;
use super::telling::Telling;
use super::{directory_lost, rescued, tables};
use crate::dispatch::{self, DispatchError, DispatchReport};
use bladeoff_record::RecordError;
use bladeoff_system::files::write_whole;
use bladeoff_worker::fault::At;
use std::time::{Instant, SystemTime};

/// Result of the computation.
pub(super) struct Computed {
    /// Report of the dispatch.
    pub report: Result<DispatchReport, DispatchError>,
    /// End of the table, if `[stop]` determines it.
    pub end: Result<Option<TableEnd>, RunError>,
    /// Combinations of a map in the table, if `[refine]` chooses them.
    pub chosen: Option<Chosen>,
    /// Result of the last commit.
    pub committed: Result<(), RecordError>,
    /// Result of writing the last parts, if requested.
    pub parts: Result<(), RunError>,
}

/// Writes tables or parts after the computation. `begun`: course of the run at its beginning.
///
/// # Errors
/// The first failure; the loss of the directory has priority.
pub(super) fn conclude(
    session: &Session<'_>,
    computed: Computed,
    begun: &Course,
    telling: &mut Telling,
) -> Result<Finished, RunError> {
    let Session { request, prepared, opened, directory } = session;
    let (samples, record) = (prepared.samples, &opened.record);
    let Computed { mut report, end, chosen, committed, parts } = computed;
    // Shared memory is removed when everything is written; its errors do not affect the results.
    let memory = report.as_mut().ok().and_then(|report| report.memory.take());
    // Results that are not recorded are computed again and do not count.
    let durable = telling.durable();
    telling.progress.finish(&durable, Instant::now());
    let ended = |state| Course { state, finished: Some(SystemTime::now()), done: durable.done(), ..*begun };
    let manifest = |course: &Course| manifest(request, samples, &prepared.provenance, course);
    let write = || {
        let report = report?;
        // After a failure the first error is reported.
        committed?;
        let end = end?;
        let mut tally = durable.clone();
        let (table, tables) = if end.is_some() || durable.done() == samples.count() {
            let which = (end.as_ref(), chosen.as_ref().filter(|_| end.is_some()));
            let (tables, of_table) = tables::write_tables(directory, prepared, record.reader(), which)?;
            tally = of_table;
            request.faults.reached(At::Retiring, 0, None);
            directory.remove_parts()?;
            (Some(directory.file(RESULTS).to_path_buf()), tables)
        } else {
            parts?;
            let has_rows = !row_files(directory.path()).is_empty();
            (has_rows.then(|| directory.file(PARTS).to_path_buf()), Checksums::default())
        };
        let (worker_deaths, dropped_messages) = (report.worker_deaths, report.dropped_messages);
        let why = Some(report.ended.word());
        // counts of the table, without further samples in the record
        let (state, done) = (report.ended.state(), tally.done());
        let course = Course { worker_deaths, dropped_messages, tables, ended: why, end, done, ..ended(state) };
        write_whole(directory.file(MANIFEST), manifest(&course).as_bytes())?;
        Ok(Finished { tally, reused: begun.reused, ended: report.ended, end, table })
    };
    let lost =
        |loss| RunError::from(rescued::keep(loss, directory, prepared, record, &durable, &manifest(&ended("failed"))));
    let finished = match directory_lost::loss(directory, record) {
        Some(loss) => Err(lost(loss)),
        // The directory may be lost while the tables are written.
        None => write().map_err(|error| match directory_lost::loss(directory, record) {
            Some(loss) => lost(loss),
            None if directory_lost::is_closed(directory) => {
                let (path, done) = (directory.path().to_path_buf(), durable.done());
                Lost::Closed { path, done, source: Box::new(error) }.into()
            }
            None => error,
        }),
    };
    dispatch::give_back(memory, telling);
    finished
}
