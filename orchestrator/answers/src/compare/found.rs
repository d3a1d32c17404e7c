//! Result of a comparison of two tables.

use super::circle;
use crate::estimate::figures::{Figures, Method};
use serde::ser::{Serialize, SerializeMap, Serializer};

/// Layout version of the JSON output.
pub const SCHEMA: u32 = 1;

/// Result of a comparison.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Compared {
    /// Layout version, [`SCHEMA`].
    pub schema: u32,
    /// The reference table.
    pub a: Sided,
    /// The table compared with A.
    pub b: Sided,
    /// Confidence level of each interval separately.
    pub confidence: f64,
    /// Provenance entries that differ between the tables.
    pub differs: Vec<Differs>,
    /// Inputs by which rows are matched.
    pub inputs: Vec<String>,
    /// Inputs ignored in the matching.
    pub ignored: Vec<String>,
    /// Results that only A has.
    pub only_in_a: Vec<String>,
    /// Results that only B has.
    pub only_in_b: Vec<String>,
    /// Results whose kind or unit differs between A and B.
    pub of_another_kind: Vec<String>,
    /// Counts of matched and unmatched rows.
    pub matched: Matched,
    /// Notes on the matching for the reader.
    pub notes: Vec<String>,
    /// Statuses of the pairs.
    pub status: Statuses,
    /// Differences of every numeric column, over pairs that are ok in both tables.
    pub paired: Vec<Difference>,
    /// Text columns that differ, over the same pairs.
    pub words: Vec<WordChange>,
    /// Differences of every numeric column between the unmatched rows, where both tables have some.
    pub apart: Vec<Apart>,
    /// Result of each tolerance.
    pub tolerances: Vec<Judged>,
    /// Whether any tolerance is exceeded; `None` without tolerances. The key keeps its name from schema 1.
    #[serde(rename = "beyond")]
    pub out_of_tolerance: Option<bool>,
}

/// One of the two tables.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Sided {
    /// Directory or file.
    pub name: String,
    /// Number of rows.
    pub rows: u64,
    /// Number of rows that are ok.
    pub ok: u64,
}

/// A provenance entry that differs; `None` where a table has no such entry.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Differs {
    /// Key of the entry.
    pub what: String,
    /// Value in A.
    pub a: Option<String>,
    /// Value in B.
    pub b: Option<String>,
}

/// Counts of matched and unmatched rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Matched {
    /// Number of pairs.
    pub pairs: u64,
    /// Pairs whose inputs occur in several rows of each table; these are matched in the order of samples.
    pub repeated: u64,
    /// Rows of A without partner.
    pub only_in_a: u64,
    /// Rows of B without partner.
    pub only_in_b: u64,
    /// Unmatched rows of A whose inputs occur in B a different number of times.
    pub unclear_in_a: u64,
    /// Unmatched rows of B whose inputs occur in A a different number of times.
    pub unclear_in_b: u64,
}

/// A pair of rows, with the inputs that identify it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Pair {
    /// Sample number in A.
    pub a: u64,
    /// Sample number in B.
    pub b: u64,
    /// Inputs in A; an ignored input also with its value in B.
    pub inputs: Inputs,
    /// Row indices in the two tables.
    #[serde(skip)]
    pub(super) rows: (usize, usize),
}

impl Pair {
    pub(super) fn new(rows: (usize, usize), samples: (u64, u64)) -> Self {
        Self { a: samples.0, b: samples.1, inputs: Inputs::default(), rows }
    }
}

/// Inputs by column, in the order of the columns; an ignored input has two values where the tables differ.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Inputs(pub Vec<(String, String)>);

impl Serialize for Inputs {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut map = out.serialize_map(Some(self.0.len()))?;
        for (column, value) in &self.0 {
            map.serialize_entry(column, value)?;
        }
        map.end()
    }
}

/// Statuses of the pairs.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Statuses {
    /// Pairs that are ok in both tables.
    pub ok: u64,
    /// Pairs that are not ok in either table, with the same cause. Only `guarded_` columns and `beyond_s` of these are compared.
    pub bad_alike: u64,
    /// Pairs whose status or cause differs.
    pub changed: u64,
    /// Changes of status, each with its pairs.
    pub changes: Vec<Change>,
}

/// A change of status.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Change {
    /// Verdict in A: "ok", or status and cause.
    pub from: String,
    /// Verdict in B.
    pub to: String,
    /// Number of pairs.
    pub count: u64,
    /// The first pairs of this change.
    pub pairs: Vec<Pair>,
}

/// An estimate with its interval.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Estimate.
    pub estimate: Option<f64>,
    /// Lower limit.
    pub low: Option<f64>,
    /// Upper limit.
    pub high: Option<f64>,
    /// Method of the interval.
    pub method: Method,
    /// Whether the interval holds asymptotically (many points) instead of exactly.
    pub approximate: bool,
    /// Reservations and remarks for the reader.
    pub notes: Vec<String>,
}

