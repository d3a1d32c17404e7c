//! Formats SI numbers in readable units.

use std::f64::consts::PI;

/// `value` in the SI unit `si`, with a suitable unit and at most six significant digits: 0.008 m is "8 mm".
#[must_use]
pub fn format_quantity(value: f64, si: &str) -> String {
    format_digits(value, si, 6)
}

/// As [`format_quantity`] with up to `digits` significant digits.
#[must_use]
pub fn format_digits(value: f64, si: &str, digits: usize) -> String {
    let (scaled, unit) = readable(value, si);
    let number = significant(scaled, digits);
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// The number in a suitable unit.
fn readable<'a>(value: f64, si: &'a str) -> (f64, &'a str) {
    let size = value.abs();
    let pick = |steps: &[(f64, f64, &'static str)], otherwise: &'a str| {
        if size == 0.0 || !size.is_finite() {
            return (value, otherwise);
        }
        // The first step whose lower bound the value reaches; 1 ppm of slack so that 0.01 m - rounding stays 10 mm.
        steps
            .iter()
            .find(|(from, _, _)| size >= from * (1.0 - 1e-6))
            .map_or((value, otherwise), |&(_, factor, unit)| (value * factor, unit))
    };
    match si {
        "m" => pick(&[(1.0, 1.0, "m"), (1e-4, 1e3, "mm"), (1e-7, 1e6, "um")], "m"),
        "s" => pick(&[(0.1, 1.0, "s"), (1e-3, 1e3, "ms"), (1e-9, 1e6, "us")], "s"),
        "kg" => pick(&[(1.0, 1.0, "kg"), (1e-4, 1e3, "g")], "kg"),
        "m/s" => pick(&[(0.1, 1.0, "m/s"), (1e-6, 1e3, "mm/s")], "m/s"),
        "N" => pick(&[(1e6, 1e-6, "MN"), (1e3, 1e-3, "kN")], "N"),
        "N m" => pick(&[(1e6, 1e-6, "MN m"), (1e3, 1e-3, "kN m")], "N m"),
        "J" => pick(&[(1e6, 1e-6, "MJ"), (1e3, 1e-3, "kJ")], "J"),
        "Pa" => pick(&[(1e9, 1e-9, "GPa"), (1e6, 1e-6, "MPa"), (1e3, 1e-3, "kPa")], "Pa"),
        "rad" => (value / PI * 180.0, "deg"),
        "rad/s" => (value / PI * 30.0, "rpm"),
        "rad/s2" => (value / PI * 30.0, "rpm/s"),
        _ => (value, si),
    }
}

/// Shortest decimal with at most `digits` significant digits; powers of ten from 1e5 up and below 1e-3.
fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    let scientific = format!("{value:.*e}", digits.max(1) - 1);
    let (mantissa, exponent) = scientific.split_once('e').expect("`:e` always writes an exponent");
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    let exponent: i32 = exponent.parse().expect("`:e` writes a whole exponent");
    if !(-3..5).contains(&exponent) {
        return format!("{mantissa}e{exponent}");
    }
    // The rounded decimal is parsed and printed again: shortest form without an exponent.
    scientific.parse::<f64>().expect("written just above").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_read_as_an_engineer_writes_them() {
        for (value, si, shown) in [
            (0.008, "m", "8 mm"),
            (5.275, "m", "5.275 m"),
            (2e-5, "m", "20 um"),
            (0.0, "m", "0 m"),
            (-0.0005, "m", "-0.5 mm"),
            (50.0 * PI, "rad/s", "1500 rpm"),
            (PI / 6.0, "rad", "30 deg"),
            (2.1e11, "Pa", "210 GPa"),
            (1.2e6, "N", "1.2 MN"),
            (495e3, "N", "495 kN"),
            (6e8, "N/m", "6e8 N/m"),
            (0.01, "kg", "10 g"),
            (2.5e-6, "s", "2.5 us"),
            (0.2, "", "0.2"),
            (1e-6, "", "1e-6"),
            (2e-5, "1/s", "2e-5 1/s"),
            (0.1 + 0.2, "", "0.3"),
            (12_345.678, "kg", "12345.7 kg"),
        ] {
            assert_eq!(format_quantity(value, si), shown);
        }
    }

    #[test]
    fn what_is_shown_reads_back() {
        for si in
            ["m", "s", "kg", "m/s", "Pa", "rad", "rad/s", "rad/s2", "N/m", "N m", "N m s2", "1/s", "kg m2", "", "m/s2"]
        {
            for value in [1.234_567_89e-12, 3.3e-5, 0.001, 0.5, 7.0, 1e4, 123_456.75, 9.9e14] {
                let shown = format_digits(value, si, 17);
                let back = super::super::parse_bare_or_quantity(&shown, si).unwrap();
                assert!((back - value).abs() <= 1e-14 * value, "{shown}: {back} for {value} {si}");
            }
        }
    }
}
