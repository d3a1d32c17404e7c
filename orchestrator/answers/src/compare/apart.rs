//! Rows without partner, compared as two samples: differences of means and of quantiles, B - A.
//!
//! Two studies with the same seed are drawn from the same random numbers: point i of A and point i of B are dependent, all other points
//! are independent. The limits of both are therefore combined with the correlation of the estimates over points (or replicates) of equal
//! number, whatever the seeds are ([`crate::estimate::reach`]). If the kinds of draw differ, the limits of A and of B hold with
//! 1 - alpha/2 each. Means use rows that are ok; quantiles let a bad row have any value.

use super::draw::Clusters;
use super::found::{Apart, Interval, QuantileApart};
use crate::ask::CONFIDENCE;
use crate::estimate::bad::Bad;
use crate::estimate::difference::{of_correlated, of_two};
use crate::estimate::figures::Figures;
use crate::estimate::known::Values;
use crate::estimate::mean::mean;
use crate::estimate::quantile::quantile;
use crate::estimate::reach::{Cluster, correlation, lessened};
use crate::estimate::scheme::{FEW, Scheme};
use crate::tables::ColumnHead;
use std::collections::BTreeMap;

/// Levels of the quantiles that are compared.
const QUANTILES: [f64; 2] = [0.5, 0.95];

/// Rows of one table that have no partner.
pub(super) struct Rest<'a> {
    /// The rows.
    pub rows: &'a [usize],
    /// Samples of all rows of the table.
    pub samples: &'a [u64],
    /// Whether each row of the table is ok.
    pub is_ok: &'a dyn Fn(usize) -> bool,
    /// Dependence between the rows.
    pub clusters: &'a Clusters,
}

/// Estimates from the unmatched rows of one table.
struct Half {
    mean: Figures,
    bad: u64,
    quantiles: [Figures; QUANTILES.len()],
    /// Number of the point or replicate of each row, and its value where the row is ok.
    rows: Vec<(u64, Option<f64>)>,
}

impl Half {
    /// Numerator and denominator of a ratio of sums, by point or replicate; `of` returns the terms of a row.
    fn clusters(&self, of: impl Fn(Option<f64>) -> Option<(f64, f64)>) -> Vec<Cluster> {
        let mut sums: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
        for (number, value) in &self.rows {
            if let Some((above, below)) = of(*value) {
                let sum = sums.entry(*number).or_default();
                *sum = (sum.0 + above, sum.1 + below);
            }
        }
        sums.into_iter().map(|(number, (above, below))| (number, above, below)).collect()
    }

    /// Numbers of rows at or below a level, by point or replicate; a bad row counts as below.
    fn at_most(&self, level: f64) -> Vec<Cluster> {
        self.clusters(|value| Some((f64::from(u8::from(value.is_none_or(|value| value <= level))), 1.0)))
    }
}

/// Compares a column of numbers of both tables; NaN is a missing value.
pub(super) fn apart(head: &ColumnHead, a: (&[f64], &Rest<'_>), b: (&[f64], &Rest<'_>)) -> Apart {
    let are_alike = a.1.clusters.are_alike(b.1.clusters);
    let halves = |alpha: f64| (half(a.0, a.1, alpha), half(b.0, b.1, alpha));
    let alpha = 1.0 - CONFIDENCE;
    let (of_a, of_b) = halves(if are_alike { alpha } else { 0.5 * alpha });
    // for figures without a known correlation
    let apart = std::cell::OnceCell::new();
    let apart = || apart.get_or_init(|| halves(0.5 * alpha));
    let mean = match are_alike.then(|| of_means(&of_a, &of_b)).flatten() {
        Some(r) => of_correlated(&of_b.mean, &of_a.mean, r),
        None => of_two(&apart().1.mean, &apart().0.mean),
    };
    let difference = |at: usize| match are_alike.then(|| of_quantiles(&of_a, &of_b, at)).flatten() {
        Some(r) => of_correlated(&of_b.quantiles[at], &of_a.quantiles[at], r),
        None => of_two(&apart().1.quantiles[at], &apart().0.quantiles[at]),
    };
    let quantiles = QUANTILES.iter().enumerate().map(|(at, &level)| QuantileApart {
        quantile: level,
        a: of_a.quantiles[at].estimate,
        b: of_b.quantiles[at].estimate,
        difference: Interval::of(difference(at)),
    });
    Apart {
        column: head.name.clone(),
        unit: head.unit.clone(),
        values_a: of_a.mean.n,
        values_b: of_b.mean.n,
        bad_a: of_a.bad,
        bad_b: of_b.bad,
        mean_a: of_a.mean.estimate,
        mean_b: of_b.mean.estimate,
        mean: Interval::of(mean),
        quantiles: quantiles.collect(),
    }
}

