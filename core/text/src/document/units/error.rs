//! Errors of a quantity with unit.

use thiserror::Error;

/// Reason for rejecting a text as a quantity of the expected unit. The message ends with the unit most likely meant;
/// [`QuantityError::parts`] returns that unit separately.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum QuantityError {
    /// No number at the start.
    #[error("`{given}` does not start with a number (write {examples})")]
    NotANumber {
        /// The text.
        given: String,
        /// Examples of valid text.
        examples: &'static str,
    },
    /// A decimal comma.
    #[error("`{given}` has a comma; the decimal sign is a point")]
    Comma {
        /// The text.
        given: String,
    },
    /// NaN, infinite, or beyond the range of a double.
    #[error("`{given}` is not a finite number within the range of a double")]
    NotFinite {
        /// The text.
        given: String,
    },
    /// A number in quotes without a unit.
    #[error("`{given}` has no unit; write {examples}, or a bare number in {expected}")]
    MissingUnit {
        /// The text.
        given: String,
        /// SI unit.
        expected: &'static str,
        /// Examples of valid text.
        examples: &'static str,
    },
    /// A symbol that is not in the table of units.
    #[error("unknown unit `{unit}`{}", did_you_mean(nearest))]
    UnknownUnit {
        /// The symbol.
        unit: String,
        /// The symbol most likely meant.
        nearest: Option<String>,
    },
    /// Hz, which may mean 1/s or revolutions per second.
    #[error("`{unit}` may mean 1/s or revolutions per second: write the value in {}", instead.join(" or "))]
    Hertz {
        /// The symbol.
        unit: String,
        /// Units that are accepted in its place, at least one.
        instead: Vec<&'static str>,
    },
    /// The unit cannot be read.
    #[error("the unit `{unit}` cannot be read: {reason}")]
    Malformed {
        /// The unit.
        unit: String,
        /// Reason.
        reason: &'static str,
    },
    /// A unit of another dimension.
    #[error(
        "the unit `{unit}` does not fit: {}{}",
        if expected.is_empty() { format!("{examples} is expected") } else { format!("{expected} is expected, such as {examples}") },
        did_you_mean(nearest)
    )]
    WrongDimension {
        /// The unit.
        unit: String,
        /// SI unit.
        expected: &'static str,
        /// Examples of valid text.
        examples: &'static str,
        /// The unit most likely meant.
        nearest: Option<String>,
    },
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |unit| format!("; did you mean `{unit}`?"))
}

impl QuantityError {
    /// The message without the suggestion, and the unit most likely meant.
    #[must_use]
    pub fn parts(mut self) -> (String, Option<String>) {
        let meant = match &mut self {
            Self::UnknownUnit { nearest, .. } | Self::WrongDimension { nearest, .. } => nearest.take(),
            _ => None,
        };
        (self.to_string(), meant)
    }
}
