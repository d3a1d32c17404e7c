//! Samples per second, for whoever watches.

use std::collections::VecDeque;
use std::time::Duration;

/// Samples per second over the last seconds.
#[derive(Debug, Clone, Default)]
pub(super) struct Rate {
    /// Times and counts, about one a second.
    points: VecDeque<(Duration, u64)>,
    /// When samples were assigned first, in attended time.
    begun: Option<Duration>,
}

/// Span of the rate, in points.
const RATE_POINTS: usize = 15;

impl Rate {
    /// Samples are assigned; the first time counts.
    pub fn begin(&mut self, now: Duration) {
        self.begun.get_or_insert(now);
    }

    /// Time since samples were assigned first.
    pub fn computing(&self, now: Duration) -> Duration {
        self.begun.map_or(Duration::ZERO, |begun| now.saturating_sub(begun))
    }

    /// So many samples are done at that time.
    pub fn note(&mut self, now: Duration, done: u64) {
        let is_due = self.points.back().is_none_or(|(last, _)| now.saturating_sub(*last) >= Duration::from_secs(1));
        if is_due {
            self.points.push_back((now, done));
            if self.points.len() > RATE_POINTS {
                self.points.pop_front();
            }
        }
    }

    /// Of the last seconds, where so many are done now.
    pub fn per_second(&self, now: Duration, done: u64) -> f64 {
        let Some(&(since, before)) = self.points.front() else { return 0.0 };
        let span = now.saturating_sub(since).as_secs_f64();
        if span > 0.0 { done.saturating_sub(before) as f64 / span } else { 0.0 }
    }
}
