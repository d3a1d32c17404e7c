//! Limit on open files of this process, and the need of a run.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::domain_error::DomainError;
use crate::transport::PortError;

/// Files that an orchestrator opens apart from those of its workers (record, tables, parts, log, event loop, its own ports: 34 were counted),
/// with a margin.
const BASE_FILES: u64 = 48;
/// Files per worker (two pipes, its process, memory and sockets of its ports: 8 were counted), with a margin.
const WORKER_FILES: u64 = 10;
/// With this few files left to open, the limit counts as reached: an operation that failed has already closed the files it had opened.
const FEW: u64 = 12;

/// Files that a run with this many workers can have open.
fn needed(workers: usize) -> u64 {
    BASE_FILES + WORKER_FILES * workers as u64
}

/// Raises the limit on open files (`ulimit -n`), if it is too low for a run with this many workers, as far as this process may.
///
/// # Errors
/// [`DomainError::FewDescriptors`] if the highest allowed limit is too low.
pub(crate) fn allow_files(workers: usize) -> Result<(), DomainError> {
    let needed = needed(workers);
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    // `None` means unlimited.
    let is_enough = |limit: Option<u64>| limit.is_none_or(|limit| limit >= needed);
    if is_enough(current) {
        return Ok(());
    }
    if is_enough(maximum) && setrlimit(Resource::Nofile, Rlimit { current: Some(needed), maximum }).is_ok() {
        return Ok(());
    }
    let limit = if is_enough(maximum) { current } else { maximum };
    Err(DomainError::FewDescriptors { limit: limit.unwrap_or_default(), needed, workers })
}

/// [`PortError::NoDescriptors`] if this process has reached its limit on open files.
pub(crate) fn few_descriptors() -> Option<PortError> {
    let limit = getrlimit(Resource::Nofile).current?;
    // A directory that cannot be opened also means that the limit is reached.
    let open = std::fs::read_dir("/proc/self/fd").map_or(limit, |entries| entries.count() as u64);
    (open + FEW >= limit).then_some(PortError::NoDescriptors { limit, open })
}
