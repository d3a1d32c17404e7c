//! Where the shared memory of a run lives: made before, removed after, swept by the next run if nobody could.
//!
//! ```text
//! /tmp/bladeoff-UID/           0700, of this user; flock while domains are made or removed
//!   ID/                        0700, one run; flock held by its orchestrator as long as it lives
//! /dev/shm/bladeoff_ID_*       the run's memory, 0600, by iceoryx2, all of it taken at the start (`shm.rs`)
//! /dev/shm/bladeoff_ID_owner   flock held by its orchestrator as long as it lives (`owner.rs`)
//! ```
//! The prefix bears the run's id, so what a run leaves behind is known by its name. The path is short because events are
//! Unix sockets inside it, whose path is limited to 108 bytes, and never in the result directory, which may be long or NFS.
//! A domain whose lock is free belongs to a dead orchestrator; its workers leave within moments, and it is swept once
//! none of its processes is alive. If somebody has removed its root, the owner's file tells the same.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::FlockOperation;

use crate::files::FileError;
use crate::messages::RunId;
use crate::shm::SHM;
use crate::{ipc_domain, ipc_hub, owner, shm};

/// First part of every name of ours.
pub(crate) const PRODUCT: &str = "bladeoff";
/// Longest root and prefix together: what is left of 108 bytes beside iceoryx2's part of a socket's name.
const LONGEST_ADDRESS: usize = 65;
/// Free memory wanted in /dev/shm. A run takes 256 kB per worker and 0.25 MB besides; a worker has 116 kB of its own, which can be
/// there twice while it is replaced.
const BASE_BYTES: u64 = 1 << 20;
const WORKER_BYTES: u64 = 384 << 10;

/// Making or removing a domain takes milliseconds; who holds the base for longer is stopped.
const LOCK_PATIENCE: Duration = Duration::from_secs(15);
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// What a process needs to find a domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// Directory for files and sockets.
    pub root: PathBuf,
    /// Start of the names in /dev/shm.
    pub prefix: String,
}

/// Why a domain could not be made or removed.
#[derive(Debug, thiserror::Error)]
pub enum DomainError {
    /// Not enough free shared memory.
    #[error(
        "{SHM} has {free} bytes free, {workers} workers need {needed}; enlarge it (Docker: --shm-size) or use fewer workers"
    )]
    ShmTooSmall {
        /// Free bytes.
        free: u64,
        /// Bytes needed.
        needed: u64,
        /// For how many workers.
        workers: usize,
    },
    /// This process may not make files as large as are needed.
    #[error(
        "files may have {limit} bytes (ulimit -f), {workers} workers need {needed} in one piece; raise the limit or use fewer workers"
    )]
    FileSizeLimit {
        /// The limit in bytes.
        limit: u64,
        /// Bytes needed.
        needed: u64,
        /// For how many workers.
        workers: usize,
    },
    /// No shared memory can be created.
    #[error("{SHM} cannot be written, and workers exchange samples through it")]
    ShmUnwritable {
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The base directory belongs to someone else or is open to others.
    #[error("{} must be a directory of user {uid} that nobody else may enter (owner {owner}, mode {mode:o})", path.display())]
    BaseUnsafe {
        /// The directory.
        path: PathBuf,
        /// This user.
        uid: u32,
        /// Its owner.
        owner: u32,
        /// Its mode.
        mode: u32,
    },
    /// Another run makes or removes its domain, and does not come to an end.
    #[error("another run has held {} for {} s; is it stopped?", path.display(), LOCK_PATIENCE.as_secs())]
    BaseLocked {
        /// The directory.
        path: PathBuf,
    },
    /// Socket paths would be too long.
    #[error("{} is too long for Unix sockets: with the prefix {length} bytes, at most {LONGEST_ADDRESS}", path.display())]
    PathTooLong {
        /// The root.
        path: PathBuf,
        /// Bytes.
        length: usize,
    },
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
}

