//! Remaining time of a study, with its uncertainty.
//!
//! Samples are assigned in shuffled order (`run::order`), so the finished ones are a random sample of all. The cost of a sample is the time
//! its worker was busy, including the effect of other load on the machine. With `n` finished and `r` remaining samples, mean cost `m` and
//! variance `v` of a sample, and `e` the elapsed time of the finished ones with the present number of workers,
//!
//! ```text
//! rest = r·m ± t·r·√(v/n + v/r)        v/n: variance of the mean, v/r: of the mean of the rest; t: 95 % of Student's distribution
//! from   (rest - ...)·e / (n·m)
//! to     (rest + ...)·e / (n·m) + the longest sample, because all other workers may have to wait for one at the end
//! ```
//! `v` is the largest of the estimates from single samples and from blocks of successive ones, because samples of one batch, or under the same
//! load, have similar costs. It includes one additional sample with a deviation of the whole mean: ten equal samples do not exclude others.
//! Samples in progress count by their time so far: short samples end first, and would make all look short.
//!
//! The estimate cannot include what has not occurred: while every worker computes its first samples, nothing indicates that one of a hundred
//! takes ten times as long, or that the machine will slow down.

use bladeoff_answers::summary::duration;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Number of blocks at which they are joined in pairs.
const MOST_BLOCKS: usize = 64;
/// Smallest number of blocks of a length that is evaluated.
const LONG_BLOCKS: usize = 8;
/// Smallest number of finished samples for an estimate.
const LEAST: u64 = 4;
/// Smallest relative uncertainty, due to the speed of the machine.
const SPEED: f64 = 0.02;
/// Smallest share of a core of a running worker: below this the worker was stopped, which is not a cost of the samples.
const LEAST_SHARE: f64 = 0.1;
/// Ratio of the lower to the upper end below which the lower end is not printed.
const SAYS_NOTHING: f64 = 0.05;
/// Time from the last result to the end of the run \[s\]: last commit, and end of the workers.
const LAST: f64 = 0.3;

/// Costs of the samples finished in this run, as time of their workers \[s\].
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    blocks: Vec<f64>,
    /// Samples per block.
    size: u64,
    /// Block in progress: number of samples, cost \[s\].
    open: (u64, f64),
    ended: u64,
    total: f64,
    squares: f64,
    longest: f64,
    cpu_s: f64,
    /// Time of the last report of each worker.
    reported: BTreeMap<u32, Instant>,
}

impl Default for Costs {
    fn default() -> Self {
        Self {
            blocks: Vec::new(),
            size: 1,
            open: (0, 0.0),
            ended: 0,
            total: 0.0,
            squares: 0.0,
            longest: 0.0,
            cpu_s: 0.0,
            reported: BTreeMap::new(),
        }
    }
}

/// Work in progress.
#[derive(Debug, Clone, PartialEq)]
pub struct Underway {
    /// Number of unfinished samples.
    pub left: u64,
    /// Time since the first samples were assigned.
    pub computing: Duration,
    /// Number of workers.
    pub workers: usize,
    /// Workers with samples, and the time since their last change of state.
    pub busy: Vec<(u32, Duration)>,
    /// Present time.
    pub now: Instant,
}

/// Range of the remaining time. Measured coverage: docs/study-running.md, "Remaining time".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eta {
    /// Lower end.
    pub low: Duration,
    /// Upper end.
    pub high: Duration,
}

impl Eta {
    /// "50 s to 1 min 20 s left"; one time if both print alike; "up to 1 min 20 s left" if the lower end is too small to be useful.
    #[must_use]
    pub fn text(&self) -> String {
        let (low, high) = (duration(self.low), duration(self.high));
        match () {
            () if low == high => format!("{low} left"),
            () if self.low < self.high.mul_f64(SAYS_NOTHING) => format!("up to {high} left"),
            () => format!("{low} to {high} left"),
        }
    }
}

