//! Why a run has no domain, or leaves some of it behind.

use bladeoff_system::shown;
use std::io;
use std::path::PathBuf;

use crate::names::{LONGEST_ADDRESS, REFUSED_SIGNS, RUNTIME_VARIABLE, SHM};
use bladeoff_system::files::FileError;

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
    /// This process may not open as many files as are needed.
    #[error(
        "{limit} files may be open at once (ulimit -n), {workers} workers need {needed}; raise the limit or use fewer workers"
    )]
    FewDescriptors {
        /// The limit.
        limit: u64,
        /// Files needed.
        needed: u64,
        /// For how many workers.
        workers: usize,
    },
    /// The base directory belongs to someone else or is open to others.
    #[error(
        "{} ({}) must be a directory of user {uid} with permissions 700; it is {kind} of user {owner}, mode {mode:o}",
        shown(path),
        RUNTIME_VARIABLE
    )]
    BaseUnsafe {
        /// The directory.
        path: PathBuf,
        /// This user.
        uid: u32,
        /// What it is.
        kind: &'static str,
        /// Its owner.
        owner: u32,
        /// Its mode.
        mode: u32,
    },
    /// The base directory has a name that the transport does not take.
    #[error(
        "{} ({}) has {sign} in its name; allowed are the printable signs of ASCII but {}",
        shown(path),
        RUNTIME_VARIABLE,
        REFUSED_SIGNS
    )]
    BaseSigns {
        /// The directory.
        path: PathBuf,
        /// What is not allowed in it.
        sign: String,
    },
    /// The base directory was named without a place.
    #[error("{} must be an absolute path ({})", shown(path), RUNTIME_VARIABLE)]
    BaseRelative {
        /// The directory.
        path: PathBuf,
    },
    /// Every id was taken.
    #[error("no name is free below {} and in {SHM}", shown(base))]
    NoName {
        /// The base.
        base: PathBuf,
    },
    /// Socket paths would be too long.
    #[error(
        "{} ({}) is too long for Unix sockets: with the prefix {length} bytes, at most {LONGEST_ADDRESS}",
        shown(path),
        RUNTIME_VARIABLE
    )]
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

/// What of a domain is left, and why.
#[derive(Debug, thiserror::Error)]
pub enum Left {
    /// It could not be removed.
    #[error("{} is left: {}", shown(&.0.path), .0.source)]
    File(#[from] FileError),
    /// Somebody has made it under a name of ours.
    #[error("{} is left: it belongs to user {owner}, who made it during the run", shown(path))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Whose it is.
        owner: u32,
    },
}
