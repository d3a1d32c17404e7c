//! From the record of finished samples to the tables.

use super::RunError;
use super::directory::{INCOMPLETE_RESULTS, RESULTS, RunDirectory, TIMINGS};
use super::prepare::Prepared;
use crate::engine;
use crate::ledger::{Entry, LedgerError, Reader};
use crate::results::{Provenance, ResultsWriter, Row, TableError, TableSchema, Timing, TimingsWriter, read_metadata};
use std::path::{Path, PathBuf};

/// Writes `results.parquet` (or its incomplete stand-in) and `timings.parquet`; gives the path of the former.
pub(super) fn write_tables(
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    record: &Reader,
) -> Result<PathBuf, RunError> {
    let complete = record.len()? == prepared.samples.count();
    let path = directory.file(if complete { RESULTS } else { INCOMPLETE_RESULTS });
    write(directory, &path, prepared, record, &|| false)?;
    if complete {
        directory.remove(INCOMPLETE_RESULTS)?;
    }
    Ok(path)
}

/// Why writing ended early.
enum Ended {
    Cancelled,
    Failed(RunError),
}

impl From<LedgerError> for Ended {
    fn from(error: LedgerError) -> Self {
        Self::Failed(error.into())
    }
}

impl From<TableError> for Ended {
    fn from(error: TableError) -> Self {
        Self::Failed(error.into())
    }
}

/// Writes the rows of all durable results to `path` and their timings beside it, one entry at a time: the writers hold one
/// row group. False if it was cancelled: nothing has changed then.
pub(super) fn write(
    directory: &RunDirectory,
    path: &Path,
    prepared: &Prepared<'_>,
    record: &Reader,
    is_cancelled: &dyn Fn() -> bool,
) -> Result<bool, RunError> {
    let samples = prepared.samples;
    let schema = TableSchema::new(samples.fields(), &engine::columns(&prepared.machine));
    let fixed_detection = engine::detection(&prepared.machine);
    let mut timings = TimingsWriter::create(&directory.file(TIMINGS))?;
    let mut results = ResultsWriter::create(path, &schema, &Provenance(prepared.provenance.clone()))?;
    let visited = record.for_each::<Ended>(|sample, Entry { outcome, cpu_s, worker, attempt }| {
        if is_cancelled() {
            return Err(Ended::Cancelled);
        }
        timings.push(Timing { sample, cpu_s, worker, attempt })?;
        results.push(Row {
            sample,
            parameters: samples.cells(sample),
            detection: samples.detection(sample).or_else(|| fixed_detection.map(str::to_owned)),
            outcome,
        })?;
        Ok(())
    });
    match visited {
        Ok(()) => {}
        Err(Ended::Cancelled) => return Ok(false),
        Err(Ended::Failed(error)) => return Err(error),
    }
    timings.finish()?;
    results.finish()?;
    Ok(true)
}

/// Whether a table is there and comes from these inputs.
pub(super) fn is_current(directory: &RunDirectory, name: &str, provenance: &[(String, String)]) -> bool {
    let Ok(found) = read_metadata(&directory.file(name)) else { return false };
    let has = |(key, value): &(String, String)| {
        let key = format!("bladeoff.{key}");
        found.iter().any(|(name, text)| *name == key && text == value)
    };
    provenance.iter().all(has)
}
