//! Conditions of which only bounds of the variables are known: certainly true, certainly false, or open.
//!
//! A condition that is true for every value of its variables is true. One that is open may still be decided by how its variables
//! depend on one another (`x > 1 or x <= 1`): that is not seen, and it stays open, which is the safe side.
//! Comparisons with no number do not hold but `!=`, as in [`bladeoff_text::formula::Program::value`].

use super::span::Span;
use bladeoff_text::formula::{Instruction, Program, call};

/// What is known of a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// It does not hold.
    No,
    /// It may hold.
    Open,
    /// It holds.
    Yes,
}

impl Truth {
    /// From a condition that is known.
    #[must_use]
    pub fn of(holds: bool) -> Self {
        if holds { Self::Yes } else { Self::No }
    }

    /// Whether it counts where what is open does not.
    #[must_use]
    pub fn low(self) -> bool {
        self == Self::Yes
    }

    /// Whether it counts where what is open does.
    #[must_use]
    pub fn high(self) -> bool {
        self != Self::No
    }
}

/// Whether a condition holds for variables that are known; NaN is a column in which nothing happened, which no comparison but `!=` holds for.
/// It is open where the formula itself has no value (the square root of a negative number, 0/0) and the rest does not decide.
pub fn truth_of_known(program: &Program, variables: impl Fn(usize) -> f64, stack: &mut Vec<(f64, bool)>) -> Truth {
    stack.clear();
    let take = |stack: &mut Vec<(f64, bool)>| stack.pop().unwrap_or((f64::NAN, true));
    let said = |holds: bool| f64::from(u8::from(holds));
    for step in program.steps() {
        // a value, and whether it was lost on the way
        let value = match *step {
            Instruction::Number(number) => (number, false),
            Instruction::Variable(number) => (variables(number), false),
            Instruction::Negate => {
                let (a, lost) = take(stack);
                (-a, lost)
            }
            Instruction::Not => {
                let (a, lost) = take(stack);
                (said(a == 0.0), lost)
            }
            Instruction::Call(function, count) => {
                let from = stack.len().saturating_sub(usize::from(count));
                let arguments: Vec<f64> = stack[from..].iter().map(|(value, _)| *value).collect();
                let value = call(function, &arguments);
                let lost = stack[from..].iter().any(|(_, lost)| *lost);
                stack.truncate(from);
                (value, lost || value.is_nan() && arguments.iter().all(|value| !value.is_nan()))
            }
            binary => {
                let (b, lost_b) = take(stack);
                let (a, lost_a) = take(stack);
                let lost = lost_a || lost_b;
                match binary {
                    Instruction::Less => (said(a < b), lost),
                    Instruction::AtMost => (said(a <= b), lost),
                    Instruction::More => (said(a > b), lost),
                    Instruction::AtLeast => (said(a >= b), lost),
                    Instruction::Equal => (said(a == b), lost),
                    Instruction::NotEqual => (said(a != b), lost),
                    // one that certainly does not hold decides
                    Instruction::And => {
                        (said(a != 0.0 && b != 0.0), lost && (a != 0.0 || lost_a) && (b != 0.0 || lost_b))
                    }
                    // one that certainly holds decides
                    Instruction::Or => {
                        (said(a != 0.0 || b != 0.0), lost && (a == 0.0 || lost_a) && (b == 0.0 || lost_b))
                    }
                    other => {
                        let value = arithmetic(other, a, b).unwrap_or(f64::NAN);
                        (value, lost || value.is_nan() && !a.is_nan() && !b.is_nan())
                    }
                }
            }
        };
        stack.push(value);
    }
    match take(stack) {
        (_, true) => Truth::Open,
        (value, false) => Truth::of(value == 1.0),
    }
}

/// Whether a condition holds for variables within their spans; open where a formula in it may have no value and the rest does not decide.
/// `stack` is scratch.
pub fn truth(program: &Program, variables: impl Fn(usize) -> Span, stack: &mut Vec<Span>) -> Truth {
    let found = span(program, variables, stack);
    if found.lost {
        Truth::Open
    } else if found.hi == 0.0 {
        Truth::No
    } else if found.lo == 1.0 && !found.empty {
        Truth::Yes
    } else {
        Truth::Open
    }
}

