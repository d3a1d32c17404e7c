//! Default result directory.

use super::output::remark;
use super::refusals::NoDirectory;
use crate::run::STATUS;
use crate::run::directory::{LEDGER, LOCK};
use crate::run::shards::SHARDS;
use bladeoff_system::shown;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The current directory if a study was run there, otherwise the directory below runs/ that was written last; its name is printed.
///
/// # Errors
/// There is no such directory.
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

/// Time of the last write of a run to a directory; `None` if it is no result directory.
fn written(directory: &Path) -> Option<SystemTime> {
    let modified = |name: &str| fs::symlink_metadata(directory.join(name)).and_then(|found| found.modified()).ok();
    // a run that has just begun has its lock before its record; `status` and `why` require one of them
    let begun = [LEDGER, LOCK, SHARDS].into_iter().filter_map(modified).max()?;
    Some(modified(STATUS).map_or(begun, |told| told.max(begun)))
}
