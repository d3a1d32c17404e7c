//! Parameters that differ between samples: those of the machine, and variables of formulas.

use super::column::{Column, ColumnKind};
use super::derived::Variable;
use bladeoff_model::machine::{self, ParamValue, PathInfo, PathKind, is_detection};
use bladeoff_text::document::Collector;
use std::ops::Range;

/// Origin of the values of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// `[[uncertain]]`: index of the distribution.
    Uncertain(usize),
    /// `[[vary]]` or `[points]`: index of the axis, and of the parameter among those of the axis.
    Varied(usize, usize),
    /// `[[derived]]`: index of the formula.
    Derived(usize),
}

/// A parameter or variable that has a value in each sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The parameter; for a variable, its name in place of a path, and no limits.
    pub info: PathInfo,
    /// Short name, `as`.
    pub short: Option<String>,
    /// Whether the values are words.
    pub has_words: bool,
    /// Whether this is a variable of formulas, not a parameter of a machine.
    pub is_variable: bool,
    /// Origin of the values.
    pub origin: Origin,
    /// Byte range in the study file that names the parameter.
    pub place: Range<usize>,
}

/// Describes a variable like a parameter.
#[must_use]
pub(super) fn variable_info(name: &str) -> PathInfo {
    PathInfo {
        path: name.to_owned(),
        unit: "",
        kind: PathKind::Number,
        value: None,
        shown: String::new(),
        meaning: "a variable of the study's formulas",
        allowed: "a finite number".to_owned(),
        range: machine::Range::ANY,
        default: false,
    }
}

impl Parameter {
    /// The short name, otherwise the path or name.
    #[must_use]
    pub fn shown(&self) -> &str {
        self.short.as_deref().unwrap_or(&self.info.path)
    }

    /// Whether each sample has a separate value: uncertain or derived, not along an axis.
    #[must_use]
    pub fn is_own(&self) -> bool {
        !matches!(self.origin, Origin::Varied(..))
    }

    /// The key of the study file in messages: `uncertain[0]`.
    #[must_use]
    pub fn key(&self) -> String {
        match self.origin {
            Origin::Uncertain(table) => format!("uncertain[{table}]"),
            Origin::Varied(..) => "vary".to_owned(),
            Origin::Derived(table) => format!("derived[{table}]"),
        }
    }

    /// Allowed words, if the values are words.
    #[must_use]
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.info.kind {
            PathKind::Choice(words) | PathKind::NumberOrChoice(words) if self.has_words => Some(words),
            _ => None,
        }
    }

    /// Whether this is the contact detection, whose column has a special name.
    #[must_use]
    pub fn is_detection(&self) -> bool {
        is_detection(&self.info.path)
    }

    /// Whether this is an angle of a machine: of an unbalance, the rotor at the start, or a diaphragm.
    #[must_use]
    pub fn is_angle(&self) -> bool {
        !self.is_variable && (self.info.path.ends_with(".phase") || self.info.path.ends_with(".angle"))
    }

    /// The variable of formulas with this value.
    #[must_use]
    pub fn variable(&self) -> Variable {
        let (name, short) = (self.info.path.clone(), self.short.clone());
        Variable { name, short, unit: self.info.unit.to_owned(), has_words: self.has_words }
    }

    /// Column of the result table.
    #[must_use]
    pub fn column(&self) -> Column {
        let (unit, kind) = match self.info.kind {
            _ if self.has_words => ("", ColumnKind::Word),
            PathKind::Count => ("", ColumnKind::Integer),
            _ => (self.info.unit, ColumnKind::Real),
        };
        // Column names of words have no unit, even for a parameter that may also be a number.
        let name = self.variable().column();
        Column { name, unit: unit.to_owned(), meaning: self.info.meaning.to_owned(), kind }
    }

    /// Value as sent to a worker: the number, or the position of a word in the list; `None`: an unknown word.
    #[must_use]
    pub fn number(&self, value: &ParamValue) -> Option<f64> {
        match value {
            ParamValue::Number(number) => Some(*number),
            ParamValue::Choice(word) => Some(self.words()?.iter().position(|known| known == word)? as f64),
        }
    }
}

/// Rejects names that would give a parameter the column of something else; paths cannot.
pub(super) fn refuse_same(parameters: &[Parameter], own: &[String], problems: &mut Collector<'_>) {
    let columns: Vec<String> = parameters.iter().map(|parameter| parameter.column().name).collect();
    for (number, parameter) in parameters.iter().enumerate() {
        if !parameter.is_variable && parameter.short.is_none() {
            continue;
        }
        let column = &columns[number];
        // reported at the later of two, or at the one whose name can be changed; equal names have been reported already
        let named = |of: usize| parameters[of].is_variable || parameters[of].short.is_some();
        let is_told = |of: usize| parameters[of].shown() == parameter.shown();
        let has = |other: &usize| {
            columns[*other] == *column && !is_told(*other) && (*other < number || (*other > number && !named(*other)))
        };
        let is_own = own.contains(column) || parameter.short.as_ref().is_some_and(|short| own.contains(short));
        let what = match (is_own, (0..columns.len()).find(has)) {
            (true, _) => "the table already has a column with this name".to_owned(),
            (_, Some(other)) => format!("{} has the same column", parameters[other].info.path),
            _ => continue,
        };
        let problem = problems.add(parameter.place.clone(), parameter.key(), what);
        problem.value = Some(format!("{column:?}"));
        problem.allowed = Some("another name".to_owned());
    }
}
