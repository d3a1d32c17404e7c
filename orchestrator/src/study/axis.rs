//! One axis of a study: one parameter, or several that advance together.

use crate::results::{Field, FieldKind};
use bladeoff_core::document::units::format_digits;
use bladeoff_core::machine::{ParamValue, PathInfo, PathKind};
use std::ops::Range;

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
        matches!(self.values.at(0), ParamValue::Choice(_))
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
        self.info.path.ends_with(".contact.detection")
    }

    /// Its column of the result table.
    #[must_use]
    pub fn field(&self) -> Field {
        let (unit, kind) = match self.info.kind {
            _ if self.has_words() => ("", FieldKind::Word),
            PathKind::Count => ("", FieldKind::Integer),
            _ => (self.info.unit, FieldKind::Real),
        };
        // A number-or-word parameter that holds words has no unit in its name.
        let name = if kind == FieldKind::Word { self.info.path.clone() } else { self.info.column() };
        Field { name, unit: unit.to_owned(), meaning: self.info.meaning.to_owned(), kind }
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

/// Values along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum ValueList {
    /// Each given.
    Listed(Vec<ParamValue>),
    /// `count` >= 2 real numbers from the first to the last, evenly spaced or in constant ratio.
    Range {
        /// First value (SI).
        from: f64,
        /// Last value (SI).
        to: f64,
        /// Number of values.
        count: u64,
        /// Constant ratio instead of constant difference; both ends have the same sign then.
        log: bool,
    },
}

impl ValueList {
    /// Number of values.
    #[must_use]
    pub fn len(&self) -> u64 {
        match self {
            ValueList::Listed(values) => values.len() as u64,
            ValueList::Range { count, .. } => *count,
        }
    }

    /// Whether there are no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value at `position` < `len()`.
    #[must_use]
    pub fn at(&self, position: u64) -> ParamValue {
        match self {
            ValueList::Listed(values) => {
                values[usize::try_from(position).expect("a position in a list indexes memory")].clone()
            }
            &ValueList::Range { from, to, count, log } => {
                ParamValue::Number(between(from, to, position, count - 1, log))
            }
        }
    }
}

/// The value after `part` of `parts` equal steps; the ends come out exactly as given. The fraction is reduced first, so
/// that a point has the same bits in every range that has it: a range of 10 values contains the one of 4.
fn between(from: f64, to: f64, part: u64, parts: u64, log: bool) -> f64 {
    if part == 0 {
        return from;
    }
    if part == parts {
        return to;
    }
    let divisor = greatest_common_divisor(part, parts);
    let (part, parts) = (part / divisor, parts / divisor);
    let (done, whole) = (part as f64, parts as f64);
    if log {
        // libm, not the system's: the same values, bit for bit, on every machine.
        from * libm::pow(to / from, done / whole)
    } else {
        (from * (whole - done) + to * done) / whole
    }
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finer_range_contains_the_coarser_one_bit_for_bit() {
        for log in [false, true] {
            for (parts, times) in [(1, 7), (3, 3), (4, 2), (7, 10)] {
                for part in 0..=parts {
                    let coarse = between(0.1, 0.7, part, parts, log);
                    assert_eq!(coarse.to_bits(), between(0.1, 0.7, part * times, parts * times, log).to_bits());
                }
            }
        }
    }

    #[test]
    fn a_linear_range_has_equal_differences_and_its_exact_ends() {
        let values: Vec<f64> = (0..5).map(|part| between(0.1, 0.3, part, 4, false)).collect();
        assert_eq!((values[0], values[4]), (0.1, 0.3));
        for pair in values.windows(2) {
            assert!((pair[1] - pair[0] - 0.05).abs() < 1e-15);
        }
    }

    #[test]
    fn a_log_range_has_equal_ratios_and_its_exact_ends() {
        let values: Vec<f64> = (0..4).map(|part| between(1e-3, 1.0, part, 3, true)).collect();
        assert_eq!((values[0], values[3]), (1e-3, 1.0));
        assert!((values[1] - 1e-2).abs() < 1e-15 && (values[2] - 1e-1).abs() < 1e-14);
    }
}
