//! Exact order statistics of any number of values in limited memory. If the values do not fit, they are read again.
//!
//! ```text
//! first pass     counts the values; keeps all of them while they are few, then a random part
//! ask(ranks)     sets a bracket around each rank, from the kept part
//! next pass      counts values below a bracket, keeps values within it
//! ask(ranks)     finds the value in its bracket; a bracket that missed its rank is widened for another pass
//! ```
//! The result is always the value of that rank in the sorted list. The random part only determines the number of passes. Source of the
//! brackets: R. W. Floyd, R. L. Rivest, "Expected time bounds for selection" (1975).

use bladeoff_system::random::SplitMix;

/// Values kept by one accumulator, if there are few.
pub const KEPT: usize = 1 << 16;
/// Values kept by all accumulators together, and the least for each.
const TOGETHER: usize = 1 << 21;
const FEWEST: usize = 1 << 12;
/// Half width of a bracket in standard deviations of the rank in the kept part; factor by which each further one is wider.
const WIDTH: f64 = 4.0;
const WIDER: f64 = 4.0;

/// Values that each of `of` accumulators may keep.
#[must_use]
pub fn kept_by_each(of: usize) -> usize {
    (TOGETHER / of.max(1)).clamp(FEWEST, KEPT)
}

/// An unsigned integer with the order of `f64::total_cmp`.
fn key(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | (1 << 63) }
}

fn value(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}

/// Bracket around a rank: values below `low` and values equal to its ends are counted, values between them are kept.
#[derive(Debug, Clone)]
struct Bracket {
    rank: u64,
    width: f64,
    low: u64,
    high: u64,
    below: u64,
    at_low: u64,
    at_high: u64,
    within: Vec<u64>,
}

impl Bracket {
    /// Bracket around a rank of `n`, from sorted values that were kept with equal probability.
    fn around(rank: u64, n: u64, kept: &[u64], width: f64) -> Self {
        let count = kept.len() as f64;
        let share = (rank as f64 - 0.5) / n as f64;
        let half = width * (libm::sqrt(count * share * (1.0 - share)) + 1.0);
        let (first, last) = (libm::floor(count * share - half), libm::ceil(count * share + half));
        let low = if first < 0.0 { 0 } else { kept.get(first as usize).copied().unwrap_or(0) };
        let high = if last < 0.0 { u64::MAX } else { kept.get(last as usize).copied().unwrap_or(u64::MAX) };
        Self { rank, width, low, high, below: 0, at_low: 0, at_high: 0, within: Vec::new() }
    }

    fn see(&mut self, key: u64) {
        if key < self.low {
            self.below += 1;
        } else if key == self.low {
            self.at_low += 1;
        } else if key < self.high {
            self.within.push(key);
        } else if key == self.high {
            self.at_high += 1;
        }
    }

    /// Value of the rank, if it lies in this bracket.
    fn found(&mut self) -> Option<u64> {
        let rank = self.rank.checked_sub(self.below).filter(|rank| *rank > 0)?;
        if rank <= self.at_low {
            return Some(self.low);
        }
        let rank = rank - self.at_low;
        if rank <= self.within.len() as u64 {
            let (_, found, _) = self.within.select_nth_unstable(rank as usize - 1);
            return Some(*found);
        }
        (rank - self.within.len() as u64 <= self.at_high).then_some(self.high)
    }
}

/// Accumulator over several passes of the same values in the same order.
#[derive(Debug, Clone)]
pub struct Order {
    limit: usize,
    n: u64,
    /// All values, or a random part of them.
    kept: Vec<u64>,
    /// Number of times that the part was halved.
    halved: u32,
    random: SplitMix,
    is_first_pass: bool,
    brackets: Vec<Bracket>,
    found: Vec<(u64, u64)>,
}

