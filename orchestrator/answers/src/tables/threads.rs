//! The threads of the table library: it starts them at its first need and panics where it cannot; so it does over some damaged files.

use super::error::TableError;
use bladeoff_system::guarded;
use bladeoff_system::threads;
use polars::prelude::{NamedFrom, Series, SortOptions};
use std::path::Path;

/// Has the library start its threads. Later calls cost next to nothing.
///
/// # Errors
/// [`TableError::Threads`] if it cannot; it never will in this process.
pub fn start_threads() -> Result<(), TableError> {
    // Its sort asks for the number of its threads.
    let sort = || Series::new("".into(), [2u32, 1]).sort(SortOptions::default()).is_ok();
    if guarded::guarded(sort).is_some() {
        return Ok(());
    }
    let failed = threads::ThreadsError { threads: 1, source: std::io::Error::other("the table library gave up") };
    Err(threads::check().err().unwrap_or(failed).into())
}

/// The library answers some damaged files with a panic; that is damage, too, unless it lacks its threads.
pub(super) fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, TableError>) -> Result<T, TableError> {
    guarded::guarded(read).unwrap_or_else(|| start_threads().and(Err(TableError::Damaged { path: path.to_path_buf() })))
}
