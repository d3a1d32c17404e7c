//! Parses a formula by operator precedence (V. Pratt, "Top down operator precedence", 1973) into a program for a stack machine.
//!
//! ```text
//! or < and < not < comparisons (one) < + - < * / < sign < ^ (from the right)       -2^2 = -4, 2^3^2 = 512, 2^-1 = 0.5
//! ```
//! Numbers and truth values are distinct types: `(a > 1) + 2` and `1 and 2` are rejected.

use super::FormulaError;
use super::measure::{Mark, Measure, measure};
use super::program::{Function, Instruction, Kind, Program};
use super::token::{Token, is_name, tokens, wrong};
use crate::document::nearest;
use std::ops::Range;

/// Deepest nesting of brackets, signs and powers.
const DEEPEST: usize = 200;

type Place = Range<usize>;

struct Parser<'a> {
    tokens: Vec<(Token, Place)>,
    next: usize,
    depth: usize,
    end: usize,
    known: &'a dyn Fn(&str) -> Option<usize>,
    nearest: &'a dyn Fn(&str) -> Option<String>,
    program: Vec<Instruction>,
    /// One mark per step.
    marks: Vec<Mark>,
    names: Vec<usize>,
}

const FUNCTIONS: &[(&str, Function, usize)] = &[
    ("abs", Function::Abs, 1),
    ("sqrt", Function::Sqrt, 1),
    ("exp", Function::Exp, 1),
    ("ln", Function::Ln, 1),
    ("log10", Function::Log10, 1),
    ("sin", Function::Sin, 1),
    ("cos", Function::Cos, 1),
    ("tan", Function::Tan, 1),
    ("asin", Function::Asin, 1),
    ("acos", Function::Acos, 1),
    ("atan", Function::Atan, 1),
    ("atan2", Function::Atan2, 2),
    ("hypot", Function::Hypot, 2),
    ("floor", Function::Floor, 1),
    ("min", Function::Min, 0),
    ("max", Function::Max, 0),
];

/// Whether a name has a meaning in formulas, so that a variable cannot have it.
#[must_use]
pub fn is_reserved(name: &str) -> bool {
    matches!(name, "pi" | "e" | "and" | "or" | "not" | "log" | "if")
        || FUNCTIONS.iter().any(|(known, ..)| *known == name)
}

/// Parses a formula of the given kind, with variables without units. `known`: index of a variable; `nearest`: name most likely meant.
///
/// # Errors
/// The first mistake, with its position.
pub fn parse(
    text: &str,
    kind: Kind,
    known: &dyn Fn(&str) -> Option<usize>,
    nearest: &dyn Fn(&str) -> Option<String>,
) -> Result<Program, FormulaError> {
    parse_measured(text, kind, known, nearest, &|_| None).map(|(program, _)| program)
}

/// As [`parse`], for variables with the dimension of `unit` if it is known; returns also the dimension of the result.
///
/// # Errors
/// As [`parse`].
pub fn parse_measured(
    text: &str,
    kind: Kind,
    known: &dyn Fn(&str) -> Option<usize>,
    nearest: &dyn Fn(&str) -> Option<String>,
    unit: &dyn Fn(usize) -> Option<Measure>,
) -> Result<(Program, Option<Measure>), FormulaError> {
    let tokens = tokens(text)?;
    let (program, marks, names) = (Vec::new(), Vec::new(), Vec::new());
    let mut parser = Parser { tokens, next: 0, depth: 0, end: text.len(), known, nearest, program, marks, names };
    if parser.tokens.is_empty() {
        return wrong(0..text.len(), "there is no formula");
    }
    let found = parser.expression(0)?;
    if let Some((token, place)) = parser.tokens.get(parser.next) {
        let word = match token {
            Token::Number(..) => format!("`{}`", &text[place.clone()]),
            Token::Name(name) => format!("`{name}`"),
            Token::Sign(sign) => format!("`{sign}`"),
        };
        return wrong(place.clone(), format!("{word} is not expected here: an operator is missing before it"));
    }
    if found != kind {
        return wrong(
            0..text.len(),
            match kind {
                Kind::Truth => "this is a number; a condition such as `x > 1` is expected",
                Kind::Number => "this is a condition; a number is expected",
            },
        );
    }
    parser.names.sort_unstable();
    parser.names.dedup();
    let program = Program::new(parser.program, parser.names);
    let measure = measure(text, &program, &parser.marks, unit)?;
    Ok((program, measure))
}

