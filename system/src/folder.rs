//! A directory that is held open: names are looked up in the open directory, even if it is moved or its path is replaced.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::fs::{self, CWD, Dir, Mode, OFlags, Stat};

use crate::error::FileError;
use crate::place::{Place, Unfit, gone, identity};

/// State of a directory since it was opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Standing {
    /// The directory is still at its path, or its state cannot be read.
    Here,
    /// The directory was removed.
    Removed,
    /// The directory was moved; the new path if the system reports one.
    Moved(Option<PathBuf>),
}

/// A directory that is held open.
#[derive(Debug, Clone)]
pub struct Folder {
    fd: Arc<OwnedFd>,
    path: PathBuf,
}

impl AsFd for Folder {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

impl Folder {
    /// Opens a directory by the path that the user gave; symbolic links in that path are followed.
    ///
    /// # Errors
    /// The path does not exist, is not a directory, or cannot be read.
    pub fn open(path: &Path) -> io::Result<Self> {
        let named = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        let fd = fs::openat(CWD, named, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?;
        Ok(Self { fd: Arc::new(fd), path: path.to_path_buf() })
    }

    /// Opens a subdirectory, but not through a symbolic link.
    ///
    /// # Errors
    /// As [`Folder::open`].
    pub fn folder(&self, name: &str) -> io::Result<Self> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC | OFlags::NOFOLLOW;
        let fd = fs::openat(&self.fd, name, flags, Mode::empty())
            .map_err(|errno| if self.place(name).is_link() { Unfit::Link.into() } else { io::Error::from(errno) })?;
        Ok(Self { fd: Arc::new(fd), path: self.path.join(name) })
    }

    /// The place of a name in this directory.
    #[must_use]
    pub fn place(&self, name: impl AsRef<OsStr>) -> Place {
        let name = name.as_ref();
        Place::within(Arc::clone(&self.fd), name, self.path.join(name))
    }

    /// The path by which the directory was opened, for messages.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All names in the directory except `.` and `..`.
    ///
    /// # Errors
    /// The directory cannot be read.
    pub fn names(&self) -> io::Result<Vec<OsString>> {
        let mut names = Vec::new();
        for entry in Dir::read_from(&self.fd)? {
            let entry = entry?;
            let name = OsStr::from_bytes(entry.file_name().to_bytes());
            if name != "." && name != ".." {
                names.push(name.to_owned());
            }
        }
        Ok(names)
    }

    /// Makes the names in this directory durable.
    ///
    /// # Errors
    /// The system refused.
    pub fn sync(&self) -> Result<(), FileError> {
        fs::fsync(&self.fd).map_err(|errno| FileError::at("sync", &self.path)(errno.into()))
    }

    /// Status of the open directory (`fstat`).
    ///
    /// # Errors
    /// The system refused.
    pub fn stat(&self) -> io::Result<Stat> {
        Ok(fs::fstat(&self.fd)?)
    }

    /// Compares the open directory with the one at its path. A directory whose status cannot be read counts as unchanged.
    #[must_use]
    pub fn standing(&self) -> Standing {
        let Ok(held) = fs::fstat(&self.fd) else { return Standing::Here };
        if held.st_nlink == 0 {
            return Standing::Removed;
        }
        let named = if self.path.as_os_str().is_empty() { Path::new(".") } else { &self.path };
        match fs::stat(named) {
            Ok(found) if identity(&found) == identity(&held) => Standing::Here,
            Ok(_) => self.moved(),
            Err(errno) if gone(errno) => self.moved(),
            Err(_) => Standing::Here,
        }
    }

    fn moved(&self) -> Standing {
        let path = std::fs::read_link(format!("/proc/self/fd/{}", self.fd.as_raw_fd())).ok();
        // Some file systems keep no link count of directories.
        if path.as_ref().is_some_and(|path| path.as_os_str().as_bytes().ends_with(b" (deleted)")) {
            return Standing::Removed;
        }
        let is_it = |path: &PathBuf| {
            fs::stat(path).is_ok_and(|found| fs::fstat(&self.fd).is_ok_and(|held| identity(&found) == identity(&held)))
        };
        Standing::Moved(path.filter(is_it))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_directory_is_the_one_that_was_opened_whatever_becomes_of_its_path() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let (first, second) = (directory.path().join("first"), directory.path().join("second"));
        std::fs::create_dir(&first).expect("created");
        let folder = Folder::open(&first).expect("opened");
        assert_eq!(folder.standing(), Standing::Here);
        std::fs::rename(&first, &second).expect("renamed");
        let now = std::fs::canonicalize(&second).expect("there");
        assert_eq!(folder.standing(), Standing::Moved(Some(now.clone())));
        symlink(&now, &first).expect("linked");
        assert_eq!(folder.standing(), Standing::Here, "the path leads to it again");
        std::fs::remove_file(&first).expect("removed");
        std::fs::create_dir(&first).expect("created");
        assert_eq!(folder.standing(), Standing::Moved(Some(now)), "another one at its path");
        folder.place("file").create_new().expect("made");
        assert!(second.join("file").exists() && !first.join("file").exists());
        std::fs::remove_dir_all(&second).expect("removed");
        assert_eq!(folder.standing(), Standing::Removed);
        symlink(&first, directory.path().join("link")).expect("linked");
        assert!(Folder::open(directory.path()).expect("there").folder("link").is_err(), "not through a link");
    }
}
