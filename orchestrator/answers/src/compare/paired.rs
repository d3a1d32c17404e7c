//! Differences of a column over pairs that are ok in both tables, and tolerances on them. Columns with values before a guard or limit was
//! exceeded ([`is_reached`]) are also compared over pairs with the same other status.
//!
//! ```text
//! d = B - A,   mean d with Student's t over pairs, over points where a point has several pairs, or over replicates
//! ```

use super::circle::{self, is_angle};
use super::draw::Clusters;
use super::found::{Difference, Interval, Judged, Pair, PairChange, WordChange};
use super::load::Words;
use super::tolerance::Tolerance;
use crate::ask::CONFIDENCE;
use crate::estimate::figures::{Sum, finite};
use crate::estimate::known::Values;
use crate::estimate::mean::mean;
use crate::tables::ColumnHead;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Largest number of pairs listed as largest differences, or with a value in only one table.
const SHOWN: usize = 5;
/// Largest number of word changes listed.
const MOST_CHANGES: usize = 20;

/// Pairs of rows to compare.
pub(super) struct Pairs<'a> {
    /// Row indices in A and B.
    pub rows: &'a [(usize, usize)],
    /// Sample numbers of all rows of A and of B.
    pub samples: (&'a [u64], &'a [u64]),
    /// Dependence between the pairs.
    pub clusters: &'a Clusters,
}

impl Pairs<'_> {
    fn pair(&self, at: usize) -> Pair {
        let (a, b) = self.rows[at];
        Pair::new((a, b), (self.samples.0[a], self.samples.1[b]))
    }

    fn change(&self, at: usize, a: f64, b: f64) -> PairChange {
        let value = |value: f64| (!value.is_nan()).then_some(value);
        PairChange { pair: self.pair(at), value_a: value(a), value_b: value(b) }
    }
}

/// Whether a column also has values in rows that are not ok: values before a guard or limit was exceeded, and the time of a limit.
pub(super) fn is_reached(column: &str) -> bool {
    column.starts_with("guarded_") || column == "beyond_s"
}

/// The pairs with the largest values of a measure; the first of equal ones.
#[derive(Default)]
struct Farthest(Vec<(f64, usize)>);

impl Farthest {
    fn see(&mut self, how_far: f64, at: usize, most: usize) {
        if self.0.len() == most && self.0.last().is_some_and(|(least, _)| how_far <= *least) {
            return;
        }
        let place = self.0.partition_point(|(other, _)| *other >= how_far);
        self.0.insert(place, (how_far, at));
        self.0.truncate(most);
    }
}

/// Difference of a numeric column; NaN is a missing value.
pub(super) fn difference(head: &ColumnHead, a: &[f64], b: &[f64], pairs: &Pairs<'_>) -> Difference {
    let mut values = Values::default();
    let (mut same, mut empty, mut only_in_a, mut only_in_b) = (0, 0, 0, 0);
    let (mut mean_a, mut mean_b, mut squares) = (circle::Mean::default(), circle::Mean::default(), Sum::default());
    let (mut farthest, mut one_sided) = (Farthest::default(), Vec::new());
    for (at, &(row_a, row_b)) in pairs.rows.iter().enumerate() {
        let (of_a, of_b) = (a[row_a], b[row_b]);
        if of_a.is_nan() || of_b.is_nan() {
            empty += u64::from(of_a.is_nan() && of_b.is_nan());
            only_in_a += u64::from(!of_a.is_nan());
            only_in_b += u64::from(!of_b.is_nan());
            if of_a.is_nan() != of_b.is_nan() && one_sided.len() < SHOWN {
                one_sided.push(pairs.change(at, of_a, of_b));
            }
            continue;
        }
        let moved = circle::difference(&head.unit, of_a, of_b);
        same += u64::from(moved == 0.0);
        if moved != 0.0 {
            farthest.see(moved.abs(), at, SHOWN);
        }
        mean_a.add(&head.unit, of_a);
        mean_b.add(&head.unit, of_b);
        squares.add(of_a * of_a);
        values.point.push(pairs.clusters.cluster(at));
        values.low.push(moved);
    }
    values.high = values.low.clone();
    let count = values.low.len() as f64;
    let scheme = pairs.clusters.narrowed(&mut values.point);
    let found = mean(&values, &scheme, |cluster| cluster, 1.0 - CONFIDENCE);
    let largest = farthest.0.first().map(|(moved, _)| *moved);
    // angles have no root mean square: half a turn is the largest difference
    let size = if is_angle(&head.unit) { PI } else { libm::sqrt(squares.value() / count) };
    let largest_changes = farthest.0.iter().map(|&(_, at)| {
        let (row_a, row_b) = pairs.rows[at];
        pairs.change(at, a[row_a], b[row_b])
    });
    Difference {
        column: head.name.clone(),
        unit: head.unit.clone(),
        pairs: values.low.len() as u64,
        same,
        empty,
        only_in_a,
        only_in_b,
        mean_a: finite(mean_a.value(&head.unit)),
        mean_b: finite(mean_b.value(&head.unit)),
        mean: Interval::of(found),
        relative: largest.and_then(|largest| finite(largest / size)),
        largest_changes: largest_changes.collect(),
        one_sided,
    }
}

