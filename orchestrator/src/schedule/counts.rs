//! What has become of the samples and the workers of a run, in numbers.

use bladeoff_model::outcome::{Cause, Status};

/// Counts of one run.
#[derive(Debug)]
pub(super) struct Counts {
    /// Samples of the run.
    pub total: u64,
    /// Those that have ended.
    pub done: u64,
    pub by_status: [u64; Status::ALL.len()],
    pub by_cause: [u64; Cause::ALL.len()],
    /// Workers that died or were killed while they should have lived.
    pub worker_deaths: u64,
    /// Results and requests that were late, doubled or lies.
    pub dropped: u64,
}

impl Counts {
    pub fn new(total: u64) -> Self {
        let (by_status, by_cause) = ([0; Status::ALL.len()], [0; Cause::ALL.len()]);
        Self { total, done: 0, by_status, by_cause, worker_deaths: 0, dropped: 0 }
    }

    /// A sample has ended.
    pub fn add(&mut self, status: Status, cause: Option<Cause>) {
        self.done += 1;
        self.by_status[usize::from(status.code())] += 1;
        if let Some(cause) = cause {
            self.by_cause[usize::from(cause.code())] += 1;
        }
    }

    /// Samples that have failed or were quarantined.
    pub fn failed(&self) -> u64 {
        let of = |status: Status| self.by_status[usize::from(status.code())];
        of(Status::Failed) + of(Status::Quarantined)
    }
}
