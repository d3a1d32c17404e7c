//! Places of the rows of a study on a map: axes, panels, and the recorded value of each row.

use super::{Axis, Frame, Of, REGIME, Wanted};
use crate::estimate::input::{Cells, DesignKind, Group, InputError, Label, Study};
use crate::estimate::known::{levels_at, truths_at};
use crate::estimate::truth::Truth;
use bladeoff_model::outcome::Status;
use std::collections::BTreeMap;

/// Largest and smallest number of raster places along an axis.
const MOST_PLACES: f64 = 40.0;
const FEWEST_PLACES: f64 = 8.0;

/// Largest number of values of an axis that are drawn value by value while the other axis is smoothed.
const MOST_SINGLE: usize = 20;
/// Smallest mean number of samples of such a value: for values that recur by chance, and for values given by the study (`[[vary]]`).
const EACH: usize = 4;
const EACH_VARIED: usize = 2;

/// Axes and panels of a map.
pub(super) struct Places {
    pub x: Axis,
    pub y: Axis,
    /// Whether both axes are drawn value by value.
    pub is_grid: bool,
    /// Whether each axis has its own values instead of a raster.
    pub single: (bool, bool),
    pub panels: Vec<(Group, Vec<usize>)>,
    /// Number of rows without a place.
    pub nowhere: u64,
}

/// Result of a run on a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Seen {
    Truth(Truth),
    /// Truths of both runs of a pair.
    Truths(Truth, Truth),
    /// Bounds of the value.
    Value(f64, f64),
    /// No value, because the event or quantity did not occur.
    Empty,
}

impl Seen {
    /// Whether a bad run leaves the event open.
    pub fn is_open(self) -> bool {
        match self {
            Self::Truth(a) => a == Truth::Open,
            Self::Truths(a, b) => a == Truth::Open || b == Truth::Open,
            Self::Value(..) | Self::Empty => false,
        }
    }
}

/// A run, or a pair of runs, on a map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub x: f64,
    pub y: f64,
    pub row: usize,
    pub status: Status,
    pub regime: Option<u32>,
    pub seen: Seen,
}

impl Item {
    /// Whether the run is not ok.
    pub fn is_bad(&self) -> bool {
        self.status != Status::Ok
    }

    /// Whether the run is beyond the model.
    pub fn is_beyond(&self) -> bool {
        self.status == Status::Beyond
    }
}

/// Status of a pair: if neither run is ok, that of the failed or invalid one.
pub(super) fn of_pair(a: Status, b: Status) -> Status {
    match (a, b) {
        (Status::Ok, other) | (Status::Beyond, other) if other != Status::Ok => other,
        _ => a,
    }
}

/// The runs of a panel.
#[derive(Debug, Clone, Default)]
pub(super) struct Items {
    pub list: Vec<Item>,
    pub unpaired: u64,
    pub empty: u64,
}

/// Names of the regimes, the worst last; empty if the study has no such column.
pub(super) fn regimes(study: &Study<'_>) -> Vec<String> {
    match study.column(REGIME).map(|column| column.cells) {
        Ok(Cells::Words(_, words)) => words.to_vec(),
        _ => Vec::new(),
    }
}

/// Number of each row's value of a column, and the distinct values.
pub(super) fn codes(study: &Study<'_>, column: &str) -> Result<(Vec<u32>, Vec<Label>), InputError> {
    let mut labels: Vec<Label> = Vec::new();
    let mut next = |label: Label| {
        labels.push(label);
        labels.len() as u32 - 1
    };
    let of_rows: Vec<u32> = match study.column(column)?.cells {
        Cells::Numbers(values, _) => {
            let mut known: BTreeMap<u64, u32> = BTreeMap::new();
            let numbers = values.iter().map(|value| value.unwrap_or(f64::NAN) + 0.0);
            numbers
                .map(|number| *known.entry(number.to_bits()).or_insert_with(|| next(Label::Number(number))))
                .collect()
        }
        Cells::Words(words, _) => {
            let mut known: BTreeMap<&str, u32> = BTreeMap::new();
            let words = words.iter().map(|word| word.as_deref().unwrap_or(""));
            words.map(|word| *known.entry(word).or_insert_with(|| next(Label::Word(word.to_owned())))).collect()
        }
    };
    Ok((of_rows, labels))
}

