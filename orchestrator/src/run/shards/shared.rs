//! Shared directory of all shards: opening, permission check, folders of chunks, hints and attempts.
//!
//! No lock on it is used: a network file system may grant a lock twice, or keep that of a dead node. Names are taken by
//! `link(2)`.

use super::super::trust::{Untrusted, check};
use super::error::ShardError;
use super::layout::{ATTEMPTS, CHUNKS, HINTS, REUSED, SCHEDULER, SHARDS, chunk_of, folder_name};
use bladeoff_study::{MACHINE, POINTS, STUDY, is_empirical};
use bladeoff_system::files::{FileError, is_temporary, sync_parent};
use bladeoff_system::folder::{Folder, Standing};
use bladeoff_worker::job_spec::{BASIS_FILE, PLAN_FILE};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::Path;

/// Names that exist before [`SHARDS`].
const FIRST: [&str; 10] = [REUSED, STUDY, MACHINE, POINTS, BASIS_FILE, PLAN_FILE, CHUNKS, HINTS, ATTEMPTS, SCHEDULER];

/// Open directory of shards.
#[derive(Debug, Clone)]
pub(super) struct Shared(Folder);

impl Shared {
    /// Opens the directory and creates it if necessary; `trusts`: also accept a directory to which other users may write.
    ///
    /// # Errors
    /// The directory has another purpose or cannot be used.
    pub fn claim(path: &Path, trusts: bool, note: &dyn Fn(&str)) -> Result<Self, ShardError> {
        if fs::symlink_metadata(path).is_err() {
            let made = fs::DirBuilder::new().recursive(true).mode(0o755).create(path);
            made.map_err(FileError::at("create", path))?;
            sync_parent(path)?;
        }
        let folder = Folder::open(path).map_err(FileError::at("open", path))?;
        trusted(&folder, trusts, note)?;
        let shared = Self(folder);
        shared.refuse_foreign()?;
        Ok(shared)
    }

    /// Opens an existing directory for reading; `None`: no shard has begun it.
    ///
    /// # Errors
    /// A file error.
    pub fn open(path: &Path) -> Result<Option<Self>, FileError> {
        match Folder::open(path) {
            Ok(folder) if folder.place(SHARDS).is_file() => Ok(Some(Self(folder))),
            Ok(_) => Ok(None),
            Err(source) if matches!(source.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(None),
            Err(source) => Err(FileError::at("open", path)(source)),
        }
    }

    /// Checks that other users cannot write to the directory, or that `trusts` allows it.
    ///
    /// # Errors
    /// [`ShardError::Untrusted`], or a file error.
    pub fn trusted(&self, trusts: bool, note: &dyn Fn(&str)) -> Result<(), ShardError> {
        trusted(&self.0, trusts, note)
    }

    fn refuse_foreign(&self) -> Result<(), ShardError> {
        if self.0.place(SHARDS).is_file() {
            return Ok(());
        }
        let names = self.0.names().map_err(FileError::at("read", self.path()))?;
        let is_first = |name: &OsStr| {
            FIRST.iter().any(|first| name == *first || is_temporary(name, first))
                // begun by another process since the check above
                || name == SHARDS
                || is_temporary(name, SHARDS)
                || name.to_str().is_some_and(is_empirical)
        };
        match names.into_iter().filter(|name| !is_first(name)).min() {
            None => Ok(()),
            Some(file) => Err(ShardError::Foreign { path: self.path().to_path_buf(), file }),
        }
    }

    /// Open folder.
    pub fn folder(&self) -> &Folder {
        &self.0
    }

    /// Path of the directory.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Whether the directory was removed.
    pub fn is_removed(&self) -> bool {
        self.0.standing() == Standing::Removed
    }

    /// Opens the folder of chunks or hints of this number; creates it if necessary.
    ///
    /// # Errors
    /// As [`Shared::made_below`].
    pub fn numbered(&self, kind: &str, number: u64) -> Result<Folder, FileError> {
        self.made_below(kind, &folder_name(number))
    }

    /// Opens a folder in one of these folders; creates it if necessary.
    ///
    /// # Errors
    /// The system refused, or another file has the name.
    pub fn made_below(&self, kind: &str, name: &str) -> Result<Folder, FileError> {
        made_in(&made_in(&self.0, kind)?, name)
    }

    /// Opens the folder of chunks of this number; `None`: it does not exist.
    pub fn chunks_in(&self, number: u64) -> io::Result<Option<Folder>> {
        match self.0.folder(CHUNKS).and_then(|chunks| chunks.folder(&folder_name(number))) {
            Ok(folder) => Ok(Some(folder)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Lists the published chunks in the folder of this number.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn names_in(&self, number: u64) -> Result<BTreeSet<u64>, FileError> {
        let names = self.chunks_in(number).and_then(|folder| folder.map_or(Ok(Vec::new()), |folder| folder.names()));
        let names = names.map_err(FileError::at("read", &self.path().join(CHUNKS).join(folder_name(number))))?;
        Ok(names.iter().filter_map(|name| chunk_of(name)).collect())
    }
}

fn made_in(folder: &Folder, name: &str) -> Result<Folder, FileError> {
    let place = folder.place(name);
    match folder.folder(name) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        found => return found.map_err(FileError::at("use", &place)),
    }
    match place.create_folder() {
        // Another process has created it.
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            return Err(FileError::at("create", &place)(error));
        }
        _ => {}
    }
    let made = folder.folder(name).map_err(FileError::at("use", &place))?;
    folder.sync()?;
    Ok(made)
}

/// Checks who may write to the directory. A group-writable directory of the user is usual on clusters and gives a note. Any other
/// writable directory is accepted only with `--trust-dir`.
fn trusted(folder: &Folder, trusts: bool, note: &dyn Fn(&str)) -> Result<(), ShardError> {
    match check(folder, trusts)? {
        None => Ok(()),
        Some(Untrusted::Mode { path, mode }) if mode & 0o002 == 0 => {
            let path = bladeoff_system::shown(&path).to_string();
            note(&format!(
                "{path} can be written by its group (mode {mode:04o}): members of the group could change the results there"
            ));
            Ok(())
        }
        Some(doubt) => Err(doubt.into()),
    }
}
