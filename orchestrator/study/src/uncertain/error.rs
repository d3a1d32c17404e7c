//! Errors of the keys of an uncertain parameter.

use super::keys::Distribution;
use thiserror::Error;

/// A mistake in a table of `[[uncertain]]`; [`UncertainError::key`] returns the key at fault.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UncertainError {
    /// A required key is missing.
    #[error("`{}` is missing; {} has {}", keys.join("` or `"), distribution.word(), distribution.keys_in_words())]
    Missing {
        /// The alternatives.
        keys: &'static [&'static str],
        /// Distribution that requires the key.
        distribution: Distribution,
    },
    /// A key that the distribution does not have.
    #[error("{} has no `{key}`; it has {}", distribution.word(), distribution.keys_in_words())]
    Surplus {
        /// The key.
        key: String,
        /// Distribution without the key.
        distribution: Distribution,
    },
    /// Two keys with the same meaning.
    #[error("`{key}` and `{other}` are both given: only one of them is allowed")]
    Both {
        /// The later one.
        key: String,
        /// The other.
        other: &'static str,
    },
    /// A value outside the allowed range.
    #[error("`{key}` = {given}; allowed: {allowed}")]
    Value {
        /// The key.
        key: String,
        /// Value given, with its unit.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// An invalid value in a list.
    #[error("`{key}`, value {} = {given}; allowed: {allowed}", position + 1)]
    Element {
        /// The key.
        key: &'static str,
        /// Position in the list, from 0.
        position: usize,
        /// Value given.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// A list of another length.
    #[error("`{key}` has {given} values; allowed: {allowed}")]
    Length {
        /// The key.
        key: &'static str,
        /// Its length.
        given: usize,
        /// Allowed values.
        allowed: String,
    },
    /// Truncation leaves an empty interval.
    #[error("nothing is left between `lower` and `upper`: {between} has a probability of {probability:e} in {law}")]
    NothingLeft {
        /// `lower` or `upper`.
        key: &'static str,
        /// The interval.
        between: String,
        /// Its probability.
        probability: f64,
        /// Description of the distribution.
        law: String,
    },
    /// Values that the machine rejects have too large a probability.
    #[error("values that are not allowed have a probability of {probability:.1e}, above 1e-12; allowed: {allowed}{}", if *key == "values" { String::new() } else { format!("; `{key}` cuts them off") })]
    Refused {
        /// `lower` or `upper`, on the side with the larger probability.
        key: &'static str,
        /// Probability of rejected values.
        probability: f64,
        /// Allowed values.
        allowed: String,
    },
    /// Values that overflow.
    #[error(
        "`{key}` = {given}: {law} is so wide that its values or their squares are beyond 1e308; allowed: {allowed}"
    )]
    TooWide {
        /// The key of the width.
        key: String,
        /// Value given.
        given: String,
        /// Description of the distribution.
        law: String,
        /// Allowed values.
        allowed: String,
    },
}

impl UncertainError {
    /// The key at fault; if one of several is missing, the first of them.
    #[must_use]
    pub fn key(&self) -> &str {
        match self {
            UncertainError::Missing { keys, .. } => keys[0],
            UncertainError::Surplus { key, .. }
            | UncertainError::Both { key, .. }
            | UncertainError::Value { key, .. }
            | UncertainError::TooWide { key, .. } => key,
            UncertainError::Element { key, .. }
            | UncertainError::Length { key, .. }
            | UncertainError::Refused { key, .. }
            | UncertainError::NothingLeft { key, .. } => key,
        }
    }
}
