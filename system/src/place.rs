//! Names in a directory that is held open. Only regular files are used, and no symbolic links are followed.
//!
//! Another user who can write in a directory can put a link, a pipe, a device or a huge file under any name in it. So a name is looked up in
//! the directory that was opened and checked ([`Folder`](crate::folder::Folder)), even if the path of that directory changes. The last step
//! follows no symbolic link and opening never blocks. An opened file is used only if it is regular. A file that is read whole has a size
//! limit; a file that is written in place has no second name.

use crate::shown;
use std::ffi::OsStr;
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::fs::{self, AtFlags, CWD, FileType, Mode, OFlags, RenameFlags, Stat};
use rustix::process::geteuid;

use crate::error::{FileError, SYNC, sync_parent};

/// Reason for not using the file under a name.
#[derive(Debug, thiserror::Error)]
pub enum Unfit {
    /// A directory, device, pipe ...
    #[error("it is {0} and not a regular file")]
    Kind(&'static str),
    /// A symbolic link, where links are not followed.
    #[error("it is a symbolic link, which is not followed here")]
    Link,
    /// A file that exceeds the size limit.
    #[error("it has {bytes} bytes; at most {limit} are read")]
    TooLarge {
        /// Size of the file.
        bytes: u64,
        /// Largest allowed.
        limit: u64,
    },
    /// A file that would be written in place but has a second hard link.
    #[error(
        "it has a second name ({links} hard links), and writing it would change that file, too; remove it, or copy \
         the directory"
    )]
    Links {
        /// Number of hard links.
        links: u64,
    },
    /// Error of the system.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl From<rustix::io::Errno> for Unfit {
    fn from(errno: rustix::io::Errno) -> Self {
        Self::Io(errno.into())
    }
}

impl From<Unfit> for io::Error {
    fn from(unfit: Unfit) -> Self {
        match unfit {
            Unfit::Io(source) => source,
            unfit => io::Error::new(io::ErrorKind::InvalidInput, unfit),
        }
    }
}

/// Identity of a file, independent of its names: device and inode number.
pub type Identity = (u64, u64);

/// A name in an open directory, or a path as a whole. Messages use it as a path. Files are opened by its own functions only, none of which
/// follows a symbolic link under the name itself (except for [`Place::named`]).
#[derive(Debug, Clone)]
pub struct Place {
    base: Option<Arc<OwnedFd>>,
    name: PathBuf,
    path: PathBuf,
    follows: bool,
}

impl Place {
    /// A file that the user names. Symbolic links are followed: the user is responsible for them.
    #[must_use]
    pub fn named(path: &Path) -> Self {
        Self { follows: true, ..Self::from(path) }
    }

    /// A name in an open directory; `path`: for messages.
    pub(crate) fn within(base: Arc<OwnedFd>, name: &OsStr, path: PathBuf) -> Self {
        Self { base: Some(base), name: name.into(), path, follows: false }
    }

    /// Appends `suffix` to the name; the directory stays the same.
    #[must_use]
    pub fn with_suffix(&self, suffix: &str) -> Self {
        let longer = |path: &Path| {
            let mut name = path.as_os_str().to_owned();
            name.push(suffix);
            PathBuf::from(name)
        };
        Self { base: self.base.clone(), name: longer(&self.name), path: longer(&self.path), follows: self.follows }
    }

    /// Another name in the same directory.
    #[must_use]
    pub fn with_name(&self, name: &str) -> Self {
        let (name, path) = (self.name.with_file_name(name), self.path.with_file_name(name));
        Self { base: self.base.clone(), name, path, follows: self.follows }
    }

