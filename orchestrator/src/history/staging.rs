//! Temporary name of a history until it is complete.
//!
//! The usual name is `FILE.tmp`, where `recover` finds what a killed run left. An existing file of that name may be such a remainder or
//! belong to another user: it is left unchanged, the history is written under an unguessable name (`run-0123abcd.mcap.tmp`), and that is
//! reported.

use bladeoff_system::files::{FileError, unguessable};
use bladeoff_system::place::{Identity, Place};
use std::fs::File;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Largest number of names tried.
const MOST_NAMES: u32 = 16;

/// File of an incomplete history. On failure the written part stays; an empty file is removed.
#[derive(Debug)]
pub(super) struct StagedFile {
    temporary: Place,
    path: PathBuf,
    /// Identity of the file.
    identity: Identity,
}

impl StagedFile {
    /// Creates the file.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn create(path: &Path) -> Result<(File, Self), FileError> {
        let mut temporary = usual(path);
        for _ in 0..MOST_NAMES {
            match Place::from(&temporary).create_new() {
                Err(error) if error.source.kind() == io::ErrorKind::AlreadyExists => temporary = unusual(path),
                Err(error) => return Err(FileError::at("create", path)(error.source)),
                Ok(file) => {
                    let about = file.metadata().map_err(FileError::at("read", &temporary))?;
                    let identity = (about.dev(), about.ino());
                    let staged = Self { temporary: temporary.into(), path: path.to_path_buf(), identity };
                    return Ok((file, staged));
                }
            }
        }
        Err(FileError::at("create", path)(io::ErrorKind::AlreadyExists.into()))
    }

    /// Temporary path of the file.
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Renames the complete file to its final name, durably.
    ///
    /// # Errors
    /// Disk full, or the rename failed: the file stays under its temporary name.
    pub fn publish(self, file: File) -> Result<(), FileError> {
        file.sync_all().map_err(FileError::at("write", &self.temporary))?;
        drop(file);
        let place = Place::from(&self.path);
        self.temporary.rename_to(&place).map_err(FileError::at("rename to", &self.path))?;
        place.sync_parent()
    }
}

impl Drop for StagedFile {
    fn drop(&mut self) {
        // After publishing, the file has another name.
        let is_empty = || self.temporary.symlink_metadata().is_ok_and(|found| found.len() == 0);
        if self.temporary.identity().is_ok_and(|found| found == Some(self.identity)) && is_empty() {
            let _ = self.temporary.remove();
        }
    }
}

/// Usual temporary name of a history.
pub(super) fn usual(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".tmp");
    name.into()
}

/// An unguessable temporary name. Without `.tmp` it is a valid name of a history, too.
fn unusual(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{}", unguessable()));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    usual(&path.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::Write;

    #[test]
    fn what_stands_there_is_left_and_a_failed_history_keeps_what_it_has() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let (path, taken) = (folder.path().join("run.mcap"), folder.path().join("run.mcap.tmp"));
        let (mut file, first) = StagedFile::create(&path).expect("created");
        assert_eq!(first.temporary(), taken);
        file.write_all(b"half").expect("written");
        drop(first);
        assert_eq!(fs::read(&taken).expect("kept"), b"half");
        let (mut file, second) = StagedFile::create(&path).expect("created");
        let name = second.temporary().file_name().and_then(|name| name.to_str()).expect("UTF-8").to_owned();
        assert!(name.starts_with("run-") && name.ends_with(".mcap.tmp") && name.len() == 21, "{name}");
        file.write_all(b"whole").expect("written");
        second.publish(file).expect("renamed");
        assert_eq!(
            (fs::read(&path).expect("whole"), fs::read(&taken).expect("left")),
            (b"whole".to_vec(), b"half".to_vec())
        );
        let (_, empty) = StagedFile::create(&path).expect("created");
        drop(empty);
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 2, "nothing empty is left");
    }
}
