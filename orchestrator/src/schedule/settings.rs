//! Settings of the scheduler: limits of the run, limits of a sample, allowed silence.

use std::time::Duration;

use bladeoff_protocol::messages::MAX_BATCH;
use bladeoff_study::SampleLimits;

use super::until::Until;

/// Limits of a run, the same in command line, dispatch loop and scheduler.
#[derive(Debug, Clone, Copy, Default)]
pub struct RunLimits {
    /// Time by the monotonic clock after which no sample is assigned; samples in progress finish within the grace time.
    pub wall: Option<Duration>,
    /// Time by the wall clock after which no sample is assigned.
    pub until: Option<Until>,
    /// Number of failed and quarantined samples that the study may have, those of earlier runs included.
    pub max_failures: Option<u64>,
}

impl RunLimits {
    /// Remaining limits after some time.
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

/// Settings of the scheduler.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Slots for workers, at least 1.
    pub workers: usize,
    /// Longest batch, at least 1 and at most what a message holds; 1 sends samples one by one.
    pub max_batch: usize,
    /// Limits of a sample.
    pub sample: SampleLimits,
    /// Limits of the run.
    pub run: RunLimits,
    /// Failed samples of earlier runs of the study.
    pub failed_before: u64,
    /// Whether samples are added during the run.
    pub is_fed: bool,
    /// Silence of a worker after which it is shown as stale.
    pub stale_after: Duration,
    /// Silence of a worker after which it is replaced.
    pub replace_after: Duration,
    /// Time after the order to stop in which samples in progress may finish.
    pub grace: Duration,
}

impl Settings {
    /// Default settings without limits of the run: usual limits of a sample, stale after 5 s, replaced after 30 s, grace 2 s.
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