    fn base(&self) -> BorrowedFd<'_> {
        self.base.as_ref().map_or(CWD, |fd| fd.as_fd())
    }

    fn stat(&self) -> rustix::io::Result<Stat> {
        let flags = if self.follows { AtFlags::empty() } else { AtFlags::SYMLINK_NOFOLLOW };
        fs::statat(self.base(), &self.name, flags)
    }

    /// Whether any file has this name, including a broken link.
    #[must_use]
    pub fn exists(&self) -> bool {
        self.stat().is_ok()
    }

    /// Whether a regular file has this name.
    #[must_use]
    pub fn is_file(&self) -> bool {
        self.stat().is_ok_and(|found| fit(&found).is_ok())
    }

    /// Whether the name is taken by anything but a regular file.
    #[must_use]
    pub fn is_there_but_no_file(&self) -> bool {
        self.stat().is_ok_and(|found| fit(&found).is_err())
    }

    /// Whether the name is a symbolic link.
    pub(crate) fn is_link(&self) -> bool {
        let found = fs::statat(self.base(), &self.name, AtFlags::SYMLINK_NOFOLLOW);
        found.is_ok_and(|found| FileType::from_raw_mode(found.st_mode) == FileType::Symlink)
    }

    /// User id of the owner of the file; `None` if there is no file.
    #[must_use]
    pub fn owner(&self) -> Option<u32> {
        self.stat().ok().map(|found| found.st_uid)
    }

    /// Identity of the file; `None` if there is no file.
    ///
    /// # Errors
    /// The system refused.
    pub fn identity(&self) -> io::Result<Option<Identity>> {
        match self.stat() {
            Ok(found) => Ok(Some(identity(&found))),
            Err(errno) if gone(errno) => Ok(None),
            Err(errno) => Err(errno.into()),
        }
    }

    fn open_as(&self, flags: OFlags, mode: Mode) -> Result<File, Unfit> {
        // Checked before opening, because opening a device can have side effects, and again afterwards.
        match self.stat() {
            Ok(found) => fit(&found)?,
            Err(errno) if gone(errno) && flags.contains(OFlags::CREATE) => {}
            Err(errno) => return Err(errno.into()),
        }
        let follow = if self.follows { OFlags::empty() } else { OFlags::NOFOLLOW };
        let flags = flags | follow | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
        let file = match fs::openat(self.base(), &self.name, flags, mode) {
            Err(rustix::io::Errno::LOOP) if !self.follows => return Err(Unfit::Link),
            opened => opened?,
        };
        fit(&fs::fstat(&file)?)?;
        Ok(File::from(file))
    }

    /// Opens a regular file to be read.
    ///
    /// # Errors
    /// The file does not exist, is not a regular file, or cannot be read.
    pub fn open(&self) -> Result<File, FileError> {
        self.open_as(OFlags::RDONLY, FILE_MODE).map_err(|unfit| FileError::at("read", &self.path)(unfit.into()))
    }

    /// Opens a regular file that has no other name, to be read and written in place.
    ///
    /// # Errors
    /// As [`Place::open`]; the file has a second name.
    pub fn open_own(&self) -> Result<File, FileError> {
        self.open_to("write", OFlags::RDWR, FILE_MODE)
    }

    /// Opens a file like [`Place::open_own`] and creates it if it is missing. Other users get no permissions: who may open a file may also lock it.
    ///
    /// # Errors
    /// As [`Place::open_own`].
    pub fn open_or_create(&self) -> Result<File, FileError> {
        let file = self.open_to("create", OFlags::RDWR | OFlags::CREATE, CLOSED_MODE)?;
        close_to_others(&file);
        Ok(file)
    }

    /// Opens a file for appending, readable by other users, and creates it if it is missing.
    ///
    /// # Errors
    /// As [`Place::open_own`].
    pub fn append(&self) -> Result<File, FileError> {
        self.open_to("create", OFlags::WRONLY | OFlags::APPEND | OFlags::CREATE, FILE_MODE)
    }

    fn open_to(&self, action: &'static str, flags: OFlags, mode: Mode) -> Result<File, FileError> {
        let open = || {
            let file = self.open_as(flags, mode)?;
            let links = links(&fs::fstat(&file)?);
            if links > 1 { Err(Unfit::Links { links }) } else { Ok(file) }
        };
        open().map_err(|unfit: Unfit| FileError::at(action, &self.path)(unfit.into()))
    }

    /// Creates a new file for reading and writing, readable by other users.
    ///
    /// # Errors
    /// The name is taken, or the directory cannot be written.
    pub fn create_new(&self) -> Result<File, FileError> {
        self.create_with(FILE_MODE)
    }

    /// Creates a new file for reading and writing, without permissions for other users.
    ///
    /// # Errors
    /// As [`Place::create_new`].
    pub fn create_closed(&self) -> Result<File, FileError> {
        self.create_with(CLOSED_MODE)
    }

    fn create_with(&self, mode: Mode) -> Result<File, FileError> {
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let created = fs::openat(self.base(), &self.name, flags, mode);
        created.map(File::from).map_err(|errno| FileError::at("create", &self.path)(errno.into()))
    }

    /// Reads a regular file of at most `limit` bytes.
    ///
    /// # Errors
    /// [`Unfit`]: the reason for not reading the file.
    pub fn read_checked(&self, limit: u64) -> Result<Vec<u8>, Unfit> {
        let file = self.open_as(OFlags::RDONLY, FILE_MODE)?;
        let bytes = file.metadata()?.len();
        if bytes > limit {
            return Err(Unfit::TooLarge { bytes, limit });
        }
        let mut read = Vec::with_capacity(usize::try_from(bytes).unwrap_or_default() + 1);
        // The file may grow meanwhile, and generated files (/proc) report no size.
        file.take(limit + 1).read_to_end(&mut read)?;
        if read.len() as u64 > limit { Err(Unfit::TooLarge { bytes: read.len() as u64, limit }) } else { Ok(read) }
    }

    /// As [`Place::read_checked`], with the error of a file operation.
    ///
    /// # Errors
    /// The file is not read; the source of the error is the reason.
    pub fn read(&self, limit: u64) -> Result<Vec<u8>, FileError> {
        self.read_checked(limit).map_err(|unfit| FileError::at("read", &self.path)(unfit.into()))
    }

    /// Removes the file under this name, but no directory. Returns whether there was one.
    ///
    /// # Errors
    /// The system refused.
    pub fn remove(&self) -> Result<bool, FileError> {
        match fs::unlinkat(self.base(), &self.name, AtFlags::empty()) {
            Ok(()) => Ok(true),
            Err(errno) if gone(errno) => Ok(false),
            Err(errno) => Err(FileError::at("remove", &self.path)(errno.into())),
        }
    }

    /// Removes an empty directory.
    ///
    /// # Errors
    /// The system refused.
    pub fn remove_folder(&self) -> io::Result<()> {
        Ok(fs::unlinkat(self.base(), &self.name, AtFlags::REMOVEDIR)?)
    }

    /// Creates a directory that other users cannot write in.
    ///
    /// # Errors
    /// The system refused.
    pub fn create_folder(&self) -> io::Result<()> {
        Ok(fs::mkdirat(self.base(), &self.name, Mode::from_bits_truncate(0o755))?)
    }

    /// Checks that a file named by the user may be replaced by a new one: the name is free, or a regular file or a link to one. A device, a
    /// pipe or an open file (`/dev/stdout`) must stay in place for the programs that use it.
    ///
    /// # Errors
    /// The name is taken by anything else.
    pub fn may_be_replaced(&self) -> Result<(), FileError> {
        if self.base.is_some() {
            return Ok(());
        }
        let refused = |unfit: Unfit| FileError::at("replace", &self.path)(unfit.into());
        if self.is_link() {
            let target = fs::readlinkat(self.base(), &self.name, Vec::new()).map_err(|errno| refused(errno.into()))?;
            if target.as_bytes().starts_with(b"/proc/") {
                return Err(refused(Unfit::Kind("the name of an open file")));
            }
        }
        match fs::stat(&self.name) {
            Ok(found) => fit(&found).map_err(refused),
            Err(_) => Ok(()),
        }
    }

    /// Renames the file to `other` and replaces the file there.
    ///
    /// # Errors
    /// The system refused.
    pub fn rename_to(&self, other: &Self) -> io::Result<()> {
        Ok(fs::renameat(self.base(), &self.name, other.base(), &other.name)?)
    }

    /// Renames the file to `other` if that name is free.
    ///
    /// # Errors
    /// The system refused.
    pub fn rename_to_free(&self, other: &Self) -> io::Result<()> {
        match fs::renameat_with(self.base(), &self.name, other.base(), &other.name, RenameFlags::NOREPLACE) {
            // The file system does not support this flag.
            Err(rustix::io::Errno::INVAL | rustix::io::Errno::NOSYS) if !other.exists() => self.rename_to(other),
            renamed => Ok(renamed?),
        }
    }

    /// Exchanges two names.
    ///
    /// # Errors
    /// The system refused, or does not support the exchange.
    pub fn exchange_with(&self, other: &Self) -> io::Result<()> {
        Ok(fs::renameat_with(self.base(), &self.name, other.base(), &other.name, RenameFlags::EXCHANGE)?)
    }

    /// Gives a file a second name.
    ///
    /// # Errors
    /// The name `other` is taken, or the file system does not support hard links.
    pub fn link_to(&self, other: &Self) -> io::Result<()> {
        Ok(fs::linkat(self.base(), &self.name, other.base(), &other.name, AtFlags::empty())?)
    }

    /// Makes the names in the parent directory durable.
    ///
    /// # Errors
    /// The system refused.
    pub fn sync_parent(&self) -> Result<(), FileError> {
        match &self.base {
            Some(fd) if self.name.components().count() == 1 => {
                fs::fsync(fd).map_err(|errno| FileError::at(SYNC, &self.path)(errno.into()))
            }
            _ => sync_parent(&self.path),
        }
    }
}

