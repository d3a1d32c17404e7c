//! From the record of finished samples to the tables.

use super::RunError;
use super::directory::{INCOMPLETE_RESULTS, RESULTS, RunDirectory, TIMINGS};
use crate::engine;
use crate::ledger::{Entry, Ledger};
use crate::results::{Provenance, ResultsWriter, Row, TableSchema, Timing, TimingsWriter, read_metadata};
use crate::study::Samples;
use bladeoff_core::machine::Machine;
use std::path::PathBuf;

/// Writes `results.parquet` (or its incomplete stand-in) and `timings.parquet`; gives the path of the former.
///
/// `machine`: a machine of the study; it says which columns there are.
pub(super) fn write_tables(
    directory: &RunDirectory,
    samples: &Samples,
    machine: &Machine,
    ledger: &Ledger,
    provenance: &[(String, String)],
) -> Result<PathBuf, RunError> {
    let complete = ledger.len()? == samples.count();
    let path = directory.file(if complete { RESULTS } else { INCOMPLETE_RESULTS });
    let schema = TableSchema::new(samples.fields(), &engine::columns(machine));
    let fixed_detection = engine::detection(machine);
    let mut timings = TimingsWriter::create(&directory.file(TIMINGS))?;
    let mut results = ResultsWriter::create(&path, &schema, &Provenance(provenance.to_vec()))?;
    // One entry at a time: the writers hold one row group.
    ledger.for_each::<RunError>(|sample, Entry { outcome, cpu_s, worker, attempt }| {
        timings.push(Timing { sample, cpu_s, worker, attempt })?;
        results.push(Row {
            sample,
            parameters: samples.cells(sample),
            detection: samples.detection(sample).or_else(|| fixed_detection.map(str::to_owned)),
            outcome,
        })?;
        Ok(())
    })?;
    timings.finish()?;
    results.finish()?;
    if complete {
        directory.remove(INCOMPLETE_RESULTS)?;
    }
    Ok(path)
}

/// Whether the table of a complete study is there and comes from these inputs.
pub(super) fn is_current(directory: &RunDirectory, provenance: &[(String, String)]) -> bool {
    let Ok(found) = read_metadata(&directory.file(RESULTS)) else { return false };
    let has = |(key, value): &(String, String)| {
        let key = format!("bladeoff.{key}");
        found.iter().any(|(name, text)| *name == key && text == value)
    };
    provenance.iter().all(has)
}
