//! Conversion of text to an SI number.

use crate::document::cut;

use super::error::QuantityError;
use super::symbols::{Dimension, Unit, examples, look_up, similar};

/// Reads a number with its unit; a pure number (`expected` empty) needs no unit.
///
/// # Errors
/// [`QuantityError`]: no number, missing or unknown unit, dimension other than `expected`, not finite.
pub fn parse_quantity(text: &str, expected: &'static str) -> Result<f64, QuantityError> {
    parse(text, expected, false)
}

/// Reads a number with its unit, or a bare number in SI units (as on the command line, where there are no quotes).
///
/// # Errors
/// As [`parse_quantity`], but a missing unit is allowed.
pub fn parse_bare_or_quantity(text: &str, expected: &'static str) -> Result<f64, QuantityError> {
    parse(text, expected, true)
}

/// Reads a number with any unit, or a bare number; for variables, whose dimension is not known.
///
/// # Errors
/// [`QuantityError`]: no number, an unknown unit, not finite.
pub fn parse_any_quantity(text: &str) -> Result<f64, QuantityError> {
    let given = text.trim();
    let split = number_end(given);
    let (number, unit_text) = (&given[..split], given[split..].trim());
    let Some(number) = Decimal::read(number) else {
        let word = given.trim_start_matches(['+', '-']).to_ascii_lowercase();
        return Err(if word.starts_with("inf") || word.starts_with("nan") {
            QuantityError::NotFinite { given: cut(given, 60) }
        } else {
            QuantityError::NotANumber { given: cut(given, 60), examples: examples("") }
        });
    };
    if unit_text.starts_with(',') {
        return Err(QuantityError::Comma { given: cut(given, 60) });
    }
    let unit = if unit_text.is_empty() {
        Unit::ONE
    } else {
        parse_unit(unit_text).map_err(|error| match error {
            QuantityError::UnknownUnit { unit, .. } => {
                let nearest = similar(&unit).into_iter().next();
                QuantityError::UnknownUnit { unit, nearest }
            }
            QuantityError::Hertz { unit, .. } => QuantityError::Hertz { unit, instead: INSTEAD_OF_HERTZ.to_vec() },
            other => other,
        })?
    };
    number.in_si(unit).ok_or_else(|| QuantityError::NotFinite { given: cut(given, 60) })
}

/// The unit of a quantity as written; "" for a bare number.
#[must_use]
pub fn unit_of(text: &str) -> &str {
    let given = text.trim();
    given[number_end(given)..].trim()
}

fn parse(text: &str, expected: &'static str, bare_is_si: bool) -> Result<f64, QuantityError> {
    let given = text.trim();
    let given_shown = || given.chars().take(60).collect::<String>();
    let split = number_end(given);
    let (number, unit_text) = (&given[..split], given[split..].trim());
    let Some(number) = Decimal::read(number) else {
        let word = given.trim_start_matches(['+', '-']).to_ascii_lowercase();
        return Err(if word.starts_with("inf") || word.starts_with("nan") {
            QuantityError::NotFinite { given: given_shown() }
        } else {
            QuantityError::NotANumber { given: given_shown(), examples: examples(expected) }
        });
    };
    if unit_text.starts_with(',') {
        return Err(QuantityError::Comma { given: given_shown() });
    }
    let unit = if unit_text.is_empty() {
        if !bare_is_si && !expected.is_empty() {
            return Err(QuantityError::MissingUnit { given: given_shown(), expected, examples: examples(expected) });
        }
        Unit { dimension: dimension_of(expected), ..Unit::ONE }
    } else {
        parse_unit(unit_text).map_err(|error| with_nearest(error, unit_text, expected))?
    };
    if !dimension_of(expected).accepts(unit.dimension) {
        let fits = |found| dimension_of(expected).accepts(found);
        let (unit, nearest) = (cut(unit_text, 60), as_force(unit_text, &fits));
        return Err(QuantityError::WrongDimension { unit, expected, examples: examples(expected), nearest });
    }
    number.in_si(unit).ok_or_else(|| QuantityError::NotFinite { given: given_shown() })
}

/// The unit with pounds read as a force, if it fits then: `lb/in` becomes `lbf/in`.
fn as_force(unit_text: &str, fits: &dyn Fn(Dimension) -> bool) -> Option<String> {
    let pounds = unit_text.find("lb").filter(|_| unit_text.len() <= 60)?;
    let (before, after) = (&unit_text[..pounds], &unit_text[pounds + 2..]);
    let is_letter = |c: char| c.is_alphabetic();
    if before.ends_with(is_letter) || after.starts_with(is_letter) {
        return None;
    }
    let meant = format!("{before}lbf{after}");
    parse_unit(&meant).is_ok_and(|found| fits(found.dimension)).then_some(meant)
}

