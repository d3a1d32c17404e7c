//! Errors while reading or writing a table.

use super::schema::SCHEMA_VERSION;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// Error while reading or writing a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// An error of Polars.
    #[error("cannot {action} {}", shown(path))]
    Table {
        /// "write", "read" or "export".
        action: &'static str,
        /// Path of the table.
        path: PathBuf,
        /// Error of Polars.
        #[source]
        source: polars::error::PolarsError,
    },
    /// A panic of Polars on a damaged file.
    #[error("{} is damaged", shown(path))]
    Damaged {
        /// Path of the table.
        path: PathBuf,
    },
    /// A file whose checksum differs from the recorded one.
    #[error(
        "{} is damaged: it has changed since it was written (its BLAKE3 is not the recorded one); the \
         `bladeoff run` that made it rewrites it from the record without computing a sample",
        shown(path)
    )]
    Changed {
        /// Path of the table.
        path: PathBuf,
    },
    /// The thread pool of Polars could not be started.
    #[error(transparent)]
    Threads(#[from] bladeoff_system::threads::ThreadsError),
    /// A file without a schema version, or with an unknown one.
    #[error("{} was written by another version of the program (table schema {}, this one's {SCHEMA_VERSION}): compute the study again with another --out, or read it with that version", shown(path), found.as_deref().unwrap_or("unknown"))]
    Version {
        /// Path of the table.
        path: PathBuf,
        /// Version found in the file.
        found: Option<String>,
    },
}
