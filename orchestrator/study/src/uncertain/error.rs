//! Errors of the keys of an uncertain parameter.

use super::keys::Distribution;
use thiserror::Error;

/// A mistake in a table of `[[uncertain]]`; [`UncertainError::key`] is where it stands.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UncertainError {
    /// A key is not there.
    #[error("`{}` is missing; {} has {}", keys.join("` or `"), distribution.word(), distribution.keys_in_words())]
    Missing {
        /// One of these.
        keys: &'static [&'static str],
        /// Key that requires another one.
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
    /// Two keys that say the same.
    #[error("`{key}` and `{other}` are both given: only one of them is allowed")]
    Both {
        /// The later one.
        key: String,
        /// The other.
        other: &'static str,
    },
    /// A number that cannot be.
    #[error("`{key}` = {given}; allowed: {allowed}")]
    Value {
        /// The key.
        key: String,
        /// Value given, with its unit.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// A value of a list that cannot be.
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
    /// Truncation leaves nothing.
    #[error("nothing is left between `lower` and `upper`: {between} has a probability of {probability:e} in {law}")]
    NothingLeft {
        /// `lower` or `upper`.
        key: &'static str,
        /// The interval.
        between: String,
        /// Its probability.
        probability: f64,
        /// The law in words.
        law: String,
    },
    /// Values that the machine refuses.
    #[error("values that are not allowed have a probability of {probability:.1e}, above 1e-12; allowed: {allowed}{}", if *key == "values" { String::new() } else { format!("; `{key}` cuts them off") })]
    Refused {
        /// `lower` or `upper`, on the side where more of them are.
        key: &'static str,
        /// Their probability.
        probability: f64,
        /// Allowed values.
        allowed: String,
    },
    /// Values that are no numbers any more.
    #[error(
        "`{key}` = {given}: {law} is so wide that its values or their squares are beyond 1e308; allowed: {allowed}"
    )]
    TooWide {
        /// The key that says how wide it is.
        key: String,
        /// Value given.
        given: String,
        /// The law in words.
        law: String,
        /// Allowed values.
        allowed: String,
    },
}

impl UncertainError {
    /// The key at fault; the first of them where one of several is missing.
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
