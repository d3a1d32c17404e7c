//! Errors of creating or removing a domain.

use bladeoff_system::shown;
use std::io;
use std::path::PathBuf;

use crate::names::{LONGEST_ADDRESS, REFUSED_SIGNS, RUNTIME_VARIABLE, SHM};
use bladeoff_system::files::FileError;

/// Error of creating or removing a domain.
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
        /// Number of workers.
        workers: usize,
    },
    /// The limit on file sizes of this process is too small.
    #[error(
        "files may have {limit} bytes (ulimit -f), {workers} workers need {needed} in one piece; raise the limit or use fewer workers"
    )]
    FileSizeLimit {
        /// The limit in bytes.
        limit: u64,
        /// Bytes needed.
        needed: u64,
        /// Number of workers.
        workers: usize,
    },
    /// No shared memory can be created.
    #[error("{SHM} cannot be written, and workers exchange samples through it")]
    ShmUnwritable {
        /// Error of the system.
        #[source]
        source: io::Error,
    },
    /// The limit on open files of this process is too small.
    #[error(
        "{limit} files may be open at once (ulimit -n), {workers} workers need {needed}; raise the limit or use fewer workers"
    )]
    FewDescriptors {
        /// The limit.
        limit: u64,
        /// Files needed.
        needed: u64,
        /// Number of workers.
        workers: usize,
    },
    /// The base directory belongs to another user or is open to others.
    #[error(
        "{} ({}) must be a directory of user {uid} with permissions 700; it is {kind} of user {owner}, mode {mode:o}",
        shown(path),
        RUNTIME_VARIABLE
    )]
    BaseUnsafe {
        /// The directory.
        path: PathBuf,
        /// Id of the current user.
        uid: u32,
        /// File type of the base.
        kind: &'static str,
        /// User id of its owner.
        owner: u32,
        /// Its permissions.
        mode: u32,
    },
    /// The path of the base directory has a character that the transport rejects.
    #[error(
        "{} ({}) has {sign} in its name; allowed are the printable signs of ASCII but {}",
        shown(path),
        RUNTIME_VARIABLE,
        REFUSED_SIGNS
    )]
    BaseSigns {
        /// The directory.
        path: PathBuf,
        /// The rejected character.
        sign: String,
    },
    /// The path of the base directory is relative.
    #[error("{} must be an absolute path ({})", shown(path), RUNTIME_VARIABLE)]
    BaseRelative {
        /// The directory.
        path: PathBuf,
    },
    /// All ids that were tried are taken.
    #[error("no name is free below {} and in {SHM}", shown(base))]
    NoName {
        /// The base.
        base: PathBuf,
    },
    /// Socket paths would exceed their limit.
    #[error(
        "{} ({}) is too long for Unix sockets: with the prefix {length} bytes, at most {LONGEST_ADDRESS}",
        shown(path),
        RUNTIME_VARIABLE
    )]
    PathTooLong {
        /// The root.
        path: PathBuf,
        /// Length of root and prefix in bytes.
        length: usize,
    },
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A file of a domain that is left after its removal, with the reason.
#[derive(Debug, thiserror::Error)]
pub enum Left {
    /// The file could not be removed.
    #[error("{} is left: {}", shown(&.0.path), .0.source)]
    File(#[from] FileError),
    /// Another user has created the file under a name of this run.
    #[error("{} is left: it belongs to user {owner}, who made it during the run", shown(path))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// User id of the owner.
        owner: u32,
    },
}
