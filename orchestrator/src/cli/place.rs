//! The result directory that is meant where none is named.

use super::output::remark;
use super::refusals::NoDirectory;
use crate::run::STATUS;
use crate::run::directory::{LEDGER, LOCK};
use crate::run::shards::SHARDS;
use bladeoff_system::shown;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The current directory if a study was run there, otherwise the one below runs/ that was written to last; which one is said.
///
/// # Errors
/// Neither is there.
pub fn default_directory() -> Result<PathBuf, NoDirectory> {
    if written(Path::new(".")).is_some() {
        return Ok(PathBuf::from("."));
    }
    let entries = fs::read_dir("runs").map_err(|_| NoDirectory)?;
    let runs = entries.flatten().filter_map(|entry| Some((written(&entry.path())?, entry.path())));
    let (_, latest) = runs.max().ok_or(NoDirectory)?;
    remark(&format!("in {}:", shown(&latest)));
    Ok(latest)
}

/// When a run has written to a directory last; `None` where none was.
fn written(directory: &Path) -> Option<SystemTime> {
    let modified = |name: &str| fs::symlink_metadata(directory.join(name)).and_then(|found| found.modified()).ok();
    // A run that has just begun has its lock before its record; without either `status` and `why` know of no run.
    let begun = [LEDGER, LOCK, SHARDS].into_iter().filter_map(modified).max()?;
    Some(modified(STATUS).map_or(begun, |told| told.max(begun)))
}
