//! Difference of a figure between two values of a varied parameter, a - b, at the same points: the common part of the scatter cancels.
//!
//! ```text
//! probability   p_a - p_b = p_10 - p_01: only one event occurs. Exact limits of both, and their correlation in a multinomial sample
//! quantile      limits of both, and the correlation of "at most the estimate" over the points (or over the shares of replicates)
//! mean          Student's t of the differences
//! ```
//! Probabilities and quantiles combine two pairs of limits by [`reach`], each at the full level.
//!
//! * Probabilities of independent points: the smallest coverage over all outcomes, computed on a grid of p_10 and p_01, is 0.953 for 95 %
//!   and 0.990 for 99 % (n = 10, 20, 50, 100, 200).
//! * Quantiles are approximate; `tests/uncertainty/paired.rs` measures the coverage. Quantiles without a common point use limits that hold
//!   with 1 - alpha/2 each.
//! * Bad runs: the estimates count those of both values as harmless, or those of both as harmful. The lower limit counts those of a as
//!   harmless and those of b as harmful, the upper limit the reverse, so that the interval contains every combination.

use super::figures::{Figures, Method, ratio_of_counts};
use super::known::{Truths, Values};
use super::limits::{lower_limit, upper_limit};
use super::mean::mean;
use super::quantile::quantile;
use super::reach::{Arms, Cluster, UNSEEN, correlation, lessened, reach};
use super::scheme::{FEW, Scheme};

/// Numbers of points where only a occurred, where only b occurred, and of all points of a part.
#[derive(Debug, Clone, Copy, Default)]
struct Apart {
    a: u64,
    b: u64,
    n: u64,
}

fn apart(
    a: &Truths,
    b: &Truths,
    of: impl Fn(usize) -> (bool, bool),
    parts: usize,
    part: impl Fn(usize) -> usize,
) -> Vec<Apart> {
    let mut counts = vec![Apart::default(); parts];
    for point in 0..a.of.len().min(b.of.len()) {
        let (a, b) = of(point);
        let count = &mut counts[part(point)];
        count.n += 1;
        count.a += u64::from(a && !b);
        count.b += u64::from(b && !a);
    }
    counts
}

/// Confidence limits of p_10 - p_01.
fn limits(of: Apart, alpha: f64) -> (f64, f64) {
    let n = of.n as f64;
    let (a, b) = (of.a as f64 / n, of.b as f64 / n);
    let arms = |count: u64, share: f64| Arms {
        below: share - lower_limit(count, of.n, alpha / 2.0),
        above: upper_limit(count, of.n, alpha / 2.0) - share,
    };
    // correlation of two counts of a multinomial sample; a point without either event may as well have had one
    let rest = of.n - of.a - of.b;
    let half = 0.5 * UNSEEN.min(rest as f64) / n;
    let odds = (a + half) * (b + half) / ((1.0 - a - half) * (1.0 - b - half));
    let r = if rest > 0 && odds.is_finite() { -odds.sqrt().min(1.0) } else { -1.0 };
    let off = reach(arms(of.a, a), arms(of.b, b), r);
    ((a - b - off.below).max(-1.0), (a - b + off.above).min(1.0))
}

fn sum(parts: &[Apart]) -> Apart {
    parts.iter().fold(Apart::default(), |all, one| Apart { a: all.a + one.a, b: all.b + one.b, n: all.n + one.n })
}

