//! Words of a formula.
//!
//! ```text
//! 12, 1.5e-3         a number; followed by a unit as in files: 8 mm, 2e6 N s/m, 20 1/s, 1500 rpm (no blanks around its `/` and `*`)
//! gap, max_load_N    a name; one with dots, hyphens or blanks in backquotes: `rotor.bearings.left.stiffness`
//! + - * / ^ ( ) ,  < <= > >= == !=   and or not
//! ```

use super::FormulaError;
use crate::document::units::parse_any_quantity;
use std::ops::Range;

/// Most bytes of a formula.
const LONGEST: usize = 10_000;

/// One word.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    /// Value in SI, and the unit as written ("" for none).
    Number(f64, String),
    /// Name of a variable or a function, or `and`, `or`, `not`.
    Name(String),
    /// Operator or bracket.
    Sign(&'static str),
}

/// An error at a position in the formula.
pub(super) fn wrong<T>(place: Range<usize>, message: impl Into<String>) -> Result<T, FormulaError> {
    Err(FormulaError { place, message: message.into() })
}

const SIGNS: [&str; 15] = ["<=", ">=", "==", "!=", "<", ">", "+", "-", "*", "/", "^", "(", ")", ",", "="];

fn begins_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

pub(super) fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn begins_unit(c: char) -> bool {
    c.is_alphabetic() || c == '%' || c == '°'
}

/// Splits a text into words with their positions.
pub(super) fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, FormulaError> {
    if text.len() > LONGEST {
        return wrong(0..0, format!("longer than {LONGEST} bytes"));
    }
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        if c.is_whitespace() {
            at += c.len_utf8();
        } else if c.is_ascii_digit() || (c == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit())) {
            let length = number_length(rest);
            let (number, taken) = quantity(rest, length)
                .map_err(|(place, message)| FormulaError { place: at + place.start..at + place.end, message })?;
            let unit = rest[length..taken].trim().to_owned();
            found.push((Token::Number(number, unit), at..at + taken));
            at += taken;
        } else if begins_name(c) {
            let length = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
            found.push((Token::Name(rest[..length].to_owned()), at..at + length));
            at += length;
        } else if c == '`' {
            let Some(length) = rest[1..].find('`') else { return wrong(at..text.len(), "the backquote is not closed") };
            if length == 0 {
                return wrong(at..at + 2, "a name is missing between the backquotes");
            }
            found.push((Token::Name(rest[1..=length].to_owned()), at..at + length + 2));
            at += length + 2;
        } else if rest.starts_with("**") {
            return wrong(at..at + 2, "`**` is not an operator; write `^` for a power");
        } else if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(**sign)) {
            if *sign == "=" {
                return wrong(at..at + 1, "`=` is not an operator; write `==` to compare");
            }
            found.push((Token::Sign(sign), at..at + sign.len()));
            at += sign.len();
        } else {
            return wrong(at..at + c.len_utf8(), format!("`{}` is not allowed in a formula", c.escape_default()));
        }
    }
    Ok(found)
}

/// Reads the number of `length` bytes at the start of the text and the unit that follows. Returns the value in SI and the number of bytes read.
/// The longest valid unit is taken: in `3 N/m*x` the x is a variable.
fn quantity(text: &str, length: usize) -> Result<(f64, usize), (Range<usize>, String)> {
    let in_si = |taken: usize| parse_any_quantity(&text[..taken]);
    let begins = length + text[length..].len() - text[length..].trim_start_matches(' ').len();
    let mut unit = &text[begins..begins + unit_length(&text[begins..])];
    let word = unit.split(' ').next().unwrap_or(unit);
    let bare = || in_si(length).map(|number| (number, length)).map_err(|error| (0..length, error.to_string()));
    if matches!(word, "" | "and" | "or" | "not") {
        return bare();
    }
    loop {
        let error = match in_si(begins + unit.len()) {
            // the text after the 1 is not a unit
            Ok(_) if unit == "1" => return bare(),
            Ok(number) => return Ok((number, begins + unit.len())),
            Err(error) => error,
        };
        match unit.rfind(['*', '/', '·', ' ']) {
            Some(cut) => unit = unit[..cut].trim_end(),
            None => return Err((begins..begins + word.len(), error.to_string())),
        }
    }
}

/// Length of a number: digits, a point, digits, an exponent.
fn number_length(text: &str) -> usize {
    let digits =
        |from: usize| text[from..].find(|c: char| !c.is_ascii_digit()).map_or(text.len(), |length| from + length);
    let mut end = digits(0);
    if text[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if let Some(exponent) = text[end..].strip_prefix(['e', 'E']) {
        let sign = usize::from(exponent.starts_with(['+', '-']));
        let last = digits(end + 1 + sign);
        if last > end + 1 + sign {
            end = last;
        }
    }
    end
}

/// Length of a unit: names joined by `/`, `*`, `^`, digits and blanks, such as `N/m`, `kg*m^2`, `m^-1`, `N s/m`, `1/s`, `N/(m s)`. A `*` or `/`
/// belongs to the unit if a letter follows. A name after a blank cannot be a variable, which would need an operator before it.
fn unit_length(text: &str) -> usize {
    let begins = |text: &str| text.starts_with(begins_unit);
    let is_one = text.strip_prefix("1/").is_some_and(begins);
    if !is_one && !begins(text) {
        return 0;
    }
    let chars: Vec<(usize, char)> = text.char_indices().collect();
    let (mut i, mut open) = (usize::from(is_one), false);
    while i < chars.len() {
        let (at, c) = chars[i];
        let behind = &text[at + c.len_utf8()..];
        let next = behind.chars().next();
        let joins = match c {
            '/' if !open && behind.strip_prefix('(').is_some_and(begins) => {
                (open, i) = (true, i + 1);
                true
            }
            ')' if open => {
                open = false;
                true
            }
            '/' | '*' | '·' => next.is_some_and(begins_unit),
            ' ' => begins(behind.trim_start_matches(' ')) && !is_operator(behind.trim_start_matches(' ')),
            '^' => next.is_some_and(|next| next.is_ascii_digit() || next == '-'),
            '-' => i > 0 && chars[i - 1].1 == '^',
            c => begins_unit(c) || c.is_ascii_digit() || "²³¹⁴⁻_".contains(c),
        };
        if !joins {
            break;
        }
        i += 1;
    }
    chars.get(i).map_or(text.len(), |next| next.0)
}

/// Whether a text begins with `and`, `or` or `not`.
fn is_operator(text: &str) -> bool {
    matches!(&text[..text.find(|c| !is_name(c)).unwrap_or(text.len())], "and" | "or" | "not")
}
