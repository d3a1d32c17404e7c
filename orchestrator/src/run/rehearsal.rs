//! Result directory filled without computing, for measurements of the time to resume.

use super::directory::{LEDGER, MANIFEST, RESULTS, RunDirectory, TIMINGS};
use super::error::RunError;
use super::prepare::{Prepared, new_basis};
use super::tables::RowsWriter;
use super::{manifest, partial_tables, resume, tables};
use bladeoff_record::{Entry, Record};
use bladeoff_study::Samples;
use bladeoff_system::files::{Pending, write_whole};
use bladeoff_worker::fault::NoFaults;
use bladeoff_worker::function_solver::FunctionSolver;
use bladeoff_worker::job_spec::JobSpec;
use bladeoff_worker::noop::noop_outcome;
use std::path::Path;
use std::time::{Duration, Instant};

/// Times of resuming a directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResumeTime {
    /// Time for the keys of all samples.
    pub keys: Duration,
    /// Time from the lock to the list of missing samples, with the keys.
    pub whole: Duration,
    /// Samples found in the record.
    pub found: u64,
}

/// Creates a result directory whose record contains no-op results of all samples except the last.
///
/// # Errors
/// As [`run`](super::run).
pub fn fill(path: &Path, samples: &Samples) -> Result<(), RunError> {
    let directory = RunDirectory::claim(path, true, None)?;
    let prepared = Prepared::new(samples, new_basis(samples)?)?;
    prepared.write(&directory)?;
    let mut record = Record::create(directory.file(LEDGER), &prepared.header())?;
    for sample in 0..samples.count().saturating_sub(1) {
        record.put(sample, prepared.keys.key(sample), &noop_entry(sample), Instant::now())?;
    }
    Ok(record.publish()?)
}

/// Resumes a directory as `run` does, up to the first sample to compute.
///
/// # Errors
/// As [`run`](super::run).
pub fn time_resume(path: &Path, samples: &Samples) -> Result<ResumeTime, RunError> {
    let begun = Instant::now();
    let directory = RunDirectory::claim(path, true, None)?;
    let basis = super::prepare::frozen_basis(samples, directory.open(), &|_| ())?;
    let keyed = Instant::now();
    let prepared = Prepared::new(samples, basis)?;
    let keys = keyed.elapsed();
    let opened = resume::open(&directory, &prepared, resume::Again { rerun: None, suspects: true })?;
    Ok(ResumeTime { keys, whole: begun.elapsed(), found: opened.tally.done() })
}

/// Writes the finished rows of a directory as parts, as a resume does; returns the time.
///
/// # Errors
/// As [`run`](super::run).
pub fn time_parts(path: &Path, samples: &Samples) -> Result<Duration, RunError> {
    with_record(path, samples, |directory, prepared, record| {
        let record = record.reader().clone();
        let there = Some(record.view()?);
        let begun = Instant::now();
        let place = (directory, prepared, &record);
        partial_tables::written_beside(Duration::ZERO, place, there, &NoFaults, |parts| parts.write_rest())?.1?;
        Ok(begun.elapsed())
    })
}

/// Records the missing sample and writes the tables; returns the time for the tables.
///
/// # Errors
/// As [`run`](super::run).
pub fn time_tables(path: &Path, samples: &Samples) -> Result<Duration, RunError> {
    with_record(path, samples, |directory, prepared, record| {
        let last = samples.count() - 1;
        record.put(last, prepared.keys.key(last), &noop_entry(last), Instant::now())?;
        record.commit()?;
        let begun = Instant::now();
        tables::write_tables(directory, prepared, record.reader(), (None, None))?;
        Ok(begun.elapsed())
    })
}

/// Creates the complete result directory of a study of formulas, computed in this process: tables and checksums, without workers
/// and record.
///
/// # Errors
/// As [`run`](super::run).
pub fn tabulate(path: &Path, samples: &Samples) -> Result<(), RunError> {
    let directory = RunDirectory::claim(path, true, None)?;
    let prepared = Prepared::new(samples, new_basis(samples)?)?;
    prepared.write(&directory)?;
    let JobSpec::Function(job) = &prepared.job else { unreachable!("asked of studies of formulas alone") };
    let mut solver = FunctionSolver::new(job).expect("formulas are checked when a study is read");
    let (results, timings) = (directory.file(RESULTS), directory.file(TIMINGS));
    let mut rows = RowsWriter::create(&prepared, Pending::create(results)?, Pending::create(timings)?, &[])?;
    let mut params = Vec::new();
    for sample in 0..samples.count() {
        params.clear();
        samples.params(sample, &mut params);
        rows.push(sample, Entry { outcome: solver.outcome(&params), cpu_s: 0.0, worker: 1, attempt: 1 })?;
    }
    write_whole(directory.file(MANIFEST), manifest::of_tables(rows.finish()?).as_bytes())?;
    Ok(())
}

fn with_record<T>(
    path: &Path,
    samples: &Samples,
    work: impl FnOnce(&RunDirectory, &Prepared<'_>, &mut Record) -> Result<T, RunError>,
) -> Result<T, RunError> {
    let directory = RunDirectory::claim(path, true, None)?;
    let basis = super::prepare::frozen_basis(samples, directory.open(), &|_| ())?;
    let prepared = Prepared::new(samples, basis)?;
    let mut opened = resume::open(&directory, &prepared, resume::Again { rerun: None, suspects: true })?;
    work(&directory, &prepared, &mut opened.record)
}

fn noop_entry(sample: u64) -> Entry {
    Entry { outcome: noop_outcome(sample, &[]), cpu_s: 0.0, worker: 1, attempt: 1 }
}
