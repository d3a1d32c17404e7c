//! Shares in per cent.

use bladeoff_text::document::units::format_digits;

/// A share in per cent with two significant digits of its distance from 0 or from 1, whichever is less, so that 0.9963 is not printed as 100 %.
#[must_use]
pub fn percent(share: f64) -> String {
    percent_with(share, 2)
}

pub(crate) fn percent_with(share: f64, digits: usize) -> String {
    let rest = 100.0 * (1.0 - share.abs());
    if rest <= 0.0 || rest >= 10.0 {
        return format!("{} %", format_digits(100.0 * share, "", digits));
    }
    let places = digits - 1 + usize::try_from(-libm::floor(libm::log10(rest)) as i32).unwrap_or(0);
    let text = format!("{:.*}", places.min(12), 100.0 * share);
    format!("{} %", not_all(text.trim_end_matches('0').trim_end_matches('.'), share))
}

/// Text of a share in per cent, with all digits if rounding would give 100 % for a share below 1.
fn not_all(text: &str, share: f64) -> String {
    let shortest = format!("{}", share.abs());
    match shortest.strip_prefix("0.").and_then(|digits| digits.split_at_checked(2)) {
        Some((whole, rest)) if text.trim_start_matches('-') == "100" && share.abs() < 1.0 => {
            format!("{}{whole}.{rest}", if share < 0.0 { "-" } else { "" })
        }
        _ => text.to_owned(),
    }
}

/// A share from a study file with all its digits: 0.975 is not printed as 98 %.
#[must_use]
pub fn percent_given(share: f64) -> String {
    format!("{} %", not_all(&format_digits(100.0 * share, "", 12), share))
}
