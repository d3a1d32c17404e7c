//! Rows of a report, from one pass over a table of any length.
//!
//! Rows are thinned by a hash of the sample number: those with the smallest hashes are kept, so the selection does not depend on the order of
//! rows. Rows that are not ok are thinned by cause, so that rare causes are complete.

use crate::run::{Availability, TableColumn};
use bladeoff_answers::figures::plain_name;
use bladeoff_answers::tables::{DETECTION, FieldKind, Table, TableError};
use bladeoff_study::{Origin, Parameter, Samples};
use std::collections::{BTreeMap, BinaryHeap};
use std::path::PathBuf;

/// Largest number of ok rows shown, and of rows of each cause.
const MOST_GOOD: usize = 3000;
const MOST_OF_CAUSE: usize = 400;
/// Largest number of parameters and of results with an axis of their own.
const MOST_PARAMETERS: usize = 9;
const MOST_RESULTS: usize = 4;
/// Largest number of results of questions and gates.
const MOST_ASKED: usize = 12;
/// Length of a list of the worst runs.
const WORST: usize = 5;
/// Results of a machine's table that are shown by default.
const FIRST: [&str; 4] =
    ["max_bearing_load_N", "max_filtered_contact_force_N", "max_eccentricity_m", "friction_energy_J"];

/// Status and cause; an ok row has no cause.
pub(super) type Kind = (String, String);

/// A column shown on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordinate {
    /// Column name in the table.
    pub column: String,
    /// Name for the reader.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Whether the cells are words.
    pub is_word: bool,
    /// Whether the column is a result.
    pub is_result: bool,
    /// Value that a run which is not ok has in this column.
    pub held: Held,
}

/// Value that the row of a run which is not ok has in a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Held {
    /// Value before a guard or limit was exceeded, from the column of this name.
    Reached(String),
    /// Time of a first event, valid if a step limit or a limit of the model ended the run.
    Once,
    /// No value.
    Nothing,
}

impl Held {
    fn of(availability: &Availability) -> Self {
        match availability {
            Availability::LowerBound(Some(column)) => Self::Reached(column.clone()),
            Availability::EventTime(Some(column)) | Availability::LimitTime(Some(column)) => {
                Self::Reached(column.clone())
            }
            Availability::EventTime(None) | Availability::LimitTime(None) => Self::Once,
            _ => Self::Nothing,
        }
    }
}

/// A row shown in the report.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Picked {
    pub sample: u64,
    /// Index of its kind in [`Seen::kinds`].
    pub kind: usize,
    /// Values by coordinate; words as indices into [`Seen::words`].
    pub values: Vec<Option<f64>>,
}

/// Count of the rows of one kind.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OfKind {
    pub kind: Kind,
    pub count: u64,
    /// Smallest sample number.
    pub first: u64,
}

/// An entry of a list of the worst rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Extreme {
    /// Value by which the list is sorted: for a row that is not ok, the value before a guard or limit was exceeded.
    pub value: f64,
    pub sample: u64,
    /// Status and cause.
    pub kind: Kind,
    /// Value in the result's own column.
    pub recorded: Option<f64>,
}

/// Rows at one end of a result: rows of all statuses, and the first ok row.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct End {
    pub all: Vec<Extreme>,
    pub ok: Option<Extreme>,
}

/// Rows with the largest and the smallest values of a result.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Ends {
    pub largest: End,
    pub least: End,
    /// The row that is not ok with the largest value in the result's own column, which may be invalid.
    pub recorded: Option<Extreme>,
    /// Number of rows that are not ok and have no value to sort by.
    pub unknown: u64,
}

/// Runs by status.
pub(super) type ByStatus = BTreeMap<String, u64>;

/// Contents of a table for the report.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Seen {
    pub coordinates: Vec<Coordinate>,
    /// Distinct words of each coordinate, sorted.
    pub words: Vec<Vec<String>>,
    pub rows: u64,
    /// Kinds of rows: ok first, then by status and cause.
    pub kinds: Vec<OfKind>,
    /// Rows shown, in the order of samples.
    pub picked: Vec<Picked>,
    /// Extreme rows by coordinate; empty except for results.
    pub ends: Vec<Ends>,
    /// Counts by column of words among the results, detection, word and status. Rows that are not ok count with the word "", too.
    pub regimes: BTreeMap<(String, String, String), ByStatus>,
}

