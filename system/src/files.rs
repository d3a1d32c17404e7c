//! Files that are either whole or absent: written aside, synced, renamed, the directory synced.

use std::fs::File;
use std::io::Write;
use std::path::Path;

pub use crate::error::{FileError, sync_directory};
use crate::place::Place;

/// A file under construction: under another name (`NAME.tmp` beside its final place, if nothing else is said), removed if
/// it is never finished.
#[derive(Debug)]
pub struct Pending {
    file: Option<File>,
    temporary: Place,
    path: Place,
}

impl Pending {
    /// Starts a file that will be `path`.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn create(path: impl Into<Place>) -> Result<Self, FileError> {
        let path = path.into();
        let temporary = path.with_suffix(".tmp");
        Self::create_at(path, temporary)
    }

    /// Starts a file that will be `path` and is written at `temporary`, on the same file system, in place of whatever has that
    /// name.
    ///
    /// # Errors
    /// The directory of `temporary` cannot be written.
    pub fn create_at(path: impl Into<Place>, temporary: impl Into<Place>) -> Result<Self, FileError> {
        let (path, temporary) = (path.into(), temporary.into());
        Ok(Self { file: Some(temporary.create_new()?), temporary, path })
    }

    /// The file to write to.
    pub fn file(&mut self) -> &mut File {
        self.file.as_mut().expect("present until finish consumes self")
    }

    /// Its final name.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes it durable under its final name.
    ///
    /// # Errors
    /// Disk full, or the rename or sync failed; nothing is left under the final name then.
    pub fn finish(mut self) -> Result<(), FileError> {
        let file = self.file.take().expect("present until finish consumes self");
        file.sync_all().map_err(FileError::at("write", &self.temporary))?;
        drop(file);
        self.temporary.rename_to(&self.path).map_err(FileError::at("rename to", &self.path))?;
        self.path.sync_parent()
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        // After `finish` the temporary name no longer exists; on the error path the leftover is of no use.
        let _ = self.temporary.remove();
    }
}

/// Writes a whole file durably.
///
/// # Errors
/// As [`Pending::finish`].
pub fn write_whole(path: impl Into<Place>, bytes: &[u8]) -> Result<(), FileError> {
    let path = path.into();
    let mut pending = Pending::create(&path)?;
    pending.file().write_all(bytes).map_err(FileError::at("write", &path))?;
    pending.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn an_unfinished_file_leaves_nothing() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let path = directory.path().join("a.txt");
        let mut pending = Pending::create(&path).expect("create");
        pending.file().write_all(b"half").expect("write");
        drop(pending);
        assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 0);
        write_whole(&path, b"whole").expect("write");
        assert_eq!(fs::read(&path).expect("read"), b"whole");
        assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 1);
    }
}