/// The domain of a run, held by its orchestrator. Removed by [`Domain::close`], at the latest when dropped; the ports
/// in it must have been dropped before.
#[derive(Debug)]
pub struct Domain {
    address: Address,
    run: RunId,
    base: PathBuf,
    _lock: File,
    _owner: File,
    is_open: bool,
}

impl Domain {
    /// Whether a domain for this many workers could be made now: said before a study begins.
    ///
    /// # Errors
    /// See [`DomainError`].
    pub fn check(workers: usize) -> Result<(), DomainError> {
        check_shm(Path::new(SHM), workers)?;
        check_file_size(workers)?;
        open_base(&default_base()).map(drop)
    }

    /// Makes a domain for a run with this many workers below `/tmp/bladeoff-UID`, after sweeping those of dead runs.
    ///
    /// # Errors
    /// See [`DomainError`]; nothing is left behind.
    pub fn create(workers: usize) -> Result<Self, DomainError> {
        Self::create_below(&default_base(), workers)
    }

    /// The same below another directory, for tests.
    ///
    /// # Errors
    /// As [`Domain::create`].
    pub fn create_below(base: &Path, workers: usize) -> Result<Self, DomainError> {
        check_shm(Path::new(SHM), workers)?;
        check_file_size(workers)?;
        let base_lock = open_base(base)?;
        sweep(base);
        owner::sweep(base);
        let run = RunId(random()?);
        let id = format!("{:010x}", run.0 & 0xff_ffff_ffff);
        let address = Address { root: base.join(&id), prefix: prefix_of(&id) };
        let length = address.root.as_os_str().len() + address.prefix.len();
        if length > LONGEST_ADDRESS {
            return Err(DomainError::PathTooLong { path: address.root, length });
        }
        let owner = owner::claim(&address)?;
        let lock = make_root(&address.root).inspect_err(|_| {
            // The error is what made it fail; the next run sweeps what is left.
            let _ = remove_files(&address);
        })?;
        drop(base_lock);
        Ok(Self { address, run, base: base.to_owned(), _lock: lock, _owner: owner, is_open: true })
    }

    /// Where it is.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// Number of the run, random.
    #[must_use]
    pub fn run(&self) -> RunId {
        self.run
    }

    /// Removes the domain: afterwards nothing of it is in /dev/shm or below the base.
    ///
    /// # Errors
    /// What could not be removed; the next run tries again.
    pub fn close(mut self) -> Result<(), DomainError> {
        self.remove()
    }

    fn remove(&mut self) -> Result<(), DomainError> {
        if !std::mem::take(&mut self.is_open) {
            return Ok(());
        }
        let _base_lock = open_base(&self.base)?;
        remove_files(&self.address)
    }
}

impl Drop for Domain {
    fn drop(&mut self) {
        // The next run sweeps what could not be removed.
        let _ = self.remove();
    }
}

fn default_base() -> PathBuf {
    PathBuf::from(format!("/tmp/{PRODUCT}-{}", rustix::process::getuid().as_raw()))
}

/// Refuses a /dev/shm that cannot be written or is too small: memory that is not there would kill processes by SIGBUS
/// on first touch.
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

/// Refuses a limit on the size of files (`ulimit -f`) that the largest piece of memory exceeds, by which it would not be made.
fn check_file_size(workers: usize) -> Result<(), DomainError> {
    let needed = ipc_hub::largest_file(workers);
    match rustix::process::getrlimit(rustix::process::Resource::Fsize).current {
        Some(limit) if limit < needed => Err(DomainError::FileSizeLimit { limit, needed, workers }),
        _ => Ok(()),
    }
}

/// Makes and locks the root of a domain.
fn make_root(root: &Path) -> Result<File, DomainError> {
    fs::DirBuilder::new().mode(0o700).create(root).map_err(FileError::at("create", root))?;
    lock(root)
}

