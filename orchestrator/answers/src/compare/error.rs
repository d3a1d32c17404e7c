//! Errors of a comparison of two tables.

use crate::tables::TableError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// Reason why two tables cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// Error while reading a table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A table without a column that every result table has.
    #[error("{} has no column {column} before its results: it is not a result table", shown(path))]
    NoColumn {
        /// Path of the table.
        path: PathBuf,
        /// Name of the missing column.
        column: &'static str,
    },
    /// A row whose sample number or status cannot be read.
    #[error("{}: row {row} has no number of a sample, or its status cannot be read", shown(path))]
    Row {
        /// Path of the table.
        path: PathBuf,
        /// Row number from 0.
        row: usize,
    },
    /// Invalid options, one line for each error.
    #[error("{}", .0.join("\n"))]
    Asked(Vec<String>),
}
