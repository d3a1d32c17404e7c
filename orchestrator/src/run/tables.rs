//! From the record of finished samples to the tables.

use super::RunError;
use super::directory::{INCOMPLETE_RESULTS, RESULTS, RunDirectory, TIMINGS};
use crate::engine;
use crate::ledger::{Entry, Ledger, LedgerError};
use crate::results::{Provenance, Row, TableSchema, Timing, write_results, write_timings};
use crate::study::Samples;
use bladeoff_core::machine::Machine;
use std::path::PathBuf;

/// Writes `results.parquet` (or its incomplete stand-in) and `timings.parquet`; gives the path of the former.
///
/// `machine`: the machine of the study without what varies; it says which columns there are.
pub(super) fn write_tables(
    directory: &RunDirectory,
    samples: &Samples,
    machine: &Machine,
    ledger: &Ledger,
    provenance: &[(String, String)],
) -> Result<PathBuf, RunError> {
    let mut entries: Vec<(u64, Entry)> = Vec::new();
    ledger.for_each::<LedgerError>(|sample, entry| {
        entries.push((sample, entry));
        Ok(())
    })?;
    let complete = entries.len() as u64 == samples.count();
    let timings: Vec<Timing> = entries
        .iter()
        .map(|(sample, entry)| Timing {
            sample: *sample,
            cpu_s: entry.cpu_s,
            worker: entry.worker,
            attempt: entry.attempt,
        })
        .collect();
    write_timings(&directory.file(TIMINGS), &timings)?;
    let schema = TableSchema::new(samples.fields(), &engine::columns(machine));
    let fixed_detection = engine::detection(machine);
    let rows = entries.into_iter().map(|(sample, entry)| Row {
        sample,
        parameters: samples.cells(sample),
        detection: samples.detection(sample).or_else(|| fixed_detection.map(str::to_owned)),
        outcome: entry.outcome,
    });
    let path = directory.file(if complete { RESULTS } else { INCOMPLETE_RESULTS });
    write_results(&path, &schema, &Provenance(provenance.to_vec()), rows)?;
    Ok(path)
}
