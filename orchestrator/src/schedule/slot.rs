//! Data of the scheduler: slots for workers, and effects.

use std::collections::VecDeque;
use std::time::Duration;

use bladeoff_model::outcome::Cause;
use bladeoff_protocol::messages::{BatchId, WorkerId};

use super::ended::Ended;

/// Action of the dispatch loop.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Start a worker process with this number.
    Spawn(WorkerId),
    /// Answer the worker's request with these samples.
    Assign {
        /// Worker.
        worker: WorkerId,
        /// Number of the batch.
        batch: BatchId,
        /// Attempt number, 1 for the first.
        attempt: u32,
        /// Sample numbers.
        samples: Vec<u64>,
    },
    /// Answer the worker's request with `continue`.
    Continue(WorkerId),
    /// Answer the worker's request with `leave`: the rest of its batch was assigned to other workers.
    Leave(WorkerId),
    /// Answer the worker's request with `stop`.
    Stop(WorkerId),
    /// Record a sample of the present report.
    Record {
        /// Index of the sample in the report.
        index: usize,
        /// Attempt that succeeded.
        attempt: u32,
        /// Worker that computed it.
        worker: WorkerId,
    },
    /// Record a sample as quarantined.
    Quarantine {
        /// Sample number.
        sample: u64,
        /// Cause recorded for the sample.
        cause: Cause,
        /// Worker that died last.
        worker: WorkerId,
        /// Attempts made.
        attempt: u32,
    },
    /// Kill the worker's process.
    Kill {
        /// Worker to kill.
        worker: WorkerId,
        /// Reason of the kill.
        why: KillReason,
    },
    /// Report that no sample is assigned any more, although the study is not complete.
    Stopping(Ended),
    /// End the run because workers do not start.
    GiveUp {
        /// Number of workers in a row that died before they asked for work.
        deaths: u32,
    },
}

/// Reason of a kill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KillReason {
    /// The worker's sample takes longer than the time limit.
    TimeLimit,
    /// The worker sent no heartbeat.
    Silent,
    /// The worker waits although it has samples: a message was lost.
    Lost,
    /// The run ends.
    Ending,
}

/// End of a worker's process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Death {
    /// An allocation had failed.
    pub out_of_memory: bool,
    /// Ended by a signal of another process.
    pub from_outside: bool,
}

/// Attempts at a sample that lost its worker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trouble {
    /// Attempts that ended without a result.
    pub attempts: u32,
    /// Attempts in which the worker had only this sample and crashed or was killed because of the sample.
    pub crashes: u32,
    /// Attempts in which the worker had only this sample and was killed by another process.
    pub kills: u32,
}

/// Batch of a worker.
#[derive(Debug, Clone)]
pub(super) struct Work {
    pub batch: BatchId,
    pub attempt: u32,
    /// Number of samples at first.
    pub size: usize,
    /// Samples without a result yet.
    pub left: VecDeque<u64>,
    /// Samples taken back for other workers (`work_stealing`): later results of this worker do not count.
    pub taken_back: Vec<u64>,
    pub assigned: Duration,
    /// Sample in progress according to the heartbeats, and its start.
    pub current: Option<(u64, Duration)>,
    /// Time since which heartbeats report that the worker waits.
    pub waiting: Option<Duration>,
}

/// State of a slot's worker.
#[derive(Debug, Clone)]
pub(super) enum State {
    /// Has not requested work; whether it has connected.
    Starting { greeted: bool },
    /// Its request for work is open.
    Idle,
    /// Computes.
    Busy(Work),
    /// Has the order to stop or was killed; results of its batch are still accepted.
    Leaving { work: Option<Work> },
    /// Has ended; time of the start of the next one.
    Gone { due: Duration },
    /// Has ended without a successor.
    Closed,
}

#[derive(Debug, Clone)]
pub(super) struct Slot {
    pub worker: WorkerId,
    pub pid: Option<u32>,
    pub state: State,
    /// Time since which it is in this state.
    pub since: Duration,
    /// Time of the last message or heartbeat.
    pub heard: Duration,
    pub killed: Option<KillReason>,
    /// Deaths in a row without a result.
    pub deaths: u32,
}

impl Slot {
    pub fn work(&self) -> Option<&Work> {
        match &self.state {
            State::Busy(work) | State::Leaving { work: Some(work) } => Some(work),
            _ => None,
        }
    }

    /// Whether a process exists.
    pub fn lives(&self) -> bool {
        !matches!(self.state, State::Gone { .. } | State::Closed)
    }

    pub fn enter(&mut self, state: State, now: Duration) {
        self.state = state;
        self.since = now;
    }
}

/// Processes that were started.
#[derive(Debug, Default)]
pub(super) struct Starts {
    /// Number of started processes.
    made: u32,
    /// Number in a row that died before they asked for work.
    pub failed: u32,
}

impl Starts {
    pub fn next(&mut self) -> WorkerId {
        self.made += 1;
        WorkerId(self.made)
    }
}
