//! From the record of finished samples to the tables.

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

/// Writes `results.parquet` and `timings.parquet` of a study whose samples are all recorded, or those up to the table's end, or those
/// that are chosen, one entry at a time: the writers hold one row group. Gives their checksums, and what became of these samples.
pub(super) fn write_tables(
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    record: &Reader,
    (end, chosen): (Option<&TableEnd>, Option<&Chosen>),
) -> Result<(Checksums, Tally), RunError> {
    let (results, timings) = (directory.file(RESULTS), directory.file(TIMINGS));
    let mut more = told(end);
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

/// What a table says of its end.
pub(super) fn told(end: Option<&TableEnd>) -> Vec<(String, String)> {
    end.map(|end| (STOP.to_owned(), end.json().to_string())).into_iter().collect()
}

/// Whether a table has a sample.
fn is_in((end, chosen): (Option<&TableEnd>, Option<&Chosen>), samples: &Samples, sample: u64) -> bool {
    match chosen {
        Some(chosen) => sample < samples.count() && chosen.has(samples, sample),
        None => end.is_none_or(|end| sample < end.samples),
    }
}

/// Writes the rows of these samples, in ascending order and all of them recorded, as a table aside.
pub(super) fn write_rows(
    place: &Place,
    prepared: &Prepared<'_>,
    record: &Reader,
    samples: &[u64],
) -> Result<(), RunError> {
    let mut rows = LookWriter::create(prepared, Pending::create(place)?)?;
    // no more than these, however many there are
    record.view()?.for_each_of(samples, |sample, entry| rows.push(sample, entry).map_err(RunError::from))?;
    Ok(rows.finish()?)
}

/// Rows to be looked at, under construction.
pub(super) struct LookWriter<'a> {
    prepared: &'a Prepared<'a>,
    rows: ResultsWriter,
}

impl<'a> LookWriter<'a> {
    pub fn create(prepared: &'a Prepared<'a>, place: Pending) -> Result<Self, TableError> {
        let provenance = Provenance(prepared.provenance.clone());
        Ok(Self { prepared, rows: ResultsWriter::create(place, &prepared.schema, &provenance)? })
    }

    /// Takes a finished sample; they come in ascending order.
    pub fn push(&mut self, sample: u64, entry: Entry) -> Result<(), TableError> {
        self.rows.push(row(self.prepared, sample, entry.outcome))
    }

    pub fn finish(self) -> Result<(), TableError> {
        self.rows.finish().map(|_| ())
    }
}

/// Writes `timings.parquet` alone, again.
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

/// A sample as the table wants it.
fn row(prepared: &Prepared<'_>, sample: u64, outcome: Outcome) -> Row {
    let samples = prepared.samples;
    let detection = samples.detection(sample).or_else(|| prepared.detection.clone());
    let engine = samples.engine(sample).or_else(|| prepared.engine.clone());
    Row { sample, parameters: samples.cells(sample), detection, engine, outcome }
}

/// Rows and their timings, under construction side by side.
pub(super) struct RowsWriter<'a> {
    prepared: &'a Prepared<'a>,
    results: ResultsWriter,
    timings: TimingsWriter,
}

impl<'a> RowsWriter<'a> {
    /// Starts both; `more`: what is said of the table beside where it comes from.
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

    /// Takes a finished sample; they come in ascending order.
    pub fn push(&mut self, sample: u64, entry: Entry) -> Result<(), TableError> {
        let Entry { outcome, cpu_s, worker, attempt } = entry;
        self.timings.push(Timing { sample, cpu_s, worker, attempt })?;
        self.results.push(row(self.prepared, sample, outcome))
    }

    /// Makes both durable, the rows last: whoever sees a row finds its timing.
    pub fn finish(self) -> Result<Checksums, TableError> {
        let timings = self.timings.finish()?;
        Ok(Checksums { results: Some(self.results.finish()?), timings: Some(timings) })
    }
}

/// What became of the samples of a complete table, by its rows.
///
/// # Errors
/// The table is not as it was written, or cannot be read.
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

/// Whether a table is there and comes from these inputs.
pub(super) fn is_current(directory: &Path, name: &str, provenance: &[(String, String)]) -> bool {
    let Ok(found) = read_metadata(&directory.join(name)) else { return false };
    let has = |(key, value): &(String, String)| {
        let key = format!("bladeoff.{key}");
        found.iter().any(|(name, text)| *name == key && text == value)
    };
    provenance.iter().all(has)
}
