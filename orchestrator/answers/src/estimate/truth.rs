//! Truth of a condition whose variables are known only within bounds: certainly true, certainly false, or open.
//!
//! A condition is true if it holds for every value of its variables within the bounds. A condition that is true only because its variables
//! depend on one another (`x > 1 or x <= 1`) is not recognised and stays open, which is conservative.
//! No comparison with a missing number holds except `!=`, as in [`bladeoff_text::formula::Program::value`].

use super::span::Span;
use bladeoff_text::formula::{Instruction, Program, call};

/// Truth of a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// The condition does not hold.
    No,
    /// The condition may hold.
    Open,
    /// The condition holds.
    Yes,
}

impl Truth {
    /// Truth of a condition that is known.
    #[must_use]
    pub fn of(holds: bool) -> Self {
        if holds { Self::Yes } else { Self::No }
    }

    /// Whether the condition counts as an event if open conditions do not.
    #[must_use]
    pub fn low(self) -> bool {
        self == Self::Yes
    }

    /// Whether the condition counts as an event if open conditions do.
    #[must_use]
    pub fn high(self) -> bool {
        self != Self::No
    }
}

/// Truth of a condition for known variables. NaN is an empty cell, for which no comparison except `!=` holds. The condition is open if
/// its formula has no value (square root of a negative number, 0/0) and the remaining terms do not determine it.
pub fn truth_of_known(program: &Program, variables: impl Fn(usize) -> f64, stack: &mut Vec<(f64, bool)>) -> Truth {
    stack.clear();
    let take = |stack: &mut Vec<(f64, bool)>| stack.pop().unwrap_or((f64::NAN, true));
    let said = |holds: bool| f64::from(u8::from(holds));
    for step in program.steps() {
        // a value, and whether it was lost in the calculation
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
                    // one operand that certainly does not hold is sufficient
                    Instruction::And => {
                        (said(a != 0.0 && b != 0.0), lost && (a != 0.0 || lost_a) && (b != 0.0 || lost_b))
                    }
                    // one operand that certainly holds is sufficient
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

/// Truth of a condition for variables within their spans. Open if a formula in it may have no value and the remaining terms do not determine it.
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

/// Span of a formula's value; for a condition the bounds are 0 and 1.
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

/// Span of a condition that is certainly true, certainly false, or neither; `lost`: an operand may have no value.
fn truths(yes: bool, no: bool, lost: bool) -> Span {
    Span { lo: f64::from(u8::from(yes)), hi: f64::from(u8::from(!no)), empty: lost, lost }
}

fn of_two(instruction: Instruction, a: Span, b: Span) -> Span {
    if let (Some(x), Some(y)) = (a.known(), b.known())
        && let Some(value) = arithmetic(instruction, x, y)
    {
        return Span::result(value);
    }
    // neither operand may be missing; one is certainly missing; one may be lost
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
        // an operand that determines the result does so even if the other is lost
        Instruction::And => {
            let false_for_certain = no(a) || no(b);
            truths(a.lo == 1.0 && b.lo == 1.0, a.hi == 0.0 || b.hi == 0.0, lost && !false_for_certain)
        }
        // all other instructions have one operand
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