/// Opens and locks the base directory, making it if it is not there.
fn open_base(base: &Path) -> Result<File, DomainError> {
    match fs::DirBuilder::new().mode(0o700).create(base) {
        Err(source) if source.kind() != io::ErrorKind::AlreadyExists => {
            return Err(FileError::at("create", base)(source).into());
        }
        _ => {}
    }
    let found = fs::symlink_metadata(base).map_err(FileError::at("read", base))?;
    let (uid, owner, mode) = (rustix::process::getuid().as_raw(), found.uid(), found.permissions().mode() & 0o777);
    if !found.is_dir() || owner != uid {
        return Err(DomainError::BaseUnsafe { path: base.to_owned(), uid, owner, mode });
    }
    if mode & 0o077 != 0 {
        fs::set_permissions(base, Permissions::from_mode(0o700)).map_err(FileError::at("close to others", base))?;
    }
    let start = Instant::now();
    loop {
        match lock(base) {
            Err(DomainError::File(FileError { source, .. })) if source.kind() == io::ErrorKind::WouldBlock => {
                if start.elapsed() >= LOCK_PATIENCE {
                    return Err(DomainError::BaseLocked { path: base.to_owned() });
                }
                std::thread::sleep(LOCK_PAUSE);
            }
            locked => return locked,
        }
    }
}

/// Locks a directory for as long as the result lives; does not wait.
fn lock(dir: &Path) -> Result<File, DomainError> {
    let file = File::open(dir).map_err(FileError::at("open", dir))?;
    rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive)
        .map_err(|errno| FileError::at("lock", dir)(errno.into()))?;
    Ok(file)
}

/// Removes the domains of dead runs. The base is locked. What fails is left for the next time.
fn sweep(base: &Path) {
    for entry in fs::read_dir(base).into_iter().flatten().flatten() {
        let root = entry.path();
        let Some(id) = entry.file_name().to_str().filter(|id| is_id(id)).map(str::to_owned) else { continue };
        let Ok(_lock) = lock(&root) else { continue };
        let address = Address { root, prefix: prefix_of(&id) };
        if ipc_domain::is_deserted(&address) {
            let _ = remove_files(&address);
        }
    }
}

/// Start of the names of a run in /dev/shm.
pub(crate) fn prefix_of(id: &str) -> String {
    format!("{PRODUCT}_{id}_")
}

pub(crate) fn is_id(name: &str) -> bool {
    name.len() == 10 && name.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// Memory first: the directory is what a later sweep finds the rest by.
fn remove_files(address: &Address) -> Result<(), DomainError> {
    owner::remove(&address.prefix)?;
    let removed = fs::remove_dir_all(&address.root).or_else(ignore_missing);
    Ok(removed.map_err(FileError::at("remove", &address.root))?)
}

fn ignore_missing(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}

/// A random number that is not 0, from the system.
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

    #[test]
    fn a_long_base_is_refused_before_anything_is_made() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let base = dir.path().join("a-name-that-takes-more-than-the-socket-path-allows");
        let error = Domain::create_below(&base, 1).expect_err("too long");
        assert!(matches!(error, DomainError::PathTooLong { .. }), "{error}");
        assert_eq!(fs::read_dir(&base).expect("readable").count(), 0);
    }

    #[test]
    fn a_domain_is_closed_to_others_and_leaves_nothing() {
        let dir = tempfile::tempdir_in("/tmp").expect("temporary directory");
        let base = dir.path().join("b");
        let domain = Domain::create_below(&base, 1).expect("created");
        let root = domain.address().root.clone();
        for path in [&base, &root] {
            assert_eq!(fs::metadata(path).expect("there").permissions().mode() & 0o777, 0o700);
        }
        domain.close().expect("removed");
        assert!(!root.exists());
    }

    #[test]
    fn a_dead_domain_is_swept_and_a_living_one_is_not() {
        let dir = tempfile::tempdir_in("/tmp").expect("temporary directory");
        let dead = dir.path().join("00000000aa");
        fs::create_dir(&dead).expect("created");
        let shm = Path::new(SHM).join("bladeoff_00000000aa_left");
        fs::write(&shm, b"x").expect("written");
        let living = Domain::create_below(dir.path(), 1).expect("created");
        assert!(!dead.exists() && !shm.exists());
        let other = Domain::create_below(dir.path(), 1).expect("created");
        assert!(living.address().root.exists() && other.address().root != living.address().root);
    }
}
