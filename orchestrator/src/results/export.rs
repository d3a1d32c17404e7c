//! The result table as CSV: for programs that read nothing better. Numbers keep all their digits; null is empty.

use super::TableError;
use super::read::read_frame;
use polars::prelude::{CsvWriter, SerWriter};
use std::io::Write;
use std::path::Path;

/// Writes the table at `path` as CSV with a header line to `out`.
///
/// # Errors
/// The table cannot be read, or `out` cannot be written.
pub fn export_csv(path: &Path, out: impl Write) -> Result<(), TableError> {
    let mut frame = read_frame(path)?;
    CsvWriter::new(out).include_header(true).finish(&mut frame).map_err(|source| TableError::Table {
        action: "export",
        path: path.to_path_buf(),
        source,
    })
}
