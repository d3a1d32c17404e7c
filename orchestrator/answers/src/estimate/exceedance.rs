//! Probability that a column exceeds a level, for every level.
//!
//! ```text
//! independent points   share of values above x, for all levels at once: on each side the narrower of
//!                        share -+ sqrt(ln(4/alpha)/(2 n)), which holds everywhere with 1 - alpha/2, and
//!                        Clopper-Pearson limits where few values are above or below: they hold together with 1 - alpha/2
//! replicates           at each level separately, the interval of a probability
//! ```
//! A run without a value exceeds no level, as in `probability = "COLUMN > x"`; the share is that of all runs. A bad run certainly exceeds
//! the levels below its reached value, and may exceed any level.
//! The Clopper-Pearson part is exact: the probability above the value that exactly k values exceed has a beta distribution, so
//! one Clopper-Pearson limit for k values fails with its own level at all levels of x together. Limits for 0, 1, 3, 7 ... values
//! have the levels alpha/16, alpha/32 ..., likewise for each limit and each end: their sum is alpha/2. Without an event in 10 000 runs
//! the upper limit is 0.058 % (DKW alone: 1.4 %; Clopper and Pearson for that level alone: 0.037 %).
//! Sources: P. Massart, "The tight constant in the Dvoretzky-Kiefer-Wolfowitz inequality" (1990); C. J. Clopper, E. S. Pearson (1934).

use super::curve::CurvePoint;
use super::figures::{Figures, Method};
use super::input::Label;
use super::known::Values;
use super::limits::{band, lower_limit, upper_limit};
use super::proportion::{Tally, proportion_by};
use super::scheme::Scheme;

/// Largest number of levels of a curve, and number of the largest values among them that are not thinned.
const MOST_LEVELS: usize = 1000;
const LARGEST: usize = 200;

/// Levels: the distinct values, thinned below the largest ones.
fn levels(mut all: Vec<f64>) -> Vec<f64> {
    all.sort_unstable_by(f64::total_cmp);
    all.dedup();
    if all.len() <= MOST_LEVELS {
        return all;
    }
    let below = all.len() - LARGEST;
    let steps = MOST_LEVELS - LARGEST;
    let thinned = (0..steps).map(|step| all[step * below / steps]);
    thinned.chain(all[below..].iter().copied()).collect()
}

/// Accumulator of a curve over two passes: levels, then counts.
#[derive(Debug, Clone, Default)]
pub struct Exceedances {
    /// First pass: candidates for levels.
    all: Vec<f64>,
    /// Second pass: the levels.
    levels: Option<Vec<f64>>,
    /// Second pass: number of points that exceed exactly this many levels, by part, for lower and for upper bounds.
    low: Vec<Vec<u64>>,
    high: Vec<Vec<u64>>,
}

impl Exceedances {
    /// Adds a value by its bounds.
    pub fn see(&mut self, low: f64, high: f64, part: usize) {
        let Some(levels) = &self.levels else {
            if low.is_finite() {
                self.all.push(low);
            }
            return;
        };
        for (value, counts) in [(low, &mut self.low), (high, &mut self.high)] {
            counts[part][levels.partition_point(|level| *level < value)] += 1;
        }
    }

    /// Ends a pass. Returns whether another pass is needed.
    pub fn go_on(&mut self, scheme: &Scheme) -> bool {
        if self.levels.is_some() {
            return false;
        }
        let levels = levels(std::mem::take(&mut self.all));
        self.low = vec![vec![0; levels.len() + 1]; scheme.parts()];
        self.high.clone_from(&self.low);
        self.levels = Some(levels);
        true
    }

    /// The curve, after both passes; `points`: number of points of each part, including those without a value; `bad`: number of bad runs.
    #[must_use]
    pub fn curve(mut self, points: &[u64], bad: u64, scheme: &Scheme, alpha: f64) -> (Vec<CurvePoint>, Method) {
        let levels = self.levels.unwrap_or_default();
        // from counts of points that exceed exactly so many levels to counts that exceed each level
        for counts in self.low.iter_mut().chain(&mut self.high) {
            for at in (0..levels.len()).rev() {
                counts[at] += counts[at + 1];
            }
            counts.remove(0);
        }
        let (low, high) = (self.low, self.high);
        let (n, t): (u64, f64) = (points.iter().sum(), scheme.t(alpha));
        let mut method = Method::Without;
        let band = Band::new(n, alpha);
        let point = |(at, level): (usize, &f64)| {
            let tally = |part: usize| Tally { n: points[part], low: low[part][at], high: high[part][at] };
            let tallies: Vec<Tally> = (0..points.len()).map(tally).collect();
            let mut figures = match scheme {
                Scheme::Independent => banded(Tally::of_all(&tallies), &band),
                _ => proportion_by(&tallies, scheme, alpha, t),
            };
            figures.notes.clear();
            if figures.method != Method::Without {
                let is_same = method == Method::Without || method == figures.method;
                method = if is_same { figures.method } else { Method::Replicates };
            }
            CurvePoint { at: (Label::Number(*level), Label::Number(*level)), bad, figures }
        };
        let curve = levels.iter().enumerate().map(point).collect();
        (curve, method)
    }
}

