//! How long the rest of a study will take, with its uncertainty.
//!
//! Samples cost differently, above all by whether they rub, and neighbours in a grid cost alike. So the spread is taken from
//! the means of blocks of successive samples, as for any correlated series: with `n` blocks of `b` samples, whose means
//! have the mean `m` and the variance `v`, the cost of `r` samples to come is
//!
//! ```text
//! r·m ± 2·r·√(v/n + v·b/r)        the mean is known to v/n, the rest varies by itself
//! ```
//! divided by the speed so far, CPU seconds per second. What has not been seen is not in it: when the first half of a
//! grid never rubs, nothing says what the second costs.

use super::text::duration;
use std::time::Duration;

/// Blocks are joined in pairs when there are so many.
const MOST_BLOCKS: usize = 64;
/// Fewer say nothing about a spread.
const LEAST_BLOCKS: usize = 4;

/// CPU times of the samples seen so far \[s\].
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    blocks: Vec<f64>,
    /// Samples per block.
    size: u64,
    /// The block under way.
    open: (u64, f64),
    seen: u64,
    total: f64,
}

impl Default for Costs {
    fn default() -> Self {
        Self { blocks: Vec::new(), size: 1, open: (0, 0.0), seen: 0, total: 0.0 }
    }
}

/// Time left, from and to: about nineteen times of twenty it lies between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eta {
    /// Shortest.
    pub low: Duration,
    /// Longest.
    pub high: Duration,
}

impl Eta {
    /// "50 s to 1 min 20 s left", or one time where there is no doubt.
    #[must_use]
    pub fn text(&self) -> String {
        let (low, high) = (duration(self.low), duration(self.high));
        if low == high { format!("{low} left") } else { format!("{low} to {high} left") }
    }
}

impl Costs {
    /// A sample has cost so much.
    pub fn add(&mut self, cpu_s: f64) {
        self.seen += 1;
        self.total += cpu_s;
        self.open = (self.open.0 + 1, self.open.1 + cpu_s);
        if self.open.0 == self.size {
            self.blocks.push(self.open.1);
            self.open = (0, 0.0);
        }
        if self.blocks.len() == MOST_BLOCKS {
            self.blocks = self.blocks.chunks_exact(2).map(|pair| pair[0] + pair[1]).collect();
            self.size *= 2;
        }
    }

    /// Time for `left` more samples, when those seen took `elapsed`; `None` before four are known.
    #[must_use]
    pub fn eta(&self, left: u64, elapsed: Duration) -> Option<Eta> {
        let n = self.blocks.len() as f64;
        if self.blocks.len() < LEAST_BLOCKS || left == 0 {
            return None;
        }
        let (size, rest) = (self.size as f64, left as f64);
        let mean = self.blocks.iter().sum::<f64>() / (n * size);
        let variance = self.blocks.iter().map(|block| (block / size - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let relative = if mean > 0.0 { 2.0 * (variance / n + variance * size / rest).sqrt() / mean } else { 0.0 };
        let expected = elapsed.as_secs_f64() * rest / self.seen as f64;
        let time = |seconds: f64| Duration::from_secs_f64(seconds.clamp(0.0, 1e12));
        Some(Eta { low: time(expected * (1.0 - relative)), high: time(expected * (1.0 + relative)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(values: impl IntoIterator<Item = f64>) -> Costs {
        let mut costs = Costs::default();
        values.into_iter().for_each(|value| costs.add(value));
        costs
    }

    /// splitmix64 as a number from 0 to 1.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn width(eta: Eta) -> f64 {
        (eta.high - eta.low).as_secs_f64()
    }

    #[test]
    fn equal_samples_leave_no_doubt_and_few_say_nothing() {
        assert_eq!(costs([1.0; 3]).eta(10, Duration::from_secs(3)), None);
        let eta = costs([2.0; 100]).eta(50, Duration::from_secs(100)).expect("known");
        assert_eq!((eta.low, eta.high), (Duration::from_secs(50), Duration::from_secs(50)));
        assert_eq!(costs([2.0; 100]).eta(0, Duration::from_secs(100)), None);
    }

    #[test]
    fn the_truth_lies_in_the_range_about_nineteen_times_of_twenty() {
        // A third of the samples rubs and costs five times as much; two workers.
        let (seen, left) = (150, 400);
        let mut hits = 0;
        for seed in 0..1000 {
            let mut state = seed;
            let mut next = || if random(&mut state) < 0.33 { 5.0 } else { 1.0 };
            let before: Vec<f64> = (0..seen).map(|_| next()).collect();
            let after: f64 = (0..left).map(|_| next()).sum::<f64>() / 2.0;
            let elapsed = Duration::from_secs_f64(before.iter().sum::<f64>() / 2.0);
            let eta = costs(before).eta(left, elapsed).expect("known");
            hits += u32::from((eta.low.as_secs_f64()..=eta.high.as_secs_f64()).contains(&after));
        }
        assert!((920..=985).contains(&hits), "{hits} of 1000");
    }

    #[test]
    fn neighbours_that_cost_alike_make_it_less_certain_and_more_samples_more() {
        let mixed = costs((0..512).map(|i| if i % 2 == 0 { 1.0 } else { 5.0 }));
        let sorted = costs((0..512).map(|i| if i / 64 % 2 == 0 { 1.0 } else { 5.0 }));
        let elapsed = Duration::from_secs(1536);
        let of = |costs: &Costs| width(costs.eta(512, elapsed).expect("known"));
        assert!(of(&sorted) > 3.0 * of(&mixed), "{} {}", of(&sorted), of(&mixed));
        let mut state = 7;
        let mut rubs = || if random(&mut state) < 0.33 { 5.0 } else { 1.0 };
        let early = costs((0..50).map(|_| rubs()));
        let late = costs((0..5000).map(|_| rubs()));
        let relative = |costs: &Costs, seconds| {
            let eta = costs.eta(10_000, Duration::from_secs(seconds)).expect("known");
            width(eta) / eta.high.as_secs_f64()
        };
        assert!(relative(&late, 5000) < 0.5 * relative(&early, 50));
    }
}
