//! `timings.parquet`: what may differ between equal runs. Kept apart from the results for that reason.

use super::{ROW_GROUP, TableError};
use crate::files::{FileError, Pending};
use polars::io::parquet::write::BatchedWriter;
use polars::prelude::{DataFrame, IntoColumn, NamedFrom, ParquetCompression, ParquetWriter, PolarsError, Series};
use std::fs::File;
use std::path::{Path, PathBuf};

/// What one sample cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Row number in the study.
    pub sample: u64,
    /// CPU time of the attempt that counted [s].
    pub cpu_s: f64,
    /// Number of the worker that computed it.
    pub worker: u32,
    /// Attempts, the one that counted included.
    pub attempt: u32,
}

/// The table under construction, written in row groups as they come.
pub struct TimingsWriter {
    path: PathBuf,
    pending: Pending,
    writer: BatchedWriter<File>,
    group: Vec<Timing>,
}

impl TimingsWriter {
    /// Starts a table that will be `path`.
    ///
    /// # Errors
    /// The disk is full or not writable, or the table library refused.
    pub fn create(path: &Path) -> Result<Self, TableError> {
        let mut pending = Pending::create(path)?;
        let file = pending.file().try_clone().map_err(FileError::at("write", path))?;
        let empty = frame(&[]).map_err(failed(path))?;
        let writer = ParquetWriter::new(file)
            .with_compression(ParquetCompression::Zstd(None))
            .batched(empty.schema())
            .map_err(failed(path))?;
        Ok(Self { path: path.to_path_buf(), pending, writer, group: Vec::new() })
    }

    /// Takes a row.
    ///
    /// # Errors
    /// As [`TimingsWriter::create`].
    pub fn push(&mut self, timing: Timing) -> Result<(), TableError> {
        self.group.push(timing);
        if self.group.len() == ROW_GROUP { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> Result<(), TableError> {
        let written = frame(&self.group).and_then(|frame| self.writer.write_batch(&frame));
        self.group.clear();
        written.map_err(failed(&self.path))
    }

    /// Writes the rest and makes the table durable under its name.
    ///
    /// # Errors
    /// As [`TimingsWriter::create`].
    pub fn finish(mut self) -> Result<(), TableError> {
        if !self.group.is_empty() {
            self.write_group()?;
        }
        self.writer.finish().map_err(failed(&self.path))?;
        Ok(self.pending.finish()?)
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

fn failed(path: &Path) -> impl FnOnce(PolarsError) -> TableError {
    let path = path.to_path_buf();
    move |source| TableError::Table { action: "write", path, source }
}
