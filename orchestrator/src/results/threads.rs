//! The threads of the table library: it starts them at its first need and panics where it cannot.

use super::TableError;
use crate::guarded::guarded;
use crate::threads;
use polars::prelude::{NamedFrom, Series, SortOptions};

/// Has the library start its threads. Later calls cost next to nothing.
///
/// # Errors
/// [`TableError::Threads`] if it cannot; it never will in this process.
pub fn start_threads() -> Result<(), TableError> {
    // Its sort asks for the number of its threads.
    let sort = || Series::new("".into(), [2u32, 1]).sort(SortOptions::default()).is_ok();
    if guarded(sort).is_some() {
        return Ok(());
    }
    let failed = threads::ThreadsError { threads: 1, source: std::io::Error::other("the table library gave up") };
    Err(threads::check().err().unwrap_or(failed).into())
}
