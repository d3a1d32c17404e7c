//! One value of a machine: read from TOML or from text, with common checks.

use thiserror::Error;

use super::layout::{Scalar, Slot};
use super::schema::{FLAG, Kind};
use bladeoff_text::document::units::{QuantityError, examples, format_digits, parse_bare_or_quantity, parse_quantity};
use bladeoff_text::document::{Collector, Node, Value, nearest};

/// Value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum ParamValue {
    /// A number in SI; counts are whole.
    Number(f64),
    /// A word.
    Choice(String),
}

/// Reason for rejecting the value of a parameter.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ValueError {
    /// Not readable as a quantity of its unit.
    #[error("{path}: {source}")]
    Quantity {
        /// Path of the parameter.
        path: String,
        /// Reason.
        source: QuantityError,
    },
    /// Several values in place of one.
    #[error(
        "{path}: one value is set at a time; write a matrix or list in the machine file; each of its entries then has \
         its own path (`{path}[0]...`)"
    )]
    List {
        /// Path of the parameter.
        path: String,
    },
    /// Outside the allowed range.
    #[error("{path} = {given}: out of range; allowed: {allowed}")]
    OutOfRange {
        /// Path of the parameter.
        path: String,
        /// The value with its unit.
        given: String,
        /// Allowed range.
        allowed: String,
    },
    /// Not a whole number.
    #[error("{path} = {given}: not a whole number; allowed: {allowed}")]
    NotWhole {
        /// Path of the parameter.
        path: String,
        /// The value.
        given: String,
        /// Allowed range.
        allowed: String,
    },
    /// Not an allowed word.
    #[error("{path} = {given}: not an allowed word; allowed: {allowed}{}", did_you_mean(nearest.as_deref()))]
    NotAChoice {
        /// Path of the parameter.
        path: String,
        /// The word.
        given: String,
        /// Allowed words.
        allowed: String,
        /// The word most likely meant.
        nearest: Option<String>,
    },
    /// The machine has no such parameter.
    #[error("{path}: this machine has no such parameter")]
    NoSuchParameter {
        /// Path of the parameter.
        path: String,
    },
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |word| format!("; did you mean `{word}`?"))
}

/// Checks a value against its slot.
pub(super) fn check(slot: &Slot, value: &ParamValue) -> Result<Scalar, ValueError> {
    match value {
        ParamValue::Choice(word) => match slot.words().iter().find(|known| *known == word) {
            Some(known) => Ok(Scalar::Word(known)),
            None => Err(not_a_choice(slot, word)),
        },
        ParamValue::Number(number) if matches!(slot.key.kind, Kind::Choice(_)) => {
            Err(not_a_choice(slot, &number.to_string()))
        }
        ParamValue::Number(number) => check_number(slot, *number),
    }
}

fn check_number(slot: &Slot, number: f64) -> Result<Scalar, ValueError> {
    let path = slot.path.clone();
    if slot.key.kind == Kind::Count && number.fract() != 0.0 {
        return Err(ValueError::NotWhole { path, given: number.to_string(), allowed: slot.allowed() });
    }
    if !slot.range().contains(number) {
        let given = format_digits(number, slot.key.unit(), 10);
        return Err(ValueError::OutOfRange { path, given, allowed: slot.allowed() });
    }
    // -0 would print and hash differently from 0 with the same meaning.
    Ok(Scalar::Number(if number == 0.0 { 0.0 } else { number }))
}

fn not_a_choice(slot: &Slot, word: &str) -> ValueError {
    ValueError::NotAChoice {
        path: slot.path.clone(),
        given: word.chars().take(60).collect(),
        allowed: slot.allowed(),
        nearest: nearest(word, slot.words().iter().copied()).map(str::to_owned),
    }
}

/// Reads a value written without quotes, as on a command line: "8 mm", "0.008" (SI), "hyp1", "12".
pub(super) fn parse(slot: &Slot, text: &str) -> Result<ParamValue, ValueError> {
    let text = text.trim();
    let quantity = |unit| {
        parse_bare_or_quantity(text, unit)
            .map(ParamValue::Number)
            .map_err(|source| ValueError::Quantity { path: slot.path.clone(), source })
    };
    match slot.key.kind {
        Kind::Matrix(_) | Kind::Vector(_) | Kind::Diagonal(_) | Kind::List(_) if text.starts_with('[') => {
            Err(ValueError::List { path: slot.path.clone() })
        }
        Kind::Choice(_) => Ok(ParamValue::Choice(text.to_owned())),
        Kind::NumberOr(unit, _) if text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
            quantity(unit)
        }
        Kind::NumberOr(..) => Ok(ParamValue::Choice(text.to_owned())),
        _ => quantity(slot.key.unit()),
    }
}

/// Reads a value from the file; mistakes are added to `problems`.
pub(super) fn from_node(slot: &Slot, node: &Node, problems: &mut Collector<'_>) -> Scalar {
    let wrong_type = |problems: &mut Collector<'_>| {
        let shown = problems.excerpt(node.span.clone());
        let (message, allowed) = match slot.key.kind {
            Kind::Choice(_) => ("a word in quotes is expected", slot.allowed()),
            Kind::Count => ("a whole number is expected", slot.allowed()),
            _ => ("a number, or a string with number and unit, is expected", slot.allowed()),
        };
        let problem = problems.add(node.span.clone(), &slot.path, format!("{message}, not {}", node.value.type_name()));
        problem.value = Some(shown);
        problem.allowed = Some(allowed);
        Scalar::Bad
    };
    let value = match (&node.value, slot.key.kind) {
        (Value::Bool(flag), Kind::Choice(words)) if words == FLAG => {
            Ok(ParamValue::Choice(FLAG[usize::from(*flag)].to_owned()))
        }
        (Value::Text(word), Kind::Choice(_)) => Ok(ParamValue::Choice(word.clone())),
        (Value::Text(_), Kind::Count) => return wrong_type(problems),
        (Value::Text(text), Kind::NumberOr(..)) => parse(slot, text),
        (Value::Text(text), _) => parse_quantity(text, slot.key.unit())
            .map(ParamValue::Number)
            .map_err(|source| ValueError::Quantity { path: slot.path.clone(), source }),
        (_, Kind::Choice(_)) => return wrong_type(problems),
        (other, _) => match other.as_number() {
            Some(number) => Ok(ParamValue::Number(number)),
            None => return wrong_type(problems),
        },
    };
    match value.and_then(|value| check(slot, &value)) {
        Ok(scalar) => scalar,
        Err(error) => {
            let shown = problems.excerpt(node.span.clone());
            let (message, near) = match &error {
                ValueError::Quantity { source, .. } => {
                    let (message, meant) = source.clone().parts();
                    let is_unknown = matches!(source, QuantityError::UnknownUnit { .. });
                    let write =
                        if is_unknown { format!(", write {}", examples(slot.key.unit())) } else { String::new() };
                    (message + &write, meant)
                }
                ValueError::NotAChoice { nearest, .. } => ("not an allowed word".to_owned(), nearest.clone()),
                ValueError::NotWhole { .. } => ("a whole number is expected".to_owned(), None),
                ValueError::List { .. } => ("a single value is expected, not a list in quotes".to_owned(), None),
                ValueError::OutOfRange { .. } | ValueError::NoSuchParameter { .. } => ("out of range".to_owned(), None),
            };
            let problem = problems.add(node.span.clone(), &slot.path, message);
            problem.value = Some(shown);
            problem.allowed = Some(slot.allowed());
            problem.nearest = near;
            Scalar::Bad
        }
    }
}