/// Difference of probabilities.
#[must_use]
pub fn of_probabilities(a: &Truths, b: &Truths, scheme: &Scheme, part: impl Fn(usize) -> usize, alpha: f64) -> Figures {
    let parts = scheme.parts();
    let least = apart(a, b, |point| (a.of[point].low(), b.of[point].high()), parts, &part);
    let most = apart(a, b, |point| (a.of[point].high(), b.of[point].low()), parts, &part);
    let harmless = apart(a, b, |point| (a.of[point].low(), b.of[point].low()), parts, &part);
    let harmful = sum(&apart(a, b, |point| (a.of[point].high(), b.of[point].high()), parts, &part));
    let all = sum(&harmless);
    let mut found = Figures::over(all.n);
    if all.n == 0 {
        found.notes.push("there is no point".to_owned());
        return found;
    }
    let share = |of: Apart| (of.a as f64 - of.b as f64) / of.n as f64;
    found.estimate = Some(share(all));
    found.harmful = Some(share(harmful));
    found.notes.push(format!("only the first at {} points, only the second at {}", all.a, all.b));
    let t = scheme.t(alpha);
    let replicated = |of: &[Apart]| {
        let few = {
            let all = sum(of);
            all.a + all.b < FEW
        };
        let sums: Vec<_> = of.iter().map(|of| (of.a as f64 - of.b as f64, of.n as f64)).collect();
        ratio_of_counts(&sums, t, alpha)
            .filter(|_| !few)
            .map(|(mean, half)| ((mean - half).max(-1.0), (mean + half).min(1.0)))
    };
    if let Scheme::Without(why) = scheme {
        found.notes.push(why.clone());
        return found;
    }
    let independent = *scheme == Scheme::Independent;
    if !independent && let (Some(low), Some(high)) = (replicated(&least), replicated(&most)) {
        (found.low, found.high) = (Some(low.0), Some(high.1));
        found.statistical = replicated(&harmless).map(|(low, high)| high - low);
        found.method = Method::Replicates;
    } else {
        (found.low, found.high) = (Some(limits(sum(&least), alpha).0), Some(limits(sum(&most), alpha).1));
        let (low, high) = limits(all, alpha);
        found.statistical = Some(high - low);
        found.method = Method::PairedClopperPearson;
    }
    found.approximate = !independent;
    found
}

/// Difference of quantiles.
#[must_use]
pub fn of_quantiles(
    a: &Values,
    b: &Values,
    u: f64,
    scheme: &Scheme,
    part: impl Fn(usize) -> usize,
    alpha: f64,
) -> Figures {
    let (first, second) = (quantile(a, u, scheme, &part, alpha), quantile(b, u, scheme, &part, alpha));
    let r = first.estimate.zip(second.estimate).and_then(|at| common(a, b, at, scheme, &part));
    match r {
        Some(r) => of_correlated(&first, &second, r),
        None => of_two(&quantile(a, u, scheme, &part, alpha / 2.0), &quantile(b, u, scheme, &part, alpha / 2.0)),
    }
}

/// Difference of two figures whose limits hold with 1 - alpha/2 each; both hold with 1 - alpha, whatever their dependence.
#[must_use]
pub fn of_two(first: &Figures, second: &Figures) -> Figures {
    let minus = |x: Option<f64>, y: Option<f64>| x.zip(y).map(|(x, y)| x - y);
    let mut found = Figures::over(first.n.min(second.n));
    found.estimate = minus(first.estimate, second.estimate);
    found.harmful = minus(first.harmful, second.harmful);
    found.low = minus(first.low, second.high);
    found.high = minus(first.high, second.low);
    found.statistical = first.statistical.zip(second.statistical).map(|(x, y)| x + y);
    found.method = first.method;
    found.approximate = first.approximate || second.approximate;
    found.notes = first.notes.clone();
    for note in &second.notes {
        if !found.notes.contains(note) {
            found.notes.push(note.clone());
        }
    }
    found
}

