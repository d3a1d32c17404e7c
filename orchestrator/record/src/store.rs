//! The library's store, closed without a panic.

use bladeoff_system::guarded::guarded;
use redb::Database;
use std::ops::Deref;

/// An open store. Closing one writes to it, in memory where it is only read, and a damaged one may be found to be so only then: no matter, for
/// what counts is committed before.
#[derive(Debug)]
pub(super) struct Store(Option<Database>);

impl Store {
    pub fn new(database: Database) -> Self {
        Self(Some(database))
    }
}

impl Deref for Store {
    type Target = Database;

    fn deref(&self) -> &Database {
        self.0.as_ref().expect("there until it is dropped")
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        let database = self.0.take();
        let _ = guarded(|| drop(database));
    }
}