/// The curve of values in memory. `part` gives the part of a point; `points`: number of points of each part, including those without a value.
#[must_use]
pub fn exceedance(
    values: &Values,
    scheme: &Scheme,
    points: &[u64],
    part: impl Fn(usize) -> usize,
    alpha: f64,
) -> (Vec<CurvePoint>, Method) {
    let mut found = Exceedances::default();
    loop {
        for ((low, high), point) in values.low.iter().zip(&values.high).zip(&values.point) {
            found.see(*low, *high, part(*point as usize));
        }
        if !found.go_on(scheme) {
            return found.curve(points, values.bad.all, scheme, alpha);
        }
    }
}

/// Limits of the exceedance probabilities at all levels at once.
struct Band {
    n: u64,
    half: f64,
    /// Numbers of values 2^j - 1, with the upper limit of each.
    upper: Vec<(u64, f64)>,
    /// Numbers of values 2^j, with the lower limit of each.
    lower: Vec<(u64, f64)>,
}

impl Band {
    fn new(n: u64, alpha: f64) -> Self {
        let (mut upper, mut lower, mut part) = (Vec::new(), Vec::new(), alpha / 16.0);
        let mut count = 1;
        while count <= n {
            upper.push((count - 1, upper_limit(count - 1, n, part)));
            lower.push((count, lower_limit(count, n, part)));
            part *= 0.5;
            count *= 2;
        }
        Self { n, half: band(n, alpha / 2.0), upper, lower }
    }

    /// Upper limit for a count: that of the next larger count that has one.
    fn above(&self, events: u64) -> f64 {
        let at = self.upper.partition_point(|(count, _)| *count < events);
        self.upper.get(at).map_or(1.0, |(_, limit)| *limit)
    }

    /// Lower limit for a count: that of the next smaller count that has one.
    fn below(&self, events: u64) -> f64 {
        let at = self.lower.partition_point(|(count, _)| *count <= events);
        at.checked_sub(1).map_or(0.0, |at| self.lower[at].1)
    }

    fn low(&self, events: u64) -> f64 {
        let share = events as f64 / self.n as f64;
        (share - self.half).max(self.below(events)).max(1.0 - self.above(self.n - events))
    }

    fn high(&self, events: u64) -> f64 {
        let share = events as f64 / self.n as f64;
        (share + self.half).min(self.above(events)).min(1.0 - self.below(self.n - events))
    }
}

fn banded(tally: Tally, band: &Band) -> Figures {
    let mut found = Figures::over(tally.n);
    let share = |events: u64| events as f64 / tally.n as f64;
    found.events = Some(tally.low);
    found.estimate = Some(share(tally.low));
    found.harmful = Some(share(tally.high));
    found.low = Some(band.low(tally.low));
    found.high = Some(band.high(tally.high));
    found.statistical = Some(band.high(tally.low) - band.low(tally.low));
    found.method = Method::Band;
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_system::random::SplitMix;

    #[test]
    fn the_band_is_near_clopper_pearson_in_the_tail_and_near_dkw_in_the_middle() {
        let found = Band::new(10_000, 0.05);
        // ln(320)/10000
        assert!((found.high(0) - 5.767e-4).abs() < 1e-6, "{}", found.high(0));
        assert!(found.high(0) < 1.6 * upper_limit(0, 10_000, 0.025) && found.low(0) == 0.0);
        // ten values: the lower limit of eight, at the fourth level, and the upper limit of fifteen, at the fifth
        assert_eq!(found.low(10), lower_limit(8, 10_000, 0.05 / 128.0));
        assert_eq!(found.high(10), upper_limit(15, 10_000, 0.05 / 256.0));
        assert!(found.high(5000) - 0.5 < 1.1 * band(10_000, 0.05));
        for events in 0..=10_000 {
            let (low, high, share) = (found.low(events), found.high(events), events as f64 / 10_000.0);
            assert!(low <= share && share <= high, "{events}");
            assert!((low - (1.0 - found.high(10_000 - events))).abs() < 1e-12, "both ends alike: {events}");
            assert!(events == 0 || (found.low(events - 1) <= low && found.high(events - 1) <= high), "{events}");
        }
    }

    /// Uniform values: the probability above a value x is 1 - x; the band holds at every level in at least 95 of 100 studies.
    #[test]
    fn the_band_holds_at_all_levels_at_once() {
        let mut random = SplitMix(9);
        for n in [5u64, 100, 1000] {
            let (band, mut held) = (Band::new(n, 0.05), 0);
            for _ in 0..1000 {
                let mut values: Vec<f64> = (0..n).map(|_| random.unit()).collect();
                values.sort_unstable_by(f64::total_cmp);
                // between two values the count is constant, while the probability covers the interval between them
                let holds = |above: u64| {
                    let at = (n - above) as usize;
                    let most = 1.0 - at.checked_sub(1).map_or(0.0, |at| values[at]);
                    let least = 1.0 - values.get(at).copied().unwrap_or(1.0);
                    band.low(above) <= least && most <= band.high(above)
                };
                held += u32::from((0..=n).all(holds));
            }
            println!("{n} values: {held} of 1000 bands hold");
            assert!(held >= 940, "{n}: {held}");
        }
    }
}
