//! Tolerances of results: `COLUMN VALUE`, in the unit of the column, in another unit, or in per cent of the value of A.
//!
//! ```text
//! |B - A| <= VALUE,   |B - A| <= VALUE/100 |A|           the bound itself is within; for A = 0 only B = 0 is within
//! ```
//! Decimals have no exact binary value, so a difference equal to the tolerance as written may exceed it by an ulp. The allowed
//! difference is therefore enlarged by its 1e-9th part. A tolerance of 0 requires equal values.

use super::circle::{difference, is_angle};
use crate::tables::{ColumnHead, HeadKind};
use bladeoff_text::document::units::parse_bare_or_quantity;
use bladeoff_text::document::{cut, nearest};

/// Relative enlargement of the allowed difference for rounding.
const ROUNDING: f64 = 1e-9;

/// Largest number of columns listed where none resembles the given name.
const FEW: usize = 8;

/// Units of results that the parser of quantities accepts.
const UNITS: [&str; 16] =
    ["", "m", "kg", "s", "rad", "rad/s", "rad/s2", "m/s", "m/s2", "N", "N m", "N s", "N/m", "J", "Pa", "1/s"];

/// Allowed difference between A and B.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Limit {
    /// Absolute, in SI units.
    Absolute(f64),
    /// Relative to the value of A.
    Share(f64),
}

/// Columns that a name can refer to, or that explain why it refers to none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns<'a> {
    /// Results of both tables.
    pub results: &'a [ColumnHead],
    /// Inputs of either table.
    pub inputs: &'a [ColumnHead],
    /// Results of A alone and of B alone.
    pub only: (&'a [String], &'a [String]),
    /// Results whose kind or unit differs between the tables.
    pub of_another_kind: &'a [String],
}

/// Allowed difference of a column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tolerance {
    /// The tolerance as entered.
    pub text: String,
    /// Name of the column.
    pub column: String,
    limit: Limit,
    /// Unit of the column.
    unit: String,
}

impl Tolerance {
    /// # Errors
    /// Message that describes the error.
    pub fn read(text: &str, columns: Columns<'_>) -> Result<Self, String> {
        let text = text.trim();
        let (name, value) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let value = value.trim();
        let head = column(name, columns)?;
        if value.is_empty() {
            return Err(format!("it has no value; such as \"{name} 1 %\""));
        }
        let limit = match value.strip_suffix('%') {
            Some(_) if is_angle(&head.unit) => {
                return Err(format!("a share of an angle has no meaning; such as \"{name} 5 deg\""));
            }
            Some(number) => Limit::Share(plain(number.trim())? / 100.0),
            None => Limit::Absolute(amount(value, head)?),
        };
        let (Limit::Absolute(number) | Limit::Share(number)) = limit;
        if number < 0.0 {
            return Err("a tolerance is 0 or more".to_owned());
        }
        Ok(Self { text: text.to_owned(), column: head.name.clone(), limit, unit: head.unit.clone() })
    }

    /// Allowed difference for a value of A, in the unit of the column.
    pub fn allowed(&self, a: f64) -> f64 {
        match self.limit {
            Limit::Absolute(value) => value,
            Limit::Share(share) => share * a.abs(),
        }
    }

    /// Whether a value of B is within the tolerance, and the ratio of the difference to the allowed one.
    pub fn judge(&self, a: f64, b: f64) -> (bool, f64) {
        let (apart, allowed) = (difference(&self.unit, a, b).abs(), self.allowed(a));
        let is_within = apart <= allowed * (1.0 + ROUNDING);
        (is_within, if apart == 0.0 { 0.0 } else { apart / allowed })
    }
}

/// The result column with this name.
fn column<'n>(name: &str, columns: Columns<'n>) -> Result<&'n ColumnHead, String> {
    let found = columns.results.iter().find(|head| head.name == name);
    match found {
        Some(head) if head.kind == HeadKind::Words => {
            return Err(format!("{name} is a column of words, which have no distance"));
        }
        Some(head) => return Ok(head),
        None => {}
    }
    if name.is_empty() {
        return Err("it names no column; such as \"max_bearing_load_N 1 %\"".to_owned());
    }
    if columns.inputs.iter().any(|head| head.name == name) {
        return Err(format!("{name} is an input; tolerances apply to results"));
    }
    let is = |list: &[String]| list.iter().any(|column| column == name);
    if is(columns.only.0) {
        return Err(format!("B has no column {name}"));
    }
    if is(columns.only.1) {
        return Err(format!("A has no column {name}"));
    }
    if is(columns.of_another_kind) {
        return Err(format!("{name} has another meaning in A than in B, or another unit"));
    }
    let numbers = columns.results.iter().filter(|head| head.kind == HeadKind::Numbers);
    let numbers: Vec<&str> = numbers.map(|head| head.name.as_str()).collect();
    let hint = match nearest(name, numbers.iter().copied()) {
        Some(near) => format!("; did you mean {near}?"),
        None if numbers.is_empty() => "; the two tables have no numeric results in common".to_owned(),
        None if numbers.len() <= FEW => format!("; there are {}", numbers.join(", ")),
        None => String::new(),
    };
    Err(format!("there is no column {}{hint}", cut(name, 60)))
}

