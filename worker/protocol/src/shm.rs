//! The files of a domain: with all their memory, and closed to everybody else.
//!
//! iceoryx2 0.10 leaves two things to do once a process has made its ports. Its files in /dev/shm have a size and, until they are
//! touched, no memory: [`back`] takes the memory at once, so that a /dev/shm that fills up later is no matter to a
//! run under way. And it opens one file to all users, and its directories to the group: [`close`].

use std::fs::{self, DirEntry, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use rustix::fs::FallocateFlags;
use rustix::io::Errno;

use crate::domain::Address;
use crate::transport::PortError;

/// Where iceoryx2 keeps memory on Linux.
pub(crate) const SHM: &str = "/dev/shm";
/// Permissions of anybody but the owner.
const OTHERS: u32 = 0o077;

/// Bytes free for this user.
pub(crate) fn free(dir: &Path) -> io::Result<u64> {
    let found = rustix::fs::statvfs(dir)?;
    Ok(found.f_bavail.saturating_mul(found.f_frsize))
}

/// Whether nothing more can be made: no page, or no file, is left.
pub(crate) fn is_full() -> bool {
    rustix::fs::statvfs(SHM).is_ok_and(|found| found.f_bavail == 0 || (found.f_files > 0 && found.f_favail == 0))
}

/// The error that says so.
pub(crate) fn full() -> PortError {
    PortError::MemoryFull { free: free(Path::new(SHM)).unwrap_or(0) }
}

/// The files of a domain in /dev/shm.
pub(crate) fn files(prefix: &str) -> io::Result<impl Iterator<Item = DirEntry>> {
    let prefix = prefix.to_owned();
    let is_ours = move |entry: &DirEntry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
    Ok(fs::read_dir(SHM)?.flatten().filter(is_ours))
}

/// Takes the memory of all files of a domain that have their size. Contents do not change; a second time costs
/// nothing.
///
/// # Errors
/// [`PortError::MemoryFull`] when there is not enough.
pub(crate) fn back(prefix: &str) -> Result<(), PortError> {
    let refused = refused("taking shared memory");
    for entry in files(prefix).map_err(&refused)? {
        // It may be of a worker that is just leaving.
        gone_is_none(back_file(&entry.path())).map_err(&refused)?;
    }
    Ok(())
}

/// For `map_err`: what the system refused, by its cause.
fn refused(doing: &'static str) -> impl Fn(io::Error) -> PortError {
    move |error| match error.raw_os_error().map(Errno::from_raw_os_error) {
        Some(Errno::NOSPC | Errno::NOMEM) => full(),
        _ => PortError::failed(doing)(error),
    }
}

fn back_file(path: &Path) -> io::Result<()> {
    let file = OpenOptions::new().write(true).open(path)?;
    let found = file.metadata()?;
    if found.blocks() * 512 >= found.len() {
        return Ok(());
    }
    loop {
        match rustix::fs::fallocate(&file, FallocateFlags::KEEP_SIZE, 0, found.len()) {
            Err(Errno::INTR) => {}
            // A file system that cannot promise anything.
            Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => return Ok(()),
            Err(errno) => return Err(errno.into()),
        }
    }
}

/// Takes every permission of others from the files and directories of a domain. The orchestrator does so before a
/// worker is started.
///
/// A file in /dev/shm that was open to all for a moment is made anew: whoever opened it then holds a file that nobody uses.
/// That is the counter of nodes; iceoryx2 reads it when a node is made, so it is exchanged between two of them.
///
/// # Errors
/// [`PortError::MemoryFull`], or what the system refused.
pub(crate) fn close(address: &Address) -> Result<(), PortError> {
    let refused = refused("closing shared memory to other users");
    for entry in files(&address.prefix).map_err(&refused)? {
        if entry.metadata().map_err(&refused)?.mode() & OTHERS != 0 {
            make_anew(&entry.path(), &address.prefix).map_err(&refused)?;
        }
    }
    close_directories(&address.root)
}

fn make_anew(path: &Path, prefix: &str) -> io::Result<()> {
    let fresh = Path::new(SHM).join(format!("{prefix}fresh"));
    let bytes = fs::read(path)?;
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&fresh)?;
    file.write_all(&bytes)?;
    fs::rename(&fresh, path)
}

/// The same for the directories below the root alone, which a worker adds to. The root itself lets nobody in.
///
/// # Errors
/// What the system refused.
pub(crate) fn close_directories(root: &Path) -> Result<(), PortError> {
    close_below(root).map_err(refused("closing a directory to other users"))
}

fn close_below(dir: &Path) -> io::Result<()> {
    for entry in fs::read_dir(dir)?.flatten() {
        let Some(found) = gone_is_none(entry.metadata())?.filter(fs::Metadata::is_dir) else { continue };
        if found.mode() & OTHERS != 0 {
            gone_is_none(fs::set_permissions(entry.path(), Permissions::from_mode(found.mode() & 0o700)))?;
        }
        gone_is_none(close_below(&entry.path()))?;
    }
    Ok(())
}

/// Workers come and go meanwhile.
fn gone_is_none<T>(result: io::Result<T>) -> io::Result<Option<T>> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        other => other.map(Some),
    }
}
