//! How probable it is that a column exceeds a level, for every level.
//!
//! ```text
//! independent points   share of values above x, -+ sqrt(ln(2/alpha)/(2 n)) for all levels at once
//! replicates           at each level the interval of a probability, each level by itself
//! ```
//! A run without a value exceeds no level, as in `probability = "COLUMN > x"`; so the share is of all runs. A bad run exceeds what it
//! had reached for certain, and any level perhaps.
//! Source: P. Massart, "The tight constant in the Dvoretzky-Kiefer-Wolfowitz inequality" (1990).

use super::curve::CurvePoint;
use super::figures::{Figures, Method};
use super::input::Label;
use super::known::Values;
use super::limits::band;
use super::proportion::{Tally, proportion_by};
use super::scheme::Scheme;

/// Levels of a curve at most, and how many of them are the largest values, each for itself.
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

/// A curve of values that pass by twice: for the levels, and to be counted.
#[derive(Debug, Clone, Default)]
pub struct Exceedances {
    /// All that may be levels: on the first pass.
    all: Vec<f64>,
    /// On the second one.
    levels: Option<Vec<f64>>,
    /// Points that exceed so many levels, by part: by their lower ends, and by their upper ones.
    low: Vec<Vec<u64>>,
    high: Vec<Vec<u64>>,
}

impl Exceedances {
    /// Takes a value by its ends.
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

    /// After a pass: whether another one is needed.
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

    /// The curve, after both passes; `points`: of each part, those without a value too; `bad`: runs among them.
    #[must_use]
    pub fn curve(mut self, points: &[u64], bad: u64, scheme: &Scheme, alpha: f64) -> (Vec<CurvePoint>, Method) {
        let levels = self.levels.unwrap_or_default();
        // of those that exceed so many levels, to those that exceed this one
        for counts in self.low.iter_mut().chain(&mut self.high) {
            for at in (0..levels.len()).rev() {
                counts[at] += counts[at + 1];
            }
            counts.remove(0);
        }
        let (low, high) = (self.low, self.high);
        let (n, t): (u64, f64) = (points.iter().sum(), scheme.t(alpha));
        let mut method = Method::Without;
        let point = |(at, level): (usize, &f64)| {
            let tally = |part: usize| Tally { n: points[part], low: low[part][at], high: high[part][at] };
            let tallies: Vec<Tally> = (0..points.len()).map(tally).collect();
            let mut figures = match scheme {
                Scheme::Independent => banded(Tally::of_all(&tallies), band(n, alpha)),
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

/// The curve. `part`: that of a point; `points`: of each part, those without a value too.
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

fn banded(tally: Tally, half: f64) -> Figures {
    let mut found = Figures::over(tally.n);
    let share = |events: u64| events as f64 / tally.n as f64;
    found.events = Some(tally.low);
    found.estimate = Some(share(tally.low));
    found.harmful = Some(share(tally.high));
    found.low = Some((share(tally.low) - half).max(0.0));
    found.high = Some((share(tally.high) + half).min(1.0));
    found.statistical = Some(2.0 * half);
    found.method = Method::Band;
    found
}
