//! What the scheduler shows of itself: plain data for progress lines, `status` and events.

use std::time::Duration;

use bladeoff_model::outcome::{Cause, Status};
use bladeoff_protocol::messages::WorkerId;

use super::scheduler::Scheduler;
use super::slot::State;

/// The state of a run at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Time since the run began.
    pub elapsed: Duration,
    /// Attended time since the first samples were assigned.
    pub computing: Duration,
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
    /// The workers, in the order of their slots.
    pub workers: Vec<WorkerView>,
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

impl Scheduler {
    /// The sample a worker was last heard to be in, or has alone.
    #[must_use]
    pub fn sample_of(&self, worker: WorkerId) -> Option<u64> {
        let work = self.slots[self.slot_of(worker)?].work()?;
        let alone = work.left.front().filter(|_| work.left.len() == 1).copied();
        work.current.map(|(sample, _)| sample).or(alone)
    }

    /// What the run looks like.
    #[must_use]
    pub fn snapshot(&self, now: Duration) -> Snapshot {
        let attended = self.clock.now();
        let workers = self.slots.iter().filter(|slot| !matches!(slot.state, State::Closed)).map(|slot| {
            let current = slot.work().and_then(|work| work.current);
            WorkerView {
                worker: slot.worker.0,
                pid: slot.pid,
                activity: match &slot.state {
                    State::Starting { .. } => Activity::Starting,
                    State::Idle => Activity::Idle,
                    State::Busy(work) => {
                        Activity::Busy { sample: current.map(|(sample, _)| sample), left: work.left.len() }
                    }
                    State::Leaving { .. } => Activity::Leaving,
                    State::Gone { .. } | State::Closed => Activity::Gone,
                },
                stale: slot.lives() && attended.saturating_sub(slot.heard) >= self.settings.stale_after,
                since: attended.saturating_sub(current.map_or(slot.since, |(_, since)| since)),
            }
        });
        Snapshot {
            elapsed: now,
            computing: self.rate.computing(attended),
            total: self.counts.total,
            done: self.counts.done,
            by_status: self.counts.by_status,
            by_cause: self.counts.by_cause,
            rate: self.rate.per_second(now, self.counts.done),
            worker_deaths: self.counts.worker_deaths,
            dropped_messages: self.counts.dropped,
            workers: workers.collect(),
        }
    }
}
