//! The database, closed without a panic.

use bladeoff_system::guarded::guarded;
use redb::Database;
use std::ops::Deref;

/// An open database. Closing it writes to the file (in memory, if opened for reading only) and may reveal damage. Errors at that point are
/// ignored: all results were committed before.
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
