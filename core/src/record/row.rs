//! One row of the table: columns and values, reported together.

use super::peak::Peak;
use bladeoff_model::outcome::{Column, ColumnKind, Group, Part};
use std::fmt::Display;

/// Takes what recorders report, in table order, and keeps one half of it: what the columns are, or what they hold.
pub(super) struct Row<'a> {
    kept: Kept<'a>,
    group: Group,
}

enum Kept<'a> {
    Columns(&'a mut Vec<Column>),
    Values(&'a mut Vec<Option<f64>>),
}

impl<'a> Row<'a> {
    /// Keeps what the columns are.
    pub fn columns(columns: &'a mut Vec<Column>) -> Self {
        Self { kept: Kept::Columns(columns), group: Group::Course }
    }

    /// Keeps what they hold.
    pub fn values(values: &'a mut Vec<Option<f64>>) -> Self {
        Self { kept: Kept::Values(values), group: Group::Course }
    }

    /// What the next columns tell of.
    pub fn of(&mut self, group: Group) -> &mut Self {
        self.group = group;
        self
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
        self.add(value.into(), unit, ColumnKind::Real, Part::Whole, || (name.to_string(), meaning.to_string()));
    }

    /// A count.
    pub fn count(&mut self, name: &str, meaning: &str, value: impl Into<Option<u64>>) {
        let value = value.into().map(|count| count as f64);
        self.add(value, "", ColumnKind::Count, Part::Whole, || (name.to_owned(), meaning.to_owned()));
    }

    /// One of the words, by its place among them.
    pub fn choice(&mut self, name: &str, words: &'static [&'static str], meaning: &str, value: Option<usize>) {
        let value = value.map(|at| at as f64);
        self.add(value, "", ColumnKind::Choice(words), Part::Whole, || (name.to_owned(), meaning.to_owned()));
    }

    /// A peak, and time and speed at which it was reached.
    pub fn peak(
        &mut self,
        name: impl Display,
        unit: &'static str,
        meaning: impl Display,
        peak: impl Into<Option<Peak>>,
    ) {
        let Peak { value, at } = peak.into().unwrap_or_default();
        let column = || format!("{name}_{}", unit.replace(' ', ""));
        self.add(value, unit, ColumnKind::Real, Part::Peak, || (column(), meaning.to_string()));
        let time = || (format!("{name}_at_s"), format!("time of {}", column()));
        self.add(value.map(|_| at.time), "s", ColumnKind::Real, Part::PeakTime, time);
        let speed = || (format!("{name}_at_rad_s"), format!("mean spin at the time of {}", column()));
        self.add(value.map(|_| at.speed), "rad/s", ColumnKind::Real, Part::PeakSpeed, speed);
    }

    /// `words`: name and meaning, made only where they are kept.
    fn add(
        &mut self,
        value: Option<f64>,
        unit: &'static str,
        kind: ColumnKind,
        part: Part,
        words: impl FnOnce() -> (String, String),
    ) {
        match &mut self.kept {
            Kept::Columns(columns) => {
                let (name, meaning) = words();
                columns.push(Column { name, unit, kind, meaning, group: self.group, part });
            }
            Kept::Values(values) => values.push(value.filter(|value| value.is_finite())),
        }
    }
}
