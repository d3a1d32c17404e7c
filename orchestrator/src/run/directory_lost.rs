//! A result directory that is removed, emptied or moved under its run: noticed within seconds, not at the end of the night.
//!
//! Every two seconds the run looks whether the directory that it holds open is the one at its path, and whether the record is
//! still under its name; two looks have to agree. Then it stops. What was only moved is whole: nothing else is done. What
//! becomes of that which was removed: `kept`. One that was closed to its user (`chmod 0 DIR`) is opened again or not before the
//! end: the record goes on in the open file; where tables cannot be written then, that is said.

use super::directory::{LEDGER, RunDirectory};
use bladeoff_record::Record;
use bladeoff_system::folder::Standing;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// What has become of the directory of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Loss {
    /// It was removed, or the record in it was.
    Removed(&'static str),
    /// It is elsewhere, with its record.
    Moved(Option<PathBuf>),
}

/// Looks from time to time.
#[derive(Debug)]
pub(super) struct Guard<'a> {
    directory: &'a RunDirectory,
    next: Instant,
    suspected: bool,
}

impl<'a> Guard<'a> {
    pub fn new(directory: &'a RunDirectory) -> Self {
        Self { directory, next: Instant::now() + LOOK_EVERY, suspected: false }
    }

    /// Whether the directory is lost, by two looks, if it is time for one.
    pub fn finds_loss(&mut self, record: &Record) -> bool {
        let now = Instant::now();
        if now < self.next {
            return false;
        }
        self.next = now + LOOK_EVERY;
        let is_lost = loss(self.directory, record).is_some();
        is_lost && std::mem::replace(&mut self.suspected, is_lost)
    }
}

/// What has become of the directory; `None`: it is where it was.
pub(super) fn loss(directory: &RunDirectory, record: &Record) -> Option<Loss> {
    let standing = directory.open().standing();
    match (standing, record.is_in_place()) {
        (Standing::Removed, _) => Some(Loss::Removed("the result directory")),
        (_, false) => Some(Loss::Removed("the record of finished samples in")),
        (Standing::Moved(to), true) => Some(Loss::Moved(to)),
        (Standing::Here, true) => None,
    }
}

/// Whether the directory cannot be entered any more.
pub(super) fn is_closed(directory: &RunDirectory) -> bool {
    let record = directory.file(LEDGER).identity();
    record.is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied)
}
