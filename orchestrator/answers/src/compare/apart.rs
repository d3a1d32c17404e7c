//! Rows that have no partner, as two samples: differences of means and of quantiles, B less A.
//!
//! The limits of A and of B hold with 1 - alpha/2 each, so that the difference of one's upper and the other's lower limit holds with
//! 1 - alpha however A and B depend on one another: two studies with one seed are drawn from the same numbers. Means are those of rows that
//! are ok; quantiles count a bad row as anything at all.

use super::draw::Clusters;
use super::found::{Apart, Interval, QuantileApart};
use crate::ask::CONFIDENCE;
use crate::estimate::bad::Bad;
use crate::estimate::difference::of_two;
use crate::estimate::figures::Figures;
use crate::estimate::known::Values;
use crate::estimate::mean::mean;
use crate::estimate::quantile::quantile;
use crate::estimate::scheme::{FEW, Scheme};
use crate::tables::ColumnHead;

/// Quantiles that are told.
const QUANTILES: [f64; 2] = [0.5, 0.95];

/// Rows of one table that have no partner.
pub(super) struct Rest<'a> {
    /// The rows.
    pub rows: &'a [usize],
    /// Whether each row of the table is ok.
    pub is_ok: &'a dyn Fn(usize) -> bool,
    /// What depends on what.
    pub clusters: &'a Clusters,
}

/// Values of a rest.
struct Half {
    mean: Figures,
    bad: u64,
    quantiles: [Figures; QUANTILES.len()],
}

/// A column of numbers in both; NaN is none.
pub(super) fn apart(head: &ColumnHead, a: (&[f64], &Rest<'_>), b: (&[f64], &Rest<'_>)) -> Apart {
    let (of_a, of_b) = (half(a.0, a.1), half(b.0, b.1));
    let quantiles = QUANTILES.iter().zip(of_a.quantiles.iter().zip(&of_b.quantiles)).map(|(&level, (a, b))| {
        QuantileApart { quantile: level, a: a.estimate, b: b.estimate, difference: Interval::of(of_two(b, a)) }
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
        mean: Interval::of(of_two(&of_b.mean, &of_a.mean)),
        quantiles: quantiles.collect(),
    }
}

fn half(cells: &[f64], rest: &Rest<'_>) -> Half {
    let mut sorted: Vec<(f64, u32)> = Vec::with_capacity(rest.rows.len());
    let mut bad: Vec<u32> = Vec::new();
    for (at, &row) in rest.rows.iter().enumerate() {
        let cluster = rest.clusters.cluster(at);
        if !(rest.is_ok)(row) {
            bad.push(cluster);
        } else if !cells[row].is_nan() {
            sorted.push((cells[row], cluster));
        }
    }
    // once here, so that no quantile has to
    sorted.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let alpha = 0.5 * (1.0 - CONFIDENCE);
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
    Half { mean: of_mean, bad: count, quantiles }
}

/// Limits of few values are those of as many independent ones, which rows of one point are not.
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
