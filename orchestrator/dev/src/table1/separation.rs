//! When an ordering of two detections is claimed.
//!
//! Each detection has one value for each start. If the detection made no difference, the values of two detections over n starts
//! each would be exchangeable, and all of one would lie below all of the other in 2 of C(2n, n) cases (the extreme of the
//! rank-sum test; values of equal starts that resemble one another make it rarer). An ordering is claimed where the ranges lie
//! apart and that chance is at most [`CHANCE`]: four starts are needed, three lie apart by accident one time in ten.

use super::done::Done;
use bladeoff_model::outcome::Status;

/// Chance up to which two separate ranges are taken for more than an accident.
pub(super) const CHANCE: f64 = 0.05;

/// What the starts say about one quantity of one detection.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spread {
    /// Value from the machine's own start.
    pub own: f64,
    /// All values, in rising order.
    pub sorted: Vec<f64>,
    /// Runs that are not `ok`: their values are not to be believed.
    pub not_ok: usize,
}

impl Spread {
    /// Of the runs of an engine and detection; `None` where the own start has no value.
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

/// What can be said about `small < large`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is so.
    ComesOut,
    /// The opposite is so.
    Reversed,
    /// The ranges overlap.
    Overlap,
    /// They lie apart, but so few values do that by accident.
    TooFew,
    /// Some of the values come from runs that are not to be believed.
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
            // one value each is a point, which overlaps only where it is equal
            return Verdict::Overlap;
        }
        if accident(small.sorted.len(), large.sorted.len()) > CHANCE {
            return Verdict::TooFew;
        }
        if small.high() < large.low() { Verdict::ComesOut } else { Verdict::Reversed }
    }

    /// Of several engines: what all of them claim.
    pub fn of_all(verdicts: &[Self]) -> Self {
        let first = verdicts.first().copied().unwrap_or(Verdict::Missing);
        if verdicts.iter().all(|verdict| *verdict == first) {
            return first;
        }
        verdicts.iter().copied().find(|verdict| !verdict.claims()).unwrap_or(Verdict::Overlap)
    }

    /// Whether something is claimed.
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

/// Chance that `a` and `b` exchangeable values lie apart, in either order: 2/C(a+b, a).
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

    /// Counted: of all ways to deal 2n distinct values to two hands, those in which one hand has all the small ones.
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
