//! The files of a domain: with all their memory, and closed to everybody else.
//!
//! iceoryx2 0.10 leaves two things to do. Its files in /dev/shm have a size and, until they are
//! touched, no memory: [`back`] takes the memory at once, so that a /dev/shm that fills up later is no matter to a
//! run under way. And it opens one file to all users, and its directories to the group: [`prepare`] makes that file before it does, closed,
//! and [`close`] closes what is open all the same.
//!
//! /dev/shm belongs to everybody, so a file there is trusted for nothing but its name until [`open_own`] has opened it.

use std::fs::{self, DirEntry, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use rustix::fs::{FallocateFlags, OFlags};
use rustix::io::Errno;

use crate::names::{Address, SHM};
use crate::transport::PortError;

/// Permissions of anybody but the owner.
const OTHERS: u32 = 0o077;
/// iceoryx2 0.10.0 as it stands at the beginning of its files.
const ICEORYX2_VERSION: u64 = 10 << 16;
/// Name of its counter of nodes after our prefix: a hash of the type in it, and a suffix. Another compiler may name the type otherwise: then
/// the file is found open to others, and made anew.
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
const COUNTER_SUFFIX: &str = ".global_mgmt";
const COUNTER_BYTES: usize = 16;

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

/// What a file is opened for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
}

/// Whether this is our user.
pub(crate) fn is_own(uid: u32) -> bool {
    uid == rustix::process::getuid().as_raw()
}

/// Whose a file is, links not followed; `None`: it is gone.
pub(crate) fn owner_of(path: &Path) -> io::Result<Option<u32>> {
    Ok(gone_is_none(fs::symlink_metadata(path))?.map(|found| found.uid()))
}

/// Opens a regular file of this user, not through a link and without waiting; `None` if it is anything else, or gone.
pub(crate) fn open_own(path: &Path, access: Access) -> io::Result<Option<File>> {
    let is_ours = |found: &fs::Metadata| found.is_file() && is_own(found.uid());
    // What is not ours is not even opened.
    if !gone_is_none(fs::symlink_metadata(path))?.is_some_and(|found| is_ours(&found)) {
        return Ok(None);
    }
    let mut options = OpenOptions::new();
    match access {
        Access::Read => options.read(true),
        Access::Write => options.write(true),
    };
    options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32);
    let Some(file) = gone_is_none(options.open(path))? else { return Ok(None) };
    Ok(is_ours(&file.metadata()?).then_some(file))
}

fn back_file(path: &Path) -> io::Result<()> {
    let Some(file) = open_own(path, Access::Write)? else { return Ok(()) };
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

/// The counter of nodes, which iceoryx2 opens to everybody: its version, the count, nothing.
fn counter(nodes: u32) -> [u8; COUNTER_BYTES] {
    let mut bytes = [0; COUNTER_BYTES];
    let (version, count) = bytes.split_at_mut(8);
    version.copy_from_slice(&ICEORYX2_VERSION.to_ne_bytes());
    count[..4].copy_from_slice(&nodes.to_ne_bytes());
    bytes
}

/// Before anything of iceoryx2: makes the file that it would make open to everybody.
///
/// # Errors
/// [`PortError::MemoryFull`], or what the system refused.
pub(crate) fn prepare(prefix: &str) -> Result<(), PortError> {
    let path = Path::new(SHM).join(format!("{prefix}{COUNTER}"));
    make_counter(&path, prefix, 0).map_err(refused("making shared memory"))
}

/// Takes every permission of others from the files and directories of a domain. The orchestrator does so before a
/// worker is started.
///
/// A file in /dev/shm that was open to all is made anew: whoever opened it then holds a file that nobody uses. What is in it is
/// not believed: the only such file is the counter of nodes, of which this process has made one. iceoryx2 reads it when a node is made,
/// so it is exchanged between two of them.
///
/// # Errors
/// [`PortError::MemoryFull`], or what the system refused; [`PortError::OpenToOthers`] for any other file.
pub(crate) fn close(address: &Address) -> Result<(), PortError> {
    let refused = refused("closing shared memory to other users");
    for entry in files(&address.prefix).map_err(&refused)? {
        let Some(found) = gone_is_none(entry.metadata()).map_err(&refused)? else { continue };
        // Of others there may be what there will: it is not used.
        if !is_own(found.uid()) || found.mode() & OTHERS == 0 {
            continue;
        }
        let name = entry.file_name();
        if !found.is_file() || !name.as_encoded_bytes().ends_with(COUNTER_SUFFIX.as_bytes()) {
            return Err(PortError::OpenToOthers { path: entry.path() });
        }
        make_counter(&entry.path(), &address.prefix, 1).map_err(&refused)?;
    }
    close_directories(&address.root)
}

fn make_counter(path: &Path, prefix: &str, nodes: u32) -> io::Result<()> {
    let fresh = Path::new(SHM).join(format!("{prefix}fresh"));
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&fresh)?;
    file.write_all(&counter(nodes))?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn prefix(id: &str) -> String {
        format!("bladeoff_{id}_")
    }

    #[test]
    fn what_others_could_write_is_replaced_by_what_is_known() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let address = Address { root: dir.path().to_owned(), prefix: prefix("00000000c1") };
        let path = Path::new(SHM).join(format!("{}any{COUNTER_SUFFIX}", address.prefix));
        // Bytes of somebody, and a gigabyte more.
        fs::write(&path, [7; 64]).expect("written");
        OpenOptions::new().write(true).open(&path).and_then(|file| file.set_len(1 << 30)).expect("sparse");
        fs::set_permissions(&path, Permissions::from_mode(0o666)).expect("opened");
        let before = fs::metadata(&path).expect("there").ino();
        let closed = close(&address);
        let (found, bytes) = (fs::metadata(&path).expect("there"), fs::read(&path).expect("readable"));
        // Another file that is open to others is not known.
        let other = path.with_extension("other");
        fs::write(&other, b"x").expect("written");
        fs::set_permissions(&other, Permissions::from_mode(0o622)).expect("opened");
        let refused = close(&address);
        [&path, &other].iter().for_each(|path| fs::remove_file(path).expect("removed"));
        closed.expect("closed");
        assert!(found.ino() != before && found.mode() & 0o777 == 0o600);
        assert_eq!(bytes, counter(1));
        assert!(matches!(refused, Err(PortError::OpenToOthers { path }) if path == other));
    }

    #[test]
    fn only_own_regular_files_are_opened_and_none_is_waited_for() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let path = |name: &str| dir.path().join(name);
        fs::write(path("file"), b"x").expect("written");
        std::os::unix::fs::symlink(path("file"), path("link")).expect("linked");
        let fifo = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, path("pipe"), fifo, 0o600.into(), 0).expect("a FIFO");
        fs::create_dir(path("dir")).expect("created");
        for access in [Access::Read, Access::Write] {
            let is_open = |name: &str| open_own(&path(name), access).expect("no error").is_some();
            assert_eq!(["file", "link", "pipe", "dir", "none"].map(is_open), [true, false, false, false, false]);
        }
        if is_own(0) {
            std::os::unix::fs::chown(path("file"), Some(65_534), None).expect("given away");
            assert!(open_own(&path("file"), Access::Read).expect("no error").is_none());
            assert_eq!(owner_of(&path("file")).expect("there"), Some(65_534));
        }
    }
}
