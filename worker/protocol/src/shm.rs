//! Files of a domain in shared memory: their memory is allocated early, and they are closed to other users.
//!
//! iceoryx2 0.10 leaves two tasks. Its files in /dev/shm have a size but no memory until they are touched: [`back`] allocates the memory at
//! once, so that a /dev/shm that fills up later does not affect a run in progress. And it opens one file to all users, and its directories
//! to the group: [`prepare`] creates that file first, closed to others, and [`close`] closes all that is still open.
//!
//! Every user may write in /dev/shm, so a file there is not trusted until [`open_own`] has opened it.

use std::fs::{self, DirEntry, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use rustix::fs::{FallocateFlags, OFlags};
use rustix::io::Errno;

use crate::names::{Address, SHM};
use crate::transport::PortError;

/// Permissions of all users except the owner.
const OTHERS: u32 = 0o077;
/// Version 0.10.0 as iceoryx2 writes it at the beginning of its files.
const ICEORYX2_VERSION: u64 = 10 << 16;
/// Name of iceoryx2's node counter after our prefix: a hash of a type in the file, and a suffix. Another compiler may name the type
/// differently; then the file is found open to others and is replaced.
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
const COUNTER_SUFFIX: &str = ".global_mgmt";
const COUNTER_BYTES: usize = 16;

/// Free bytes available to this user.
pub(crate) fn free(dir: &Path) -> io::Result<u64> {
    let found = rustix::fs::statvfs(dir)?;
    Ok(found.f_bavail.saturating_mul(found.f_frsize))
}

/// Whether /dev/shm has no free page or no free file entry.
pub(crate) fn is_full() -> bool {
    rustix::fs::statvfs(SHM).is_ok_and(|found| found.f_bavail == 0 || (found.f_files > 0 && found.f_favail == 0))
}

/// [`PortError::MemoryFull`] with the present number of free bytes.
pub(crate) fn full() -> PortError {
    PortError::MemoryFull { free: free(Path::new(SHM)).unwrap_or(0) }
}

/// Files of a domain in /dev/shm.
pub(crate) fn files(prefix: &str) -> io::Result<impl Iterator<Item = DirEntry>> {
    let prefix = prefix.to_owned();
    let is_ours = move |entry: &DirEntry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
    Ok(fs::read_dir(SHM)?.flatten().filter(is_ours))
}

/// Allocates the memory of all files of a domain that have their size already. Contents do not change; a second call costs
/// nothing.
///
/// # Errors
/// [`PortError::MemoryFull`] if there is too little memory.
pub(crate) fn back(prefix: &str) -> Result<(), PortError> {
    let refused = refused("taking shared memory");
    for entry in files(prefix).map_err(&refused)? {
        // A worker that is ending may remove its file meanwhile.
        gone_is_none(back_file(&entry.path())).map_err(&refused)?;
    }
    Ok(())
}

/// For `map_err`: the error for a refused system call; [`PortError::MemoryFull`] if memory is missing.
fn refused(doing: &'static str) -> impl Fn(io::Error) -> PortError {
    move |error| match error.raw_os_error().map(Errno::from_raw_os_error) {
        Some(Errno::NOSPC | Errno::NOMEM) => full(),
        _ => PortError::failed(doing)(error),
    }
}

/// Mode in which a file is opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
}

/// Whether `uid` is the current user.
pub(crate) fn is_own(uid: u32) -> bool {
    uid == rustix::process::getuid().as_raw()
}

/// User id of the owner of a file, without following links; `None`: the file is gone.
pub(crate) fn owner_of(path: &Path) -> io::Result<Option<u32>> {
    Ok(gone_is_none(fs::symlink_metadata(path))?.map(|found| found.uid()))
}

/// Opens a regular file of this user, without following links and without blocking; `None` for any other file or none.
pub(crate) fn open_own(path: &Path, access: Access) -> io::Result<Option<File>> {
    let is_ours = |found: &fs::Metadata| found.is_file() && is_own(found.uid());
    // Files of other users are not even opened.
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
            // The file system cannot allocate in advance.
            Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => return Ok(()),
            Err(errno) => return Err(errno.into()),
        }
    }
}

/// Content of the node counter, which iceoryx2 opens to all users: version, count, padding.
fn counter(nodes: u32) -> [u8; COUNTER_BYTES] {
    let mut bytes = [0; COUNTER_BYTES];
    let (version, count) = bytes.split_at_mut(8);
    version.copy_from_slice(&ICEORYX2_VERSION.to_ne_bytes());
    count[..4].copy_from_slice(&nodes.to_ne_bytes());
    bytes
}

/// Creates the node counter, closed to others, before iceoryx2 would create it open to all users.
///
/// # Errors
/// [`PortError::MemoryFull`], or another error of the system.
pub(crate) fn prepare(prefix: &str) -> Result<(), PortError> {
    let path = Path::new(SHM).join(format!("{prefix}{COUNTER}"));
    make_counter(&path, prefix, 0).map_err(refused("making shared memory"))
}

/// Removes all permissions of other users from the files and directories of a domain. The orchestrator calls this function before starting a
/// worker.
///
/// A file in /dev/shm that was open to all is replaced, so that a process that opened it before holds an unused file. Its content is
/// not trusted: the only such file is the node counter, and this process has created one node. iceoryx2 reads the counter when a node is
/// created, so the file is replaced between two such times.
///
/// # Errors
/// [`PortError::MemoryFull`] or another error of the system; [`PortError::OpenToOthers`] for any other file.
pub(crate) fn close(address: &Address) -> Result<(), PortError> {
    let refused = refused("closing shared memory to other users");
    for entry in files(&address.prefix).map_err(&refused)? {
        let Some(found) = gone_is_none(entry.metadata()).map_err(&refused)? else { continue };
        // Files of other users are not used, so their permissions do not matter.
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

/// Removes all permissions of other users from the directories below the root, where a worker creates more. The root itself is closed already.
///
/// # Errors
/// Errors of the system.
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

/// A missing file is no error, because workers start and end meanwhile.
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
        // Content from another user, and a size of one gigabyte.
        fs::write(&path, [7; 64]).expect("written");
        OpenOptions::new().write(true).open(&path).and_then(|file| file.set_len(1 << 30)).expect("sparse");
        fs::set_permissions(&path, Permissions::from_mode(0o666)).expect("opened");
        let before = fs::metadata(&path).expect("there").ino();
        let closed = close(&address);
        let (found, bytes) = (fs::metadata(&path).expect("there"), fs::read(&path).expect("readable"));
        // Any other file that is open to others is an error.
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
