//! Result of a comparison of two tables.

use super::circle;
use crate::estimate::figures::{Figures, Method};
use serde::ser::{Serialize, SerializeMap, Serializer};

/// Version of the JSON.
pub const SCHEMA: u32 = 1;

/// All of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Compared {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The reference.
    pub a: Sided,
    /// What is held against it.
    pub b: Sided,
    /// Of every interval, each for itself.
    pub confidence: f64,
    /// What the two say of where they come from, where that differs.
    pub differs: Vec<Differs>,
    /// Inputs that rows match by.
    pub inputs: Vec<String>,
    /// Inputs that they do not.
    pub ignored: Vec<String>,
    /// Results that A alone has.
    pub only_in_a: Vec<String>,
    /// Results that B alone has.
    pub only_in_b: Vec<String>,
    /// Results that hold something else in A than in B.
    pub of_another_kind: Vec<String>,
    /// Rows and their partners.
    pub matched: Matched,
    /// What a reader has to know of the matching.
    pub notes: Vec<String>,
    /// Statuses of the pairs.
    pub status: Statuses,
    /// Of each column of numbers, over pairs that are ok in both.
    pub paired: Vec<Difference>,
    /// Columns of words that differ, over the same pairs.
    pub words: Vec<WordChange>,
    /// Of each column of numbers, over the rows without partner, where both have some.
    pub apart: Vec<Apart>,
    /// Each tolerance.
    pub tolerances: Vec<Judged>,
    /// Whether anything is out of tolerance; `None` without tolerances. Its key keeps the name that it has in schema 1.
    #[serde(rename = "beyond")]
    pub out_of_tolerance: Option<bool>,
}

/// One of both.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Sided {
    /// Its directory or file.
    pub name: String,
    /// Rows.
    pub rows: u64,
    /// Rows that are ok.
    pub ok: u64,
}

/// Something that differs; `None`: not told.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Differs {
    /// What.
    pub what: String,
    /// In A.
    pub a: Option<String>,
    /// In B.
    pub b: Option<String>,
}

/// Rows and their partners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Matched {
    /// Pairs.
    pub pairs: u64,
    /// Pairs of inputs that several rows of each have, matched in the order of samples.
    pub repeated: u64,
    /// Rows of A without partner.
    pub only_in_a: u64,
    /// Rows of B without partner.
    pub only_in_b: u64,
    /// Of those of A: B has their inputs another number of times.
    pub unclear_in_a: u64,
    /// Of those of B.
    pub unclear_in_b: u64,
}

/// A pair, with what finds it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Pair {
    /// Number of the sample in A.
    pub a: u64,
    /// In B.
    pub b: u64,
    /// Its inputs in A; one that is ignored also with its value in B.
    pub inputs: Inputs,
    /// Places in the tables.
    #[serde(skip)]
    pub(super) rows: (usize, usize),
}

impl Pair {
    pub(super) fn new(rows: (usize, usize), samples: (u64, u64)) -> Self {
        Self { a: samples.0, b: samples.1, inputs: Inputs::default(), rows }
    }
}

/// Inputs by column, in the order of the columns; of an ignored one two values where they differ.
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

/// What became of the pairs.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Statuses {
    /// Pairs that are ok in both.
    pub ok: u64,
    /// Pairs that are not ok in both, for the same cause: `guarded_` columns and `beyond_s` alone are compared.
    pub bad_alike: u64,
    /// Pairs whose status or cause is another one.
    pub changed: u64,
    /// From what to what.
    pub changes: Vec<Change>,
}

/// A change of status.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Change {
    /// In A: "ok", or status and cause.
    pub from: String,
    /// In B.
    pub to: String,
    /// Pairs.
    pub count: u64,
    /// The first of them.
    pub pairs: Vec<Pair>,
}

/// A number with its interval.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Interval {
    /// The number.
    pub estimate: Option<f64>,
    /// Lower limit.
    pub low: Option<f64>,
    /// Upper limit.
    pub high: Option<f64>,
    /// How the limits were made.
    pub method: Method,
    /// They hold in the limit of many points.
    pub approximate: bool,
    /// What a reader has to know.
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