/// Checks the tolerance of a column.
pub(super) fn judge(tolerance: &Tolerance, a: &[f64], b: &[f64], pairs: &Pairs<'_>) -> Judged {
    let (mut compared, mut out, mut one_sided, mut empty) = (0, 0, 0, 0);
    let (mut first_one_sided, mut first_empty) = (None, None);
    let mut farthest = Farthest::default();
    for (at, &(row_a, row_b)) in pairs.rows.iter().enumerate() {
        let (of_a, of_b) = (a[row_a], b[row_b]);
        match (of_a.is_nan(), of_b.is_nan()) {
            (true, true) => {
                empty += 1;
                first_empty.get_or_insert_with(|| pairs.pair(at));
            }
            (false, false) => {
                compared += 1;
                let (is_within, how_far) = tolerance.judge(of_a, of_b);
                out += u64::from(!is_within);
                farthest.see(how_far, at, 1);
            }
            _ => {
                one_sided += 1;
                first_one_sided.get_or_insert_with(|| pairs.pair(at));
            }
        }
    }
    let worst = farthest.0.first().map(|&(_, at)| {
        let (row_a, row_b) = pairs.rows[at];
        pairs.change(at, a[row_a], b[row_b])
    });
    let (text, column) = (tolerance.text.clone(), tolerance.column.clone());
    Judged { tolerance: text, column, compared, out, one_sided, empty, first_one_sided, first_empty, worst }
}

