//! Errors of histories.

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
    /// A file name whose extension is not a history format.
    #[error("{}: the extension of a history is .mcap, .csv or .parquet", shown(path))]
    Extension {
        /// Path of the file.
        path: PathBuf,
    },
    /// Decimal commas for a format other than CSV.
    #[error("{}: decimal commas are for histories in CSV; choose a file name that ends in .csv", shown(path))]
    DecimalComma {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file that does not exist.
    #[error("there is no file {}{}", shown(path), meant(path))]
    Missing {
        /// Path of the file.
        path: PathBuf,
    },
    /// A channel that the machine does not have.
    #[error("no channel {pattern:?}{}; the channels are {}", nearest.as_ref().map(|name| format!(" (did you mean {name:?}?)")).unwrap_or_default(), known.join(", "))]
    Channel {
        /// The pattern as entered.
        pattern: String,
        /// Nearest channel name.
        nearest: Option<String>,
        /// Groups of channels that the machine has.
        known: Vec<String>,
    },
    /// A file operation that failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// An error of the table reader or writer.
    #[error(transparent)]
    Table(#[from] TableError),
    /// An error of the MCAP library.
    #[error("cannot {action} {}", shown(path))]
    Mcap {
        /// "write" or "read".
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the library.
        #[source]
        source: mcap::McapError,
    },
    /// A readable file that is not a history of this version.
    #[error("{} is not a history of version {HISTORY_VERSION}: {detail}", shown(path))]
    NotAHistory {
        /// Path of the file.
        path: PathBuf,
        /// Reason.
        detail: &'static str,
    },
    /// A line of a CSV file that is not numbers.
    #[error("{}, line {line}: {text:?} is not a number", shown(path))]
    Number {
        /// Path of the file.
        path: PathBuf,
        /// Line number from 1.
        line: usize,
        /// Text of the cell.
        text: String,
    },
    /// A file from which nothing could be recovered.
    #[error("{} holds no complete message", shown(path))]
    NothingToRecover {
        /// Path of the file.
        path: PathBuf,
    },
}

impl HistoryError {
    /// For `map_err` on reading a file that the user named: a missing file is not an input/output error.
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

    /// Error for a readable file that is not a history of this version.
    pub(super) fn not_ours(path: &Path, detail: &'static str) -> Self {
        Self::NotAHistory { path: path.to_path_buf(), detail }
    }

    /// For `map_err` on calls of the MCAP library.
    pub(super) fn mcap(action: &'static str, path: &Path) -> impl FnOnce(mcap::McapError) -> Self {
        let path = path.to_path_buf();
        move |source| HistoryError::Mcap { action, path, source }
    }
}
