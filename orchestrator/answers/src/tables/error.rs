//! Why a table is not written or read.

use super::schema::SCHEMA_VERSION;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// What can go wrong with a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The table library refused to read or write.
    #[error("cannot {action} {}", shown(path))]
    Table {
        /// "write", "read" or "export".
        action: &'static str,
        /// The table.
        path: PathBuf,
        /// What it said.
        #[source]
        source: polars::error::PolarsError,
    },
    /// The table library gave up on it.
    #[error("{} is damaged", shown(path))]
    Damaged {
        /// The table.
        path: PathBuf,
    },
    /// Its bytes are not those that were written.
    #[error(
        "{} is damaged: it has changed since it was written (its BLAKE3 is not the recorded one); the \
         `bladeoff run` that made it rewrites it from the record without computing a sample",
        shown(path)
    )]
    Changed {
        /// The table.
        path: PathBuf,
    },
    /// The table library has no threads.
    #[error(transparent)]
    Threads(#[from] bladeoff_system::threads::ThreadsError),
    /// The file has no schema version, or one that this program does not know.
    #[error("{} was written by another version of the program (table schema {}, this one's {SCHEMA_VERSION}): compute the study again with another --out, or read it with that version", shown(path), found.as_deref().unwrap_or("unknown"))]
    Version {
        /// The table.
        path: PathBuf,
        /// What the file says.
        found: Option<String>,
    },
}
