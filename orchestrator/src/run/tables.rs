//! Tables written from the record of finished samples.

use super::checksums::refuse_changed;
use super::chosen::{Chosen, REFINED};
use super::directory::{RESULTS, RunDirectory, TIMINGS};
use super::end::{STOP, TableEnd};
use super::error::RunError;
use super::manifest::Checksums;
use super::prepare::Prepared;
use super::questions::questions;
use crate::terminal::Tally;
use bladeoff_answers::tables::{
    Checksum, Provenance, ResultsWriter, Row, Table, TableError, Timing, TimingsWriter, read_metadata,
};
use bladeoff_model::outcome::{Cause, Outcome, Status};
use bladeoff_record::{Entry, Reader};
use bladeoff_study::Samples;
use bladeoff_system::files::Pending;
use bladeoff_system::place::Place;
use std::path::Path;

/// Writes `results.parquet` and `timings.parquet` of a study whose samples are all recorded, or those before the end of the
/// table, or the chosen ones. One entry at a time: the writers hold one row group. Returns their checksums and the counts by
/// status.
pub(super) fn write_tables(
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    record: &Reader,
    (end, chosen): (Option<&TableEnd>, Option<&Chosen>),
) -> Result<(Checksums, Tally), RunError> {
    let (results, timings) = (directory.file(RESULTS), directory.file(TIMINGS));
    let mut more = end_metadata(end);
    more.extend(chosen.map(|chosen| (REFINED.to_owned(), chosen.json().to_string())));
    let mut rows = RowsWriter::create(prepared, Pending::create(results)?, Pending::create(timings)?, &more)?;
    let mut tally = Tally::default();
    record.for_each(|sample, entry| {
        if is_in((end, chosen), prepared.samples, sample) {
            tally.add(&entry.outcome);
            rows.push(sample, entry)?;
        }
        Ok::<_, RunError>(())
    })?;
    Ok((rows.finish()?, tally))
}

/// Metadata of the end of a table.
pub(super) fn end_metadata(end: Option<&TableEnd>) -> Vec<(String, String)> {
    end.map(|end| (STOP.to_owned(), end.json().to_string())).into_iter().collect()
}

/// Whether a table contains a sample.
fn is_in((end, chosen): (Option<&TableEnd>, Option<&Chosen>), samples: &Samples, sample: u64) -> bool {
    match chosen {
        Some(chosen) => sample < samples.count() && chosen.contains(samples, sample),
        None => end.is_none_or(|end| sample < end.samples),
    }
}

/// Writes a temporary table with the rows of these recorded samples in ascending order.
pub(super) fn write_rows(
    place: &Place,
    prepared: &Prepared<'_>,
    record: &Reader,
    samples: &[u64],
) -> Result<(), RunError> {
    let mut rows = LookWriter::create(prepared, Pending::create(place)?)?;
    // these only, even if the record has more
    record.view()?.for_each_of(samples, |sample, entry| rows.push(sample, entry).map_err(RunError::from))?;
    Ok(rows.finish()?)
}

/// Writer of the rows of an interim analysis.
pub(super) struct LookWriter<'a> {
    prepared: &'a Prepared<'a>,
    rows: ResultsWriter,
}

impl<'a> LookWriter<'a> {
    pub fn create(prepared: &'a Prepared<'a>, place: Pending) -> Result<Self, TableError> {
        let provenance = Provenance(prepared.provenance.clone());
        Ok(Self { prepared, rows: ResultsWriter::create(place, &prepared.schema, &provenance)? })
    }

    /// Adds a finished sample; samples are added in ascending order.
    pub fn push(&mut self, sample: u64, entry: Entry) -> Result<(), TableError> {
        self.rows.push(row(self.prepared, sample, entry.outcome))
    }

    pub fn finish(self) -> Result<(), TableError> {
        self.rows.finish().map(|_| ())
    }
}

/// Writes `timings.parquet` alone again.
pub(super) fn write_timings(
    directory: &RunDirectory,
    samples: &Samples,
    record: &Reader,
    which: (Option<&TableEnd>, Option<&Chosen>),
) -> Result<Checksum, RunError> {
    let mut timings = TimingsWriter::create(Pending::create(directory.file(TIMINGS))?)?;
    record.for_each(|sample, entry| {
        let Entry { cpu_s, worker, attempt, .. } = entry;
        if is_in(which, samples, sample) {
            timings.push(Timing { sample, cpu_s, worker, attempt })?;
        }
        Ok::<_, RunError>(())
    })?;
    Ok(timings.finish()?)
}

/// Row of a sample.
fn row(prepared: &Prepared<'_>, sample: u64, outcome: Outcome) -> Row {
    let samples = prepared.samples;
    let detection = samples.detection(sample).or_else(|| prepared.detection.clone());
    let engine = samples.engine(sample).or_else(|| prepared.engine.clone());
    Row { sample, parameters: samples.cells(sample), detection, engine, outcome }
}

/// Writer of rows and of their timings side by side.
pub(super) struct RowsWriter<'a> {
    prepared: &'a Prepared<'a>,
    results: ResultsWriter,
    timings: TimingsWriter,
}

impl<'a> RowsWriter<'a> {
    /// Starts both files; `more`: metadata in addition to the provenance.
    pub fn create(
        prepared: &'a Prepared<'a>,
        results: Pending,
        timings: Pending,
        more: &[(String, String)],
    ) -> Result<Self, TableError> {
        let asked = questions(&prepared.samples.study().asked);
        let provenance = Provenance([&prepared.provenance, &asked[..], more].concat());
        Ok(Self {
            prepared,
            results: ResultsWriter::create(results, &prepared.schema, &provenance)?,
            timings: TimingsWriter::create(timings)?,
        })
    }

    /// Adds a finished sample; samples are added in ascending order.
    pub fn push(&mut self, sample: u64, entry: Entry) -> Result<(), TableError> {
        let Entry { outcome, cpu_s, worker, attempt } = entry;
        self.timings.push(Timing { sample, cpu_s, worker, attempt })?;
        self.results.push(row(self.prepared, sample, outcome))
    }

    /// Makes both files durable, the rows last, so that every row has a timing.
    pub fn finish(self) -> Result<Checksums, TableError> {
        let timings = self.timings.finish()?;
        Ok(Checksums { results: Some(self.results.finish()?), timings: Some(timings) })
    }
}

/// Counts the samples of a complete table by status, from its rows.
///
/// # Errors
/// The table has changed or cannot be read.
pub(super) fn tally(directory: &Path) -> Result<Tally, RunError> {
    refuse_changed(directory)?;
    let mut tally = Tally::default();
    Table::for_each_piece(&[directory.join(RESULTS)], &["status", "cause"], |piece| {
        let (statuses, causes) = (piece.words("status").unwrap_or_default(), piece.words("cause").unwrap_or_default());
        for (status, cause) in statuses.iter().zip(causes) {
            if let Some(status) = status.as_deref().and_then(Status::from_word) {
                tally.count(status, cause.as_deref().and_then(Cause::from_word));
            }
        }
        Ok(())
    })?;
    Ok(tally)
}

/// Whether a table exists and belongs to these inputs.
pub(super) fn is_current(directory: &Path, name: &str, provenance: &[(String, String)]) -> bool {
    let Ok(found) = read_metadata(&directory.join(name)) else { return false };
    let has = |(key, value): &(String, String)| {
        let key = format!("bladeoff.{key}");
        found.iter().any(|(name, text)| *name == key && text == value)
    };
    provenance.iter().all(has)
}
