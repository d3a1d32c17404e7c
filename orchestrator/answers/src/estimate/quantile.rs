//! Quantile: the level that a share u of the values does not exceed.
//!
//! ```text
//! estimate               x_(ceil(n u)), the inverse of the share of values at most x
//! independent points     x_(j), x_(k): exact for any distribution; the lower limit uses the lower bounds of bad runs, the upper limit the
//!                        upper bounds
//! replicates             h = half width of the share of values at most the estimate;  x_(floor(n (u - h))), x_(floor(n (u + h)) + 1)
//! ```
//! Sources: W. J. Conover, "Practical nonparametric statistics"; R. S. Woodruff (1952) for the replicates; S. S. Wilks (1941) for the
//! number of points needed.

use super::bad::Bad;
use super::figures::{Figures, Method, finite, ratio_of_counts};
use super::known::Values;
use super::limits::{lower_order, upper_order, wilks};
use super::order::Order;
use super::scheme::{FEW, Scheme};
use crate::share::percent;
use bladeoff_text::document::units::format_digits;

/// Rank ceil(n u), protected against rounding of n u across an integer.
fn rank(n: u64, u: f64) -> u64 {
    let place = n as f64 * u;
    let whole = libm::rint(place);
    let up = if (place - whole).abs() <= 1e-9 * place.max(1.0) { whole } else { libm::ceil(place) };
    (up as u64).clamp(1, n.max(1))
}

/// A number of values as text; large numbers with four digits.
fn enough(values: f64) -> String {
    if values < 1e15 { format!("{values}") } else { format!("about {}", format_digits(values, "", 4)) }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

/// Whether the replicates have too few values beyond the quantile.
fn is_few(n: u64, u: f64) -> bool {
    n as f64 * u.min(1.0 - u) < FEW as f64
}

/// Ranks among `n` values: of the estimate, and of the limits for independent points.
fn ranks(n: u64, u: f64, alpha: f64) -> [Option<u64>; 3] {
    if n == 0 {
        return [None; 3];
    }
    [Some(rank(n, u)), lower_order(u, n, alpha / 2.0), upper_order(u, n, alpha / 2.0)]
}

/// Ranks of the limits by replicates, from the half widths of both shares: lower, upper, and upper with every bad run harmless.
fn ranks_by_halves(n: u64, u: f64, (down, up): (f64, f64)) -> [u64; 3] {
    let place = |share: f64| libm::floor(n as f64 * share).max(0.0) as u64;
    [place(u - down), place(u + up) + 1, place(u + down) + 1]
}

/// Values by rank, with bad runs at their lower and at their upper bounds.
struct Ranked<'a> {
    n: u64,
    bad: Bad,
    low: &'a dyn Fn(u64) -> Option<f64>,
    high: &'a dyn Fn(u64) -> Option<f64>,
    /// Half widths of the shares of values at most the estimate, for replicates.
    halves: Option<(f64, f64)>,
}

impl Ranked<'_> {
    fn figures(&self, u: f64, scheme: &Scheme, alpha: f64) -> Figures {
        let n = self.n;
        let mut found = Figures::over(n);
        if n == 0 {
            found.notes.push("no run has a value".to_owned());
            return found;
        }
        let at = |sorted: &dyn Fn(u64) -> Option<f64>, rank: Option<u64>| {
            rank.filter(|rank| (1..=n).contains(rank)).and_then(sorted).and_then(finite)
        };
        let [middle, below, above] = ranks(n, u, alpha);
        found.estimate = at(self.low, middle);
        found.harmful = at(self.high, middle);
        let independent = |found: &mut Figures| {
            found.low = at(self.low, below);
            found.high = at(self.high, above);
            found.statistical = at(self.low, above).zip(found.low).map(|(above, below)| above - below);
            found.method = Method::OrderStatistics;
            let values = if n == 1 { "1 value is".to_owned() } else { format!("{n} values are") };
            for (end, order, beyond) in [("upper", above, 1.0 - u), ("lower", below, u)] {
                if order.is_none() {
                    let needed = enough(wilks(beyond, alpha / 2.0));
                    found.notes.push(format!("no {end} limit: {values} too few, it needs {needed} (Wilks)"));
                }
            }
        };
        match scheme {
            Scheme::Independent => independent(&mut found),
            Scheme::Without(why) => found.notes.push(why.clone()),
            Scheme::Replicated(_) => {
                found.approximate = true;
                match self.halves.filter(|_| !is_few(n, u)) {
                    Some(halves) => {
                        let [lower, upper, harmless] = ranks_by_halves(n, u, halves);
                        found.low = at(self.low, Some(lower));
                        found.high = at(self.high, Some(upper));
                        found.statistical = at(self.low, Some(harmless)).zip(found.low).map(|(top, low)| top - low);
                        found.method = Method::Replicates;
                    }
                    None => {
                        independent(&mut found);
                        found.notes.push(format!(
                            "fewer than {FEW} values beyond it: the limits are those of the same number of \
                             independent points"
                        ));
                    }
                }
            }
        }
        if self.bad.failing() > 0 && (found.low.is_none() || found.high.is_none()) {
            let note = "failed or invalid runs may have any value, so the missing limit is undetermined";
            found.notes.push(note.to_owned());
        }
        if self.bad.beyond > 0 && found.high.is_none() && found.method != Method::Without {
            let inside = percent((n - self.bad.beyond.min(n)) as f64 / n as f64);
            let outside = percent(self.bad.beyond as f64 / n as f64);
            found.notes.push(format!(
                "{outside} of the runs are beyond the model, so quantiles above {inside} have a lower limit only, and those \
                 shortly below have no upper confidence limit"
            ));
        }
        found
    }
}

