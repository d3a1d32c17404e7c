//! Domain of a run: the place of its shared memory. A domain is created before and removed after the run; the next run removes leftovers.
//!
//! ```text
//! BASE/                      0700, of this user: see `runtime.rs`
//!   ID/                      0700, one run; flock held by its orchestrator as long as it lives
//! /dev/shm/bladeoff_ID_*       the run's memory, 0600, by iceoryx2, all of it taken at the start (`shm.rs`)
//! /dev/shm/bladeoff_ID_owner   flock held by its orchestrator as long as it lives (`owner.rs`)
//! ```
//! The prefix contains the run's id, so leftovers of a run are recognised by their names. The path is short because events use Unix
//! sockets inside the directory, whose path is limited to 108 bytes. The result directory is not used, as its path may be long or on NFS.
//! A domain whose lock is free belongs to a dead orchestrator. The workers of that run end within moments; the domain is removed once none
//! of its processes is alive. If the root directory has been removed, the lock of the owner's file shows the same.
//!
//! No process waits for a lock, and no lock is shared by several runs, so a stopped run blocks no other. A sweep can find a root between its
//! creation and its lock; the run being started then takes another id.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::FlockOperation;

use crate::messages::RunId;
use crate::names::{ID_LENGTH, PRODUCT, SHM, prefix_of};
use crate::runtime::{self, Base, Runtime};
use crate::{ipc_domain, ipc_hub, limits, owner, shm};
use bladeoff_system::files::FileError;
use bladeoff_system::shown;

pub use crate::domain_error::{DomainError, Left};
pub use crate::names::Address;

/// Free space required in /dev/shm. A run takes 256 kB per worker plus 0.25 MB; each worker takes another 116 kB, twice while the worker is
/// being replaced.
const BASE_BYTES: u64 = 1 << 20;
const WORKER_BYTES: u64 = 384 << 10;

/// Ids that are tried. An id fails only if its name is taken or a sweep removes its root between creation and lock.
const MOST_IDS: usize = 16;

/// The domain of a run, held by its orchestrator. [`Domain::close`] removes the domain, as does dropping it; all ports in the domain must be
/// dropped before.
#[derive(Debug)]
pub struct Domain {
    address: Address,
    run: RunId,
    _lock: File,
    _owner: File,
    is_open: bool,
}

impl Domain {
    /// Checks that a domain for this many workers can be created now, to report errors before a study begins.
    ///
    /// # Errors
    /// See [`DomainError`].
    pub fn check(workers: usize) -> Result<(), DomainError> {
        check_limits(workers)?;
        Runtime::find().map(drop)
    }

    /// Creates a domain in the directory given by the environment (`runtime.rs`), after removing the domains of dead runs.
    ///
    /// # Errors
    /// See [`DomainError`]; nothing is left behind.
    pub fn create(workers: usize) -> Result<Self, DomainError> {
        Self::create_in(&Runtime::find()?, workers)
    }

    /// Creates a domain below `base`, whatever the environment sets; for tests.
    ///
    /// # Errors
    /// As [`Domain::create`].
    pub fn create_below(base: &Path, workers: usize) -> Result<Self, DomainError> {
        Self::create_in(&Runtime::within(base)?, workers)
    }

    fn create_in(runtime: &Runtime, workers: usize) -> Result<Self, DomainError> {
        check_limits(workers)?;
        runtime.swept.iter().for_each(sweep);
        owner::sweep(&runtime.swept.iter().map(|base| base.dir.as_path()).collect::<Vec<_>>());
        for _ in 0..MOST_IDS {
            let run = RunId(random()?);
            let id = format!("{:0ID_LENGTH$x}", run.0 & 0xff_ffff_ffff);
            let address = Address { root: runtime.base.root(&id), prefix: prefix_of(&id) };
            let Some(owner) = owner::claim(&address)? else { continue };
            match make_root(&address.root) {
                Ok(Some(lock)) => return Ok(Self { address, run, _lock: lock, _owner: owner, is_open: true }),
                Ok(None) => drop(owner::remove(&address.prefix)),
                Err(error) => {
                    // The first error is reported; the next run removes the leftovers.
                    discard(&address);
                    return Err(error);
                }
            }
        }
        Err(DomainError::NoName { base: runtime.base.dir.clone() })
    }

    /// Names of the domain's directory and memory.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// Random number of the run.
    #[must_use]
    pub fn run(&self) -> RunId {
        self.run
    }

    /// Removes the domain from /dev/shm and from the base directory and returns the files that are left. A file that cannot be removed does not
    /// keep the others; the next run tries again.
    #[must_use]
    pub fn close(mut self) -> Vec<Left> {
        self.remove()
    }

    fn remove(&mut self) -> Vec<Left> {
        if std::mem::take(&mut self.is_open) { discard(&self.address) } else { Vec::new() }
    }
}

