//! Dimensions in formulas, so that for example a load is never compared with a mass.
//!
//! ```text
//! variables, quantities with a unit     known if their unit is
//! bare numbers, variables without one   fit any dimension: they are in SI units, 2 means 2 N as well as 2
//! a + b, a < b, min(a, b), hypot(a, b)  both of one dimension if both are known; otherwise the known one
//! a*b, a/b                              known if both are
//! a^c, sqrt(a)                          known if a is known and c has bare numbers only; c has no dimension
//! sin, cos, tan                         take pure numbers and angles, and give pure numbers; their inverses alike
//! exp                                   takes pure numbers; its result fits any dimension
//! ln, log10                             take any dimension, as the number in SI units; the result fits any dimension
//! ```
//! Angles: in a unit as written, 1/s is not a spin speed and a degree is not a pure number, as in files. Products lose this distinction: the
//! arc r*angle is a length. Limits: exponents of metre, kilogram and second are stored as doubles and compared within 1e-9.

use super::FormulaError;
use super::program::{Function, Instruction, Program};
use super::token::wrong;
use crate::document::cut;
use crate::document::units::{Dimension, format_digits, nearest_unit};
use std::ops::Range;

/// Tolerance for equal exponents, because thirds are not exact doubles.
const SAME: f64 = 1e-9;

/// Units that are easier to read than products of powers of kg, m and s.
const READABLE: [&str; 5] = ["N", "N m", "N s", "N/m", "Pa"];

/// A dimension and its written form.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// Exponents of metre, kilogram, second.
    powers: [f64; 3],
    /// The dimension with angles, for a unit as written; `None` for a computed dimension.
    written: Option<Dimension>,
    unit: String,
}

impl Measure {
    /// Dimension of a unit as written in files; "" means a pure number. `None`: unknown unit.
    #[must_use]
    pub fn of_unit(unit: &str) -> Option<Self> {
        let found = Dimension::of_unit(unit)?;
        Some(Self { powers: powers(found), written: Some(found), unit: unit.to_owned() })
    }

    /// Whether two dimensions agree.
    #[must_use]
    pub fn fits(&self, other: &Self) -> bool {
        let angles = self.written.zip(other.written).is_none_or(|(a, b)| a.accepts(b) || b.accepts(a));
        angles && same(self.powers, other.powers)
    }

    /// Description for messages: "in N", "a pure number".
    #[must_use]
    pub fn shown(&self) -> String {
        if self.unit.is_empty() { "a pure number".to_owned() } else { format!("in {}", self.unit) }
    }

    fn is_pure(&self) -> bool {
        same(self.powers, [0.0; 3])
    }

    /// The dimension with these exponents: "N", "kg m^2/s^3". `None`: an exponent is 1e6 or more.
    fn new(powers: [f64; 3]) -> Option<Self> {
        if !powers.iter().all(|power| power.abs() < 1e6) {
            return None;
        }
        let readable = |unit: &&&str| Dimension::of_unit(unit).is_some_and(|found| same(self::powers(found), powers));
        let unit = READABLE.iter().find(readable).map_or_else(|| in_base_units(powers), |unit| (*unit).to_owned());
        Some(Self { powers, written: None, unit })
    }

    fn times(&self, other: &Self, sign: f64) -> Option<Self> {
        let mut powers = self.powers;
        powers.iter_mut().zip(&other.powers).for_each(|(power, other)| *power += sign * other);
        Self::new(powers)
    }

    fn to_the(&self, exponent: f64) -> Option<Self> {
        Self::new(self.powers.map(|power| power * exponent))
    }
}

fn powers(of: Dimension) -> [f64; 3] {
    [of.m, of.kg, of.s].map(f64::from)
}

fn same(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(&b).all(|(a, b)| (a - b).abs() < SAME)
}