impl Places {
    pub fn of(study: &Study<'_>, wanted: &Wanted) -> Result<Self, InputError> {
        let (xs, _) = study.numbers(&wanted.x)?;
        let (ys, _) = study.numbers(&wanted.y)?;
        let is_there = |row: usize| [xs[row], ys[row]].iter().all(|value| value.is_some_and(f64::is_finite));
        let rows = study.status.len();
        let nowhere = (0..rows).filter(|row| !is_there(*row)).count() as u64;
        let distinct = |values: &[Option<f64>]| {
            let there = (0..rows).filter(|row| is_there(*row)).filter_map(|row| values[row]);
            let mut all: Vec<f64> = there.map(|value| value + 0.0).collect();
            all.sort_unstable_by(f64::total_cmp);
            all.dedup();
            all
        };
        let (all_x, all_y) = (distinct(xs), distinct(ys));
        let panels = panels(study, wanted, is_there)?;
        // at most as many combinations as points: each has some samples
        let few = all_x.len().saturating_mul(all_y.len()) <= study.points().max(1);
        let is_grid = wanted.is_grid || few;
        let most = panels.iter().map(|(_, rows)| rows.len()).max().unwrap_or(0);
        // a few values that recur are not smoothed over
        let has_few = |all: &[f64], each: usize| all.len() <= MOST_SINGLE && all.len() * each <= most;
        let single = match (has_few(&all_x, EACH), has_few(&all_y, EACH)) {
            _ if is_grid => (true, true),
            // given values become columns however few random samples each has
            _ if wanted.varied == (true, false) && has_few(&all_x, EACH_VARIED) => (true, false),
            _ if wanted.varied == (false, true) && has_few(&all_y, EACH_VARIED) => (false, true),
            (true, true) => (all_x.len() <= all_y.len(), all_y.len() < all_x.len()),
            single => single,
        };
        let axis = |column: &str, all: Vec<f64>, is_single: bool| -> Result<Axis, InputError> {
            let at = if is_single { all } else { raster(&all, most) };
            Ok(Axis { column: column.to_owned(), unit: study.column(column)?.unit.clone(), at })
        };
        Ok(Self {
            x: axis(&wanted.x, all_x, single.0)?,
            y: axis(&wanted.y, all_y, single.1)?,
            is_grid,
            single,
            panels,
            nowhere,
        })
    }
}

/// Midpoints of equal cells over the range of these values, for so many samples.
fn raster(all: &[f64], samples: usize) -> Vec<f64> {
    let (Some(first), Some(last)) = (all.first(), all.last()) else { return Vec::new() };
    let count = (2.0 * (samples as f64).sqrt()).clamp(FEWEST_PLACES, MOST_PLACES) as usize;
    (0..count).map(|k| first + (last - first) * (k as f64 + 0.5) / count as f64).collect()
}

/// Rows by the combination of the columns that have panels, in order of first occurrence.
fn panels(
    study: &Study<'_>,
    wanted: &Wanted,
    is_there: impl Fn(usize) -> bool,
) -> Result<Vec<(Group, Vec<usize>)>, InputError> {
    let columns: Vec<_> = wanted.panels.iter().map(|column| codes(study, column)).collect::<Result<_, _>>()?;
    let mut found: BTreeMap<Vec<u32>, Vec<usize>> = BTreeMap::new();
    let mut key = Vec::new();
    for row in (0..study.status.len()).filter(|row| is_there(*row)) {
        key.clear();
        key.extend(columns.iter().map(|(codes, _)| codes[row]));
        match found.get_mut(&key) {
            Some(rows) => rows.push(row),
            None => {
                found.insert(key.clone(), vec![row]);
            }
        }
    }
    let named = |key: Vec<u32>| {
        let labels = wanted.panels.iter().zip(&columns).zip(key);
        Group(labels.map(|((column, (_, labels)), code)| (column.clone(), labels[code as usize].clone())).collect())
    };
    Ok(found.into_iter().map(|(key, rows)| (named(key), rows)).collect())
}

/// Runs or pairs of these rows, with their results.
pub(super) fn items(frame: &Frame<'_>, rows: &[usize]) -> Result<Items, InputError> {
    let (study, wanted) = (frame.study, frame.wanted);
    let (xs, _) = study.numbers(&wanted.x)?;
    let (ys, _) = study.numbers(&wanted.y)?;
    let regime = regime_of(study, &frame.regimes);
    let item = |&row: &usize| Item {
        x: xs[row].unwrap_or(f64::NAN) + 0.0,
        y: ys[row].unwrap_or(f64::NAN) + 0.0,
        row,
        status: study.status[row],
        regime: regime(row),
        seen: Seen::Empty,
    };
    let mut found = Items { list: rows.iter().map(item).collect(), ..Items::default() };
    match &wanted.of {
        Of::Probability(formula) => {
            let truths = truths_at(study, formula, rows.iter().copied())?;
            for (item, truth) in found.list.iter_mut().zip(truths.of) {
                item.seen = Seen::Truth(truth);
            }
        }
        Of::Value(column) => {
            let values = levels_at(study, column, rows.iter().copied().enumerate())?;
            for (at, &place) in values.point.iter().enumerate() {
                found.list[place as usize].seen = Seen::Value(values.low[at], values.high[at]);
            }
            found.empty = values.empty;
        }
    }
    Ok(found)
}

/// Regime of an ok row, as its index among the names.
fn regime_of<'a>(study: &'a Study<'_>, words: &'a [String]) -> impl Fn(usize) -> Option<u32> + 'a {
    let cells = match study.column(REGIME).map(|column| column.cells) {
        Ok(Cells::Words(cells, _)) => Some(cells),
        _ => None,
    };
    move |row| {
        let word = cells?[row].as_deref().filter(|_| study.status[row] == Status::Ok)?;
        words.iter().position(|known| known == word).map(|at| at as u32)
    }
}

/// The most frequent regime; the worst of equally frequent ones.
pub(super) fn most_frequent(regimes: impl Iterator<Item = (u32, f64)>, words: &[String]) -> Option<String> {
    let mut weights = vec![0.0; words.len()];
    regimes.for_each(|(regime, weight)| weights[regime as usize] += weight);
    let most = (0..words.len()).filter(|at| weights[*at] > 0.0).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))?;
    Some(words[most].clone())
}

/// Number of a row among those that share their random inputs; 0 for rows of chosen values, which share none.
pub(super) fn point_of(study: &Study<'_>, row: usize) -> usize {
    if study.design.kind == DesignKind::Chosen { 0 } else { row / study.groups.len().max(1) }
}
