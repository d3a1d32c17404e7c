//! What a run may take: time, failures, and of each sample time, memory and deaths.

use crate::dispatch::{DispatchOptions, TimeOfDay, Until, next_time_of_day};
use bladeoff_study::Limits;
use std::time::Duration;

/// The limits of one run. A limit that is not given on the command line is the study's, or none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Budget {
    /// Time of the run.
    pub wall: Option<Duration>,
    /// Local time of the day at which it ends.
    pub until: Option<TimeOfDay>,
    /// More failed or quarantined samples of the study than this end the run, those of earlier runs included.
    pub max_failures: Option<u64>,
    /// Crashes of its worker, alone, that quarantine a sample.
    pub crash_limit: Option<u32>,
    /// Kills of its worker from outside, alone, that quarantine a sample.
    pub kill_limit: Option<u32>,
    /// Longest time of one sample.
    pub time_limit: Option<Duration>,
    /// Memory of one worker \[bytes\].
    pub memory_limit: Option<u64>,
}

impl Budget {
    /// With the study's limits where there are none.
    #[must_use]
    pub fn or(mut self, limits: &Limits) -> Self {
        self.crash_limit = self.crash_limit.or(limits.crash_limit);
        self.kill_limit = self.kill_limit.or(limits.kill_limit);
        self.time_limit = self.time_limit.or(limits.time_limit);
        self.memory_limit = self.memory_limit.or(limits.memory_limit);
        self
    }

    /// The end by the clock, if there is one, and how long that is from now.
    #[must_use]
    pub fn ends(&self) -> Option<(Until, Duration)> {
        let (until, left) = next_time_of_day(self.until?);
        Some((until, Duration::from_millis(u64::try_from(left).unwrap_or(0))))
    }

    /// Whether the study has too many failures before the run has begun.
    pub(super) fn is_exceeded(&self, failed: u64) -> bool {
        self.max_failures.is_some_and(|most| failed > most)
    }

    /// Puts the limits into the options of the dispatch; `failed`: samples of the study that failed before.
    pub(super) fn apply(&self, failed: u64, options: &mut DispatchOptions) {
        options.wall = self.wall;
        options.until = self.ends().map(|(until, _)| until);
        options.max_failures = self.max_failures.map(|most| most.saturating_sub(failed));
        options.crash_limit = self.crash_limit.unwrap_or(options.crash_limit);
        options.kill_limit = self.kill_limit.unwrap_or(options.kill_limit);
        options.time_limit_s = self.time_limit.map(|limit| limit.as_secs_f64());
        options.memory_limit = self.memory_limit;
    }
}