impl Seen {
    /// Number of ok rows.
    pub fn ok(&self) -> u64 {
        self.kinds.iter().filter(|kind| kind.kind.0 == "ok").map(|kind| kind.count).sum()
    }
}

/// Columns to show: parameters that vary, results in `asked`, and the main results.
pub(super) fn coordinates(samples: &Samples, columns: &[TableColumn], asked: &[String]) -> Vec<Coordinate> {
    let column_of = |parameter: &Parameter| {
        if parameter.is_detection() { DETECTION.to_owned() } else { parameter.column().name }
    };
    let order = |parameter: &&Parameter| match parameter.origin {
        Origin::Uncertain(_) => 0,
        Origin::Varied(..) => 1,
        Origin::Derived(_) => 2,
    };
    let mut parameters: Vec<&Parameter> = samples.parameters().iter().collect();
    parameters.sort_by_key(order);
    let given = parameters.into_iter().take(MOST_PARAMETERS).map(|parameter| Coordinate {
        column: column_of(parameter),
        name: parameter.short.clone().unwrap_or_else(|| ending(&parameter.info.path)),
        unit: if parameter.has_words { String::new() } else { parameter.info.unit.to_owned() },
        is_word: parameter.has_words || parameter.is_detection(),
        is_result: false,
        held: Held::Nothing,
    });
    let mut all: Vec<Coordinate> = given.collect();
    let is_result = |column: &TableColumn| {
        column.availability != Availability::Input && matches!(column.field.kind, FieldKind::Real | FieldKind::Count)
    };
    let results: Vec<&TableColumn> = columns.iter().filter(|column| is_result(column)).collect();
    let is_function = samples.study().function().is_some();
    let first =
        results.iter().map(|column| column.field.name.as_str()).filter(|name| is_function || FIRST.contains(name));
    let mut wanted: Vec<&str> = asked.iter().map(String::as_str).collect();
    first.for_each(|name| {
        if !wanted.contains(&name) {
            wanted.push(name)
        }
    });
    let found = wanted.iter().filter_map(|name| results.iter().find(|column| column.field.name == *name));
    all.extend(found.take(asked.len().clamp(MOST_RESULTS, MOST_ASKED)).map(|column| Coordinate {
        column: column.field.name.clone(),
        name: plain_name(&column.field.name, &column.field.unit),
        unit: column.field.unit.clone(),
        is_word: false,
        is_result: true,
        held: Held::of(&column.availability),
    }));
    all
}

/// The last two parts of a path: "contact.gap" of "diaphragms.seal.contact.gap".
fn ending(path: &str) -> String {
    let parts: Vec<&str> = path.split('.').collect();
    parts[parts.len().saturating_sub(2)..].join(".")
}

