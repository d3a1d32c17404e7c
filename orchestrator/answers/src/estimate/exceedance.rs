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
fn levels(values: &Values) -> Vec<f64> {
    let mut all: Vec<f64> = values.low.iter().copied().filter(|value| value.is_finite()).collect();
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

/// Points above each level, by part.
fn above(values: &[f64], points: &[u32], levels: &[f64], parts: usize, part: impl Fn(usize) -> usize) -> Vec<Vec<u64>> {
    let mut counts = vec![vec![0u64; levels.len() + 1]; parts];
    for (value, &point) in values.iter().zip(points) {
        counts[part(point as usize)][levels.partition_point(|level| level < value)] += 1;
    }
    // of those that exceed so many levels, to those that exceed this one
    for counts in &mut counts {
        for at in (0..levels.len()).rev() {
            counts[at] += counts[at + 1];
        }
        counts.remove(0);
    }
    counts
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
    let levels = levels(values);
    let parts = points.len();
    let low = above(&values.low, &values.point, &levels, parts, &part);
    let high = above(&values.high, &values.point, &levels, parts, &part);
    let (n, t): (u64, f64) = (points.iter().sum(), scheme.t(alpha));
    let mut method = Method::Without;
    let point = |(at, level): (usize, &f64)| {
        let tally = |part: usize| Tally { n: points[part], low: low[part][at], high: high[part][at] };
        let tallies: Vec<Tally> = (0..parts).map(tally).collect();
        let mut figures = match scheme {
            Scheme::Independent => banded(Tally::of_all(&tallies), band(n, alpha)),
            _ => proportion_by(&tallies, scheme, alpha, t),
        };
        figures.notes.clear();
        if figures.method != Method::Without {
            method =
                if method == Method::Without || method == figures.method { figures.method } else { Method::Replicates };
        }
        CurvePoint { at: (Label::Number(*level), Label::Number(*level)), bad: values.bad, figures }
    };
    let curve = levels.iter().enumerate().map(point).collect();
    (curve, method)
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
