//! Process of a worker: end with its parent, memory limit, identity of the program, exit codes.

use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::time::Duration;

use rustix::process::{Pid, PidfdFlags, Resource, Rlimit, Signal};

/// Exit code: invalid command line.
pub const EXIT_USAGE: u8 = 2;
/// Exit code: the plan is unreadable or unexpected, or has no solver.
pub const EXIT_PLAN: u8 = 3;
/// Exit code: no connection to the orchestrator, or a broken one.
pub const EXIT_CONNECTION: u8 = 6;
/// Last message of a worker when an allocation fails, from Rust's own handler before the abort.
pub const OUT_OF_MEMORY_WORDS: &str = "memory allocation of";

/// Error of the set-up of a worker's process.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The parent process has ended before the death signal was set.
    #[error("the orchestrator (process {expected}) has ended")]
    ParentGone {
        /// Process id of the parent.
        expected: u32,
    },
    /// The system refused.
    #[error("{doing} failed")]
    System {
        /// Failed action.
        doing: &'static str,
        /// Error of the system.
        #[source]
        source: std::io::Error,
    },
}

fn system<E: Into<std::io::Error>>(doing: &'static str) -> impl FnOnce(E) -> ProcessError {
    move |source| ProcessError::System { doing, source: source.into() }
}

/// Makes the kernel kill this process when the thread that started it ends, even in the middle of a sample or while stopped. Returns the
/// pidfd of the parent, for an orderly end where time allows.
///
/// # Errors
/// [`ProcessError::ParentGone`] if the parent has ended already; otherwise an error of the system.
pub fn end_with_parent(expected: u32) -> Result<OwnedFd, ProcessError> {
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL))
        .map_err(system("asking to be killed with the parent"))?;
    let parent = rustix::process::getppid()
        .filter(|pid| u32::try_from(pid.as_raw_nonzero().get()) == Ok(expected))
        .ok_or(ProcessError::ParentGone { expected })?;
    rustix::process::pidfd_open(parent, PidfdFlags::empty()).map_err(system("watching the parent"))
}

/// Limits the memory that this process may allocate from now on. An allocation beyond the limit fails at once: the process writes
/// [`OUT_OF_MEMORY_WORDS`] and aborts. The limit applies to private writable memory (`RLIMIT_DATA`). Unlike the address space, that does
/// not include shared memory and files; unlike a limit on resident memory, it needs no monitoring.
///
/// # Errors
/// An error of the system.
pub fn limit_memory(bytes: u64) -> Result<(), ProcessError> {
    let status = std::fs::read_to_string("/proc/self/status").map_err(system("reading /proc/self/status"))?;
    let in_use = status
        .lines()
        .find_map(|line| line.strip_prefix("VmData:")?.trim().strip_suffix("kB")?.trim().parse::<u64>().ok())
        .unwrap_or(0)
        * 1024;
    let limit = Rlimit { current: Some(in_use.saturating_add(bytes)), maximum: None };
    let allowed = rustix::process::getrlimit(Resource::Data);
    rustix::process::setrlimit(Resource::Data, Rlimit { maximum: allowed.maximum, ..limit })
        .map_err(system("limiting memory"))
}

/// Sets the process name that `ps` and `top` show; without it, the name would be `exe`.
pub fn take_name() {
    // A failure affects the display only.
    let _ = std::fs::write("/proc/self/comm", "bladeoff-worker");
}

/// Identity of the running program file: equal for orchestrator and worker exactly if they run the same file.
#[must_use]
pub fn build_id() -> u64 {
    let Ok(file) = std::fs::metadata("/proc/self/exe") else { return 0 };
    [file.dev(), file.ino(), file.size(), file.mtime() as u64, file.mtime_nsec() as u64]
        .into_iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(23))
}

/// Sends a signal to the calling thread, which has received the signal on return. A stop signal to the whole process would be delivered to
/// the first thread, and the caller would continue until that thread runs.
#[expect(unsafe_code, reason = "neither the standard library nor rustix sends a signal to a thread")]
pub fn signal_self(signal: Signal) {
    // SAFETY: no memory is passed. Cannot fail: the thread exists and may signal itself.
    unsafe { libc::raise(signal.as_raw()) };
}

/// Sends a signal to another process; returns whether the process existed.
#[must_use]
pub fn signal(pid: u32, signal: Signal) -> bool {
    i32::try_from(pid)
        .ok()
        .and_then(Pid::from_raw)
        .is_some_and(|pid| rustix::process::kill_process(pid, signal).is_ok())
}

/// Makes a write beyond the file size limit (`ulimit -f`) fail like one to a full disk, instead of ending the process.
#[expect(unsafe_code, reason = "the standard library sets no signal actions")]
pub fn fail_writes_beyond_the_limit() {
    // SAFETY: SIG_IGN is a valid action and no handler runs; called before any thread is started.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}

/// CPU time of the calling thread.
#[must_use]
pub fn thread_cpu_time() -> Duration {
    cpu_time(libc::CLOCK_THREAD_CPUTIME_ID)
}

/// CPU time of all threads of this process, including ended ones.
#[must_use]
pub fn process_cpu_time() -> Duration {
    cpu_time(libc::CLOCK_PROCESS_CPUTIME_ID)
}

#[expect(unsafe_code, reason = "the standard library has no clock of CPU time")]
fn cpu_time(clock: libc::clockid_t) -> Duration {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a valid timespec that outlives the call, which writes to nothing else.
    if unsafe { libc::clock_gettime(clock, &raw mut time) } != 0 {
        return Duration::ZERO;
    }
    Duration::new(u64::try_from(time.tv_sec).unwrap_or(0), u32::try_from(time.tv_nsec).unwrap_or(0))
}
