//! A quantile: the level that a part u of the values does not exceed.
//!
//! ```text
//! estimate               x_(ceil(n u)), the inverse of the share of values at most x
//! independent points     x_(j), x_(k): exact for any distribution; a bad run stands at its least value for the lower one, at its largest
//!                        for the upper one
//! replicates             h = half width of the share of values at most the estimate;  x_(floor(n (u - h))), x_(floor(n (u + h)) + 1)
//! ```
//! Sources: W. J. Conover, "Practical nonparametric statistics"; R. S. Woodruff (1952) for the replicates; S. S. Wilks (1941) for how
//! many points there have to be.

use super::figures::{Figures, Method, finite, ratio_of_counts};
use super::known::Values;
use super::limits::{lower_order, upper_order, wilks};
use super::scheme::{FEW, Scheme};
use bladeoff_model::document::units::format_digits;

/// A rank of n u that rounding does not move beyond a whole number.
fn rank(n: u64, u: f64) -> u64 {
    let place = n as f64 * u;
    let whole = libm::rint(place);
    let up = if (place - whole).abs() <= 1e-9 * place.max(1.0) { whole } else { libm::ceil(place) };
    (up as u64).clamp(1, n.max(1))
}

/// A number of values in words; of a large one only the first digits are known.
fn enough(values: f64) -> String {
    if values < 1e15 { format!("{values}") } else { format!("about {}", format_digits(values, "", 4)) }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

/// The u-quantile; `part`: that of a point.
#[must_use]
pub fn quantile(values: &Values, u: f64, scheme: &Scheme, part: impl Fn(usize) -> usize, alpha: f64) -> Figures {
    let n = values.low.len() as u64;
    let mut found = Figures::over(n);
    if n == 0 {
        found.notes.push("no run has a value".to_owned());
        return found;
    }
    let low = sorted(&values.low);
    let high = if values.bad > 0 { sorted(&values.high) } else { low.clone() };
    let at = |sorted: &[f64], rank: Option<u64>| {
        rank.filter(|rank| (1..=n).contains(rank)).and_then(|rank| finite(sorted[rank as usize - 1]))
    };
    let middle = rank(n, u);
    found.estimate = at(&low, Some(middle));
    found.harmful = at(&high, Some(middle));
    let independent = |found: &mut Figures| {
        let (below, above) = (lower_order(u, n, alpha / 2.0), upper_order(u, n, alpha / 2.0));
        found.low = at(&low, below);
        found.high = at(&high, above);
        found.statistical = at(&low, above).zip(found.low).map(|(above, below)| above - below);
        found.method = Method::OrderStatistics;
        let values = if n == 1 { "1 value is".to_owned() } else { format!("{n} values are") };
        for (end, order, beyond) in [("upper", above, 1.0 - u), ("lower", below, u)] {
            if order.is_none() {
                let needed = enough(wilks(beyond, alpha / 2.0));
                found.notes.push(format!("no {end} limit: {values} too few, {needed} have one (Wilks)"));
            }
        }
    };
    match scheme {
        Scheme::Independent => independent(&mut found),
        Scheme::Without(why) => found.notes.push(why.clone()),
        Scheme::Replicated(parts) => {
            found.approximate = true;
            let few = n as f64 * u.min(1.0 - u) < FEW as f64;
            let t = scheme.t(alpha);
            let halves = || {
                Some((
                    half(&values.low, values, low[middle as usize - 1], *parts, &part, (t, alpha))?,
                    half(&values.high, values, high[middle as usize - 1], *parts, &part, (t, alpha))?,
                ))
            };
            match halves() {
                Some((down, up)) if !few => {
                    let place = |share: f64| libm::floor(n as f64 * share).max(0.0) as u64;
                    found.low = at(&low, Some(place(u - down)));
                    found.high = at(&high, Some(place(u + up) + 1));
                    found.statistical = at(&low, Some(place(u + down) + 1)).zip(found.low).map(|(top, low)| top - low);
                    found.method = Method::Replicates;
                }
                _ => {
                    independent(&mut found);
                    found
                        .notes
                        .push(format!("fewer than {FEW} values beyond it: limits of as many independent points"));
                }
            }
        }
    }
    if values.bad > 0 && (found.low.is_none() || found.high.is_none()) {
        let note = "bad runs may have had any value, larger or smaller, and reach across a limit that is missing";
        found.notes.push(note.to_owned());
    }
    found
}

/// Half width of the share of values at most x.
fn half(
    values: &[f64],
    of: &Values,
    x: f64,
    parts: usize,
    part: impl Fn(usize) -> usize,
    (t, alpha): (f64, f64),
) -> Option<f64> {
    let mut counts = vec![(0.0, 0.0); parts];
    for (value, &point) in values.iter().zip(&of.point) {
        let count = &mut counts[part(point as usize)];
        count.0 += f64::from(u8::from(*value <= x));
        count.1 += 1.0;
    }
    ratio_of_counts(&counts, t, alpha).map(|(_, half)| half)
}
