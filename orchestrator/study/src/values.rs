//! The values of one parameter along an axis: 8 bytes for a number, one for a word, none for a point of a range.

use bladeoff_model::machine::{ParamValue, PathInfo, PathKind};

/// Values along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum ValueList {
    /// Individual numbers (SI).
    Numbers(Vec<f64>),
    /// Individual words.
    Words {
        /// The words of the parameter.
        known: &'static [&'static str],
        /// Index of the value at each position.
        chosen: Vec<u8>,
    },
    /// `count` >= 2 real numbers from the first to the last, evenly spaced or in constant ratio.
    Range {
        /// First value (SI).
        from: f64,
        /// Last value (SI).
        to: f64,
        /// Number of values.
        count: u64,
        /// Whether the ratio is constant instead of the difference; both ends then have the same sign.
        log: bool,
    },
}

impl ValueList {
    /// Number of values.
    #[must_use]
    pub fn len(&self) -> u64 {
        match self {
            ValueList::Numbers(numbers) => numbers.len() as u64,
            ValueList::Words { chosen, .. } => chosen.len() as u64,
            ValueList::Range { count, .. } => *count,
        }
    }

    /// Whether there are no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the values are words.
    #[must_use]
    pub fn has_words(&self) -> bool {
        matches!(self, ValueList::Words { .. })
    }

    /// Value at `position` < `len()`.
    #[must_use]
    pub fn at(&self, position: u64) -> ParamValue {
        let index = || usize::try_from(position).expect("a position in a list indexes memory");
        match self {
            ValueList::Numbers(numbers) => ParamValue::Number(numbers[index()]),
            ValueList::Words { known, chosen } => ParamValue::Choice(known[usize::from(chosen[index()])].to_owned()),
            &ValueList::Range { from, to, count, log } => {
                ParamValue::Number(between(from, to, position, count - 1, log))
            }
        }
    }
}

/// Values of one parameter while a list is read.
pub(super) struct Gathered {
    known: &'static [&'static str],
    numbers: Vec<f64>,
    chosen: Vec<u8>,
    expected: usize,
}

/// Error: a list with numbers and words, which no column can hold.
#[derive(Debug)]
pub(super) struct Mixed;

impl Gathered {
    /// An empty list for about `expected` values of a parameter.
    pub fn new(info: &PathInfo, expected: usize) -> Self {
        let known = match info.kind {
            PathKind::Choice(words) | PathKind::NumberOrChoice(words) => words,
            PathKind::Number | PathKind::Count => &[],
        };
        Self { known, numbers: Vec::new(), chosen: Vec::new(), expected }
    }

    /// Adds a value that was checked for this parameter.
    pub fn push(&mut self, value: &ParamValue) {
        match value {
            ParamValue::Number(number) => {
                self.numbers.reserve_exact(if self.numbers.is_empty() { self.expected } else { 0 });
                self.numbers.push(*number);
            }
            ParamValue::Choice(word) => {
                let at = self.known.iter().position(|known| known == word).expect("the word was checked");
                self.chosen.push(u8::try_from(at).expect("a parameter has few words"));
            }
        }
    }

    /// The list, if all values are of one type.
    pub fn finish(self) -> Result<ValueList, Mixed> {
        match (self.numbers.is_empty(), self.chosen.is_empty()) {
            (_, true) => Ok(ValueList::Numbers(self.numbers)),
            (true, false) => Ok(ValueList::Words { known: self.known, chosen: self.chosen }),
            (false, false) => Err(Mixed),
        }
    }
}

/// The value after `part` of `parts` equal steps; both ends are exactly as given. The fraction is reduced first, so that a point has the same bits
/// in every range that has it: a range of 10 values contains the one of 4.
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
        // libm instead of the system's function, for the same bits on every machine
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
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn values_are_kept_as_given_and_not_mixed() {
        let rig = include_str!("../../../studies/machines/lab_rig.toml");
        let machine = MachineDef::parse("rig", rig).expect("the lab rig");
        let info = machine.resolve("rotor.material.shear_coefficient").expect("a number or a word");
        let list = |texts: &[&str]| {
            let mut values = Gathered::new(&info, texts.len());
            texts.iter().for_each(|text| values.push(&machine.parse_value(&info, text).expect("allowed")));
            values.finish()
        };
        let words = list(&["none", "cowper", "none"]).expect("words");
        assert!(words.has_words() && words.len() == 3);
        assert_eq!(
            (0..3).map(|at| words.at(at)).collect::<Vec<_>>(),
            ["none", "cowper", "none"].map(|word| ParamValue::Choice(word.to_owned()))
        );
        let numbers = list(&["0.9", "0.8"]).expect("numbers");
        assert_eq!((numbers.has_words(), numbers.len(), numbers.at(1)), (false, 2, ParamValue::Number(0.8)));
        assert!(list(&["0.9", "cowper"]).is_err());
    }

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
