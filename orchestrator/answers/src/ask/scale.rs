//! Format of the numbers of a question: as shares, or with a unit.

use crate::share::{percent, percent_with};
use bladeoff_text::document::units::format_digits;

/// Significant digits of a value with a unit; additional digits at most, if two values would print alike.
const DIGITS: usize = 4;
const MOST_MORE: usize = 5;

/// Format of the numbers of a question.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// In per cent.
    Share,
    /// With a convenient unit derived from this SI unit.
    Unit(String),
}

impl Scale {
    /// Text of a value.
    #[must_use]
    pub fn show(&self, value: f64) -> String {
        match self {
            Self::Share => percent(value),
            Self::Unit(unit) => format_digits(value, unit, DIGITS),
        }
    }

    /// Texts of two different values with enough digits to differ: "24.9 %" and "25.3 %" instead of "25 %" twice.
    #[must_use]
    pub fn show_both(&self, a: f64, b: f64) -> (String, String) {
        let with = |more: usize| match self {
            Self::Share => (percent_with(a, 2 + more), percent_with(b, 2 + more)),
            Self::Unit(unit) => (format_digits(a, unit, DIGITS + more), format_digits(b, unit, DIGITS + more)),
        };
        // values that differ by rounding errors only may print alike
        (0..MOST_MORE).map(with).find(|(a, b)| a != b).unwrap_or_else(|| with(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::share::percent_given;

    #[test]
    fn a_share_next_to_all_is_not_all() {
        let shown = [0.9963, 0.999_975_6, -0.985, 0.95, 0.57, 0.0042, 1.0, 0.0].map(percent);
        assert_eq!(shown, ["99.63 %", "99.9976 %", "-98.5 %", "95 %", "57 %", "0.42 %", "100 %", "0 %"]);
        let nearly = 1.0 - f64::EPSILON / 2.0;
        let shown = [percent(nearly), percent_given(nearly), percent(-nearly)];
        assert_eq!(shown, ["99.99999999999999 %", "99.99999999999999 %", "-99.99999999999999 %"]);
        let both = |a: f64, b: f64| Scale::Share.show_both(a, b);
        assert_eq!(both(0.2493, 0.2534), ("24.9 %".to_owned(), "25.3 %".to_owned()));
        assert_eq!(both(0.25, 0.25), ("25 %".to_owned(), "25 %".to_owned()));
        assert_eq!(both(0.1, 0.3), ("10 %".to_owned(), "30 %".to_owned()));
        let unit = Scale::Unit("N".to_owned());
        assert_eq!(unit.show_both(1_234_567.0, 1_234_612.0), ("1.23457 MN".to_owned(), "1.23461 MN".to_owned()));
        assert_eq!([0.975, 0.999, 0.999_999, 0.07].map(percent_given), ["97.5 %", "99.9 %", "99.9999 %", "7 %"]);
    }
}