impl From<&Path> for Place {
    fn from(path: &Path) -> Self {
        Self { base: None, name: path.to_path_buf(), path: path.to_path_buf(), follows: false }
    }
}

impl From<&PathBuf> for Place {
    fn from(path: &PathBuf) -> Self {
        Self::from(path.as_path())
    }
}

impl From<PathBuf> for Place {
    fn from(path: PathBuf) -> Self {
        Self::from(path.as_path())
    }
}

impl From<&Place> for Place {
    fn from(place: &Place) -> Self {
        place.clone()
    }
}

impl Deref for Place {
    type Target = Path;
    fn deref(&self) -> &Path {
        &self.path
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        shown(&self.path).fmt(f)
    }
}

const FILE_MODE: Mode = Mode::from_bits_truncate(0o644);
/// Mode of files that only their owner may lock: every user who may open a file, even just for reading, may lock it.
const CLOSED_MODE: Mode = Mode::from_bits_truncate(0o600);
const OTHERS: Mode = Mode::from_bits_truncate(0o077);

/// Removes the permissions of other users from an open file of this user. A file system without permissions is left as it is.
pub fn close_to_others(file: &File) {
    let Ok(found) = fs::fstat(file) else { return };
    let mode = Mode::from_raw_mode(found.st_mode);
    if found.st_uid == geteuid().as_raw() && mode.intersects(OTHERS) {
        let _ = fs::fchmod(file, mode - OTHERS);
    }
}