fn no_function(name: &str) -> String {
    let known = || FUNCTIONS.iter().map(|(known, ..)| *known);
    let meant = match name {
        "pow" | "power" => Some("a^b".to_owned()),
        "ceil" => Some("-floor(-x)".to_owned()),
        _ => nearest(name, known()).map(str::to_owned),
    };
    let meant = meant.map(|meant| format!("; did you mean `{meant}`?")).unwrap_or_default();
    format!("there is no function `{name}`, but {}{meant}", known().collect::<Vec<_>>().join(", "))
}

impl Parser<'_> {
    fn take(&mut self) -> Option<(Token, Place)> {
        let found = self.tokens.get(self.next).cloned();
        self.next += usize::from(found.is_some());
        found
    }

    fn push(&mut self, does: Instruction, place: Place) {
        self.program.push(does);
        self.marks.push(Mark { place, unit: String::new(), brackets: None });
    }

    /// End of the last word.
    fn behind(&self) -> usize {
        self.next.checked_sub(1).and_then(|last| self.tokens.get(last)).map_or(self.end, |(_, place)| place.end)
    }

    fn expect(&mut self, sign: &'static str, after: &str) -> Result<(), FormulaError> {
        match self.take() {
            Some((Token::Sign(found), _)) if found == sign => Ok(()),
            Some((_, place)) => wrong(place, format!("`{sign}` is expected {after}")),
            None => wrong(self.end..self.end, format!("`{sign}` is missing {after}")),
        }
    }

    /// Parses an expression whose operators have at least this binding power.
    fn expression(&mut self, least: u8) -> Result<Kind, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            let place = self.tokens.get(self.next).map_or(self.end..self.end, |(_, place)| place.clone());
            return wrong(place, format!("more than {DEEPEST} nested brackets or operators"));
        }
        let mut kind = self.first()?;
        while let Some((token, place)) = self.tokens.get(self.next).cloned() {
            let operator = match &token {
                Token::Sign(sign) => *sign,
                Token::Name(name) if name == "and" || name == "or" => name.as_str(),
                _ => break,
            };
            // (binding power, least binding power of the right side, operand type, result type, instruction)
            let (binds, right, takes, gives, does) = match operator {
                "or" => (1, 2, Kind::Truth, Kind::Truth, Instruction::Or),
                "and" => (3, 4, Kind::Truth, Kind::Truth, Instruction::And),
                "<" => (7, 8, Kind::Number, Kind::Truth, Instruction::Less),
                "<=" => (7, 8, Kind::Number, Kind::Truth, Instruction::AtMost),
                ">" => (7, 8, Kind::Number, Kind::Truth, Instruction::More),
                ">=" => (7, 8, Kind::Number, Kind::Truth, Instruction::AtLeast),
                "==" => (7, 8, Kind::Number, Kind::Truth, Instruction::Equal),
                "!=" => (7, 8, Kind::Number, Kind::Truth, Instruction::NotEqual),
                "+" => (9, 10, Kind::Number, Kind::Number, Instruction::Add),
                "-" => (9, 10, Kind::Number, Kind::Number, Instruction::Subtract),
                "*" => (11, 12, Kind::Number, Kind::Number, Instruction::Multiply),
                "/" => (11, 12, Kind::Number, Kind::Number, Instruction::Divide),
                "^" => (15, 14, Kind::Number, Kind::Number, Instruction::Power),
                _ => break,
            };
            if binds < least {
                break;
            }
            self.next += 1;
            let found = self.expression(right)?;
            if kind != takes || found != takes {
                return wrong(
                    place,
                    match takes {
                        Kind::Number if binds == 7 => {
                            format!("`{operator}` compares two numbers, and once: write `a < b and b < c`")
                        }
                        Kind::Number => format!("`{operator}` takes numbers, not conditions"),
                        Kind::Truth => format!("`{operator}` joins conditions such as `x > 1`, not numbers"),
                    },
                );
            }
            kind = gives;
            self.push(does, place);
        }
        self.depth -= 1;
        Ok(kind)
    }

    fn first(&mut self) -> Result<Kind, FormulaError> {
        let Some((token, place)) = self.take() else { return wrong(self.end..self.end, "the formula ends too early") };
        match token {
            Token::Number(number, unit) => {
                self.refuse_variables_in(&unit, &place)?;
                self.program.push(Instruction::Number(number));
                self.marks.push(Mark { place, unit, brackets: None });
                Ok(Kind::Number)
            }
            Token::Sign("-") => self.signed(place, 13, Some(Instruction::Negate)),
            Token::Sign("+") => self.signed(place, 13, None),
            Token::Sign("(") => {
                let kind = self.expression(0)?;
                self.expect(")", "to close the bracket")?;
                let all = place.start..self.behind();
                if let Some(mark) = self.marks.last_mut() {
                    mark.brackets = Some(all);
                }
                Ok(kind)
            }
            Token::Sign(sign) => wrong(place, format!("`{sign}` is not expected here: a value is missing before it")),
            Token::Name(name) => self.named(&name, place),
        }
    }

    /// Rejects the name of a variable after a `/` or `*` of a unit, because it could also be a unit.
    fn refuse_variables_in(&self, unit: &str, place: &Place) -> Result<(), FormulaError> {
        let (begins, mut at) = (place.end - unit.len(), 0);
        for word in unit.split(|c| !is_name(c)) {
            let sign =
                unit[..at].trim_end_matches('(').chars().next_back().filter(|sign| ['/', '*', '·'].contains(sign));
            if let (Some(sign), Some(_)) = (sign, (self.known)(word)) {
                return wrong(
                    begins + at..begins + at + word.len(),
                    format!(
                        "`{word}` is a unit here and a variable: with blanks, ` {sign} {word}`, it is the variable; for the unit \
                         give the variable another name"
                    ),
                );
            }
            at += word.len() + unit[at + word.len()..].chars().next().map_or(0, char::len_utf8);
        }
        Ok(())
    }

    fn signed(&mut self, place: Place, binds: u8, does: Option<Instruction>) -> Result<Kind, FormulaError> {
        if self.expression(binds)? != Kind::Number {
            return wrong(place, "a sign belongs to a number, not to a condition");
        }
        if let Some(does) = does {
            self.push(does, place);
        }
        Ok(Kind::Number)
    }

    fn no_variable(&self, name: &str) -> String {
        let meant = match (self.nearest)(name) {
            Some(near) => format!("; did you mean `{near}`?"),
            None if Measure::of_unit(name).is_some() => {
                "; a unit follows a number, with no blanks around its `/` and `*`: `2 N/m`".to_owned()
            }
            None => String::new(),
        };
        format!("there is no variable `{name}`{meant}")
    }

    fn named(&mut self, name: &str, place: Place) -> Result<Kind, FormulaError> {
        let is_call = matches!(self.tokens.get(self.next), Some((Token::Sign("("), _)));
        if !is_call && let Some(number) = (self.known)(name) {
            self.names.push(number);
            self.push(Instruction::Variable(number), place);
            return Ok(Kind::Number);
        }
        match name {
            "not" => {
                if self.expression(5)? != Kind::Truth {
                    return wrong(place, "`not` takes a condition such as `x > 1`");
                }
                self.push(Instruction::Not, place);
                return Ok(Kind::Truth);
            }
            "and" | "or" => return wrong(place, format!("a condition is missing before `{name}`")),
            "pi" if !is_call => {
                self.push(Instruction::Number(core::f64::consts::PI), place);
                return Ok(Kind::Number);
            }
            "log" => return wrong(place, "`log` means two things: write `ln` or `log10`"),
            _ => {}
        }
        let Some((_, function, arguments)) = FUNCTIONS.iter().find(|(known, ..)| *known == name) else {
            return wrong(place, if is_call { no_function(name) } else { self.no_variable(name) });
        };
        self.expect("(", &format!("after `{name}`"))?;
        let mut count = 0;
        loop {
            let begins = self.tokens.get(self.next).map_or(self.end..self.end, |(_, place)| place.clone());
            if self.expression(0)? != Kind::Number {
                return wrong(begins, format!("`{name}` takes numbers, not conditions"));
            }
            count += 1;
            match self.take() {
                Some((Token::Sign(","), _)) => {}
                Some((Token::Sign(")"), _)) => break,
                Some((_, place)) => return wrong(place, format!("`,` or `)` is expected within `{name}(...)`")),
                None => return wrong(self.end..self.end, format!("`)` is missing after `{name}(...`")),
            }
        }
        if (*arguments > 0 && count != *arguments) || count > 64 {
            let wanted = match arguments {
                0 => "up to 64 arguments".to_owned(),
                1 => "1 argument".to_owned(),
                several => format!("{several} arguments"),
            };
            return wrong(place, format!("`{name}` takes {wanted}, not {count}"));
        }
        let all = place.start..self.behind();
        self.push(Instruction::Call(*function, count as u8), all);
        Ok(Kind::Number)
    }
}