/// Difference of two figures whose limits hold with 1 - alpha each; `r`: correlation of the estimates.
#[must_use]
pub fn of_correlated(first: &Figures, second: &Figures, r: f64) -> Figures {
    let mut found = of_two(first, second);
    // arms with bad runs harmless; an arm that bad runs leave open is infinite
    let plain = |of: &Figures| {
        let below = distance(of.estimate, of.low);
        Arms { below, above: of.statistical.map_or(f64::INFINITY, |width| width - below) }
    };
    let (a, b) = (plain(first), plain(second));
    let (worst_a, worst_b) = (distance(first.high, first.harmful), distance(second.high, second.harmful));
    let end = |estimate: Option<f64>, off: f64| estimate.filter(|_| off.is_finite()).map(|estimate| estimate + off);
    let low = first.estimate.zip(second.harmful).map(|(a, b)| a - b);
    let high = first.harmful.zip(second.estimate).map(|(a, b)| a - b);
    found.low = end(low, -reach(a, Arms { above: worst_b, ..b }, r).below);
    found.high = end(high, reach(Arms { above: worst_a, ..a }, b, r).above);
    let all = reach(a, b, r);
    found.statistical = Some(all.below + all.above).filter(|width| width.is_finite());
    found.approximate = first.method != Method::Without;
    found
}

/// How far the first value is above the second; infinite where one is missing.
fn distance(upper: Option<f64>, lower: Option<f64>) -> f64 {
    upper.zip(lower).map_or(f64::INFINITY, |(upper, lower)| (upper - lower).max(0.0))
}

/// Correlation of the counts of values at or below these levels; `None` if all values of one figure are on one side.
fn common(a: &Values, b: &Values, at: (f64, f64), scheme: &Scheme, part: impl Fn(usize) -> usize) -> Option<f64> {
    let is_single = *scheme == Scheme::Independent;
    let clusters = |of: &Values, at: f64| -> Vec<Cluster> {
        let one = |(point, low): (&u32, &f64)| (u64::from(*point), f64::from(u8::from(*low <= at)), 1.0);
        let all = of.point.iter().zip(&of.low).map(one);
        if is_single {
            return all.collect();
        }
        let mut parts: Vec<Cluster> = (0..scheme.parts() as u64).map(|part| (part, 0.0, 0.0)).collect();
        for (point, counted, weight) in all {
            let of = &mut parts[part(point as usize)];
            (of.1, of.2) = (of.1 + counted, of.2 + weight);
        }
        parts
    };
    let (of_a, of_b) = (clusters(a, at.0), clusters(b, at.1));
    let sum = |of: &[Cluster]| of.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.1, sum.1 + one.2));
    let open = |of: &Values, at: f64| {
        of.low.iter().zip(&of.high).filter(|(low, high)| (**low <= at) != (**high <= at)).count() as f64
    };
    let open = open(a, at.0) + open(b, at.1);
    Some(lessened(correlation(&of_a, &of_b)?, sum(&of_a), sum(&of_b), open))
}

/// Indices of both values, and the point, for every point that has two values.
fn in_both<'a>(a: &'a Values, b: &'a Values) -> impl Iterator<Item = (usize, usize, u32)> + 'a {
    let mut at = 0;
    a.point.iter().enumerate().filter_map(move |(first, &point)| {
        while b.point.get(at).is_some_and(|&other| other < point) {
            at += 1;
        }
        (b.point.get(at) == Some(&point)).then_some((first, at, point))
    })
}

/// Difference of means, over the points where both have a value.
#[must_use]
pub fn of_means(a: &Values, b: &Values, scheme: &Scheme, part: impl Fn(usize) -> usize, alpha: f64) -> Figures {
    let mut pairs = Values { bad: a.bad, ..Values::default() };
    pairs.bad.add(&b.bad);
    for (first, second, point) in in_both(a, b) {
        pairs.point.push(point);
        pairs.low.push(a.low[first] - b.high[second]);
        pairs.high.push(a.high[first] - b.low[second]);
    }
    let lone = a.point.len() + b.point.len() - 2 * pairs.point.len();
    let mut found = mean(&pairs, scheme, part, alpha);
    if lone > 0 {
        found.notes.push(match lone {
            1 => "at 1 point only one of the two values exists: the point is left out".to_owned(),
            _ => format!("at {lone} points only one of the two values exists: the points are left out"),
        });
    }
    found
}
