//! Repair of a complete directory: missing and changed files are made again from the record.

use super::checksums::{Compared, compare};
use super::chosen::Chosen;
use super::directory::{MANIFEST, RESULTS, RunDirectory, TIMINGS};
use super::end::TableEnd;
use super::error::RunError;
use super::manifest::{Checksums, Course, manifest, mended, tells_complete};
use super::prepare::Prepared;
use super::request::Request;
use super::status::{self, StatusWriter};
use super::tables::{tally, write_tables, write_timings};
use crate::schedule::Ended;
use crate::terminal::Tally;
use bladeoff_answers::tables::read_metadata;
use bladeoff_record::Reader;
use bladeoff_system::files::write_whole;

/// Repairs all files except the record.
pub(super) fn put_in_order(
    request: &Request,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    (record, recorded): (&Reader, &Tally),
    (end, chosen): (Option<TableEnd>, Option<&Chosen>),
    note: &dyn Fn(&str),
) -> Result<(), RunError> {
    let samples = prepared.samples;
    directory.tidy_files()?;
    prepared.write(directory)?;
    let path = directory.file(MANIFEST);
    let checksums = Checksums::recorded(&path);
    let results = compare(&directory.file(RESULTS), checksums.results)?;
    // An unreadable file is replaced like a changed one.
    let timings = compare(&directory.file(TIMINGS), checksums.timings).unwrap_or(Compared::Changed);
    let is_lost = match timings {
        Compared::Whole => false,
        Compared::Unknown => read_metadata(&directory.file(TIMINGS)).is_err(),
        Compared::Changed | Compared::Missing => true,
    };
    let mut tables = checksums;
    if results != Compared::Whole {
        note(&format!("{RESULTS} {}: rewriting it from the record", what(results)));
        (tables, _) = write_tables(directory, prepared, record, (end.as_ref(), chosen))?;
    } else if timings != Compared::Whole {
        tables.timings = Some(write_timings(directory, samples, record, (end.as_ref(), chosen))?);
    }
    if is_lost {
        note(&format!("{TIMINGS} was missing or damaged: rewriting it from the record"));
    }
    // counts of its rows, without further samples of the record
    let of_table = if end.is_some() { Some(tally(directory.path())?) } else { None };
    let tally = of_table.as_ref().unwrap_or(recorded);
    if !tells_complete(&path) {
        let begun = Course::begun(tally.done());
        let ended = Some(why_ended(end).word());
        let course = Course { state: "complete", ended, end, finished: Some(begun.started), tables, ..begun };
        let text = manifest(request, samples, &prepared.provenance, &course);
        write_whole(&path, text.as_bytes())?;
        note(&format!("{MANIFEST} was missing, damaged or of a run that did not end: rewriting it for this run"));
    } else if let Some(text) = mended(&path, tables, &prepared.provenance) {
        write_whole(&path, text.as_bytes())?;
        if tables == checksums {
            note(&format!("{MANIFEST} named other inputs: corrected"));
        }
    }
    if !status::tells_complete(directory.open()) {
        let mut status = StatusWriter::new(directory.open(), samples, recorded.done()).trusting(request.trusts);
        status.tell_end(why_ended(end), end);
        status.finish("complete", None, tally, recorded.done().saturating_sub(tally.done()));
    }
    for left in directory.try_to_remove_parts() {
        note(&format!("{left} ({}): kept unchanged, every row is in {RESULTS}", left.source));
    }
    Ok(())
}

/// Reason of the end of a complete study with this end.
fn why_ended(end: Option<TableEnd>) -> Ended {
    if end.is_some_and(|end| end.is_early()) { Ended::Stop } else { Ended::Complete }
}

fn what(compared: Compared) -> &'static str {
    match compared {
        Compared::Whole => "is as it was written",
        Compared::Changed => "is damaged (its BLAKE3 is not the one in manifest.json)",
        Compared::Unknown => "cannot be verified (manifest.json has no checksum of it)",
        Compared::Missing => "is missing",
    }
}
