//! Threads for what is computed here and not by workers. Where none can be started, that is an error and no panic.

use std::io;

/// Stack of a thread that the standard library starts \[bytes\].
const STACK: u64 = 2 << 20;

/// Address space of a command beside its threads, and of each thread with its allocator \[bytes\]. A study of 12 transients on 2 cores ran out of
/// memory at 225 MB.
const BASE: u64 = 400_000_000;
const PER_THREAD: u64 = 8_000_000;

/// A limit of the address space with which a command would be ended by the system.
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
    /// How many.
    pub threads: usize,
    /// What the system said.
    #[source]
    pub source: io::Error,
}

/// The limit on the number of threads, in words: a limit of the address space leaves no room for their stacks, and the system reports it as a lack of
/// threads.
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

/// Does work in which rayon's iterators find one thread per core (or `RAYON_NUM_THREADS`).
///
/// # Errors
/// The threads cannot be started.
pub fn in_parallel<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, ThreadsError> {
    Ok(pool()?.install(work))
}

/// Whether as many threads can be started, now.
///
/// # Errors
/// They cannot.
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
    // Threads that start until the address space is used up leave none for what they allocate: the process would end by a signal.
    let stacks = STACK.saturating_mul(threads as u64);
    if rustix::process::getrlimit(rustix::process::Resource::As).current.is_some_and(|limit| stacks > limit) {
        let needed = format!("their stacks alone need {} MB", stacks / 1_000_000);
        return Err(ThreadsError { threads, source: io::Error::other(needed) });
    }
    // The library's error says what the system said, and says it again as its source.
    let failed =
        |error: rayon::ThreadPoolBuildError| ThreadsError { threads, source: io::Error::other(error.to_string()) };
    rayon::ThreadPoolBuilder::new().build().map_err(failed)
}