impl Costs {
    /// Adds samples that a worker has reported, with their CPU times \[s\].
    pub fn add(&mut self, worker: u32, cpu_s: &[f64], now: Instant) {
        let cpu: f64 = cpu_s.iter().sum();
        let took = match self.reported.insert(worker, now) {
            Some(last) => {
                now.saturating_duration_since(last).as_secs_f64().clamp(cpu, (cpu / LEAST_SHARE).max(cpu + 1.0))
            }
            // first report of the worker: scaled by the ratio of the others
            None if self.cpu_s > 0.0 => cpu * self.total / self.cpu_s,
            None => cpu,
        };
        self.cpu_s += cpu;
        for one in cpu_s {
            self.count(if cpu > 0.0 { took * one / cpu } else { took / cpu_s.len() as f64 });
        }
    }

    fn count(&mut self, cost: f64) {
        self.ended += 1;
        self.total += cost;
        self.squares += cost * cost;
        self.longest = self.longest.max(cost);
        self.open = (self.open.0 + 1, self.open.1 + cost);
        if self.open.0 == self.size {
            self.blocks.push(self.open.1);
            self.open = (0, 0.0);
        }
        if self.blocks.len() == MOST_BLOCKS {
            self.blocks = in_pairs(&self.blocks);
            self.size *= 2;
        }
    }

    /// Remaining time; `None` before four samples are finished.
    #[must_use]
    pub fn eta(&self, underway: &Underway) -> Option<Eta> {
        if self.ended < LEAST || underway.left == 0 || self.total <= 0.0 || underway.computing.is_zero() {
            return None;
        }
        let (ended, left) = (self.ended as f64, underway.left as f64);
        let mean = self.total / ended;
        let ages: Vec<f64> =
            underway.busy.iter().map(|&(worker, since)| self.age(worker, since, underway.now)).collect();
        // With large scatter, a sample in progress is half done on average; without scatter, it takes the mean cost.
        let scatter = (self.variance() / (mean * mean)).min(1.0);
        let whole: Vec<f64> =
            ages.iter().map(|age| (1.0 - scatter) * age.max(mean) + scatter * (2.0 * age).max(mean)).collect();
        let seen = ended + whole.len() as f64;
        let sum = self.total + whole.iter().sum::<f64>();
        let squares = self.squares + whole.iter().map(|cost| cost * cost).sum::<f64>();
        let mean = sum / seen;
        let variance = self.variance().max(((squares - sum * mean).max(0.0) + mean * mean) / seen);
        let age: f64 = ages.iter().sum();
        let rest = (left - ages.len() as f64).max(0.0) * mean + whole.iter().sum::<f64>() - age;
        let student = student(self.blocks.len() as f64);
        let spread = (student * left * (variance / ended + variance / left).sqrt()).max(SPEED * rest);
        let speed = (self.total + age) / underway.computing.as_secs_f64();
        let longest = whole.iter().copied().fold(self.longest, f64::max);
        let waiting = longest * (1.0 - 1.0 / underway.workers.max(1) as f64);
        let time = |seconds: f64| Duration::from_secs_f64(seconds.clamp(0.0, 1e12));
        Some(Eta { low: time((rest - spread) / speed), high: time((rest + spread) / speed + waiting + LAST) })
    }

    /// Time for which a worker has been computing samples that are not reported \[s\].
    fn age(&self, worker: u32, since: Duration, now: Instant) -> f64 {
        let reported = self.reported.get(&worker).map(|&last| now.saturating_duration_since(last));
        reported.map_or(since, |reported| reported.min(since)).as_secs_f64()
    }

    /// Variance per sample, as it affects the sum of many samples.
    fn variance(&self) -> f64 {
        let (mut blocks, mut size) = (self.blocks.clone(), self.size as f64);
        let mut largest = 0.0_f64;
        loop {
            let count = blocks.len().max(1) as f64;
            let mean = blocks.iter().sum::<f64>() / count;
            let squares = blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / size;
            largest = largest.max((squares + (mean / size).powi(2)) / count);
            if blocks.len() < 2 * LONG_BLOCKS {
                return largest;
            }
            blocks = in_pairs(&blocks);
            size *= 2.0;
        }
    }
}