/// Correlation of the two means; `None` if one of the means does not vary.
fn of_means(a: &Half, b: &Half) -> Option<f64> {
    let sums = |half: &Half| half.clusters(|value| value.map(|value| (value, 1.0)));
    correlation(&sums(a), &sums(b))
}

/// Correlation between the counts of values at or below each table's quantile estimate.
fn of_quantiles(a: &Half, b: &Half, at: usize) -> Option<f64> {
    let (of_a, of_b) = (a.at_most(a.quantiles[at].estimate?), b.at_most(b.quantiles[at].estimate?));
    let sum = |of: &[Cluster]| of.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.1, sum.1 + one.2));
    Some(lessened(correlation(&of_a, &of_b)?, sum(&of_a), sum(&of_b), (a.bad + b.bad) as f64))
}

fn half(cells: &[f64], rest: &Rest<'_>, alpha: f64) -> Half {
    let mut sorted: Vec<(f64, u32)> = Vec::with_capacity(rest.rows.len());
    let mut bad: Vec<u32> = Vec::new();
    let mut rows = Vec::with_capacity(rest.rows.len());
    for (at, &row) in rest.rows.iter().enumerate() {
        let cluster = rest.clusters.cluster(at);
        let number = if rest.clusters.of.is_empty() { rest.samples[row] } else { u64::from(cluster) };
        if !(rest.is_ok)(row) {
            bad.push(cluster);
            rows.push((number, None));
        } else if !cells[row].is_nan() {
            sorted.push((cells[row], cluster));
            rows.push((number, Some(cells[row])));
        }
    }
    // sorted once for all quantiles
    sorted.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let numbers: Vec<f64> = sorted.iter().map(|(number, _)| *number).collect();
    let mut clusters: Vec<u32> = sorted.iter().map(|(_, cluster)| *cluster).collect();
    let scheme = rest.clusters.narrowed(&mut clusters);
    let values = Values { point: clusters, low: numbers.clone(), high: numbers, bad: Bad::default(), empty: 0 };
    let of_mean = mean(&values, &scheme, |cluster| cluster, alpha);
    let count = bad.len() as u64;
    let known = sorted.iter().map(|(number, cluster)| (*number, *number, *cluster));
    let all = bad.iter().map(|cluster| (f64::NEG_INFINITY, f64::INFINITY, *cluster)).chain(known);
    let mut values = Values { bad: Bad { all: count, ..Bad::default() }, ..Values::default() };
    for (low, high, cluster) in all {
        values.low.push(low);
        values.high.push(high);
        values.point.push(cluster);
    }
    let scheme = rest.clusters.narrowed(&mut values.point);
    let quantiles = QUANTILES.map(|level| {
        let scheme = enough(&scheme, rest.clusters, values.low.len(), level);
        quantile(&values, level, &scheme, |cluster| cluster, alpha)
    });
    Half { mean: of_mean, bad: count, quantiles, rows }
}

/// With few values the limits would be those of independent rows; rows of one point are dependent, so no interval is given.
fn enough(scheme: &Scheme, clusters: &Clusters, rows: usize, level: f64) -> Scheme {
    match scheme {
        Scheme::Replicated(points) if clusters.are_points() => {
            let beyond = *points as f64 * level.min(1.0 - level);
            if beyond < FEW as f64 {
                let rows = rows.div_ceil((*points).max(1));
                let why =
                    format!("no interval: {points} points of about {rows} rows are too few for that of a quantile");
                return Scheme::Without(why);
            }
            scheme.clone()
        }
        other => other.clone(),
    }
}
