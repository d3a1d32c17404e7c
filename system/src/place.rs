//! Names in a directory that is held open, and what may stand under them: regular files, not reached through links.
//!
//! Whoever else can write in a directory can put a link, a pipe, a device or a huge file under any name that we use. So a
//! name is looked up in the directory that was opened and checked ([`Folder`](crate::folder::Folder)), whatever becomes of its path; the last step
//! follows no symbolic link, opening waits for nobody, and what was opened is a regular file, or it is not used. What is read
//! whole has a limit; what is written in place has no second name.

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

/// Why what stands under a name is not used.
#[derive(Debug, thiserror::Error)]
pub enum Unfit {
    /// A directory, device, pipe ...
    #[error("it is {0} and not a regular file")]
    Kind(&'static str),
    /// A symbolic link, where none is followed.
    #[error("it is a symbolic link, which is not followed here")]
    Link,
    /// Too large to be what it should be.
    #[error("it has {bytes} bytes; at most {limit} are read")]
    TooLarge {
        /// Its size.
        bytes: u64,
        /// Largest allowed.
        limit: u64,
    },
    /// A file that would be written in place, with another name somewhere.
    #[error(
        "it has a second name ({links} hard links), and writing it would change that file, too; remove it, or copy \
         the directory"
    )]
    Links {
        /// Number of its names.
        links: u64,
    },
    /// The system refused.
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

/// Which file it is, whatever its names: device and number.
pub type Identity = (u64, u64);

/// A name in an open directory, or a path as a whole. It can be used as a path in messages; whoever opens it goes through
/// its own functions, none of which follows a symbolic link under the name itself (but [`Place::named`]).
#[derive(Debug, Clone)]
pub struct Place {
    base: Option<Arc<OwnedFd>>,
    name: PathBuf,
    path: PathBuf,
    follows: bool,
}

impl Place {
    /// A file that the user names: a link is followed, who put it there has decided it.
    #[must_use]
    pub fn named(path: &Path) -> Self {
        Self { follows: true, ..Self::from(path) }
    }

    /// A name in an open directory; `path`: for messages.
    pub(crate) fn within(base: Arc<OwnedFd>, name: &OsStr, path: PathBuf) -> Self {
        Self { base: Some(base), name: name.into(), path, follows: false }
    }

    /// The same name with more behind it.
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

    /// Whether anything stands under the name, a broken link included.
    #[must_use]
    pub fn exists(&self) -> bool {
        self.stat().is_ok()
    }

    /// Whether a regular file stands there.
    #[must_use]
    pub fn is_file(&self) -> bool {
        self.stat().is_ok_and(|found| fit(&found).is_ok())
    }

    /// Whether something stands there that is no regular file.
    #[must_use]
    pub fn is_there_but_no_file(&self) -> bool {
        self.stat().is_ok_and(|found| fit(&found).is_err())
    }

    /// Whether a symbolic link stands there.
    pub(crate) fn is_link(&self) -> bool {
        let found = fs::statat(self.base(), &self.name, AtFlags::SYMLINK_NOFOLLOW);
        found.is_ok_and(|found| FileType::from_raw_mode(found.st_mode) == FileType::Symlink)
    }

    /// Whose it is that stands there, if anything does.
    #[must_use]
    pub fn owner(&self) -> Option<u32> {
        self.stat().ok().map(|found| found.st_uid)
    }

    /// Which file stands there; `None` if none does.
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
        // Looked at before it is opened, which may do something to a device, and again after.
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
    /// It is not there, is something else, or may not be read.
    pub fn open(&self) -> Result<File, FileError> {
        self.open_as(OFlags::RDONLY, FILE_MODE).map_err(|unfit| FileError::at("read", &self.path)(unfit.into()))
    }

    /// Opens a regular file that has no other name, to be read and written in place.
    ///
    /// # Errors
    /// As [`Place::open`]; it has another name.
    pub fn open_own(&self) -> Result<File, FileError> {
        self.open_to("write", OFlags::RDWR, FILE_MODE)
    }

    /// The same; it is made if it is not there. Closed to others: who may open a file may lock it, too.
    ///
    /// # Errors
    /// As [`Place::open_own`].
    pub fn open_or_create(&self) -> Result<File, FileError> {
        let file = self.open_to("create", OFlags::RDWR | OFlags::CREATE, CLOSED_MODE)?;
        close_to_others(&file);
        Ok(file)
    }

    /// The same to be written to at its end only, for others to read.
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

