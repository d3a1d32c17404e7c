//! Counts of the samples and workers of a run.

use bladeoff_model::outcome::{Cause, Status};

/// Counts of one run.
#[derive(Debug)]
pub(super) struct Counts {
    /// Samples of the run.
    pub total: u64,
    /// Ended samples.
    pub done: u64,
    pub by_status: [u64; Status::ALL.len()],
    pub by_cause: [u64; Cause::ALL.len()],
    /// Workers that died or were killed without an order to stop.
    pub worker_deaths: u64,
    /// Late, duplicate and invalid messages.
    pub dropped: u64,
}

impl Counts {
    pub fn new(total: u64) -> Self {
        let (by_status, by_cause) = ([0; Status::ALL.len()], [0; Cause::ALL.len()]);
        Self { total, done: 0, by_status, by_cause, worker_deaths: 0, dropped: 0 }
    }

    /// Counts an ended sample.
    pub fn add(&mut self, status: Status, cause: Option<Cause>) {
        self.done += 1;
        self.by_status[usize::from(status.code())] += 1;
        if let Some(cause) = cause {
            self.by_cause[usize::from(cause.code())] += 1;
        }
    }

    /// Failed and quarantined samples.
    pub fn failed(&self) -> u64 {
        let of = |status: Status| self.by_status[usize::from(status.code())];
        of(Status::Failed) + of(Status::Quarantined)
    }
}
