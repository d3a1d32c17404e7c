//! Why two tables are not compared.

use crate::tables::TableError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// A table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A table that no study wrote.
    #[error("{} has no column {column} before its results: it is not a result table", shown(path))]
    NoColumn {
        /// The table.
        path: PathBuf,
        /// What it lacks.
        column: &'static str,
    },
    /// A row whose status cannot be read.
    #[error("{}: row {row} has no number of a sample, or its status cannot be read", shown(path))]
    Row {
        /// The table.
        path: PathBuf,
        /// From 0.
        row: usize,
    },
    /// What is asked cannot be meant; each line with what is wrong.
    #[error("{}", .0.join("\n"))]
    Asked(Vec<String>),
}