/// The span of a formula's value; of a truth, 0 and 1 are its ends.
pub fn span(program: &Program, variables: impl Fn(usize) -> Span, stack: &mut Vec<Span>) -> Span {
    stack.clear();
    for step in program.steps() {
        let value = match *step {
            Instruction::Number(number) => Span::point(number),
            Instruction::Variable(number) => variables(number),
            Instruction::Negate => pop(stack).negated(),
            Instruction::Not => {
                let a = pop(stack);
                truths(a.hi == 0.0, a.lo == 1.0, a.lost)
            }
            Instruction::Call(function, count) => {
                let from = stack.len().saturating_sub(usize::from(count));
                let arguments = &stack[from..];
                let known: Option<Vec<f64>> = arguments.iter().map(|argument| argument.known()).collect();
                let value = match known {
                    Some(known) => Span::result(call(function, &known)),
                    None => Span::of(function, arguments),
                };
                stack.truncate(from);
                value
            }
            binary => {
                let b = pop(stack);
                let a = pop(stack);
                of_two(binary, a, b)
            }
        };
        stack.push(value);
    }
    pop(stack)
}

fn pop(stack: &mut Vec<Span>) -> Span {
    stack.pop().unwrap_or(Span::NONE)
}

/// A truth that is certain, or certainly not, or neither; `lost`: what it is about may have no value.
fn truths(yes: bool, no: bool, lost: bool) -> Span {
    Span { lo: f64::from(u8::from(yes)), hi: f64::from(u8::from(!no)), empty: lost, lost }
}

fn of_two(instruction: Instruction, a: Span, b: Span) -> Span {
    if let (Some(x), Some(y)) = (a.known(), b.known())
        && let Some(value) = arithmetic(instruction, x, y)
    {
        return Span::result(value);
    }
    // neither may be no number; one of them has no value at all; one may have lost it
    let (full, none, lost) = (!a.empty && !b.empty, a.lo > a.hi || b.lo > b.hi, a.lost || b.lost);
    // certainly a < b, a <= b
    let (below, at_most) = (a.hi < b.lo, a.hi <= b.lo);
    let (above, at_least) = (a.lo > b.hi, a.lo >= b.hi);
    // certainly true, certainly false
    let (yes, no) = (|a: Span| a.lo == 1.0 && !a.lost, |a: Span| a.hi == 0.0 && !a.lost);
    match instruction {
        Instruction::Add => a.plus(b),
        Instruction::Subtract => a.plus(b.negated()),
        Instruction::Multiply => a.times(b),
        Instruction::Divide => a.over(b),
        Instruction::Power => a.power(b),
        Instruction::Less => truths(full && below, none || at_least, lost),
        Instruction::AtMost => truths(full && at_most, none || above, lost),
        Instruction::More => truths(full && above, none || at_most, lost),
        Instruction::AtLeast => truths(full && at_least, none || below, lost),
        Instruction::Equal => truths(same(a, b), none || below || above, lost),
        Instruction::NotEqual => truths(none || below || above, same(a, b), lost),
        // one that decides does so whatever the other has lost
        Instruction::And => {
            let false_for_certain = no(a) || no(b);
            truths(a.lo == 1.0 && b.lo == 1.0, a.hi == 0.0 || b.hi == 0.0, lost && !false_for_certain)
        }
        // the other steps take one value
        _ => {
            let true_for_certain = yes(a) || yes(b);
            truths(a.lo == 1.0 || b.lo == 1.0, a.hi == 0.0 && b.hi == 0.0, lost && !true_for_certain)
        }
    }
}

fn same(a: Span, b: Span) -> bool {
    a.known().is_some() && a.known() == b.known()
}

fn arithmetic(instruction: Instruction, x: f64, y: f64) -> Option<f64> {
    match instruction {
        Instruction::Add => Some(x + y),
        Instruction::Subtract => Some(x - y),
        Instruction::Multiply => Some(x * y),
        Instruction::Divide => Some(x / y),
        Instruction::Power => Some(libm::pow(x, y)),
        _ => None,
    }
}