/// Device and inode number of a file.
#[must_use]
pub fn identity(stat: &Stat) -> Identity {
    #[allow(clippy::useless_conversion, clippy::unnecessary_cast, reason = "their types differ between systems")]
    (stat.st_dev as u64, stat.st_ino as u64)
}

fn links(stat: &Stat) -> u64 {
    #[allow(clippy::useless_conversion, clippy::unnecessary_cast, reason = "its type differs between systems")]
    (stat.st_nlink as u64)
}

/// Whether the error means that the name does not exist.
pub(crate) fn gone(errno: rustix::io::Errno) -> bool {
    matches!(errno, rustix::io::Errno::NOENT | rustix::io::Errno::NOTDIR)
}

fn fit(stat: &Stat) -> Result<(), Unfit> {
    Err(match FileType::from_raw_mode(stat.st_mode) {
        FileType::RegularFile => return Ok(()),
        FileType::Symlink => Unfit::Link,
        FileType::Directory => Unfit::Kind("a directory"),
        FileType::Fifo => Unfit::Kind("a named pipe"),
        FileType::Socket => Unfit::Kind("a socket"),
        FileType::CharacterDevice | FileType::BlockDevice => Unfit::Kind("a device"),
        FileType::Unknown => Unfit::Kind("something unknown"),
    })
}

#[cfg(test)]
#[path = "place_tests.rs"]
mod tests;