/// A unit in base units: "kg m^2/s^3", "1/m"; "" for a pure number.
fn in_base_units([m, kg, s]: [f64; 3]) -> String {
    let part = |sign: f64| {
        let of = |(name, power): (&str, f64)| match power * sign {
            power if power < SAME => None,
            power if (power - 1.0).abs() < SAME => Some(name.to_owned()),
            power => Some(format!("{name}^{}", format_digits(power, "", 4))),
        };
        [("kg", kg), ("m", m), ("s", s)].into_iter().filter_map(of).collect::<Vec<_>>()
    };
    let (above, below) = (part(1.0), part(-1.0));
    let above = if above.is_empty() && !below.is_empty() { "1".to_owned() } else { above.join(" ") };
    match below.len() {
        0 => above,
        1 => format!("{above}/{}", below[0]),
        _ => format!("{above}/({})", below.join(" ")),
    }
}

/// Position of one step of a program in the formula's text.
#[derive(Debug, Clone)]
pub(super) struct Mark {
    /// Range of the word: a name, a number, an operator; for a call, of the whole call.
    pub place: Range<usize>,
    /// Unit of a number as written; "" if it has none.
    pub unit: String,
    /// Brackets around everything that this step evaluates.
    pub brackets: Option<Range<usize>>,
}

/// Properties of a value that are known before evaluation.
#[derive(Debug, Clone, Default)]
struct Seen {
    measure: Option<Measure>,
    /// Value of an expression of bare numbers.
    constant: Option<f64>,
    /// Unit of a quantity as written; the quantity is then the more likely error.
    unit: Option<String>,
    /// Range of the whole expression in the text.
    extent: Range<usize>,
}

/// The dimension of a program's result, if it is known. `marks`: one for each step; `of`: dimension of a variable.
///
/// # Errors
/// The first operation that combines two dimensions (sum, comparison, minimum ...), with its position.
pub(super) fn measure(
    text: &str,
    program: &Program,
    marks: &[Mark],
    of: &dyn Fn(usize) -> Option<Measure>,
) -> Result<Option<Measure>, FormulaError> {
    let mut stack: Vec<Seen> = Vec::new();
    for (step, mark) in program.steps().iter().zip(marks) {
        let count = match step {
            Instruction::Number(_) | Instruction::Variable(_) => 0,
            Instruction::Negate | Instruction::Not => 1,
            Instruction::Call(_, count) => usize::from(*count),
            _ => 2,
        };
        let taken = stack.split_off(stack.len().saturating_sub(count));
        let (measure, constant) = result(text, step, mark, &taken, of)?;
        let unit = Some(mark.unit.clone()).filter(|unit| !unit.is_empty());
        let extents = taken.iter().map(|seen| &seen.extent);
        let ends = extents.fold(mark.place.clone(), |all, one| all.start.min(one.start)..all.end.max(one.end));
        let extent = mark.brackets.clone().unwrap_or(ends);
        stack.push(Seen { measure, constant, unit, extent });
    }
    Ok(stack.pop().and_then(|seen| seen.measure))
}

