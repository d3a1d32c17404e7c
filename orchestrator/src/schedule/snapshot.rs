//! What the scheduler shows of itself: plain data for progress lines, `status` and events.

use std::time::Duration;

use bladeoff_core::outcome::{Cause, Status};

/// The state of a run at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Time since the run began.
    pub elapsed: Duration,
    /// Samples of this run.
    pub total: u64,
    /// Samples that have ended.
    pub done: u64,
    /// Ended samples by status, indexed by [`Status::code`].
    pub by_status: [u64; Status::ALL.len()],
    /// Ended samples by first cause, indexed by [`Cause::code`].
    pub by_cause: [u64; Cause::ALL.len()],
    /// Samples per second over the last seconds.
    pub rate: f64,
    /// Workers that died or were killed while they should have lived.
    pub worker_deaths: u64,
    /// Messages dropped.
    pub dropped_messages: u64,
    /// The workers, in the order of their places.
    pub workers: Vec<WorkerView>,
}

impl Snapshot {
    /// Time the rest will take at the present rate; `None` before a rate is known.
    #[must_use]
    pub fn eta(&self) -> Option<Duration> {
        (self.rate > 0.0).then(|| Duration::from_secs_f64(((self.total - self.done) as f64 / self.rate).min(1e12)))
    }
}

/// What one worker is doing.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkerView {
    /// Number over all workers started.
    pub worker: u32,
    /// Process id, once started.
    pub pid: Option<u32>,
    /// Its state.
    pub activity: Activity,
    /// Not heard of for longer than `stale_after`.
    pub stale: bool,
    /// For how long it has been in this state (on this sample, when one is known).
    pub since: Duration,
}

/// The state of one worker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// Started, has not asked yet.
    Starting,
    /// Waits for work.
    Idle,
    /// Computes a batch.
    Busy {
        /// Sample in work, as its last heartbeat said.
        sample: Option<u64>,
        /// Samples of the batch not yet reported.
        left: usize,
    },
    /// Was told to stop, or killed.
    Leaving,
    /// Died; the next one starts after a pause.
    Gone,
}
