//! What the scheduler goes by: what the run may take, what each sample may take, how long silence is borne.

use std::time::Duration;

use bladeoff_protocol::messages::MAX_BATCH;
use bladeoff_study::SampleLimits;

use super::until::Until;

/// What a run may take: the same from the command line to the loop and the scheduler.
#[derive(Debug, Clone, Copy, Default)]
pub struct RunLimits {
    /// No sample is assigned after this time by the monotonic clock; what is in work finishes within the grace.
    pub wall: Option<Duration>,
    /// No sample is assigned once the clock on the wall says so.
    pub until: Option<Until>,
    /// More failed or quarantined samples of the study than this stop the run, those of earlier runs included.
    pub max_failures: Option<u64>,
}

impl RunLimits {
    /// Limits that are left after so much time.
    #[must_use]
    pub fn after(self, passed: Duration) -> Self {
        Self { wall: self.wall.map(|wall| wall.saturating_sub(passed)), ..self }
    }

    /// Whether so many failed samples of the study are too many.
    #[must_use]
    pub fn are_too_many(&self, failed: u64) -> bool {
        self.max_failures.is_some_and(|most| failed > most)
    }
}

/// What the scheduler goes by.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Slots for workers, at least 1.
    pub workers: usize,
    /// Longest batch, at least 1 and at most what a message holds; 1 sends samples one by one.
    pub max_batch: usize,
    /// What one sample may take.
    pub sample: SampleLimits,
    /// What the run may take.
    pub run: RunLimits,
    /// Samples of the study that have failed before this run.
    pub failed_before: u64,
    /// More samples come while the run goes on.
    pub is_fed: bool,
    /// Silence of a worker after which it is shown as stale.
    pub stale_after: Duration,
    /// Silence of a worker after which it is replaced.
    pub replace_after: Duration,
    /// After the order to stop: how long samples in work may finish before their workers are killed.
    pub grace: Duration,
}

impl Settings {
    /// Without limits of the run, and otherwise as documented: a sample's usual limits, stale after 5 s, replaced after 30 s, grace 2 s.
    #[must_use]
    pub fn new(workers: usize) -> Self {
        Self {
            workers,
            max_batch: MAX_BATCH,
            sample: SampleLimits::default(),
            run: RunLimits::default(),
            failed_before: 0,
            is_fed: false,
            stale_after: Duration::from_secs(5),
            replace_after: Duration::from_secs(30),
            grace: Duration::from_secs(2),
        }
    }
}