/// The u-quantile of values in memory; `part` gives the part of a point.
#[must_use]
pub fn quantile(values: &Values, u: f64, scheme: &Scheme, part: impl Fn(usize) -> usize, alpha: f64) -> Figures {
    let n = values.low.len() as u64;
    let low = sorted(&values.low);
    let high = if values.bad.all > 0 { sorted(&values.high) } else { low.clone() };
    let of = |sorted: &[f64], rank: u64| sorted.get(usize::try_from(rank.checked_sub(1)?).ok()?).copied();
    let halves = match (scheme, n) {
        (Scheme::Without(_) | Scheme::Independent, _) | (_, 0) => None,
        (Scheme::Replicated(parts), _) => {
            let middle = rank(n, u) as usize - 1;
            let mut shares = Shares::new((low[middle], high[middle]), *parts);
            for ((low, high), point) in values.low.iter().zip(&values.high).zip(&values.point) {
                shares.see(*low, *high, part(*point as usize));
            }
            shares.halves(scheme.t(alpha), alpha)
        }
    };
    let ranked = Ranked { n, bad: values.bad, low: &|rank| of(&low, rank), high: &|rank| of(&high, rank), halves };
    ranked.figures(u, scheme, alpha)
}

/// By part: number of values whose lower bound, and whose upper bound, is at most the estimate.
#[derive(Debug, Clone)]
struct Shares {
    at_most: (f64, f64),
    /// Lower bounds, upper bounds, all values.
    parts: Vec<(f64, f64, f64)>,
}

impl Shares {
    fn new(at_most: (f64, f64), parts: usize) -> Self {
        Self { at_most, parts: vec![(0.0, 0.0, 0.0); parts] }
    }

    fn see(&mut self, low: f64, high: f64, part: usize) {
        let count = &mut self.parts[part];
        count.0 += f64::from(u8::from(low <= self.at_most.0));
        count.1 += f64::from(u8::from(high <= self.at_most.1));
        count.2 += 1.0;
    }

    /// Half widths of both shares.
    fn halves(&self, t: f64, alpha: f64) -> Option<(f64, f64)> {
        let half = |share: fn(&(f64, f64, f64)) -> f64| {
            let counts: Vec<_> = self.parts.iter().map(|part| (share(part), part.2)).collect();
            ratio_of_counts(&counts, t, alpha).map(|(_, half)| half)
        };
        Some((half(|part| part.0)?, half(|part| part.1)?))
    }
}

/// Accumulator of a quantile over several passes of the same values in the same order.
#[derive(Debug, Clone)]
pub struct Quantiles {
    u: f64,
    low: Order,
    /// Upper bounds, from the first value on whose bounds differ.
    high: Option<Order>,
    stage: Stage,
}

#[derive(Debug, Clone)]
enum Stage {
    /// Looking for values by rank.
    Ranks,
    Shares(Shares),
    /// Looking for values by the ranks that follow from the shares.
    ByHalves((f64, f64)),
}

impl Quantiles {
    /// An accumulator for the u-quantile that keeps up to `limit` values.
    #[must_use]
    pub fn keeping(u: f64, limit: usize) -> Self {
        Self { u, low: Order::keeping(limit), high: None, stage: Stage::Ranks }
    }

    /// Adds a value by its bounds.
    pub fn see(&mut self, low: f64, high: f64, part: usize) {
        if let Stage::Shares(shares) = &mut self.stage {
            return shares.see(low, high, part);
        }
        if self.high.is_none() && low.to_bits() != high.to_bits() {
            // all bounds were equal so far
            self.high = Some(self.low.clone());
        }
        self.low.see(low);
        self.high.iter_mut().for_each(|order| order.see(high));
    }

    /// Ends a pass. Returns whether another pass is needed.
    pub fn go_on(&mut self, scheme: &Scheme, alpha: f64) -> bool {
        let (n, u) = (self.low.count(), self.u);
        if let Stage::Shares(shares) = &self.stage {
            let Some(halves) = shares.halves(scheme.t(alpha), alpha) else { return false };
            self.stage = Stage::ByHalves(halves);
        }
        let asked: Vec<u64> = match &self.stage {
            Stage::ByHalves(halves) => ranks_by_halves(n, u, *halves).to_vec(),
            _ => ranks(n, u, alpha).into_iter().flatten().collect(),
        };
        let mut is_open = false;
        for order in std::iter::once(&mut self.low).chain(&mut self.high) {
            is_open |= order.ask(asked.iter().copied());
        }
        if is_open {
            return true;
        }
        let Scheme::Replicated(parts) = scheme else { return false };
        if matches!(self.stage, Stage::ByHalves(_)) || n == 0 || is_few(n, u) {
            return false;
        }
        let middle = rank(n, u);
        let ends = self.low.at(middle).zip(self.high.as_ref().unwrap_or(&self.low).at(middle));
        self.stage = Stage::Shares(Shares::new(ends.expect("asked for above"), *parts));
        true
    }

    /// The quantile, when no further pass is needed; `bad`: bad runs among the values.
    #[must_use]
    pub fn figures(&self, bad: Bad, scheme: &Scheme, alpha: f64) -> Figures {
        let halves = if let Stage::ByHalves(halves) = self.stage { Some(halves) } else { None };
        let high = self.high.as_ref().unwrap_or(&self.low);
        let ranked =
            Ranked { n: self.low.count(), bad, low: &|rank| self.low.at(rank), high: &|rank| high.at(rank), halves };
        ranked.figures(self.u, scheme, alpha)
    }
}
