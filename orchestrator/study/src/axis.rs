//! One axis of a study: one parameter, or several that advance together.

use super::ValueList;
use super::parameter::{Origin, Parameter};
use bladeoff_model::machine::{ParamValue, PathInfo};
use bladeoff_text::document::units::format_digits;
use std::ops::Range;

/// Most parameters that vary, limited by the size of a message to a worker.
pub const MOST_VARIED: usize = 128;

/// Parameters that advance together, position by position.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name: a parameter's path, the name of a zip group, or the points file.
    pub name: String,
    /// Its parameters, at least one.
    pub varied: Vec<Varied>,
    /// Number of positions, at least one; the same for each parameter.
    pub length: u64,
}

/// A parameter and its values along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// The parameter; for a variable, its name in place of a path, and no limits.
    pub info: PathInfo,
    /// Short name, `as`.
    pub short: Option<String>,
    /// Whether this is a variable of formulas, not a parameter of a machine.
    pub is_variable: bool,
    /// Its value at each position.
    pub values: ValueList,
    /// Byte range in the study file that names the parameter.
    pub place: Range<usize>,
}

impl Varied {
    /// Parameter of the study.
    #[must_use]
    pub(super) fn parameter(&self, origin: Origin) -> Parameter {
        Parameter {
            info: self.info.clone(),
            short: self.short.clone(),
            has_words: self.values.has_words(),
            is_variable: self.is_variable,
            origin,
            place: self.place.clone(),
        }
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