/// The unit of a fitting dimension most likely meant by `unit`: `lbf` for `lb`, `kN` for `kg`.
#[must_use]
pub fn nearest_unit(unit: &str, fits: &dyn Fn(Dimension) -> bool) -> Option<String> {
    let is_right = |candidate: &String| Dimension::of_unit(candidate).is_some_and(fits);
    as_force(unit, fits).or_else(|| similar(unit).into_iter().find(is_right))
}

/// Adds a suggestion to the error: to an unknown symbol the likeliest known one that gives a fitting unit, to Hz the accepted units.
fn with_nearest(error: QuantityError, unit_text: &str, expected: &'static str) -> QuantityError {
    let fits = |text: &str| parse_unit(text).is_ok_and(|found| dimension_of(expected).accepts(found.dimension));
    match error {
        QuantityError::UnknownUnit { unit, .. } => {
            // revolutions per second: by spelling the nearest symbol would be rpm, a factor of 60
            let meant = (unit == "rps").then(|| "rev/s".to_owned());
            let nearest = meant
                .into_iter()
                .chain(similar(&unit))
                .find(|candidate| fits(&unit_text.replacen(&unit, candidate, 1)));
            QuantityError::UnknownUnit { unit, nearest }
        }
        QuantityError::Hertz { unit, .. } => {
            let candidates = INSTEAD_OF_HERTZ.into_iter().chain(["rpm/s", "rad/s2"]);
            let instead: Vec<_> = candidates.filter(|candidate| fits(candidate)).collect();
            if instead.is_empty() {
                let unit = cut(unit_text, 60);
                return QuantityError::WrongDimension { unit, expected, examples: examples(expected), nearest: None };
            }
            QuantityError::Hertz { unit, instead }
        }
        other => other,
    }
}

/// Units that a user who writes Hz may mean.
const INSTEAD_OF_HERTZ: [&str; 4] = ["rpm", "rad/s", "rev/s", "1/s"];

impl Dimension {
    /// Dimension of a unit as written in files; "" means no unit. `None`: unknown unit.
    #[must_use]
    pub fn of_unit(text: &str) -> Option<Self> {
        parse_unit(text).ok().map(|unit| unit.dimension)
    }
}

/// Dimension of an SI unit of the schema.
fn dimension_of(si: &'static str) -> Dimension {
    if si.is_empty() {
        return Dimension::default();
    }
    parse_unit(si).expect("the SI units of the schema are in the table of symbols").dimension
}

/// A decimal literal: its digits with the decimal point, and its power of ten.
struct Decimal<'a> {
    digits: &'a str,
    ten: i64,
}