/// Properties of the result of one step.
fn result(
    text: &str,
    step: &Instruction,
    mark: &Mark,
    taken: &[Seen],
    of: &dyn Fn(usize) -> Option<Measure>,
) -> Result<(Option<Measure>, Option<f64>), FormulaError> {
    let all = |what: &str| joined(text, taken, what, &mark.place);
    let first = || taken.first().cloned().unwrap_or_default();
    let constant = |of: &dyn Fn(f64, f64) -> f64| match taken {
        [a, b] => Some(of(a.constant?, b.constant?)),
        _ => None,
    };
    let product = |sign: f64| match taken {
        [a, b] => a.measure.as_ref()?.times(b.measure.as_ref()?, sign),
        _ => None,
    };
    let pure = || Measure::of_unit("");
    Ok(match step {
        Instruction::Number(number) if mark.unit.is_empty() => (None, Some(*number)),
        Instruction::Number(_) => (Measure::of_unit(&mark.unit), None),
        Instruction::Variable(number) => (of(*number), None),
        Instruction::Negate => (first().measure, first().constant.map(|number| -number)),
        Instruction::Add => (all("a sum")?, constant(&|a, b| a + b)),
        Instruction::Subtract => (all("a difference")?, constant(&|a, b| a - b)),
        Instruction::Multiply => (product(1.0), constant(&|a, b| a * b)),
        Instruction::Divide => (product(-1.0), constant(&|a, b| a / b)),
        Instruction::Power => {
            if let Some(exponent) = taken.get(1) {
                expect_pure(text, exponent, "an exponent")?;
            }
            let exponent = taken.get(1).and_then(|seen| seen.constant);
            let measure = first().measure.zip(exponent).and_then(|(measure, exponent)| measure.to_the(exponent));
            (measure, constant(&libm::pow))
        }
        Instruction::Less
        | Instruction::AtMost
        | Instruction::More
        | Instruction::AtLeast
        | Instruction::Equal
        | Instruction::NotEqual => {
            all("a comparison")?;
            (None, None)
        }
        Instruction::And | Instruction::Or | Instruction::Not => (None, None),
        Instruction::Call(function, _) => match function {
            Function::Abs | Function::Floor => (first().measure, None),
            Function::Sqrt => (first().measure.and_then(|measure| measure.to_the(0.5)), None),
            Function::Min => (all("`min`")?, None),
            Function::Max => (all("`max`")?, None),
            Function::Hypot => (all("`hypot`")?, None),
            Function::Atan2 => {
                all("`atan2`")?;
                (Measure::new([0.0; 3]), None)
            }
            Function::Sin | Function::Cos | Function::Tan => {
                expect_pure(text, &first(), "an angle")?;
                (pure(), None)
            }
            Function::Asin | Function::Acos | Function::Atan => {
                expect_pure(text, &first(), "the ratio of two lengths")?;
                (Measure::new([0.0; 3]), None)
            }
            Function::Exp => {
                expect_pure(text, &first(), "an exponent")?;
                (None, None)
            }
            Function::Ln | Function::Log10 => (None, None),
        },
    })
}

/// Rejects an operand with a dimension.
fn expect_pure(text: &str, seen: &Seen, what: &str) -> Result<(), FormulaError> {
    match &seen.measure {
        Some(measure) if !measure.is_pure() => {
            let (given, shown) = (words(text, seen), measure.shown());
            wrong(seen.extent.clone(), format!("{given} is {shown}, and {what} has no dimension"))
        }
        _ => Ok(()),
    }
}

/// The common dimension of all operands, if one is known.
fn joined(text: &str, all: &[Seen], what: &str, place: &Range<usize>) -> Result<Option<Measure>, FormulaError> {
    let mut known = all.iter().filter_map(|seen| seen.measure.as_ref().map(|measure| (seen, measure)));
    let Some((first, measure)) = known.next() else { return Ok(None) };
    let Some((other, another)) = known.find(|(_, other)| !measure.fits(other)) else {
        return Ok(Some(measure.clone()));
    };
    // where a quantity meets a variable, the quantity has the wrong unit
    let (unit, quantity, beside, wanted) = match (&first.unit, &other.unit) {
        (None, Some(unit)) => (unit, other, first, measure),
        (Some(unit), None) => (unit, first, other, another),
        _ => {
            let (a, b) = (words(text, first), words(text, other));
            let (in_a, in_b) = (measure.shown(), another.shown());
            return wrong(place.clone(), format!("{what} of two dimensions: {a} is {in_a}, and {b} is {in_b}"));
        }
    };
    let fits = |found: Dimension| match wanted.written {
        Some(written) => written.accepts(found),
        None => same(powers(found), wanted.powers),
    };
    let meant = nearest_unit(unit, &fits).map(|unit| format!("; did you mean `{unit}`?")).unwrap_or_default();
    let (beside, shown) = (words(text, beside), wanted.shown());
    wrong(quantity.extent.clone(), format!("the unit `{unit}` does not fit: {beside} is {shown}{meant}"))
}

/// The operand as written, in backquotes.
fn words(text: &str, seen: &Seen) -> String {
    let given = text.get(seen.extent.clone()).unwrap_or("").trim();
    let bare = given.strip_prefix('`').and_then(|rest| rest.strip_suffix('`'));
    match bare.filter(|bare| !bare.contains('`')) {
        Some(name) => format!("`{name}`"),
        None => format!("`{}`", cut(&given.replace('`', ""), 60)),
    }
}
