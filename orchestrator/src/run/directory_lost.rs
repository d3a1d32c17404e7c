//! Detection of a result directory that is removed, emptied or moved during its run.
//!
//! Every two seconds the run checks that its open directory is the one at its path and that the record has its name. It stops
//! after two failed checks. A moved directory is whole and needs nothing else. For a removed one see `rescued`. If the directory
//! loses its permissions (`chmod 0 DIR`), the run continues in the open record; tables that cannot be written at the end are
//! reported.

use super::directory::{LEDGER, RunDirectory};
use bladeoff_record::Record;
use bladeoff_system::folder::Standing;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Interval of the checks.
const CHECK_INTERVAL: Duration = Duration::from_secs(2);

/// Loss of the directory of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Loss {
    /// The directory or its record was removed.
    Removed(&'static str),
    /// The directory was moved with its record.
    Moved(Option<PathBuf>),
}

/// Periodic check of the directory of a run.
#[derive(Debug)]
pub(super) struct DirectoryWatch<'a> {
    directory: &'a RunDirectory,
    next: Instant,
    suspected: bool,
}

impl<'a> DirectoryWatch<'a> {
    pub fn new(directory: &'a RunDirectory) -> Self {
        Self { directory, next: Instant::now() + CHECK_INTERVAL, suspected: false }
    }

    /// Checks the directory if it is time; returns whether two checks in a row have failed.
    pub fn finds_loss(&mut self, record: &Record) -> bool {
        let now = Instant::now();
        if now < self.next {
            return false;
        }
        self.next = now + CHECK_INTERVAL;
        let is_lost = loss(self.directory, record).is_some();
        is_lost && std::mem::replace(&mut self.suspected, is_lost)
    }
}

/// Checks the directory; `None`: it is in place.
pub(super) fn loss(directory: &RunDirectory, record: &Record) -> Option<Loss> {
    let standing = directory.open().standing();
    match (standing, record.is_in_place()) {
        (Standing::Removed, _) => Some(Loss::Removed("the result directory")),
        (_, false) => Some(Loss::Removed("the record of finished samples in")),
        (Standing::Moved(to), true) => Some(Loss::Moved(to)),
        (Standing::Here, true) => None,
    }
}

/// Whether permissions to enter the directory are missing.
pub(super) fn is_closed(directory: &RunDirectory) -> bool {
    let record = directory.file(LEDGER).identity();
    record.is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied)
}
