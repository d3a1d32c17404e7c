//! Rate of samples for the display.

use std::collections::VecDeque;
use std::time::Duration;

/// Samples per second over the last seconds.
#[derive(Debug, Clone, Default)]
pub(super) struct Rate {
    /// Times and counts, about one a second.
    points: VecDeque<(Duration, u64)>,
    /// Attended time of the first assignment.
    begun: Option<Duration>,
}

/// Number of points of the rate.
const RATE_POINTS: usize = 15;

impl Rate {
    /// Takes an assignment; the first one counts.
    pub fn begin(&mut self, now: Duration) {
        self.begun.get_or_insert(now);
    }

    /// Attended time since the first assignment.
    pub fn computing(&self, now: Duration) -> Duration {
        self.begun.map_or(Duration::ZERO, |begun| now.saturating_sub(begun))
    }

    /// Takes the number of done samples at a time.
    pub fn note(&mut self, now: Duration, done: u64) {
        let is_due = self.points.back().is_none_or(|(last, _)| now.saturating_sub(*last) >= Duration::from_secs(1));
        if is_due {
            self.points.push_back((now, done));
            if self.points.len() > RATE_POINTS {
                self.points.pop_front();
            }
        }
    }

    /// Rate over the last seconds, with the present number of done samples.
    pub fn per_second(&self, now: Duration, done: u64) -> f64 {
        let Some(&(since, before)) = self.points.front() else { return 0.0 };
        let span = now.saturating_sub(since).as_secs_f64();
        if span > 0.0 { done.saturating_sub(before) as f64 / span } else { 0.0 }
    }
}
