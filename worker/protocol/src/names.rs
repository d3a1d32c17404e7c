//! Names of a run's directory and memory, and the places where they are.

use std::path::PathBuf;

/// First part of every name in shared directories.
pub(crate) const PRODUCT: &str = "bladeoff";
/// Environment variable for the directory in which runs create their sockets.
pub const RUNTIME_VARIABLE: &str = "BLADEOFF_RUNTIME_DIR";
/// Printable ASCII characters that the transport rejects in a path. All other characters outside printable ASCII are rejected as well.
pub(crate) const REFUSED_SIGNS: &str = "< > \" | ? *";
/// Directory of iceoryx2's shared memory on Linux.
pub(crate) const SHM: &str = "/dev/shm";
/// Longest root and prefix together: 108 bytes minus iceoryx2's part of a socket's name.
pub(crate) const LONGEST_ADDRESS: usize = 65;
/// Digits of a run's id.
pub(crate) const ID_LENGTH: usize = 10;

/// Directory and prefix by which a process finds a domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// Directory for files and sockets.
    pub root: PathBuf,
    /// Start of the names in /dev/shm.
    pub prefix: String,
}

/// Start of the names of a run in /dev/shm.
pub(crate) fn prefix_of(id: &str) -> String {
    format!("{PRODUCT}_{id}_")
}

pub(crate) fn is_id(name: &str) -> bool {
    name.len() == ID_LENGTH && name.bytes().all(|byte| byte.is_ascii_hexdigit())
}
