//! The scheduler's data: slots for workers, effects.

use std::collections::VecDeque;
use std::time::Duration;

use bladeoff_model::outcome::Cause;
use bladeoff_protocol::messages::{BatchId, WorkerId};

use super::ended::Ended;

/// What the dispatch loop has to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Start a worker process with this number.
    Spawn(WorkerId),
    /// Answer the worker's request with these samples.
    Assign {
        /// To whom.
        worker: WorkerId,
        /// Number of the batch.
        batch: BatchId,
        /// 1 for the first.
        attempt: u32,
        /// Sample numbers.
        samples: Vec<u64>,
    },
    /// Answer the worker's request with `continue`.
    Continue(WorkerId),
    /// Answer the worker's request with `leave`: what is left of its batch is with others.
    Leave(WorkerId),
    /// Answer the worker's request with `stop`.
    Stop(WorkerId),
    /// Record the sample at this index of the report just given.
    Record {
        /// Index into its samples.
        index: usize,
        /// Attempt that succeeded.
        attempt: u32,
        /// Worker that computed it.
        worker: WorkerId,
    },
    /// Record a sample as quarantined.
    Quarantine {
        /// Which.
        sample: u64,
        /// Why.
        cause: Cause,
        /// Worker that died last.
        worker: WorkerId,
        /// Attempts made.
        attempt: u32,
    },
    /// Kill the worker's process.
    Kill {
        /// Which.
        worker: WorkerId,
        /// Why.
        why: KillReason,
    },
    /// Tell that no sample is assigned any more, though the run is not complete.
    Stopping(Ended),
    /// Workers do not start: end the run.
    GiveUp {
        /// How many in a row died before they asked for work.
        deaths: u32,
    },
}

/// Why a worker is killed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KillReason {
    /// Its sample takes longer than the time limit.
    TimeLimit,
    /// Nothing was heard of it.
    Silent,
    /// It waits although it has work: a message was lost.
    Lost,
    /// The run ends.
    Ending,
}

/// How a worker's process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Death {
    /// An allocation had failed.
    pub out_of_memory: bool,
    /// By a signal that somebody sent, not by one that a program brings upon itself.
    pub from_outside: bool,
}

/// Attempts at a sample that lost its worker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trouble {
    /// Attempts that ended without a result.
    pub attempts: u32,
    /// Those among them in which the worker had nothing else, and ended by itself or because of the sample.
    pub crashes: u32,
    /// Those in which it had nothing else, and somebody ended it.
    pub kills: u32,
}

/// A batch with a worker.
#[derive(Debug, Clone)]
pub(super) struct Work {
    pub batch: BatchId,
    pub attempt: u32,
    /// Samples it had at first.
    pub size: usize,
    /// Samples without a result yet.
    pub left: VecDeque<u64>,
    /// Taken back for others (`relief`): what this worker still says of them counts for nothing.
    pub taken_back: Vec<u64>,
    pub assigned: Duration,
    /// Sample in work by the heartbeats, and since when.
    pub current: Option<(u64, Duration)>,
    /// Since when heartbeats say that the worker waits.
    pub waiting: Option<Duration>,
}

/// State of the worker of a slot.
#[derive(Debug, Clone)]
pub(super) enum State {
    /// Has not asked for work yet; whether it has said hello.
    Starting { greeted: bool },
    /// Its request for work is open.
    Idle,
    /// Computes.
    Busy(Work),
    /// Was told to stop or killed; results of its batch are still taken.
    Leaving { work: Option<Work> },
    /// Has ended; the next one is due then.
    Gone { due: Duration },
    /// Has ended and none will follow.
    Closed,
}

#[derive(Debug, Clone)]
pub(super) struct Slot {
    pub worker: WorkerId,
    pub pid: Option<u32>,
    pub state: State,
    /// Since when it is in this state.
    pub since: Duration,
    /// Last sign of life.
    pub heard: Duration,
    pub killed: Option<KillReason>,
    /// Deaths in a row without a result between them.
    pub deaths: u32,
}

impl Slot {
    pub fn work(&self) -> Option<&Work> {
        match &self.state {
            State::Busy(work) | State::Leaving { work: Some(work) } => Some(work),
            _ => None,
        }
    }

    /// Whether there is a process.
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
    /// How many.
    made: u32,
    /// How many in a row died before they asked.
    pub failed: u32,
}

impl Starts {
    pub fn next(&mut self) -> WorkerId {
        self.made += 1;
        WorkerId(self.made)
    }
}
