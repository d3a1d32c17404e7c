//! Heartbeat thread: reports twice a second the sample in progress, and ends a process whose parent has ended.
//!
//! The kernel kills a worker with its parent (see [`process::end_with_parent`](crate::process::end_with_parent)), and idle
//! workers notice the end while they wait; this thread is the safeguard for both.

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::messages::BatchId;
use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::fs::OFlags;
use rustix::process::Signal;

use crate::process::signal_self;

/// Time between heartbeats.
pub const BEAT_EVERY: Duration = Duration::from_millis(500);
/// Time for an orderly end after the end of the parent.
const FAREWELL: Duration = Duration::from_secs(1);
const NONE: u64 = u64::MAX;

/// Sample in progress, shared with the heartbeat thread.
#[derive(Debug, Clone)]
pub struct Heartbeat(Arc<State>);

#[derive(Debug)]
struct State {
    batch: AtomicU64,
    sample: AtomicU64,
}

impl Default for Heartbeat {
    fn default() -> Self {
        Self(Arc::new(State { batch: AtomicU64::new(0), sample: AtomicU64::new(NONE) }))
    }
}

impl Heartbeat {
    /// Takes the beginning of a sample.
    pub fn working(&self, batch: BatchId, sample: u64) {
        self.0.batch.store(batch.0, Ordering::Relaxed);
        self.0.sample.store(sample, Ordering::Relaxed);
    }

    /// Takes the end of a batch.
    pub fn waiting(&self) {
        self.0.sample.store(NONE, Ordering::Relaxed);
        self.0.batch.store(0, Ordering::Relaxed);
    }

    /// Contents of the next heartbeat.
    #[must_use]
    pub fn beat(&self) -> Beat {
        let sample = self.0.sample.load(Ordering::Relaxed);
        Beat { batch: BatchId(self.0.batch.load(Ordering::Relaxed)), sample: (sample != NONE).then_some(sample) }
    }

    /// Starts the thread; heartbeats go to standard output.
    ///
    /// # Errors
    /// The thread could not be started.
    pub fn start(&self, parent: Option<OwnedFd>) -> std::io::Result<()> {
        let stdout = std::io::stdout();
        // A stopped reader must not stop this process: a heartbeat that finds the pipe full is lost.
        if let Ok(flags) = rustix::fs::fcntl_getfl(&stdout) {
            let _ = rustix::fs::fcntl_setfl(&stdout, flags | OFlags::NONBLOCK);
        }
        let heartbeat = self.clone();
        std::thread::Builder::new()
            .name("pulse".into())
            .stack_size(64 << 10)
            .spawn(move || heartbeat.run(parent))
            .map(drop)
    }

    fn run(&self, parent: Option<OwnedFd>) {
        let every = Timespec { tv_sec: 0, tv_nsec: i64::from(BEAT_EVERY.subsec_nanos()) };
        // Written past the buffer of `Stdout`, in one piece.
        let stdout = std::io::stdout();
        loop {
            let _ = rustix::io::write(&stdout, &self.beat().encode());
            let mut fds: Vec<PollFd<'_>> = parent.iter().map(|fd| PollFd::new(fd, PollFlags::IN)).collect();
            let ended = rustix::event::poll(&mut fds, Some(&every)).is_ok_and(|ready| ready > 0);
            if ended {
                std::thread::sleep(FAREWELL);
                signal_self(Signal::KILL);
            }
        }
    }
}
