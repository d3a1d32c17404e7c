//! Limit of open files of this process, compared with the need of a run.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::domain_error::DomainError;
use crate::transport::PortError;

/// Files that an orchestrator has open beside those of its workers (record, tables, parts, log, event loop, its own ports: 34 were
/// counted), and some to spare.
const BASE_FILES: u64 = 48;
/// Files for each worker (two pipes, its process, memory and sockets of its ports: 8 were counted), and some to spare.
const WORKER_FILES: u64 = 10;
/// So few left are none: what is made of several files was closed again when it failed.
const FEW: u64 = 12;

/// Files that a run with so many workers can have open.
fn needed(workers: usize) -> u64 {
    BASE_FILES + WORKER_FILES * workers as u64
}

/// Raises the limit on open files (`ulimit -n`) as far as this process may, if it is too low for a run with so many workers.
///
/// # Errors
/// [`DomainError::FewDescriptors`] if that is not far enough.
pub(crate) fn allow_files(workers: usize) -> Result<(), DomainError> {
    let needed = needed(workers);
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    // `None` is no limit.
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

/// The error that says that no more files can be opened, if that is so.
pub(crate) fn few_descriptors() -> Option<PortError> {
    let limit = getrlimit(Resource::Nofile).current?;
    // That it cannot be counted says the same.
    let open = std::fs::read_dir("/proc/self/fd").map_or(limit, |entries| entries.count() as u64);
    (open + FEW >= limit).then_some(PortError::NoDescriptors { limit, open })
}
