//! `timings.parquet`: what may differ between equal runs. Kept apart from the results for that reason.

use super::TableError;
use super::grouped::GroupedWriter;
use super::read::row_of;
use super::stream::Checksum;
use super::threads::guarded;
use bladeoff_system::files::Pending;
use bladeoff_system::place::Place;
use polars::prelude::{
    DataFrame, IntoColumn, NamedFrom, ParallelStrategy, ParquetReader, PolarsError, SerReader, Series,
};
use std::path::PathBuf;

/// What one sample cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Row number in the study.
    pub sample: u64,
    /// CPU time of the attempt that counted \[s\].
    pub cpu_s: f64,
    /// Number of the worker that computed it.
    pub worker: u32,
    /// Attempts, the one that counted included.
    pub attempt: u32,
}

/// The table under construction.
pub struct TimingsWriter(GroupedWriter<Timing>);

impl TimingsWriter {
    /// Starts a table in this file.
    ///
    /// # Errors
    /// The disk is full or not writable, or the table library refused.
    pub fn create(file: Pending) -> Result<Self, TableError> {
        let path = file.path().to_path_buf();
        let empty = frame(&[]).map_err(|source| TableError::Table { action: "write", path, source })?;
        Ok(Self(GroupedWriter::create(file, empty.schema(), |writer| writer, frame)?))
    }

    /// Takes a row.
    ///
    /// # Errors
    /// As [`TimingsWriter::create`].
    pub fn push(&mut self, timing: Timing) -> Result<(), TableError> {
        self.0.push(timing)
    }

    /// Writes the rest and makes the table durable under its name; gives its checksum.
    ///
    /// # Errors
    /// As [`TimingsWriter::create`].
    pub fn finish(self) -> Result<Checksum, TableError> {
        self.0.finish()
    }
}

impl Timing {
    /// What a sample cost, by the files that have its timing; `None` where none has.
    ///
    /// # Errors
    /// A file that cannot be read or is no table of timings.
    pub fn find(files: &[PathBuf], sample: u64) -> Result<Option<Self>, TableError> {
        for path in files {
            let failed = |source| TableError::Table { action: "read", path: path.clone(), source };
            let reader = || {
                let file = Place::from(path).open()?;
                Ok(ParquetReader::new(file).read_parallel(ParallelStrategy::None))
            };
            let Some(row) = guarded(path, || row_of(reader, path, sample))? else { continue };
            let read = || -> Result<_, PolarsError> {
                let cpu_s = row.column("cpu_s")?.f64()?.iter().next().flatten();
                let (worker, attempt) = (
                    row.column("worker")?.u32()?.iter().next().flatten(),
                    row.column("attempt")?.u32()?.iter().next().flatten(),
                );
                Ok(cpu_s.zip(worker).zip(attempt))
            };
            let found = read().map_err(failed)?;
            return Ok(found.map(|((cpu_s, worker), attempt)| Self { sample, cpu_s, worker, attempt }));
        }
        Ok(None)
    }
}

fn frame(timings: &[Timing]) -> Result<DataFrame, PolarsError> {
    let columns = vec![
        Series::new("sample".into(), timings.iter().map(|t| t.sample).collect::<Vec<_>>()).into_column(),
        Series::new("cpu_s".into(), timings.iter().map(|t| t.cpu_s).collect::<Vec<_>>()).into_column(),
        Series::new("worker".into(), timings.iter().map(|t| t.worker).collect::<Vec<_>>()).into_column(),
        Series::new("attempt".into(), timings.iter().map(|t| t.attempt).collect::<Vec<_>>()).into_column(),
    ];
    DataFrame::new(timings.len(), columns)
}
