//! Size of batches. `work_stealing` corrects wrong estimates among samples of very different length.

use std::time::Duration;

use bladeoff_protocol::messages::BatchId;

/// Target computing time of a batch: long against the cost of a message, short against a second.
pub const BATCH_TARGET: Duration = Duration::from_millis(75);
/// Weight of the newest batch in the measured cost.
const NEWEST: f64 = 0.3;
/// Largest ratio of the length of a batch to that of the last measured one.
const GROWTH: usize = 4;

/// Measures the cost of samples, sizes the next batch and numbers it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Batches {
    /// Cost of a sample \[s\].
    cost: Option<f64>,
    measured: usize,
    /// Number of batches so far.
    made: u64,
}

impl Batches {
    /// Number of a new batch.
    pub fn number(&mut self) -> BatchId {
        self.made += 1;
        BatchId(self.made)
    }

    /// Takes the time of a batch of `size` samples.
    pub fn measured(&mut self, size: usize, took: Duration) {
        let cost = took.as_secs_f64() / size.max(1) as f64;
        self.cost = Some(self.cost.map_or(cost, |old| old + NEWEST * (cost - old)));
        self.measured = size;
    }

    /// Number of samples that a worker computes in this time, by their cost so far; at least two.
    pub fn within(&self, time: Duration) -> u64 {
        self.cost.map_or(2, |cost| ((time.as_secs_f64() / cost.max(1e-9)) as u64).max(2))
    }

    /// Size of the next batch: at least 1, at most `most`, and at most half of a fair share of the remaining samples.
    pub fn next(&self, most: usize, left: u64, workers: usize) -> usize {
        let Some(cost) = self.cost else { return 1 };
        let wanted = BATCH_TARGET.as_secs_f64() / cost.max(1e-9);
        let fair = left.div_ceil(2 * workers.max(1) as u64);
        let most = most.min(self.measured.saturating_mul(GROWTH)).min(usize::try_from(fair).unwrap_or(usize::MAX));
        (wanted as usize).clamp(1, most.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_samples_are_batched_step_by_step_and_long_ones_are_not() {
        let mut size = Batches::default();
        assert_eq!(size.next(256, 1_000_000, 2), 1);
        let mut seen = Vec::new();
        for _ in 0..5 {
            let n = size.next(256, 1_000_000, 2);
            seen.push(n);
            size.measured(n, Duration::from_micros(10) * n as u32);
        }
        assert_eq!(seen, [1, 4, 16, 64, 256]);
        size.measured(1, Duration::from_secs(30));
        assert_eq!(size.next(256, 1_000_000, 2), 1);
    }

    #[test]
    fn the_rest_is_shared_out_evenly() {
        let mut size = Batches::default();
        size.measured(64, Duration::from_micros(64));
        assert_eq!(size.next(256, 8, 2), 2);
        assert_eq!(size.next(256, 1, 2), 1);
        assert_eq!(size.next(256, 0, 2), 1);
    }
}
