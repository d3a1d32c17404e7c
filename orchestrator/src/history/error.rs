//! Errors of a history.

use super::version::HISTORY_VERSION;
use bladeoff_answers::tables::TableError;
use bladeoff_study::meant;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A history that cannot be written, read or recovered.
#[derive(Debug, thiserror::Error)]
pub enum HistoryError {
    /// The extension names no format.
    #[error("{}: the extension of a history is .mcap, .csv or .parquet", shown(path))]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// Decimal commas in a format that has none.
    #[error("{}: decimal commas are for histories in CSV; choose a file name that ends in .csv", shown(path))]
    DecimalComma {
        /// The file.
        path: PathBuf,
    },
    /// No such file.
    #[error("there is no file {}{}", shown(path), meant(path))]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// A channel that the machine does not have.
    #[error("no channel {pattern:?}{}; the channels are {}", nearest.as_ref().map(|name| format!(" (did you mean {name:?}?)")).unwrap_or_default(), known.join(", "))]
    Channel {
        /// What was asked for.
        pattern: String,
        /// The nearest name.
        nearest: Option<String>,
        /// Every name there is.
        known: Vec<String>,
    },
    /// A file operation.
    #[error(transparent)]
    File(#[from] FileError),
    /// The table library.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The MCAP library.
    #[error("cannot {action} {}", shown(path))]
    Mcap {
        /// "write" or "read".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What it said.
        #[source]
        source: mcap::McapError,
    },
    /// The file is whole but not one of ours.
    #[error("{} is not a history of version {HISTORY_VERSION}: {detail}", shown(path))]
    NotAHistory {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        detail: &'static str,
    },
    /// A line of a CSV file that is not numbers.
    #[error("{}, line {line}: {text:?} is not a number", shown(path))]
    Number {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        text: String,
    },
    /// Nothing could be recovered.
    #[error("{} holds no complete message", shown(path))]
    NothingToRecover {
        /// The file.
        path: PathBuf,
    },
}

impl HistoryError {
    /// For `map_err` on what reads a file that somebody named: one that is not there is no fault of the disk.
    pub(super) fn named(path: &Path) -> impl FnOnce(Self) -> Self {
        let path = path.to_path_buf();
        move |error| match &error {
            HistoryError::File(file) | HistoryError::Table(TableError::File(file))
                if matches!(file.source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
            {
                HistoryError::Missing { path }
            }
            _ => error,
        }
    }

    /// A file that is whole and no history of ours.
    pub(super) fn not_ours(path: &Path, detail: &'static str) -> Self {
        Self::NotAHistory { path: path.to_path_buf(), detail }
    }

    /// For `map_err` on the MCAP library.
    pub(super) fn mcap(action: &'static str, path: &Path) -> impl FnOnce(mcap::McapError) -> Self {
        let path = path.to_path_buf();
        move |source| HistoryError::Mcap { action, path, source }
    }
}