fn plain(text: &str) -> Result<f64, String> {
    parse_bare_or_quantity(text, "").map_err(|error| error.to_string())
}

/// Parses a value into the unit of a column.
fn amount(text: &str, head: &ColumnHead) -> Result<f64, String> {
    match UNITS.iter().find(|unit| **unit == head.unit) {
        Some(unit) => parse_bare_or_quantity(text, unit).map_err(|error| {
            let (message, allowed) = error.parts();
            allowed.map_or_else(|| message.clone(), |allowed| format!("{message} (allowed: {allowed})"))
        }),
        // a unit of another version of the program
        None => plain(text)
            .map_err(|_| format!("a plain number in {} or per cent is allowed for {}", cut(&head.unit, 30), head.name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Tolerance, String> {
        let head = |name: &str, unit: &str, kind| ColumnHead { name: name.into(), unit: unit.into(), kind };
        let results = [
            head("load_N", "N", HeadKind::Numbers),
            head("g", "", HeadKind::Numbers),
            head("odd", "furlong", HeadKind::Numbers),
            head("place_rad", "rad", HeadKind::Numbers),
            head("end_cause", "", HeadKind::Words),
        ];
        let inputs = [head("gap_m", "m", HeadKind::Numbers)];
        let (old, new) = (["old".to_owned()], ["new".to_owned()]);
        Tolerance::read(text, Columns { results: &results, inputs: &inputs, only: (&old, &new), of_another_kind: &[] })
    }

    #[test]
    fn values_are_in_units_or_per_cent() {
        let allowed = |text: &str| read(text).expect(text).allowed(-200.0);
        assert_eq!(
            ["load_N 1 %", "load_N 1%", "load_N 1 kN", "load_N 1kN", "load_N 5", "g 0.5", "g 1 %", "odd 3"]
                .map(allowed),
            [2.0, 2.0, 1000.0, 1000.0, 5.0, 0.5, 2.0, 3.0]
        );
        for unit in UNITS {
            assert_eq!(parse_bare_or_quantity("2", unit), Ok(2.0), "{unit} is known");
        }
    }

    #[test]
    fn what_is_no_tolerance_is_told() {
        for (text, told) in [
            ("", "names no column"),
            ("load_N", "has no value"),
            ("laod_N 1 %", "did you mean load_N?"),
            ("load_N -1 %", "0 or more"),
            ("load_N 1 mm", "N"),
            ("load_N one", "one"),
            ("load_N nan", "nan"),
            ("load_N inf %", "inf"),
            ("load_N 1 % 2", "cannot be read"),
            ("end_cause 1", "is a column of words"),
            ("gap_m 1 mm", "is an input"),
            ("old 1", "B has no column old"),
            ("new 1", "A has no column new"),
            ("place_rad 1 %", "such as \"place_rad 5 deg\""),
            ("odd 3 m", "a plain number in furlong"),
        ] {
            let why = read(text).expect_err(text);
            assert!(why.contains(told), "{text}: {why}");
        }
    }

    #[test]
    fn a_tolerance_of_an_angle_holds_across_the_cut() {
        let few = read("place_rad 5 deg").expect("an angle");
        assert!(few.judge(3.1, -3.1).0 && few.judge(-3.12, 3.12).0);
        assert!(!few.judge(3.0, -3.1).0 && !few.judge(0.0, 0.1).0);
    }

    #[test]
    fn the_bound_is_within_and_an_ulp_beyond_is_not_where_nothing_is_allowed() {
        let of = |text: &str| read(text).expect(text);
        let one = of("g 1 %");
        for (a, b) in [(100.0, 101.0), (0.7, 0.707), (-0.7, -0.693), (1e-300, 1.01e-300), (3e200, 3.03e200), (0.0, 0.0)]
        {
            assert!(one.judge(a, b).0, "{a} {b}");
        }
        for (a, b) in [(100.0, 101.000_001), (0.0, 1e-300), (0.7, 0.692)] {
            assert!(!one.judge(a, b).0, "{a} {b}");
        }
        let same = of("g 0");
        assert!(same.judge(0.3, 0.3).0 && !same.judge(0.3, 0.1 + 0.2).0);
        assert_eq!(same.judge(0.3, 0.1 + 0.2).1, f64::INFINITY);
    }
}
