//! One axis of a study: one parameter, or several that advance together.

use super::ValueList;
use bladeoff_model::document::units::format_digits;
use bladeoff_model::machine::{ParamValue, PathInfo, PathKind, is_detection};
use std::ops::Range;

/// Most parameters that vary: a message to a worker has room for so many.
pub const MOST_VARIED: usize = 64;

/// Parameters that advance together, position by position.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it is: a parameter's path, the name of a zip group, or the points file.
    pub name: String,
    /// Its parameters, at least one.
    pub varied: Vec<Varied>,
    /// Number of positions, at least one; the same for each parameter.
    pub length: u64,
}

/// What a column of the study holds in a table; whole numbers, words and texts come as [`ParamValue`], too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Numbers.
    Real,
    /// Whole numbers.
    Integer,
    /// Words of a choice, or text.
    Word,
}

/// A column that the study gives to a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name; ends in the SI unit where it has one.
    pub name: String,
    /// SI unit, "" for none.
    pub unit: String,
    /// What it means, one sentence.
    pub meaning: String,
    /// What it holds.
    pub kind: ColumnKind,
}

/// A parameter and its values along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// The parameter.
    pub info: PathInfo,
    /// Its value at each position.
    pub values: ValueList,
    /// Bytes of the study file that name it.
    pub place: Range<usize>,
}

impl Varied {
    /// Whether its values are words.
    #[must_use]
    pub fn has_words(&self) -> bool {
        self.values.has_words()
    }

    /// The words it may be, where its values are words.
    #[must_use]
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.info.kind {
            PathKind::Choice(words) | PathKind::NumberOrChoice(words) if self.has_words() => Some(words),
            _ => None,
        }
    }

    /// Whether it is the contact detection, whose column has a name of its own.
    #[must_use]
    pub fn is_detection(&self) -> bool {
        is_detection(&self.info.path)
    }

    /// Its column of the result table.
    #[must_use]
    pub fn column(&self) -> Column {
        let (unit, kind) = match self.info.kind {
            _ if self.has_words() => ("", ColumnKind::Word),
            PathKind::Count => ("", ColumnKind::Integer),
            _ => (self.info.unit, ColumnKind::Real),
        };
        // A number-or-word parameter that holds words has no unit in its name.
        let name = if kind == ColumnKind::Word { self.info.path.clone() } else { self.info.column() };
        Column { name, unit: unit.to_owned(), meaning: self.info.meaning.to_owned(), kind }
    }
}

/// A value in a readable unit.
#[must_use]
pub fn show(info: &PathInfo, value: &ParamValue) -> String {
    match value {
        ParamValue::Number(number) => format_digits(*number, info.unit, 6),
        ParamValue::Choice(word) => word.clone(),
    }
}
