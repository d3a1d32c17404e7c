//! Names of a run's directory and memory, and the places where they are searched.

use std::path::PathBuf;

/// First part of every name of ours.
pub(crate) const PRODUCT: &str = "bladeoff";
/// Environment variable that names the directory below which runs have their sockets.
pub const RUNTIME_VARIABLE: &str = "BLADEOFF_RUNTIME_DIR";
/// What the transport refuses in a path, of the printable signs of ASCII; it takes no others.
pub(crate) const REFUSED_SIGNS: &str = "< > \" | ? *";
/// Where iceoryx2 keeps memory on Linux.
pub(crate) const SHM: &str = "/dev/shm";
/// Longest root and prefix together: what is left of 108 bytes beside iceoryx2's part of a socket's name.
pub(crate) const LONGEST_ADDRESS: usize = 65;
/// Digits of a run's id.
pub(crate) const ID_LENGTH: usize = 10;

/// What a process needs to find a domain.
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
