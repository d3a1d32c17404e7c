//! One row of the result table: columns and values, reported together.

use super::peak::{Peak, Sum};
use bladeoff_model::outcome::{Column, ColumnKind, Empty, Group, Growth, Part};
use std::fmt::Display;

/// Part that a machine needs for the columns of a flexible ring.
pub(super) const FLEXIBLE: &str = "a diaphragm with a flexible ring";

/// Collector of the recorders' reports, in table order. It keeps either the descriptions of the columns or their values.
pub(super) struct Row<'a> {
    kept: Kept<'a>,
    group: Group,
    /// Diaphragms to which the next columns refer.
    ring: OfRing,
    empty: Empty,
    /// Part or key without which the machine has no values in the next columns.
    lacks: Option<String>,
    guarded: Vec<Guarded>,
}

enum Kept<'a> {
    Columns(&'a mut Vec<Column>),
    Values(&'a mut Vec<Option<f64>>),
}

/// Value that a column had reached while all guards held; it becomes a column at the end of the row.
struct Guarded {
    /// Index of that column.
    of: usize,
    value: Option<f64>,
}

/// Properties of a column except its name and meaning.
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

/// Diaphragms to which columns refer.
#[derive(Clone)]
pub(super) enum OfRing {
    /// The only diaphragm of the machine.
    Only,
    /// All of several diaphragms.
    All,
    /// One of several diaphragms, by name.
    One(String),
}

impl OfRing {
    /// Column name of one of several diaphragms, with the diaphragm's name before the unit: `max_contact_force_NAME_N`,
    /// `max_contact_force_NAME_at_s`.
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
    /// Collects the descriptions of the columns.
    pub fn columns(columns: &'a mut Vec<Column>) -> Self {
        Self::keeping(Kept::Columns(columns))
    }

    /// Collects the values of the columns.
    pub fn values(values: &'a mut Vec<Option<f64>>) -> Self {
        Self::keeping(Kept::Values(values))
    }

    fn keeping(kept: Kept<'a>) -> Self {
        Self { kept, group: Group::Course, ring: OfRing::Only, empty: Empty::Absent, lacks: None, guarded: Vec::new() }
    }

    /// Sets the group of the next columns.
    pub fn of(&mut self, group: Group) -> &mut Self {
        self.group = group;
        self
    }

    /// Sets the diaphragms to which the next columns refer.
    pub fn of_ring(&mut self, ring: OfRing) {
        self.ring = ring;
    }

    /// Reports columns whose empty cells have the meaning `empty`. `lacks`: part or key without which the machine has no values in them. A
    /// part that an enclosing group of columns lacks takes precedence.
    pub fn with(&mut self, empty: Empty, lacks: Option<&str>, report: impl FnOnce(&mut Self)) {
        let outer = (self.empty, self.lacks.clone());
        self.empty = empty;
        if self.lacks.is_none() {
            self.lacks = lacks.map(str::to_owned);
        }
        report(self);
        (self.empty, self.lacks) = outer;
    }

    /// Number of columns so far.
    pub fn len(&self) -> usize {
        match &self.kept {
            Kept::Columns(columns) => columns.len(),
            Kept::Values(values) => values.len(),
        }
    }

    /// Reports a number with its unit; null if the event did not occur or the value is not finite.
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

    /// Reports the time of a first event \[s\]. `guarded`: the same time if the event occurred while all guards held.
    pub fn once(&mut self, name: &str, meaning: &str, value: Option<f64>, guarded: Option<f64>) {
        self.guarded.push(Guarded { of: self.len(), value: guarded });
        let kind = Kind::real("s", Part::Whole, Growth::Once);
        self.add(value, kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// Reports a number that never decreases during a run.
    pub fn growing(&mut self, name: &str, unit: &'static str, meaning: &str, value: impl Into<Option<f64>>) {
        let kind = Kind::real(unit, Part::Whole, Growth::Grows);
        self.add(value.into(), kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// Reports a sum, and its value while all guards held.
    pub fn sum(&mut self, name: &str, unit: &'static str, meaning: &str, sum: Option<Sum>) {
        self.guarded.push(Guarded { of: self.len(), value: sum.map(|sum| sum.guarded) });
        self.growing(name, unit, meaning, sum.map(|sum| sum.value));
    }

    /// Reports a count, and its value while all guards held.
    pub fn counted(&mut self, name: &str, meaning: &str, count: Option<Sum>) {
        self.guarded.push(Guarded { of: self.len(), value: count.map(|count| count.guarded) });
        let kind = Kind { unit: "", kind: ColumnKind::Count, part: Part::Whole, growth: Growth::Grows };
        self.add(count.map(|count| count.value), kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// Reports a count.
    pub fn count(&mut self, name: &str, meaning: &str, value: impl Into<Option<u64>>) {
        let value = value.into().map(|count| count as f64);
        let kind = Kind { unit: "", kind: ColumnKind::Count, part: Part::Whole, growth: Growth::Grows };
        self.add(value, kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// Reports one of the given words, by its index.
    pub fn choice(&mut self, name: &str, words: &'static [&'static str], meaning: &str, value: Option<usize>) {
        let value = value.map(|at| at as f64);
        let kind = Kind { unit: "", kind: ColumnKind::Choice(words), part: Part::Whole, growth: Growth::Free };
        self.add(value, kind, || (name.to_owned(), meaning.to_owned()));
    }

    /// Reports a peak, its time and speed, and its value while all guards held. `None`: the machine has no such quantity.
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

    /// Ends the row with the guarded values, after all other columns. They are null in a row that `is_ok`, whose own values are valid.
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

    /// Adds a column. `words`: its name and meaning, evaluated only if descriptions are collected.
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
