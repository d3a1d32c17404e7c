//! One row of the table: columns and values, reported together.

use super::peak::{Peak, Sum};
use bladeoff_model::outcome::{Column, ColumnKind, Empty, Group, Growth, Part};
use std::fmt::Display;

/// Part that a machine needs for columns of a flexible ring.
pub(super) const FLEXIBLE: &str = "a diaphragm with a flexible ring";

/// Takes what recorders report, in table order, and keeps one half of it: what the columns are, or what they hold.
pub(super) struct Row<'a> {
    kept: Kept<'a>,
    group: Group,
    /// Diaphragms that the next columns tell of.
    ring: OfRing,
    empty: Empty,
    /// Part or key that the machine lacks for the next columns.
    lacks: Option<String>,
    guarded: Vec<Guarded>,
}

enum Kept<'a> {
    Columns(&'a mut Vec<Column>),
    Values(&'a mut Vec<Option<f64>>),
}

/// What a column had reached while all guards held: a column at the end of the row.
struct Guarded {
    /// Place of that column.
    of: usize,
    value: Option<f64>,
}

/// What a column is, its words apart.
#[derive(Clone, Copy)]
struct Kind {
    unit: &'static str,
    kind: ColumnKind,
    part: Part,
    growth: Growth,
}

impl Kind {
    fn real(unit: &'static str, part: Part, growth: Growth) -> Self {
        Self { unit, kind: ColumnKind::Real, part, growth }
    }
}

/// Diaphragms that columns tell of.
#[derive(Clone)]
pub(super) enum OfRing {
    /// The only one.
    Only,
    /// All of several.
    All,
    /// This one of several.
    One(String),
}

impl OfRing {
    /// The column of one diaphragm of several has its name before the unit: `max_contact_force_NAME_N`, `max_contact_force_NAME_at_s`.
    fn column(&self, name: String, unit: &str) -> String {
        let Self::One(ring) = self else { return name };
        let unit = format!("_{}", unit.replace(' ', "").replace('/', "_"));
        let endings = ["_at_s", "_at_rad_s", &*unit];
        let ending = endings.into_iter().find(|ending| ending.len() > 1 && name.ends_with(ending)).unwrap_or_default();
        format!("{}_{ring}{ending}", &name[..name.len() - ending.len()])
    }

    fn meaning(&self, meaning: String) -> String {
        match self {
            Self::Only => meaning,
            Self::All => format!("of all diaphragms (the largest peak, the sum, the first contact): {meaning}"),
            Self::One(ring) => format!("diaphragm {ring}: {meaning}"),
        }
    }
}

impl<'a> Row<'a> {
    /// Keeps what the columns are.
    pub fn columns(columns: &'a mut Vec<Column>) -> Self {
        Self::keeping(Kept::Columns(columns))
    }

    /// Keeps what they hold.
    pub fn values(values: &'a mut Vec<Option<f64>>) -> Self {
        Self::keeping(Kept::Values(values))
    }

    fn keeping(kept: Kept<'a>) -> Self {
        Self { kept, group: Group::Course, ring: OfRing::Only, empty: Empty::Absent, lacks: None, guarded: Vec::new() }
    }

    /// What the next columns tell of.
    pub fn of(&mut self, group: Group) -> &mut Self {
        self.group = group;
        self
    }

    /// Which diaphragms the next columns tell of.
    pub fn of_ring(&mut self, ring: OfRing) {
        self.ring = ring;
    }

    /// Has columns reported whose empty cells have this meaning; `lacks`: part or key that the machine lacks for them. Where a group of
    /// columns around them lacks a part, that part is named.
    pub fn with(&mut self, empty: Empty, lacks: Option<&str>, report: impl FnOnce(&mut Self)) {
        let outer = (self.empty, self.lacks.clone());
        self.empty = empty;
        if self.lacks.is_none() {
            self.lacks = lacks.map(str::to_owned);
        }
        report(self);
        (self.empty, self.lacks) = outer;
    }

    /// Columns so far.
    pub fn len(&self) -> usize {
        match &self.kept {
            Kept::Columns(columns) => columns.len(),
            Kept::Values(values) => values.len(),
        }
    }

    /// A number with its unit; null where it did not happen, or is none.
    pub fn real(
        &mut self,
        name: impl Display,
        unit: &'static str,
        meaning: impl Display,
        value: impl Into<Option<f64>>,
    ) {
        let kind = Kind::real(unit, Part::Whole, Growth::Free);
        self.add(value.into(), kind, || (name.to_string(), meaning.to_string()));
    }

    /// The time of a first event \[s\]; `guarded`: the same where the event happened while all guards held.
    pub fn once(&mut self, name: &str, meaning: &str, value: Option<f64>, guarded: Option<f64>) {
        self.guarded.push(Guarded { of: self.len(), value: guarded });
        let kind = Kind::real("s", Part::Whole, Growth::Once);
        self.add(value, kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// One that only grows during a run.
    pub fn growing(&mut self, name: &str, unit: &'static str, meaning: &str, value: impl Into<Option<f64>>) {
        let kind = Kind::real(unit, Part::Whole, Growth::Grows);
        self.add(value.into(), kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// A sum, and what it was while all guards held.
    pub fn sum(&mut self, name: &str, unit: &'static str, meaning: &str, sum: Option<Sum>) {
        self.guarded.push(Guarded { of: self.len(), value: sum.map(|sum| sum.guarded) });
        self.growing(name, unit, meaning, sum.map(|sum| sum.value));
    }

    /// A count with the number reached while all guards held.
    pub fn counted(&mut self, name: &str, meaning: &str, count: Option<Sum>) {
        self.guarded.push(Guarded { of: self.len(), value: count.map(|count| count.guarded) });
        let kind = Kind { unit: "", kind: ColumnKind::Count, part: Part::Whole, growth: Growth::Grows };
        self.add(count.map(|count| count.value), kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// A count.
    pub fn count(&mut self, name: &str, meaning: &str, value: impl Into<Option<u64>>) {
        let value = value.into().map(|count| count as f64);
        let kind = Kind { unit: "", kind: ColumnKind::Count, part: Part::Whole, growth: Growth::Grows };
        self.add(value, kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// One of the words, by its place among them.
    pub fn choice(&mut self, name: &str, words: &'static [&'static str], meaning: &str, value: Option<usize>) {
        let value = value.map(|at| at as f64);
        let kind = Kind { unit: "", kind: ColumnKind::Choice(words), part: Part::Whole, growth: Growth::Free };
        self.add(value, kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// A peak, time and speed at which it was reached, and what it was while all guards held. `None` where the machine has no such
    /// quantity.
    pub fn peak(&mut self, name: impl Display, unit: &'static str, meaning: impl Display, peak: Option<Peak>) {
        self.guarded.push(Guarded { of: self.len(), value: peak.map(|peak| peak.guarded) });
        let Peak { value, at, .. } = peak.unwrap_or_default();
        let column = || format!("{name}_{}", unit.replace(' ', ""));
        let kind = Kind::real(unit, Part::Peak, Growth::Grows);
        self.add(value, kind, || (column(), meaning.to_string()));
        let kind = Kind::real("s", Part::PeakTime, Growth::Free);
        self.add(value.map(|_| at.time), kind, || (format!("{name}_at_s"), format!("time of {}", column())));
        let speed = || (format!("{name}_at_rad_s"), format!("mean spin at the time of {}", column()));
        self.add(value.map(|_| at.speed), Kind::real("rad/s", Part::PeakSpeed, Growth::Free), speed);
    }

    /// Ends the row with what was reached while all guards held; null in a row that `is_ok`, whose values stand. These values are behind all
    /// others.
    pub fn end(mut self, is_ok: bool) {
        for Guarded { of, value } in std::mem::take(&mut self.guarded) {
            match &mut self.kept {
                Kept::Columns(columns) => {
                    columns[of].is_guarded = true;
                    let (other, name) = (&columns[of], columns[of].guarded());
                    let column = Column {
                        name: name.expect("a guarded column has a name"),
                        meaning: format!(
                            "what {} had reached while all guards and limits of the run held, the step in which a limit was exceeded \
                             included; null where the status is ok",
                            other.name
                        ),
                        part: Part::Guarded,
                        growth: Growth::Free,
                        is_guarded: false,
                        ..other.clone()
                    };
                    columns.push(column);
                }
                Kept::Values(values) => values.push(value.filter(|value| !is_ok && value.is_finite())),
            }
        }
    }

    /// `words`: name and meaning, made only where they are kept.
    fn add(&mut self, value: Option<f64>, of: Kind, words: impl FnOnce() -> (String, String)) {
        let Kind { unit, kind, part, growth } = of;
        match &mut self.kept {
            Kept::Columns(columns) => {
                let (name, meaning) = words();
                let (name, meaning) = (self.ring.column(name, unit), self.ring.meaning(meaning));
                let (empty, lacks) = (self.empty, self.lacks.clone());
                let (group, is_guarded) = (self.group, false);
                columns.push(Column { name, unit, kind, meaning, group, part, growth, is_guarded, empty, lacks });
            }
            Kept::Values(values) => values.push(value.filter(|value| value.is_finite())),
        }
    }
}
