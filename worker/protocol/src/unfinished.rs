//! Removes shared memory whose process died between creating it and setting its size.
//!
//! When iceoryx2 0.10 opens such an object, it waits for the size without end (`dynamic_storage::posix_shared_memory`,
//! `MappingSizeIsZero`), also in dead-node cleanup: a worker killed in the wrong microsecond of its start would stop the hub for
//! good. Once the object is removed, a waiting process continues with "does not exist". A living process sets the size at once; a
//! process that is delayed by more than 3 s loses its connection and is replaced.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::names::{Address, SHM};

/// An object without size is removed this long after it was first seen.
const PATIENCE: Duration = Duration::from_secs(3);

/// Finds unfinished objects in the memory of one domain.
#[derive(Debug)]
pub struct Unfinished {
    shm: PathBuf,
    prefix: String,
    /// Objects without size and when they were first seen.
    seen: BTreeMap<OsString, Duration>,
}

impl Unfinished {
    /// Starts with no object seen.
    #[must_use]
    pub fn new(address: &Address) -> Self {
        Self::within(Path::new(SHM), &address.prefix)
    }

    fn within(shm: &Path, prefix: &str) -> Self {
        Self { shm: shm.to_owned(), prefix: prefix.to_owned(), seen: BTreeMap::new() }
    }

    /// Removes objects that have had no size for 3 s and returns their number. To be called about once a second; `now` must not decrease.
    pub fn sweep(&mut self, now: Duration) -> usize {
        let mut removed = 0;
        let mut still = BTreeMap::new();
        for entry in fs::read_dir(&self.shm).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let is_ours = name.as_encoded_bytes().starts_with(self.prefix.as_bytes());
            if !is_ours || entry.metadata().map_or(true, |found| found.len() > 0) {
                continue;
            }
            let since = self.seen.get(&name).copied().unwrap_or(now);
            if now.saturating_sub(since) < PATIENCE {
                still.insert(name, since);
            } else if fs::remove_file(entry.path()).is_ok() {
                removed += 1;
            }
        }
        self.seen = still;
        removed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stays_without_size_is_removed_and_nothing_else() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let path = |name: &str| dir.path().join(name);
        for name in ["ours_dead", "ours_slow", "other_dead"] {
            fs::write(path(name), b"").expect("written");
        }
        fs::write(path("ours_whole"), b"x").expect("written");
        let mut unfinished = Unfinished::within(dir.path(), "ours_");
        let seconds = Duration::from_secs;
        assert_eq!(unfinished.sweep(seconds(10)), 0);
        fs::write(path("ours_slow"), b"x").expect("written");
        assert_eq!(unfinished.sweep(seconds(12)), 0);
        fs::write(path("ours_late"), b"").expect("written");
        assert_eq!(unfinished.sweep(seconds(13)), 1);
        let left = |name: &str| path(name).exists();
        assert!(!left("ours_dead"));
        assert!(left("ours_slow") && left("ours_whole") && left("ours_late") && left("other_dead"));
    }
}
