//! Threads of Polars. Polars starts them at its first use and panics if they cannot start; it also panics on some damaged files.

use super::error::TableError;
use bladeoff_system::guarded;
use bladeoff_system::threads;
use polars::prelude::{NamedFrom, Series, SortOptions};
use std::path::Path;

/// Lets Polars start its threads. Later calls take almost no time.
///
/// # Errors
/// [`TableError::Threads`] if the threads cannot start, which is then permanent in this process.
pub fn start_threads() -> Result<(), TableError> {
    // a sort needs the number of threads
    let sort = || Series::new("".into(), [2u32, 1]).sort(SortOptions::default()).is_ok();
    if guarded::guarded(sort).is_some() {
        return Ok(());
    }
    let failed = threads::ThreadsError { threads: 1, source: std::io::Error::other("the table library gave up") };
    Err(threads::check().err().unwrap_or(failed).into())
}

/// Converts a panic of Polars to an error: a damaged file, or missing threads.
pub(super) fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, TableError>) -> Result<T, TableError> {
    guarded::guarded(read).unwrap_or_else(|| start_threads().and(Err(TableError::Damaged { path: path.to_path_buf() })))
}
