//! Time of the next flush of recorded results, and fault hooks at it.

use std::time::{Duration, Instant};

use bladeoff_worker::fault::{At, Faults};

/// Results recorded since the last flush.
pub(super) struct Flushing {
    last: Instant,
    count: u64,
    /// Samples and their workers' processes, kept for fault hooks only.
    samples: Vec<(u64, Option<u32>)>,
}

impl Flushing {
    pub fn new() -> Self {
        Self { last: Instant::now(), count: 0, samples: Vec::new() }
    }

    /// Takes recorded samples; `samples`: sample numbers for fault hooks.
    pub fn recorded(&mut self, count: usize, samples: impl IntoIterator<Item = (u64, Option<u32>)>) {
        self.count += count as u64;
        self.samples.extend(samples);
    }

    /// Whether there is something to flush, and `every` has passed.
    pub fn is_due(&self, every: Duration) -> bool {
        self.count > 0 && self.last.elapsed() >= every
    }

    /// Takes a completed flush.
    pub fn flushed(&mut self, faults: &dyn Faults) {
        (self.last, self.count) = (Instant::now(), 0);
        for (sample, pid) in std::mem::take(&mut self.samples) {
            faults.reached(At::Recorded, sample, pid);
        }
    }
}
