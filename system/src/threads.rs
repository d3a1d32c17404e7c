//! Threads for computations in the main process instead of in workers. A thread that cannot be started is an error, not a panic.

use std::io;

/// Stack size of a thread started by the standard library \[bytes\].
const STACK: u64 = 2 << 20;

/// Address space \[bytes\] of a command without its threads, and of each thread including its allocator. A study of 12 transients on 2 cores
/// ran out of memory at 225 MB.
const BASE: u64 = 400_000_000;
const PER_THREAD: u64 = 8_000_000;

/// The limit on the address space is below the need of the command, which the system would end.
#[derive(Debug, thiserror::Error)]
#[error(
    "the address space is limited to {} MB (ulimit -v {}), and {} MB are needed for {threads} threads; raise the limit with \
     `ulimit -v {}`, or remove it with `ulimit -v unlimited`",
    limit / 1_000_000,
    limit / 1024,
    needed / 1_000_000,
    needed.div_ceil(1024)
)]
pub struct AddressSpaceError {
    /// The limit \[bytes\].
    pub limit: u64,
    /// Needed size \[bytes\].
    pub needed: u64,
    /// Threads of the command.
    pub threads: usize,
}

/// Checks that the limit of the address space leaves room for a command and its threads.
///
/// # Errors
/// [`AddressSpaceError`]: the limit is too small.
pub fn check_address_space() -> Result<(), AddressSpaceError> {
    let threads = threads();
    let needed = PER_THREAD.saturating_mul(threads as u64).saturating_add(BASE);
    match rustix::process::getrlimit(rustix::process::Resource::As).current {
        Some(limit) if limit < needed => Err(AddressSpaceError { limit, needed, threads }),
        _ => Ok(()),
    }
}

/// Threads that could not be started.
#[derive(Debug, thiserror::Error)]
#[error("starting {threads} threads failed; {}", thread_limit())]
pub struct ThreadsError {
    /// Number of threads.
    pub threads: usize,
    /// Error of the system.
    #[source]
    pub source: io::Error,
}

/// Describes the limit on the number of threads. The system also reports a lack of threads when a limit on the address space leaves no room
/// for their stacks.
#[must_use]
pub fn thread_limit() -> String {
    match rustix::process::getrlimit(rustix::process::Resource::As).current {
        Some(bytes) => format!(
            "the address space is limited to {} MB (ulimit -v {}), which their stacks need: raise it with `ulimit -v unlimited`; or the number of processes \
             and threads of a user is too small (ulimit -u, or the container)",
            bytes / 1_000_000,
            bytes / 1024
        ),
        None => "the number of processes and threads that a user may have is limited (ulimit -u, or the container)"
            .to_owned(),
    }
}

/// Runs `work` in a pool with one thread per core (or `RAYON_NUM_THREADS`), which rayon's iterators use.
///
/// # Errors
/// The threads cannot be started.
pub fn in_parallel<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, ThreadsError> {
    Ok(pool()?.install(work))
}

/// Checks that the threads of the pool can be started now.
///
/// # Errors
/// [`ThreadsError`] if they cannot be started.
pub fn check() -> Result<(), ThreadsError> {
    pool().map(drop)
}

/// Threads of the pool: one per core, or `RAYON_NUM_THREADS`.
fn threads() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok()).filter(|count| *count > 0);
    asked.unwrap_or(cores)
}

fn pool() -> Result<rayon::ThreadPool, ThreadsError> {
    let threads = threads();
    // Threads that use up the address space with their stacks leave none to allocate from: a signal would end the process.
    let stacks = STACK.saturating_mul(threads as u64);
    if rustix::process::getrlimit(rustix::process::Resource::As).current.is_some_and(|limit| stacks > limit) {
        let needed = format!("their stacks alone need {} MB", stacks / 1_000_000);
        return Err(ThreadsError { threads, source: io::Error::other(needed) });
    }
    // The library's error has the system's error both in its message and as its source, so only the message is kept.
    let failed =
        |error: rayon::ThreadPoolBuildError| ThreadsError { threads, source: io::Error::other(error.to_string()) };
    rayon::ThreadPoolBuilder::new().build().map_err(failed)
}
