//! The tables of a study: schema, Parquet, reading back, CSV. With `analysis/` the only place that names polars.
//!
//! `results.parquet` holds nothing about time, host or worker: the same study gives the same bytes. Row groups are
//! cut by row number, never by arrival; the writer, its settings and their order are fixed here.

mod export;
mod grouped;
mod parquet;
mod read;
mod schema;
mod series;
mod stream;
mod threads;
mod timings;

pub use export::export_csv;
pub use parquet::{Provenance, ResultsWriter, Row, Value};
pub use read::{Cells, Table, count_sound_rows};
pub use schema::{DETECTION, Field, FieldKind, SCHEMA_VERSION, TableSchema, verdict_fields};
pub use series::{NumberColumn, read_metadata, read_numbers, write_numbers};
pub use stream::Checksum;
pub use threads::start_threads;
pub use timings::{Timing, TimingsWriter};

use crate::files::FileError;
use bladeoff_model::document::visible;
use std::path::{Path, PathBuf};

/// What can go wrong with a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The table library refused to read or write.
    #[error("cannot {action} {}", visible(&path.to_string_lossy()))]
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
    #[error("{} is damaged", visible(&path.to_string_lossy()))]
    Damaged {
        /// The table.
        path: PathBuf,
    },
    /// Its bytes are not those that were written.
    #[error(
        "{} is damaged: it is not as it was written (its BLAKE3 is not the one in manifest.json); the `bladeoff run` that \
         made it makes it again from the record, and nothing is computed for that",
        visible(&path.to_string_lossy())
    )]
    Changed {
        /// The table.
        path: PathBuf,
    },
    /// The table library has no threads.
    #[error(transparent)]
    Threads(#[from] crate::threads::ThreadsError),
    /// The file has no schema version, or one that this program does not know.
    #[error("{} is not a result table of schema version {SCHEMA_VERSION} (it says {found:?})", path.display())]
    Version {
        /// The table.
        path: PathBuf,
        /// What the file says.
        found: Option<String>,
    },
}

/// The library answers some damaged files with a panic; that is damage, too, unless it lacks its threads.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, TableError>) -> Result<T, TableError> {
    crate::guarded::guarded(read)
        .unwrap_or_else(|| start_threads().and(Err(TableError::Damaged { path: path.to_path_buf() })))
}

/// Rows per row group. One group is in memory while a table is written: near 70 MB for the widest one (256 numbers a row).
const ROW_GROUP: usize = 16_384;
