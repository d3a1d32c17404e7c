//! Conditions of a benchmark: its directory, and the load of the machine.

use super::super::error::CliError;
use bladeoff_answers::summary::counted;
use bladeoff_system::files::FileError;
use std::fs;
use std::path::PathBuf;

/// A directory on a disk, removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    /// Creates an empty directory below the temporary directory.
    ///
    /// # Errors
    /// The directory cannot be created.
    pub fn new() -> Result<Self, CliError> {
        let path = std::env::temp_dir().join(format!("bladeoff-bench-{}", std::process::id()));
        fs::create_dir(&path).map_err(FileError::at("create", &path))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Remains in a temporary directory do no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Processor and number of cores.
pub(in crate::cli) fn hardware() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    format!("{}, {}", name.map_or("unknown processor", |(_, name)| name.trim()), counted(cores as u64, "core"))
}

/// The load of the machine over the last minute, as the system reports it.
#[must_use]
pub fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().next().unwrap_or("?").to_owned()
}
