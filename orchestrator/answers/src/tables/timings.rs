//! `timings.parquet`: values that may differ between identical runs, kept apart from the results.

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

/// Cost of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Row number in the study.
    pub sample: u64,
    /// CPU time of the successful attempt \[s\].
    pub cpu_s: f64,
    /// Number of the worker that computed the sample.
    pub worker: u32,
    /// Number of attempts, including the successful one.
    pub attempt: u32,
}

/// Writer of the table.
pub struct TimingsWriter(GroupedWriter<Timing>);

impl TimingsWriter {
    /// Starts a table in this file.
    ///
    /// # Errors
    /// The disk is full or not writable, or Polars reports an error.
    pub fn create(file: Pending) -> Result<Self, TableError> {
        let path = file.path().to_path_buf();
        let empty = frame(&[]).map_err(|source| TableError::Table { action: "write", path, source })?;
        Ok(Self(GroupedWriter::create(file, empty.schema(), |writer| writer, frame)?))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// As [`TimingsWriter::create`].
    pub fn push(&mut self, timing: Timing) -> Result<(), TableError> {
        self.0.push(timing)
    }

    /// Writes the remaining rows, makes the table durable under its name, and returns its checksum.
    ///
    /// # Errors
    /// As [`TimingsWriter::create`].
    pub fn finish(self) -> Result<Checksum, TableError> {
        self.0.finish()
    }
}

impl Timing {
    /// Cost of a sample, from the first of these files that contains it; `None` if no file does.
    ///
    /// # Errors
    /// A file cannot be read or is not a table of timings.
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