/// Changes of a text column; `None` without changes.
pub(super) fn words(head: &ColumnHead, a: &[u32], b: &[u32], pairs: &Pairs<'_>, words: &Words) -> Option<WordChange> {
    let mut counts: BTreeMap<(u32, u32), u64> = BTreeMap::new();
    let mut first = None;
    for (at, &(row_a, row_b)) in pairs.rows.iter().enumerate() {
        if a[row_a] != b[row_b] {
            *counts.entry((a[row_a], b[row_b])).or_default() += 1;
            first = first.or(Some(at));
        }
    }
    let first = pairs.pair(first?);
    let word = |number: u32| words.word(number).map(str::to_owned);
    let mut changes: Vec<_> = counts.iter().map(|(&(a, b), &count)| (word(a), word(b), count)).collect();
    changes.sort_by(|x, y| (y.2, &x.0, &x.1).cmp(&(x.2, &y.0, &y.1)));
    changes.truncate(MOST_CHANGES);
    Some(WordChange { column: head.name.clone(), changes, changed: counts.values().sum(), first: Some(first) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::draw::Draw;
    use crate::estimate::scheme::Scheme;
    use crate::tables::HeadKind;

    fn head() -> ColumnHead {
        ColumnHead { name: "g".into(), unit: String::new(), kind: HeadKind::Numbers }
    }

    #[test]
    fn empty_cells_are_no_zeros_and_movers_are_the_farthest() {
        let none = f64::NAN;
        let (a, b) = ([1.0, none, none, 4.0, 0.0, 7.0], [1.0, none, 3.0, none, -2.0, 7.5]);
        let (rows, samples): (Vec<_>, Vec<u64>) = ((0..6).map(|row| (row, row)).collect(), (0..6).collect());
        let clusters = Draw::whole(Scheme::Independent, 1, vec![0; 6]).clusters(samples.iter().copied());
        let pairs = Pairs { rows: &rows, samples: (&samples, &samples), clusters: &clusters };
        let found = difference(&head(), &a, &b, &pairs);
        assert_eq!((found.pairs, found.same, found.empty, found.only_in_a, found.only_in_b), (3, 1, 1, 1, 1));
        assert_eq!(found.mean.estimate, Some(-0.5));
        let largest_changes: Vec<(u64, Option<f64>)> =
            found.largest_changes.iter().map(|one| (one.pair.a, one.difference(""))).collect();
        assert_eq!(largest_changes, [(4, Some(-2.0)), (5, Some(0.5))]);
        let sided: Vec<u64> = found.one_sided.iter().map(|one| one.pair.a).collect();
        assert_eq!(sided, [2, 3]);
        // mean -0.5, sd sqrt(7/4) of 3 values; t of two degrees of freedom in closed form
        let half = 0.95 * libm::sqrt(2.0 / (4.0 * 0.975 * 0.025)) * libm::sqrt(1.75 / 3.0);
        let (low, high) = (found.mean.low.expect("three"), found.mean.high.expect("three"));
        assert!((low + 0.5 + half).abs() < 1e-12 && (high + 0.5 - half).abs() < 1e-12, "{low} {high} {half}");
    }

    #[test]
    fn angles_are_compared_on_the_circle() {
        let (a, b) = ([3.1, -3.0, 1.0], [-3.1, 3.1, 1.0]);
        let (rows, samples): (Vec<_>, Vec<u64>) = ((0..3).map(|row| (row, row)).collect(), (0..3).collect());
        let clusters = Draw::whole(Scheme::Independent, 1, vec![0; 3]).clusters(samples.iter().copied());
        let pairs = Pairs { rows: &rows, samples: (&samples, &samples), clusters: &clusters };
        let found = difference(&ColumnHead { unit: "rad".into(), ..head() }, &a, &b, &pairs);
        let movers: Vec<(u64, f64)> =
            found.largest_changes.iter().map(|one| (one.pair.a, one.difference("rad").expect("both"))).collect();
        let turn = std::f64::consts::TAU;
        assert_eq!(movers.iter().map(|one| one.0).collect::<Vec<_>>(), [1, 0]);
        assert!((movers[0].1 + turn - 6.1).abs() < 1e-12 && (movers[1].1 - turn + 6.2).abs() < 1e-12, "{movers:?}");
        assert!((found.mean.estimate.expect("three") + 0.1 / 3.0).abs() < 1e-12, "{:?}", found.mean);
        assert!((found.relative.expect("moved") - (turn - 6.1) / PI).abs() < 1e-12);
    }

    #[test]
    fn rows_of_one_point_are_not_counted_as_several() {
        // the same difference in both rows of a point: the second row adds no information
        let (a, b) = ([0.0; 6], [1.0, 1.0, 2.0, 2.0, 6.0, 6.0]);
        let (rows, samples): (Vec<_>, Vec<u64>) = ((0..6).map(|row| (row, row)).collect(), (0..6).collect());
        let clusters = Draw::whole(Scheme::Independent, 2, vec![0; 3]).clusters(samples.iter().copied());
        let found =
            difference(&head(), &a, &b, &Pairs { rows: &rows, samples: (&samples, &samples), clusters: &clusters });
        let half = 4.302_652_729_696_142 * libm::sqrt(7.0 / 3.0);
        assert!((found.mean.high.expect("three points") - 3.0 - half).abs() < 1e-9, "{:?}", found.mean);
    }
}