fn in_pairs(blocks: &[f64]) -> Vec<f64> {
    blocks.chunks_exact(2).map(|pair| pair[0] + pair[1]).collect()
}

/// Two-sided 95 % quantile of Student's t (expansion in 1/n, n degrees of freedom; better than 2 % from n = 4).
fn student(freedoms: f64) -> f64 {
    let freedoms = freedoms.max(1.0);
    1.96 + 2.37 / freedoms + 2.82 / (freedoms * freedoms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_study::sampling::Shuffle;
    use bladeoff_system::random::SplitMix;

    /// A simulated run with these costs in this order: worker, start and end \[s\] of each sample.
    struct Run {
        spans: Vec<(u32, f64, f64)>,
        end: f64,
        workers: u32,
    }

    impl Run {
        fn of(costs: impl IntoIterator<Item = f64>, workers: u32) -> Self {
            let mut free = vec![0.0_f64; workers as usize];
            let mut spans: Vec<(u32, f64, f64)> = Vec::new();
            for cost in costs {
                let next = (0..free.len()).min_by(|&a, &b| free[a].total_cmp(&free[b])).expect("workers");
                spans.push((next as u32, free[next], free[next] + cost));
                free[next] += cost;
            }
            spans.sort_by(|a, b| a.2.total_cmp(&b.2));
            Self { spans, end: free.into_iter().fold(0.0, f64::max), workers }
        }

        /// The estimate at a time, and the true remaining time \[s\].
        fn look(&self, at: f64) -> (Option<Eta>, f64) {
            let start = Instant::now();
            let moment = |time| start + Duration::from_secs_f64(time);
            let mut costs = Costs::default();
            let ended = self.spans.iter().filter(|span| span.2 <= at);
            ended.clone().for_each(|&(worker, from, to)| costs.add(worker, &[to - from], moment(to)));
            let busy = self.spans.iter().filter(|span| span.1 <= at && at < span.2);
            let underway = Underway {
                left: (self.spans.len() - ended.count()) as u64,
                computing: Duration::from_secs_f64(at),
                workers: self.workers as usize,
                busy: busy.map(|&(worker, from, _)| (worker, Duration::from_secs_f64(at - from))).collect(),
                now: moment(at),
            };
            (costs.eta(&underway), self.end - at)
        }

        /// From a tenth of the run on: number of estimates that contain the truth, number of estimates, and mean width relative to the truth.
        fn coverage(&self) -> (u32, u32, f64) {
            let (mut hits, mut looks, mut width) = (0, 0, 0.0);
            for step in 4..40 {
                if let (Some(eta), left) = self.look(self.end * f64::from(step) / 40.0) {
                    looks += 1;
                    hits += u32::from((eta.low.as_secs_f64()..=eta.high.as_secs_f64()).contains(&left));
                    width += (eta.high - eta.low).as_secs_f64() / left;
                }
            }
            (hits, looks, width / f64::from(looks))
        }
    }

    /// Costs of twenty gaps by twelve masses: the narrowest gap costs twenty times as much as the widest.
    fn drifting(sample: u64) -> f64 {
        let gap = (sample / 12) as f64 / 19.0;
        (4.0 - 3.8 * gap.sqrt()) * (1.0 + 0.02 * (sample % 12) as f64)
    }

    #[test]
    fn where_costs_drift_the_shuffled_order_tells_the_truth_and_the_row_order_does_not() {
        for workers in [1, 2, 8] {
            let (mut hits, mut looks, mut width) = (0, 0, 0.0);
            let seeds = 150;
            for seed in 0..seeds {
                let shuffle = Shuffle::new(seed, 240);
                let run = Run::of((0..240).map(|place| drifting(shuffle.apply(place))), workers);
                let (hit, look, wide) = run.coverage();
                (hits, looks, width) = (hits + hit, looks + look, width + wide / seeds as f64);
            }
            let share = f64::from(hits) / f64::from(looks);
            assert!((0.93..0.995).contains(&share), "{workers} workers: {share}");
            assert!(width < if workers < 8 { 1.0 } else { 1.8 }, "{workers} workers: width {width}");
        }
        let (hits, looks, _) = Run::of((0..240).map(drifting), 2).coverage();
        assert!(3 * hits < looks, "what the shuffle is for: {hits} of {looks}");
    }

    #[test]
    fn rare_long_samples_are_in_the_range() {
        // a third of the samples has contact and costs five times as much
        let (mut hits, mut looks) = (0, 0);
        for seed in 0..200 {
            let mut random = SplitMix(seed);
            let run = Run::of((0..150).map(|_| if random.unit() < 0.33 { 5.0 } else { 1.0 }), 2);
            let (hit, look, _) = run.coverage();
            (hits, looks) = (hits + hit, looks + look);
        }
        let share = f64::from(hits) / f64::from(looks);
        assert!((0.93..0.995).contains(&share), "{share}");
    }

    #[test]
    fn equal_samples_give_a_narrow_range_that_holds_the_truth() {
        for workers in [1, 2, 16] {
            let run = Run::of([0.7; 400], workers);
            let (hits, looks, width) = run.coverage();
            assert_eq!(hits, looks, "{workers} workers");
            assert!(width < 0.5, "{workers} workers: {width}");
            let (eta, left) = run.look(run.end / 2.0);
            let eta = eta.expect("known");
            let width = (eta.high - eta.low).as_secs_f64();
            assert!(width < 0.12 * left + 2.0, "{workers} workers: {eta:?}");
        }
    }

    #[test]
    fn few_samples_say_nothing_and_more_say_more() {
        let run = Run::of([1.0, 2.0, 1.0, 3.0, 1.0, 2.0, 1.0], 1);
        assert_eq!(run.look(4.5).0, None, "three have ended");
        assert!(run.look(7.5).0.is_some());
        assert_eq!(run.look(run.end).0, None, "all have ended");
        let mut random = SplitMix(7);
        let run = Run::of((0..4000).map(|_| if random.unit() < 0.33 { 5.0 } else { 1.0 }), 2);
        let relative = |part: f64| {
            let (eta, left) = run.look(run.end * part);
            let eta = eta.expect("known");
            (eta.high - eta.low).as_secs_f64() / left
        };
        assert!(relative(0.5) < 0.5 * relative(0.05), "{} {}", relative(0.5), relative(0.05));
    }

    #[test]
    fn neighbours_that_cost_alike_make_it_less_certain() {
        let mixed = Run::of((0..1024).map(|i| if i % 2 == 0 { 1.0 } else { 5.0 }), 1);
        let blocks = Run::of((0..1024).map(|i| if i / 32 % 2 == 0 { 1.0 } else { 5.0 }), 1);
        let width = |run: &Run| {
            let eta = run.look(run.end / 2.0).0.expect("known");
            (eta.high - eta.low).as_secs_f64()
        };
        assert!(width(&blocks) > 2.0 * width(&mixed), "{} {}", width(&blocks), width(&mixed));
    }

    #[test]
    fn hours_in_which_the_run_was_stopped_are_no_cost() {
        let start = Instant::now();
        let mut costs = Costs::default();
        for second in 1..=100u64 {
            let stopped = if second > 50 { 4 * 3600 } else { 0 };
            costs.add(1, &[0.9], start + Duration::from_secs(second + stopped));
        }
        // time attended by the scheduler
        let underway = Underway {
            left: 100,
            computing: Duration::from_secs(102),
            workers: 1,
            busy: vec![(1, Duration::from_millis(500))],
            now: start + Duration::from_secs(100 + 4 * 3600),
        };
        let eta = costs.eta(&underway).expect("known");
        assert!(eta.low < Duration::from_secs(100) && eta.high > Duration::from_secs(100), "{eta:?}");
        assert!(eta.low > Duration::from_secs(60) && eta.high < Duration::from_secs(150), "{eta:?}");
    }
}
