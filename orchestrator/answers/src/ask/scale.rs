//! How a number reads: as a share, or in a unit.

use bladeoff_model::document::units::format_digits;

/// A share as a person reads it: two digits of what it is away from 0 or from 1, whichever is less, so that 0.9963 is not 100 %.
#[must_use]
pub fn percent(share: f64) -> String {
    let rest = 100.0 * (1.0 - share.abs());
    if rest <= 0.0 || rest >= 10.0 {
        return format!("{} %", format_digits(100.0 * share, "", 2));
    }
    let places = 1 + usize::try_from(-libm::floor(libm::log10(rest)) as i32).unwrap_or(0);
    let text = format!("{:.*}", places.min(12), 100.0 * share);
    format!("{} %", not_all(text.trim_end_matches('0').trim_end_matches('.'), share))
}

/// The digits of a share in per cent, but for one that they would round to all: that with every digit it has.
fn not_all(text: &str, share: f64) -> String {
    let shortest = format!("{}", share.abs());
    match shortest.strip_prefix("0.").and_then(|digits| digits.split_at_checked(2)) {
        Some((whole, rest)) if text.trim_start_matches('-') == "100" && share.abs() < 1.0 => {
            format!("{}{whole}.{rest}", if share < 0.0 { "-" } else { "" })
        }
        _ => text.to_owned(),
    }
}

/// A share that somebody gave, with its digits: 0.975 is not 98 %.
#[must_use]
pub fn percent_given(share: f64) -> String {
    format!("{} %", not_all(&format_digits(100.0 * share, "", 12), share))
}

/// How a number of a question reads: a share, or in its unit.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// As per cent.
    Share,
    /// In the unit a person would choose, from this SI unit.
    Unit(String),
}

impl Scale {
    /// A value as it reads.
    #[must_use]
    pub fn show(&self, value: f64) -> String {
        match self {
            Self::Share => percent(value),
            Self::Unit(unit) => format_digits(value, unit, 4),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_next_to_all_is_not_all() {
        let shown = [0.9963, 0.999_975_6, -0.985, 0.95, 0.57, 0.0042, 1.0, 0.0].map(percent);
        assert_eq!(shown, ["99.63 %", "99.9976 %", "-98.5 %", "95 %", "57 %", "0.42 %", "100 %", "0 %"]);
        let nearly = 1.0 - f64::EPSILON / 2.0;
        let shown = [percent(nearly), percent_given(nearly), percent(-nearly)];
        assert_eq!(shown, ["99.99999999999999 %", "99.99999999999999 %", "-99.99999999999999 %"]);
        assert_eq!([0.975, 0.999, 0.999_999, 0.07].map(percent_given), ["97.5 %", "99.9 %", "99.9999 %", "7 %"]);
    }
}