impl Order {
    /// An accumulator that keeps up to `limit` values.
    #[must_use]
    pub fn keeping(limit: usize) -> Self {
        Self {
            limit,
            n: 0,
            kept: Vec::new(),
            halved: 0,
            random: SplitMix(1),
            is_first_pass: true,
            brackets: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Adds a value; later passes have to repeat the values of the first.
    pub fn see(&mut self, value: f64) {
        let key = key(value);
        if !self.is_first_pass {
            self.brackets.iter_mut().for_each(|bracket| bracket.see(key));
            return;
        }
        self.n += 1;
        if self.halved > 0 && self.random.word() >> (64 - self.halved) != 0 {
            return;
        }
        self.kept.push(key);
        if self.kept.len() > self.limit {
            let random = &mut self.random;
            self.kept.retain(|_| random.word() >> 63 == 0);
            self.halved += 1;
        }
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.n
    }

    /// Requests the values of these ranks, from 1 for the smallest, after each pass. Returns whether another pass is needed.
    pub fn ask(&mut self, ranks: impl IntoIterator<Item = u64>) -> bool {
        if self.is_first_pass {
            self.is_first_pass = false;
            self.kept.sort_unstable();
        }
        let missed: Vec<Bracket> = std::mem::take(&mut self.brackets)
            .into_iter()
            .filter_map(|mut bracket| match bracket.found() {
                Some(found) => {
                    self.found.push((bracket.rank, found));
                    None
                }
                None => Some(Bracket::around(bracket.rank, self.n, &self.kept, WIDER * bracket.width)),
            })
            .collect();
        self.brackets = missed;
        for rank in ranks.into_iter().filter(|rank| (1..=self.n).contains(rank)) {
            let is_asked = self.brackets.iter().any(|bracket| bracket.rank == rank);
            if self.halved > 0 && self.at(rank).is_none() && !is_asked {
                self.brackets.push(Bracket::around(rank, self.n, &self.kept, WIDTH));
            }
        }
        !self.brackets.is_empty()
    }

    /// Value of a requested rank; `None` if the rank does not exist or another pass is needed.
    #[must_use]
    pub fn at(&self, rank: u64) -> Option<f64> {
        if self.halved == 0 {
            return self.kept.get(usize::try_from(rank.checked_sub(1)?).ok()?).copied().map(value);
        }
        self.found.iter().find(|(known, _)| *known == rank).map(|(_, found)| value(*found))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of some ranks, and the number of passes.
    fn of(values: &[f64], limit: usize, ranks: &[u64]) -> (Vec<f64>, usize) {
        let mut order = Order::keeping(limit);
        let mut passes = 0;
        loop {
            values.iter().for_each(|value| order.see(*value));
            passes += 1;
            if !order.ask(ranks.iter().copied()) {
                break;
            }
        }
        assert!(values.len() <= limit || order.kept.len() <= limit);
        (ranks.iter().map(|rank| order.at(*rank).expect("asked for")).collect(), passes)
    }

    #[test]
    fn a_rank_is_that_of_the_sorted_values_however_few_are_kept() {
        let mut random = SplitMix(7);
        let scattered: Vec<f64> = (0..50_000).map(|_| random.unit() - 0.5).collect();
        let ascending: Vec<f64> = (0..50_000).map(f64::from).collect();
        let mut stepped: Vec<f64> = scattered.iter().map(|value| (8.0 * value).round()).collect();
        stepped.extend([f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0]);
        let alike = vec![3.0; 50_000];
        for values in [scattered, ascending, stepped, alike] {
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            let n = values.len() as u64;
            let ranks = [1, 2, n / 100, n / 2, n / 2 + 1, n - 30, n];
            let expected: Vec<u64> = ranks.iter().map(|rank| sorted[*rank as usize - 1].to_bits()).collect();
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let (all, once) = of(&values, 100_000, &ranks);
            assert_eq!((bits(&all), once), (expected.clone(), 1), "all are kept");
            for limit in [16, 1000] {
                let (found, passes) = of(&values, limit, &ranks);
                assert_eq!(bits(&found), expected, "{limit}");
                assert!(passes > 1, "{passes}");
            }
        }
    }

    #[test]
    fn a_bracket_that_missed_is_made_wider() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let mut order = Order::keeping(16);
        values.iter().for_each(|value| order.see(*value));
        assert!(order.ask([500]));
        // as if the kept part came from other values
        (order.brackets[0].low, order.brackets[0].high) = (key(2000.0), key(2001.0));
        values.iter().for_each(|value| order.see(*value));
        assert!(order.ask([500]), "it is below");
        for _ in 0..10 {
            values.iter().for_each(|value| order.see(*value));
            if !order.ask([500]) {
                break;
            }
        }
        assert_eq!(order.at(500), Some(499.0));
    }

    #[test]
    fn what_was_not_asked_for_or_is_not_there_is_nothing() {
        let mut order = Order::keeping(KEPT);
        assert!(!order.ask([1]) && order.at(1).is_none() && order.at(0).is_none());
        order = Order::keeping(KEPT);
        order.see(2.0);
        assert!(!order.ask([1, 2]));
        assert_eq!((order.at(1), order.at(2), order.count()), (Some(2.0), None, 1));
    }
}
