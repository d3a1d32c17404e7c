//! `timings.parquet`: what may differ between equal runs. Kept apart from the results for that reason.

use super::{ROW_GROUP, TableError};
use crate::files::Pending;
use polars::prelude::{DataFrame, IntoColumn, NamedFrom, ParquetCompression, ParquetWriter, Series};
use std::path::Path;

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

/// Writes the table to `path`, durably.
///
/// # Errors
/// The disk is full or not writable, or the table library refused.
pub fn write_timings(path: &Path, timings: &[Timing]) -> Result<(), TableError> {
    let mut pending = Pending::create(path)?;
    let failed = |source| TableError::Table { action: "write", path: path.to_path_buf(), source };
    let columns = vec![
        Series::new("sample".into(), timings.iter().map(|t| t.sample).collect::<Vec<_>>()).into_column(),
        Series::new("cpu_s".into(), timings.iter().map(|t| t.cpu_s).collect::<Vec<_>>()).into_column(),
        Series::new("worker".into(), timings.iter().map(|t| t.worker).collect::<Vec<_>>()).into_column(),
        Series::new("attempt".into(), timings.iter().map(|t| t.attempt).collect::<Vec<_>>()).into_column(),
    ];
    let mut frame = DataFrame::new(timings.len(), columns).map_err(failed)?;
    ParquetWriter::new(pending.file())
        .with_compression(ParquetCompression::Zstd(None))
        .with_row_group_size(Some(ROW_GROUP))
        .finish(&mut frame)
        .map_err(failed)?;
    pending.finish()?;
    Ok(())
}
