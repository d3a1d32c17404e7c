//! Attended time: the time in which the dispatch loop ran; longer gaps count as a short one.

use std::time::Duration;

/// Longest time between two events that counts in full. The dispatch loop ticks many times in it.
pub const LONGEST_STEP: Duration = Duration::from_secs(2);

/// Turns the time of events into attended time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Clock {
    last: Duration,
    attended: Duration,
}

impl Clock {
    /// An event at `now`; a `now` before the last one counts as the last one.
    pub fn advance(&mut self, now: Duration) -> Duration {
        self.attended += now.saturating_sub(self.last).min(LONGEST_STEP);
        self.last = self.last.max(now);
        self.attended
    }

    /// Attended time of the last event.
    pub fn now(&self) -> Duration {
        self.attended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_absence_counts_as_one_step_and_time_never_runs_back() {
        let mut clock = Clock::default();
        let second = Duration::from_secs;
        assert_eq!(clock.advance(second(1)), second(1));
        assert_eq!(clock.advance(second(3601)), second(1) + LONGEST_STEP);
        assert_eq!(clock.advance(second(5)), second(1) + LONGEST_STEP);
        assert_eq!(clock.advance(second(3602)), second(2) + LONGEST_STEP);
        assert_eq!(clock.now(), second(2) + LONGEST_STEP);
    }
}