    /// Makes a new file to be read and written, for others to read.
    ///
    /// # Errors
    /// Something has the name; the directory it is in may not be written.
    pub fn create_new(&self) -> Result<File, FileError> {
        self.create_with(FILE_MODE)
    }

    /// The same, closed to others.
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
    /// Why it is not read.
    pub fn read_checked(&self, limit: u64) -> Result<Vec<u8>, Unfit> {
        let file = self.open_as(OFlags::RDONLY, FILE_MODE)?;
        let bytes = file.metadata()?.len();
        if bytes > limit {
            return Err(Unfit::TooLarge { bytes, limit });
        }
        let mut read = Vec::with_capacity(usize::try_from(bytes).unwrap_or_default() + 1);
        // It may grow meanwhile, and what the system makes up (/proc) has no size.
        file.take(limit + 1).read_to_end(&mut read)?;
        if read.len() as u64 > limit { Err(Unfit::TooLarge { bytes: read.len() as u64, limit }) } else { Ok(read) }
    }

    /// The same, as an error of a file.
    ///
    /// # Errors
    /// Why it is not read.
    pub fn read(&self, limit: u64) -> Result<Vec<u8>, FileError> {
        self.read_checked(limit).map_err(|unfit| FileError::at("read", &self.path)(unfit.into()))
    }

    /// Removes what has the name, a directory excepted; says whether anything was there.
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

    /// Makes a directory that others cannot write in.
    ///
    /// # Errors
    /// The system refused.
    pub fn create_folder(&self) -> io::Result<()> {
        Ok(fs::mkdirat(self.base(), &self.name, Mode::from_bits_truncate(0o755))?)
    }

    /// Whether a file that a user names may be replaced by a new one: nothing stands there, or a regular file, or a link to one. A device, a
    /// pipe or what stands for an open file (`/dev/stdout`) would be lost to everybody who uses it.
    ///
    /// # Errors
    /// Something else stands there.
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

    /// Gives what has this name another one, in place of what has that.
    ///
    /// # Errors
    /// The system refused.
    pub fn rename_to(&self, other: &Self) -> io::Result<()> {
        Ok(fs::renameat(self.base(), &self.name, other.base(), &other.name)?)
    }

    /// The same, unless something has the other name.
    ///
    /// # Errors
    /// The system refused.
    pub fn rename_to_free(&self, other: &Self) -> io::Result<()> {
        match fs::renameat_with(self.base(), &self.name, other.base(), &other.name, RenameFlags::NOREPLACE) {
            // A file system without that.
            Err(rustix::io::Errno::INVAL | rustix::io::Errno::NOSYS) if !other.exists() => self.rename_to(other),
            renamed => Ok(renamed?),
        }
    }

    /// Exchanges two names.
    ///
    /// # Errors
    /// The system refused, or cannot do it.
    pub fn exchange_with(&self, other: &Self) -> io::Result<()> {
        Ok(fs::renameat_with(self.base(), &self.name, other.base(), &other.name, RenameFlags::EXCHANGE)?)
    }

    /// Gives a file a second name.
    ///
    /// # Errors
    /// Something has that name; the file system knows no second names.
    pub fn link_to(&self, other: &Self) -> io::Result<()> {
        Ok(fs::linkat(self.base(), &self.name, other.base(), &other.name, AtFlags::empty())?)
    }

    /// Makes the names of the directory it is in durable.
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
/// Of files that nobody else may lock: whoever may open a file, be it to read, may do that.
const CLOSED_MODE: Mode = Mode::from_bits_truncate(0o600);
const OTHERS: Mode = Mode::from_bits_truncate(0o077);

/// Takes from others what they may do with an open file of this user. A file system without permissions leaves it as it is.
pub fn close_to_others(file: &File) {
    let Ok(found) = fs::fstat(file) else { return };
    let mode = Mode::from_raw_mode(found.st_mode);
    if found.st_uid == geteuid().as_raw() && mode.intersects(OTHERS) {
        let _ = fs::fchmod(file, mode - OTHERS);
    }
}

/// Which file it is.
#[must_use]
pub fn identity(stat: &Stat) -> Identity {
    #[allow(clippy::useless_conversion, clippy::unnecessary_cast, reason = "their types differ between systems")]
    (stat.st_dev as u64, stat.st_ino as u64)
}

fn links(stat: &Stat) -> u64 {
    #[allow(clippy::useless_conversion, clippy::unnecessary_cast, reason = "its type differs between systems")]
    (stat.st_nlink as u64)
}

/// Nothing has that name.
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