/// Reads the rows of these files.
pub(super) fn read(
    files: &[PathBuf],
    coordinates: Vec<Coordinate>,
    columns: &[TableColumn],
) -> Result<Seen, TableError> {
    let is_regime = |column: &&TableColumn| {
        column.availability != Availability::Input && matches!(column.field.kind, FieldKind::Choice(_))
    };
    let regimes: Vec<&str> = columns.iter().filter(is_regime).map(|column| column.field.name.as_str()).collect();
    let has_detection = columns.iter().any(|column| column.field.name == DETECTION);
    let mut names: Vec<&str> = vec!["sample", "status", "cause"];
    let others = coordinates.iter().map(|coordinate| coordinate.column.as_str()).chain(regimes.iter().copied());
    let held = coordinates.iter().filter_map(|coordinate| match &coordinate.held {
        Held::Reached(column) => Some(column.as_str()),
        Held::Once | Held::Nothing => None,
    });
    for name in others.chain(held).chain(has_detection.then_some(DETECTION)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut reading = Reading {
        kinds: Vec::new(),
        words: vec![Vec::new(); coordinates.len()],
        ends: vec![Ends::default(); coordinates.len()],
        regimes: BTreeMap::new(),
        rows: 0,
    };
    Table::for_each_piece(files, &names, |piece| {
        reading.add(piece, &coordinates, &regimes);
        Ok(())
    })?;
    Ok(reading.done(coordinates))
}

/// Rows of one kind while reading: those with the smallest hashes are kept.
struct Bag {
    seen: OfKind,
    most: usize,
    /// Kept rows, the largest hash on top.
    kept: BinaryHeap<Kept>,
}

struct Kept {
    key: (u64, u64),
    values: Vec<Option<f64>>,
}

impl PartialEq for Kept {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}
impl Eq for Kept {}
impl PartialOrd for Kept {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Kept {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key.cmp(&other.key)
    }
}

struct Reading {
    kinds: Vec<Bag>,
    words: Vec<Vec<String>>,
    ends: Vec<Ends>,
    regimes: BTreeMap<(String, String, String), ByStatus>,
    rows: u64,
}

/// SplitMix64 of a sample number (G. Steele, D. Lea, C. Flood, OOPSLA 2014).
fn hash(sample: u64) -> u64 {
    let z = sample.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Reading {
    fn add(&mut self, piece: &Table, coordinates: &[Coordinate], regimes: &[&str]) {
        fn word(words: Option<&[Option<String>]>, row: usize) -> &str {
            words.and_then(|words| words[row].as_deref()).unwrap_or("")
        }
        let numbers: Vec<Option<&[Option<f64>]>> =
            coordinates.iter().map(|coordinate| piece.numbers(&coordinate.column)).collect();
        let words: Vec<Option<&[Option<String>]>> =
            coordinates.iter().map(|coordinate| piece.words(&coordinate.column)).collect();
        let held: Vec<Option<&[Option<f64>]>> = coordinates
            .iter()
            .map(|coordinate| match &coordinate.held {
                Held::Reached(column) => piece.numbers(column),
                Held::Once | Held::Nothing => None,
            })
            .collect();
        let regimes: Vec<_> = regimes.iter().map(|name| (*name, piece.words(name))).collect();
        let (samples, status, cause) = (piece.numbers("sample"), piece.words("status"), piece.words("cause"));
        let detection = piece.words(DETECTION);
        for row in 0..piece.rows() {
            let Some(sample) = samples.and_then(|samples| samples[row]) else { continue };
            let (sample, status, cause) = (sample as u64, word(status, row), word(cause, row));
            self.rows += 1;
            let is_ok = status == "ok";
            for (at, of) in coordinates.iter().enumerate().filter(|(_, of)| of.is_result) {
                let finite =
                    |cells: Option<&[Option<f64>]>| cells.and_then(|cells| cells[row]).filter(|v| v.is_finite());
                let recorded = finite(numbers[at]);
                let value = match &of.held {
                    _ if is_ok => recorded,
                    Held::Reached(_) => finite(held[at]),
                    Held::Once => recorded.filter(|_| status == "beyond" || cause == "step_limit"),
                    Held::Nothing => None,
                };
                let kind = (status.to_owned(), cause.to_owned());
                if let Some(value) = recorded.filter(|_| !is_ok) {
                    self.ends[at].see_recorded(Extreme { value, sample, kind: kind.clone(), recorded });
                }
                match value {
                    Some(value) => {
                        self.ends[at].see(&Extreme { value, sample, kind, recorded }, is_ok);
                    }
                    None => self.ends[at].unknown += u64::from(!is_ok),
                }
            }
            for (name, words) in &regimes {
                let found = word(*words, row);
                if !found.is_empty() || !is_ok {
                    let key = ((*name).to_owned(), word(detection, row).to_owned(), found.to_owned());
                    *self.regimes.entry(key).or_default().entry(status.to_owned()).or_default() += 1;
                }
            }
            let at = self.bag(status, cause);
            let bag = &mut self.kinds[at];
            bag.seen.count += 1;
            bag.seen.first = bag.seen.first.min(sample);
            let key = (hash(sample), sample);
            if bag.kept.len() == bag.most && bag.kept.peek().is_some_and(|last| last.key <= key) {
                continue;
            }
            let mut values = Vec::with_capacity(coordinates.len());
            for (at, known) in self.words.iter_mut().enumerate() {
                values.push(match (numbers[at], words[at].and_then(|words| words[row].as_ref())) {
                    (Some(numbers), _) => numbers[row],
                    (None, Some(word)) => {
                        let place = known.iter().position(|one| one == word).unwrap_or_else(|| {
                            known.push(word.clone());
                            known.len() - 1
                        });
                        Some(place as f64)
                    }
                    (None, None) => None,
                });
            }
            bag.kept.push(Kept { key, values });
            if bag.kept.len() > bag.most {
                bag.kept.pop();
            }
        }
    }

    fn bag(&mut self, status: &str, cause: &str) -> usize {
        let found = self.kinds.iter().position(|bag| bag.seen.kind.0 == status && bag.seen.kind.1 == cause);
        found.unwrap_or_else(|| {
            let kind = (status.to_owned(), cause.to_owned());
            let most = if status == "ok" { MOST_GOOD } else { MOST_OF_CAUSE };
            self.kinds.push(Bag { seen: OfKind { kind, count: 0, first: u64::MAX }, most, kept: BinaryHeap::new() });
            self.kinds.len() - 1
        })
    }

    fn done(mut self, coordinates: Vec<Coordinate>) -> Seen {
        self.kinds.sort_by(|a, b| {
            let key = |bag: &Bag| (bag.seen.kind.0 != "ok", bag.seen.kind.clone());
            key(a).cmp(&key(b))
        });
        let mut sorted = self.words.clone();
        sorted.iter_mut().for_each(|words| words.sort());
        let place = |at: usize, value: f64| {
            let word = &self.words[at][value as usize];
            sorted[at].iter().position(|one| one == word).map(|place| place as f64)
        };
        let mut picked = Vec::new();
        for (kind, bag) in self.kinds.iter_mut().enumerate() {
            for Kept { key: (_, sample), mut values } in bag.kept.drain() {
                for (at, value) in values.iter_mut().enumerate().filter(|(at, _)| !self.words[*at].is_empty()) {
                    *value = value.and_then(|value| place(at, value));
                }
                picked.push(Picked { sample, kind, values });
            }
        }
        picked.sort_by_key(|row| row.sample);
        let kinds = self.kinds.into_iter().map(|bag| bag.seen).collect();
        Seen { coordinates, words: sorted, rows: self.rows, kinds, picked, ends: self.ends, regimes: self.regimes }
    }
}

impl Ends {
    fn see_recorded(&mut self, one: Extreme) {
        let is_more =
            |other: &Extreme| one.value > other.value || (one.value == other.value && one.sample < other.sample);
        if self.recorded.as_ref().is_none_or(is_more) {
            self.recorded = Some(one);
        }
    }

    fn see(&mut self, one: &Extreme, is_ok: bool) {
        let ends: [(&mut End, Order); 2] = [
            (&mut self.largest, |a, b| b.value.total_cmp(&a.value).then(a.sample.cmp(&b.sample))),
            (&mut self.least, |a, b| a.value.total_cmp(&b.value).then(a.sample.cmp(&b.sample))),
        ];
        for (end, order) in ends {
            if is_ok && end.ok.as_ref().is_none_or(|first| order(one, first).is_lt()) {
                end.ok = Some(one.clone());
            }
            keep(&mut end.all, one, order);
        }
    }
}

type Order = fn(&Extreme, &Extreme) -> std::cmp::Ordering;

/// Inserts an entry into a sorted list of limited length.
fn keep(list: &mut Vec<Extreme>, one: &Extreme, order: Order) {
    if list.len() == WORST && list.last().is_some_and(|last| order(last, one).is_le()) {
        return;
    }
    let at = list.partition_point(|other| order(other, one).is_lt());
    list.insert(at, one.clone());
    list.truncate(WORST);
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod rows_tests;