impl<'a> Decimal<'a> {
    fn read(text: &'a str) -> Option<Self> {
        if !text.bytes().any(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        // An exponent beyond i64 is 0 or infinite either way.
        let ten = exponent.parse().unwrap_or(if exponent.starts_with('-') { -1_000_000 } else { 1_000_000 });
        Some(Self { digits, ten })
    }

    /// The value in SI. Digits, powers of ten and the numerator of the unit go through the decimal parser together, which rounds once: "0.36 mm" is
    /// the double nearest to 0.00036. `None`: not finite, or a value that is not zero became zero.
    fn in_si(&self, unit: Unit) -> Option<f64> {
        let zero = !self.digits.bytes().any(|byte| (b'1'..=b'9').contains(&byte));
        let ten = self.ten.checked_add(i64::from(unit.ten))?;
        let mut value = match self.whole_times(unit.num) {
            Some((sign, product, decimals)) => format!("{sign}{product}e{}", ten - decimals).parse().ok()?,
            None => format!("{}e{ten}", self.digits).parse::<f64>().ok()? * unit.num as f64,
        };
        value /= unit.den as f64;
        for _ in 0..unit.pi.unsigned_abs() {
            value = if unit.pi > 0 { value * std::f64::consts::PI } else { value / std::f64::consts::PI };
        }
        (value.is_finite() && (zero || value != 0.0)).then_some(value)
    }

    /// Sign, digits as a whole number times `num`, and number of decimals; `None` if the product overflows.
    fn whole_times(&self, num: u64) -> Option<(&'static str, u128, i64)> {
        let unsigned = self.digits.trim_start_matches(['+', '-']);
        let (whole, decimals) = unsigned.split_once('.').unwrap_or((unsigned, ""));
        let product = format!("{whole}{decimals}").parse::<u128>().ok()?.checked_mul(u128::from(num))?;
        Some((if self.digits.starts_with('-') { "-" } else { "" }, product, i64::try_from(decimals.len()).ok()?))
    }
}

/// End of the decimal literal at the start of the text.
fn number_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits_from = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let sign = |at: usize| at + usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
    let mut end = digits_from(sign(0));
    if bytes.get(end) == Some(&b'.') {
        end = digits_from(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent = sign(end + 1);
        if digits_from(exponent) > exponent {
            end = digits_from(exponent);
        }
    }
    end
}

/// Reads a product of symbols: "kg m2", "kg*m^2", "kg·m²", "N-s/m", "N/mm", "m/s/s", "N/(m s)", "1/s".
fn parse_unit(text: &str) -> Result<Unit, QuantityError> {
    let malformed = |reason| QuantityError::Malformed { unit: text.chars().take(60).collect(), reason };
    let mut unit = Unit::ONE;
    let mut rest = text;
    let (mut dividing, mut divided, mut open, mut need_factor) = (false, false, false, false);
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { break };
        match first {
            '*' | '·' | '⋅' | '×' => {
                if need_factor || unit == Unit::ONE {
                    return Err(malformed("a product sign needs a symbol on both sides"));
                }
                need_factor = true;
                rest = &rest[first.len_utf8()..];
            }
            // Between two symbols a hyphen is a product sign, as in tables of bearing coefficients.
            '-' if !need_factor && unit != Unit::ONE && rest[1..].starts_with(char::is_alphabetic) => {
                need_factor = true;
                rest = &rest[1..];
            }
            '/' => {
                if need_factor || open {
                    return Err(malformed("a division sign must be between two symbols"));
                }
                (dividing, divided, need_factor) = (true, true, true);
                rest = &rest[1..];
            }
            '(' if dividing && need_factor && !open => {
                open = true;
                rest = &rest[1..];
            }
            ')' if open && !need_factor => {
                (open, dividing) = (false, false);
                rest = &rest[1..];
            }
            '1' if rest.len() == text.len() && !rest[1..].starts_with(|c: char| c.is_alphanumeric() || c == '.') => {
                rest = &rest[1..];
            }
            _ => {
                // After "N/m", a further factor could belong to the numerator or to the denominator.
                if divided && !dividing {
                    return Err(malformed("write all factors before the division sign, or N/(m s)"));
                }
                let expected = match first {
                    '.' => "a point is not a product sign; write a space: N m",
                    '"' => "inches are written `in`",
                    _ => "a symbol is expected",
                };
                let (symbol, power, after) = read_factor(rest).ok_or_else(|| malformed(expected))?;
                let power = power.ok_or_else(|| malformed("an exponent is a whole number from -9 to 9, not 0"))?;
                let factor = look_up(symbol)?;
                unit = unit
                    .times(factor, if dividing { -power } else { power })
                    .ok_or_else(|| malformed("its factor is out of range"))?;
                dividing = dividing && open;
                need_factor = false;
                rest = after;
            }
        }
    }
    if need_factor || open {
        return Err(malformed("it ends too early"));
    }
    Ok(unit)
}

/// One symbol with its exponent (`None`: an invalid exponent) and the rest of the text; `None`: no symbol here.
fn read_factor(text: &str) -> Option<(&str, Option<i32>, &str)> {
    let is_symbol = |c: char| c.is_alphabetic() || c == '%' || c == '°';
    let end = text.find(|c: char| !is_symbol(c)).unwrap_or(text.len());
    if end == 0 {
        return None;
    }
    let (symbol, rest) = text.split_at(end);
    let written = rest.strip_prefix("**").or_else(|| rest.strip_prefix('^'));
    let mut exponent = String::new();
    let mut after = written.unwrap_or(rest);
    while let Some(c) = after.chars().next() {
        let plain = match c {
            '²' => '2',
            '³' => '3',
            '¹' => '1',
            '⁴' => '4',
            '⁻' => '-',
            '0'..='9' => c,
            '-' if exponent.is_empty() && (written.is_some() || digit_behind_sign(after)) => c,
            _ => break,
        };
        exponent.push(plain);
        after = &after[c.len_utf8()..];
    }
    if exponent.is_empty() {
        return Some((symbol, if written.is_some() { None } else { Some(1) }, after));
    }
    let power = exponent.parse::<i32>().ok().filter(|power| *power != 0 && power.abs() <= 9);
    Some((symbol, power, after))
}

/// Whether a minus sign begins an exponent ("s-1") rather than joining two symbols ("N-s").
fn digit_behind_sign(text: &str) -> bool {
    text[1..].starts_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