impl Interval {
    pub(super) fn of(found: Figures) -> Self {
        let has_limit = found.low.is_some() || found.high.is_some();
        Self {
            estimate: found.estimate,
            low: found.low,
            high: found.high,
            method: if has_limit { found.method } else { Method::Without },
            approximate: has_limit && found.approximate,
            notes: found.notes,
        }
    }
}

/// Difference B - A of a numeric column.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Name of the column.
    pub column: String,
    /// SI unit.
    pub unit: String,
    /// Pairs with a value in both.
    pub pairs: u64,
    /// Pairs with a value in both tables and without a difference.
    pub same: u64,
    /// Pairs without a value in either table.
    pub empty: u64,
    /// Pairs with a value only in A.
    pub only_in_a: u64,
    /// Pairs with a value only in B.
    pub only_in_b: u64,
    /// Mean of A over the pairs with a value in both tables.
    pub mean_a: Option<f64>,
    /// Mean of B over the same pairs.
    pub mean_b: Option<f64>,
    /// Mean of B - A.
    pub mean: Interval,
    /// Largest |B - A| divided by the root mean square of A, for angles divided by pi; `None` where all A are 0 or nothing differs.
    pub relative: Option<f64>,
    /// The pairs with the largest differences, in descending order.
    pub largest_changes: Vec<PairChange>,
    /// The first pairs with a value in only one table.
    pub one_sided: Vec<PairChange>,
}

/// A pair and its two values.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PairChange {
    /// Rows and inputs of the pair.
    #[serde(flatten)]
    pub pair: Pair,
    /// Value in A.
    pub value_a: Option<f64>,
    /// Value in B.
    pub value_b: Option<f64>,
}

impl PairChange {
    /// B - A in the unit of the column; for angles along the shorter arc.
    #[must_use]
    pub fn difference(&self, unit: &str) -> Option<f64> {
        Some(circle::difference(unit, self.value_a?, self.value_b?))
    }
}

/// A text column with differences.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct WordChange {
    /// Name of the column.
    pub column: String,
    /// Old value, new value (null: missing) and number of pairs, the most frequent first.
    pub changes: Vec<(Option<String>, Option<String>, u64)>,
    /// Number of pairs that differ.
    pub changed: u64,
    /// The first pair that differs.
    pub first: Option<Pair>,
}

/// The unmatched rows of A and of B, compared as two samples of a column.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Apart {
    /// Name of the column.
    pub column: String,
    /// SI unit.
    pub unit: String,
    /// Unmatched rows of A that are ok and have a value.
    pub values_a: u64,
    /// Unmatched rows of B that are ok and have a value.
    pub values_b: u64,
    /// Unmatched rows of A that are not ok.
    pub bad_a: u64,
    /// Unmatched rows of B that are not ok.
    pub bad_b: u64,
    /// Mean over the ok rows of A.
    pub mean_a: Option<f64>,
    /// Mean over the ok rows of B.
    pub mean_b: Option<f64>,
    /// Mean of B - mean of A.
    pub mean: Interval,
    /// Differences of quantiles; the intervals cover any value of the bad rows.
    pub quantiles: Vec<QuantileApart>,
}

/// A difference of quantiles.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct QuantileApart {
    /// Level of the quantile, between 0 and 1.
    pub quantile: f64,
    /// Quantile of A.
    pub a: Option<f64>,
    /// Quantile of B.
    pub b: Option<f64>,
    /// Quantile of B - quantile of A.
    pub difference: Interval,
}

/// A tolerance and the pairs that exceed it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Judged {
    /// The tolerance as entered.
    pub tolerance: String,
    /// Name of the column.
    pub column: String,
    /// Pairs compared: those with a value in both tables.
    pub compared: u64,
    /// Pairs that exceed the tolerance. The key keeps its name from schema 1.
    #[serde(rename = "beyond")]
    pub out: u64,
    /// Pairs with a value in only one table: not compared, counted as exceeding the tolerance.
    pub one_sided: u64,
    /// Pairs without a value in either table: not compared.
    pub empty: u64,
    /// First pair with a value in only one table.
    pub first_one_sided: Option<Pair>,
    /// First pair without a value in either table.
    pub first_empty: Option<Pair>,
    /// The pair with the largest ratio of difference to tolerance.
    pub worst: Option<PairChange>,
}

impl Judged {
    /// The pairs that this result refers to.
    pub(super) fn pairs(&mut self) -> impl Iterator<Item = &mut Pair> {
        let worst = self.worst.iter_mut().map(|worst| &mut worst.pair);
        worst.chain(&mut self.first_one_sided).chain(&mut self.first_empty)
    }

    /// Whether pairs were compared and all are within the tolerance.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.compared > 0 && self.out == 0 && self.one_sided == 0
    }
}
