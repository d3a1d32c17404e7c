//! State of a run as plain data for progress lines, `status` and events.

use std::time::Duration;

use bladeoff_model::outcome::{Cause, Status};
use bladeoff_protocol::messages::WorkerId;

use super::scheduler::Scheduler;
use super::slot::State;

/// State of a run at one moment.
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
    /// Workers that died or were killed without an order to stop.
    pub worker_deaths: u64,
    /// Discarded messages.
    pub dropped_messages: u64,
    /// The workers, in the order of their slots.
    pub workers: Vec<WorkerView>,
}

/// State of a worker for the display.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkerView {
    /// Number over all workers started.
    pub worker: u32,
    /// Process id, once started.
    pub pid: Option<u32>,
    /// Its state.
    pub activity: Activity,
    /// Whether no heartbeat has come for `stale_after`.
    pub stale: bool,
    /// Time in this state, or in the present sample if it is known.
    pub since: Duration,
}

/// Activity of a worker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// Started, without a request for work.
    Starting,
    /// Waits for work.
    Idle,
    /// Computes a batch.
    Busy {
        /// Sample in progress according to the last heartbeat.
        sample: Option<u64>,
        /// Samples of the batch not yet reported.
        left: usize,
    },
    /// Has the order to stop, or was killed.
    Leaving,
    /// Died; the next one starts after a pause.
    Gone,
}

impl Scheduler {
    /// Sample in progress by the last heartbeat, or the worker's only one.
    #[must_use]
    pub fn sample_of(&self, worker: WorkerId) -> Option<u64> {
        let work = self.slots[self.slot_of(worker)?].work()?;
        let alone = work.left.front().filter(|_| work.left.len() == 1).copied();
        work.current.map(|(sample, _)| sample).or(alone)
    }

    /// Creates the snapshot.
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
