//! Criterion for an ordering of two detections.
//!
//! Each detection has one value for each start. If the detection had no effect, the values of two detections over n starts each would be
//! exchangeable, and all values of one would lie below all values of the other with probability 2/C(2n, n) (the extreme of the rank-sum
//! test; correlation between equal starts makes this less likely). An ordering is claimed if the ranges do not overlap and that probability is
//! at most [`CHANCE`]. This takes four starts: with three, the probability is one in ten.

use super::done::Done;
use bladeoff_model::outcome::Status;

/// Largest probability of separate ranges by chance for which an ordering is claimed.
pub(super) const CHANCE: f64 = 0.05;

/// Values of one quantity and detection over the starts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spread {
    /// Value from the machine's own start.
    pub own: f64,
    /// All values in ascending order.
    pub sorted: Vec<f64>,
    /// Number of runs that are not `ok`, whose values are unreliable.
    pub not_ok: usize,
}

impl Spread {
    /// Values of the runs of an engine and detection; `None` if the own start has no value.
    pub fn of(done: &[Done], engine: &str, detection: &str, value: fn(&Done) -> Option<f64>) -> Option<Self> {
        let runs = || done.iter().filter(|run| run.engine == engine && run.detection == detection);
        let own = runs().find(|run| run.start == 0).and_then(value)?;
        let mut sorted: Vec<f64> = runs().filter_map(value).collect();
        sorted.sort_by(f64::total_cmp);
        Some(Self { own, sorted, not_ok: runs().filter(|run| run.status() != Status::Ok).count() })
    }
    pub fn low(&self) -> f64 {
        self.sorted[0]
    }
    pub fn high(&self) -> f64 {
        self.sorted[self.sorted.len() - 1]
    }
    pub fn median(&self) -> f64 {
        let (count, half) = (self.sorted.len(), self.sorted.len() / 2);
        if count % 2 == 1 { self.sorted[half] } else { 0.5 * (self.sorted[half - 1] + self.sorted[half]) }
    }
}

/// Result for the ordering `small < large`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The ordering is confirmed.
    ComesOut,
    /// The reverse ordering is confirmed.
    Reversed,
    /// The ranges overlap.
    Overlap,
    /// The ranges do not overlap, but there are too few values.
    TooFew,
    /// Some values come from runs that are not `ok`.
    NotOk,
    /// There are no values.
    Missing,
}

impl Verdict {
    pub fn of(small: Option<&Spread>, large: Option<&Spread>) -> Self {
        let (Some(small), Some(large)) = (small, large) else { return Verdict::Missing };
        if small.not_ok + large.not_ok > 0 {
            return Verdict::NotOk;
        }
        let apart = small.high() < large.low() || small.low() > large.high();
        if !apart {
            // single values are points, which overlap only if they are equal
            return Verdict::Overlap;
        }
        if accident(small.sorted.len(), large.sorted.len()) > CHANCE {
            return Verdict::TooFew;
        }
        if small.high() < large.low() { Verdict::ComesOut } else { Verdict::Reversed }
    }

    /// Common result of several engines.
    pub fn of_all(verdicts: &[Self]) -> Self {
        let first = verdicts.first().copied().unwrap_or(Verdict::Missing);
        if verdicts.iter().all(|verdict| *verdict == first) {
            return first;
        }
        verdicts.iter().copied().find(|verdict| !verdict.claims()).unwrap_or(Verdict::Overlap)
    }

    /// Whether an ordering, or its reverse, is claimed.
    pub fn claims(self) -> bool {
        matches!(self, Verdict::ComesOut | Verdict::Reversed)
    }

    pub fn words(self) -> &'static str {
        match self {
            Verdict::ComesOut => "comes out",
            Verdict::Reversed => "**reversed**",
            Verdict::Overlap => "not decided: ranges overlap",
            Verdict::TooFew => "not decided: too few starts",
            Verdict::NotOk => "not decided: runs that are not ok",
            Verdict::Missing => "not computed",
        }
    }
}

/// Probability that `a` and `b` exchangeable values do not overlap, in either order: 2/C(a+b, a).
pub(super) fn accident(a: usize, b: usize) -> f64 {
    let choose = (1..=a).fold(1.0, |product, k| product * (b + k) as f64 / k as f64);
    (2.0 / choose).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(values: &[f64]) -> Spread {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        Spread { own: values[0], sorted, not_ok: 0 }
    }

    fn verdict(small: &[f64], large: &[f64]) -> Verdict {
        Verdict::of(Some(&spread(small)), Some(&spread(large)))
    }

    #[test]
    fn an_ordering_is_claimed_only_where_enough_values_lie_apart() {
        let (low, high) = ([1.0, 1.3, 1.1, 1.2], [1.4, 1.5, 1.6, 1.7]);
        assert_eq!(verdict(&low, &high), Verdict::ComesOut);
        assert_eq!(verdict(&high, &low), Verdict::Reversed);
        assert_eq!(verdict(&low, &[1.3, 1.5, 1.6, 1.7]), Verdict::Overlap);
        assert_eq!(verdict(&low[..3], &high[..3]), Verdict::TooFew, "one time in ten by accident");
        assert_eq!(verdict(&[1.0], &[2.0]), Verdict::TooFew);
        let bad = Spread { not_ok: 1, ..spread(&high) };
        assert_eq!(Verdict::of(Some(&spread(&low)), Some(&bad)), Verdict::NotOk);
        assert_eq!(Verdict::of(None, Some(&bad)), Verdict::Missing);
    }

    #[test]
    fn engines_have_to_agree() {
        use Verdict::{ComesOut, Overlap, Reversed};
        assert_eq!(Verdict::of_all(&[ComesOut, ComesOut]), ComesOut);
        assert_eq!(Verdict::of_all(&[ComesOut, Overlap]), Overlap);
        assert_eq!(Verdict::of_all(&[ComesOut, Reversed]), Overlap);
        assert_eq!(Verdict::of_all(&[Reversed]), Reversed);
    }

    /// Reference: of all ways to deal 2n distinct values to two hands, those in which one hand has all the small ones.
    #[test]
    fn the_chance_of_an_accident_is_that_of_dealing() {
        for (n, share) in [(1, 1.0), (2, 2.0 / 6.0), (3, 0.1), (4, 2.0 / 70.0), (5, 2.0 / 252.0)] {
            assert!((accident(n, n) - share).abs() < 1e-15, "{n}");
            let hands = (0u32..1 << (2 * n)).filter(|hand| hand.count_ones() as usize == n);
            let extreme = [(1u32 << n) - 1, ((1u32 << n) - 1) << n];
            let (mut all, mut apart) = (0.0, 0.0);
            for hand in hands {
                all += 1.0;
                apart += f64::from(u8::from(extreme.contains(&hand)));
            }
            assert!((apart / all - share).abs() < 1e-15, "{n}");
        }
    }
}