impl Drop for Domain {
    fn drop(&mut self) {
        self.remove();
    }
}

fn check_limits(workers: usize) -> Result<(), DomainError> {
    check_shm(Path::new(SHM), workers)?;
    check_file_size(workers)?;
    limits::allow_files(workers)
}

/// Rejects a /dev/shm that cannot be written or is too small: SIGBUS would kill processes that first touch missing memory.
fn check_shm(shm: &Path, workers: usize) -> Result<(), DomainError> {
    let needed = BASE_BYTES + WORKER_BYTES * workers as u64;
    let probe = || -> io::Result<u64> {
        let path = shm.join(format!("{PRODUCT}_probe_{:016x}", random().map_err(io::Error::other)?));
        OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path)?;
        fs::remove_file(&path)?;
        shm::free(shm)
    };
    match probe() {
        Ok(free) if free < needed => Err(DomainError::ShmTooSmall { free, needed, workers }),
        Ok(_) => Ok(()),
        Err(source) => Err(DomainError::ShmUnwritable { source }),
    }
}

/// Rejects a limit on file sizes (`ulimit -f`) below the largest piece of shared memory.
fn check_file_size(workers: usize) -> Result<(), DomainError> {
    let needed = ipc_hub::largest_file(workers);
    match rustix::process::getrlimit(rustix::process::Resource::Fsize).current {
        Some(limit) if limit < needed => Err(DomainError::FileSizeLimit { limit, needed, workers }),
        _ => Ok(()),
    }
}

/// Creates and locks the root of a domain. `None`: the name is taken, or a sweep has taken the new root for that of a dead run.
fn make_root(root: &Path) -> Result<Option<File>, DomainError> {
    match runtime::make_closed(root) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Ok(None),
        // swept before its mode was set
        Err(error) if error.kind() == io::ErrorKind::NotFound && root.parent().is_some_and(Path::exists) => {
            return Ok(None);
        }
        made => made.map_err(FileError::at("create", root))?,
    }
    Ok(lock(root).map_err(FileError::at("lock", root))?)
}

/// Locks a directory until the result is dropped, without waiting. `None`: another process holds the lock, or the directory is gone.
fn lock(dir: &Path) -> io::Result<Option<File>> {
    let file = match runtime::open(dir) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    match rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Err(rustix::io::Errno::WOULDBLOCK) => return Ok(None),
        locked => locked?,
    }
    // The previous holder of the lock may have removed the directory.
    let (ours, there) = (file.metadata()?, fs::symlink_metadata(dir));
    let is_there = there.is_ok_and(|there| (there.dev(), there.ino()) == (ours.dev(), ours.ino()));
    Ok(is_there.then_some(file))
}

/// Removes the domains of dead runs. Files that cannot be removed are left for the next sweep.
fn sweep(base: &Base) {
    for entry in fs::read_dir(&base.dir).into_iter().flatten().flatten() {
        let (name, root) = (entry.file_name(), entry.path());
        let Some(id) = base.id_of(&name) else { continue };
        if !entry.metadata().is_ok_and(|found| found.is_dir() && shm::is_own(found.uid())) {
            continue;
        }
        let Ok(Some(_lock)) = lock(&root) else { continue };
        let address = Address { prefix: prefix_of(id), root };
        if ipc_domain::is_deserted(&address) {
            discard(&address);
        }
    }
}

/// Removes all files of a domain whose ports are closed and returns the files that are left. The memory goes first, because a later sweep
/// finds the remaining files by the directory.
pub fn discard(address: &Address) -> Vec<Left> {
    let mut left = owner::remove(&address.prefix);
    match fs::remove_dir_all(&address.root) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            left.push(FileError::at("remove", &address.root)(error).into());
        }
        _ => {}
    }
    left
}

/// Descriptions of files that have the prefix of a run but belong to other users.
#[must_use]
pub fn foreign_files(prefix: &str) -> Vec<String> {
    let foreign = |path: PathBuf| {
        let owner = shm::owner_of(&path).ok()?.filter(|&owner| !shm::is_own(owner))?;
        Some(format!("{} of user {owner}", shown(&path)))
    };
    shm::files(prefix).into_iter().flatten().filter_map(|entry| foreign(entry.path())).collect()
}