/// How far a column moved, B - A.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Difference {
    /// The column.
    pub column: String,
    /// Its SI unit.
    pub unit: String,
    /// Pairs with a value in both.
    pub pairs: u64,
    /// Of those, pairs without a difference.
    pub same: u64,
    /// Pairs that have no value in either.
    pub empty: u64,
    /// Pairs with a value in A alone.
    pub only_in_a: u64,
    /// Pairs with a value in B alone.
    pub only_in_b: u64,
    /// Mean of A over the pairs with a value in both.
    pub mean_a: Option<f64>,
    /// Mean of B.
    pub mean_b: Option<f64>,
    /// Mean of B - A.
    pub mean: Interval,
    /// Largest |B - A| over the root mean square of A, of angles over half a turn; `None` where all A are 0 or nothing moved.
    pub relative: Option<f64>,
    /// The pairs that moved farthest, the farthest first.
    pub largest_changes: Vec<PairChange>,
    /// The first pairs with a value in one alone.
    pub one_sided: Vec<PairChange>,
}

/// A pair and its two values.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PairChange {
    /// The pair.
    #[serde(flatten)]
    pub pair: Pair,
    /// Value in A.
    pub value_a: Option<f64>,
    /// Value in B.
    pub value_b: Option<f64>,
}

impl PairChange {
    /// B - A, in the unit of the column; of angles the short way round.
    #[must_use]
    pub fn difference(&self, unit: &str) -> Option<f64> {
        Some(circle::difference(unit, self.value_a?, self.value_b?))
    }
}

/// A column of words of which some differ.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct WordChange {
    /// The column.
    pub column: String,
    /// From what to what (null: none) in how many pairs, the most frequent first.
    pub changes: Vec<(Option<String>, Option<String>, u64)>,
    /// Pairs that differ.
    pub changed: u64,
    /// The first one.
    pub first: Option<Pair>,
}

/// Two samples of a column: the rows of A and those of B that have no partner.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Apart {
    /// The column.
    pub column: String,
    /// Its SI unit.
    pub unit: String,
    /// Rows of A that are ok and have a value.
    pub values_a: u64,
    /// Of B.
    pub values_b: u64,
    /// Rows of A that are not ok.
    pub bad_a: u64,
    /// Of B.
    pub bad_b: u64,
    /// Mean of A over rows that are ok.
    pub mean_a: Option<f64>,
    /// Of B.
    pub mean_b: Option<f64>,
    /// Mean of B less mean of A.
    pub mean: Interval,
    /// Differences of quantiles, bad rows counted both ways.
    pub quantiles: Vec<QuantileApart>,
}

/// A difference of quantiles.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct QuantileApart {
    /// Which one.
    pub quantile: f64,
    /// Of A.
    pub a: Option<f64>,
    /// Of B.
    pub b: Option<f64>,
    /// Of B less of A.
    pub difference: Interval,
}

/// A tolerance and the pairs out of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Judged {
    /// As written.
    pub tolerance: String,
    /// Its column.
    pub column: String,
    /// Pairs that were compared: those with a value in both.
    pub compared: u64,
    /// Pairs out of tolerance. The key keeps the name that it has in schema 1.
    #[serde(rename = "beyond")]
    pub out: u64,
    /// Pairs with a value in one alone: not compared, out of tolerance.
    pub one_sided: u64,
    /// Pairs without a value in either: not compared.
    pub empty: u64,
    /// First pair with a value in one alone.
    pub first_one_sided: Option<Pair>,
    /// First pair without a value in either.
    pub first_empty: Option<Pair>,
    /// The pair that exceeds it most, or that is nearest to it.
    pub worst: Option<PairChange>,
}

impl Judged {
    /// The pairs that it names.
    pub(super) fn pairs(&mut self) -> impl Iterator<Item = &mut Pair> {
        let worst = self.worst.iter_mut().map(|worst| &mut worst.pair);
        worst.chain(&mut self.first_one_sided).chain(&mut self.first_empty)
    }

    /// Whether pairs were compared and all are within.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.compared > 0 && self.out == 0 && self.one_sided == 0
    }
}