/// A random number other than 0, from the system.
fn random() -> Result<u64, DomainError> {
    let path = Path::new("/dev/urandom");
    let mut bytes = [0; 8];
    File::open(path)
        .and_then(|mut file| io::Read::read_exact(&mut file, &mut bytes))
        .map_err(FileError::at("read", path))?;
    Ok(u64::from_ne_bytes(bytes).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_directory_that_is_too_small_or_missing_is_told_apart() {
        let dir = tempfile::tempdir().expect("temporary directory");
        assert!(check_shm(dir.path(), 1).is_ok());
        let many = check_shm(dir.path(), 1 << 40).expect_err("no such disk");
        assert!(matches!(many, DomainError::ShmTooSmall { .. }), "{many}");
        let missing = check_shm(&dir.path().join("nowhere"), 1).expect_err("not there");
        assert!(matches!(missing, DomainError::ShmUnwritable { .. }), "{missing}");
        assert_eq!(fs::read_dir(dir.path()).expect("readable").count(), 0);
    }

    /// A sweep may come between the creation of a root and its lock: the run being started then takes another name.
    #[test]
    fn runs_that_begin_at_once_sweep_each_other_and_begin_all_the_same() {
        let dir = folder();
        let begin = || (0..400).try_for_each(|_| Domain::create_below(dir.path(), 1).map(drop));
        let ended = std::thread::scope(|scope| {
            let runs: Vec<_> = (0..4).map(|_| scope.spawn(begin)).collect();
            runs.into_iter().map(|run| run.join().expect("no panic")).collect::<Result<Vec<()>, DomainError>>()
        });
        assert!(ended.is_ok(), "{ended:?}");
        assert_eq!(fs::read_dir(dir.path()).expect("readable").count(), 0, "nothing is left");
    }

    fn folder() -> tempfile::TempDir {
        let closed = std::os::unix::fs::PermissionsExt::from_mode(0o700);
        tempfile::Builder::new().prefix("bo").permissions(closed).tempdir_in("/tmp").expect("temporary directory")
    }

    #[test]
    fn a_domain_is_closed_to_others_and_leaves_nothing() {
        let dir = folder();
        let base = dir.path().join("b");
        let domain = Domain::create_below(&base, 1).expect("created");
        let root = domain.address().root.clone();
        for path in [&base, &root] {
            assert_eq!(fs::metadata(path).expect("there").mode() & 0o777, 0o700);
        }
        assert!(domain.close().is_empty());
        assert!(!root.exists());
    }

    #[test]
    fn a_dead_domain_is_swept_and_a_living_one_is_not() {
        let dir = folder();
        let dead = dir.path().join("00000000aa");
        fs::create_dir(&dead).expect("created");
        let shm = Path::new(SHM).join("bladeoff_00000000aa_left");
        fs::write(&shm, b"x").expect("written");
        let living = Domain::create_below(dir.path(), 1).expect("created");
        assert!(!dead.exists() && !shm.exists());
        let other = Domain::create_below(dir.path(), 1).expect("created");
        assert!(living.address().root.exists() && other.address().root != living.address().root);
    }

    #[test]
    fn nobody_waits_for_who_holds_a_directory() {
        let dir = folder();
        let dead = dir.path().join("00000000ab");
        fs::create_dir(&dead).expect("created");
        // A starting run that was stopped while it held locks.
        let held: Vec<File> =
            [dir.path(), &dead].iter().map(|path| lock(path).expect("opened").expect("free")).collect();
        // A new run must not wait for these locks, as the wait would have no limit.
        let domain = Domain::create_below(dir.path(), 1).expect("created");
        assert!(domain.close().is_empty() && dead.exists());
        drop(held);
        let is_gone = || {
            drop(Domain::create_below(dir.path(), 1).expect("created"));
            !dead.exists()
        };
        assert!(owner::tests::within_moments(is_gone));
    }

    #[test]
    fn a_root_that_was_swept_while_it_was_made_is_not_believed() {
        let dir = folder();
        let root = dir.path().join("00000000ac");
        assert!(make_root(&root).expect("made").is_some());
        assert!(make_root(&root).expect("no error").is_none(), "the name is taken");
        // A sweep holds the lock, and then removes the directory.
        let sweeping = lock(&root).expect("opened").expect("free");
        assert!(lock(&root).expect("no error").is_none());
        fs::remove_dir(&root).expect("removed");
        fs::create_dir(&root).expect("created");
        drop(sweeping);
        assert!(lock(&root).expect("opened").is_some());
        fs::remove_dir(&root).expect("removed");
        assert!(lock(&root).expect("no error").is_none(), "it is gone");
    }

    #[test]
    fn what_somebody_else_has_made_is_left_and_named() {
        // Only root can create files of another user.
        if !shm::is_own(0) {
            return;
        }
        let dir = folder();
        let domain = Domain::create_below(dir.path(), 1).expect("created");
        let path = |name: &str| Path::new(SHM).join(format!("{}{name}", domain.address().prefix));
        let (foreign, own) = (path("a_foreign"), path("b_own"));
        for path in [&foreign, &own] {
            fs::write(path, b"x").expect("written");
        }
        std::os::unix::fs::chown(&foreign, Some(65_534), None).expect("given away");
        let root = domain.address().root.clone();
        let left = domain.close();
        let is_there = foreign.exists();
        fs::remove_file(&foreign).expect("removed");
        assert!(matches!(&left[..], [Left::Foreign { owner: 65_534, .. }]), "{left:?}");
        assert!(is_there && !own.exists() && !root.exists());
    }
}
