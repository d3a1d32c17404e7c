//! A formula as a program for a stack machine. The result has the same bytes everywhere: plain operations in order, functions from `libm`.

/// Type of a formula's result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number,
    /// True or false.
    Truth,
}

/// Functions of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// `|a|`.
    Abs,
    /// Square root.
    Sqrt,
    /// `e^a`.
    Exp,
    /// Natural logarithm.
    Ln,
    /// Logarithm to the base 10.
    Log10,
    /// Sine, of radians.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Arc sine.
    Asin,
    /// Arc cosine.
    Acos,
    /// Arc tangent.
    Atan,
    /// Angle of the point (b, a).
    Atan2,
    /// `sqrt(a^2 + b^2)`.
    Hypot,
    /// Largest whole number that does not exceed the argument.
    Floor,
    /// Smallest argument; NaN if any argument is NaN.
    Min,
    /// Largest argument; NaN if any argument is NaN.
    Max,
}

/// One step of a program; true is 1, false is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instruction {
    /// Puts a number on the stack.
    Number(f64),
    /// Puts a variable on the stack.
    Variable(usize),
    /// a + b.
    Add,
    /// a - b.
    Subtract,
    /// a b.
    Multiply,
    /// a / b.
    Divide,
    /// a^b.
    Power,
    /// -a.
    Negate,
    /// a < b.
    Less,
    /// a <= b.
    AtMost,
    /// a > b.
    More,
    /// a >= b.
    AtLeast,
    /// a == b.
    Equal,
    /// a != b.
    NotEqual,
    /// True if both operands are true.
    And,
    /// True if at least one operand is true.
    Or,
    /// True if the operand is false.
    Not,
    /// A function with this number of arguments from the stack.
    Call(Function, u8),
}

/// A formula that can be evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    steps: Vec<Instruction>,
    names: Vec<usize>,
}

impl Program {
    /// The steps in order.
    #[must_use]
    pub fn steps(&self) -> &[Instruction] {
        &self.steps
    }

    pub(super) fn new(steps: Vec<Instruction>, names: Vec<usize>) -> Self {
        Self { steps, names }
    }

    /// Numbers of the variables used, ascending.
    #[must_use]
    pub fn variables(&self) -> &[usize] {
        &self.names
    }

    /// The value for these variables. NaN and infinities are returned unchanged; a comparison with NaN is false, except for `!=`.
    /// `stack` is scratch memory.
    pub fn value(&self, variables: impl Fn(usize) -> f64, stack: &mut Vec<f64>) -> f64 {
        stack.clear();
        let truth = |holds: bool| f64::from(u8::from(holds));
        for step in &self.steps {
            let value = match *step {
                Instruction::Number(number) => number,
                Instruction::Variable(number) => variables(number),
                Instruction::Negate => -pop(stack),
                Instruction::Not => truth(pop(stack) == 0.0),
                Instruction::Call(function, count) => {
                    let from = stack.len().saturating_sub(usize::from(count));
                    let value = call(function, &stack[from..]);
                    stack.truncate(from);
                    value
                }
                binary => {
                    let b = pop(stack);
                    let a = pop(stack);
                    match binary {
                        Instruction::Add => a + b,
                        Instruction::Subtract => a - b,
                        Instruction::Multiply => a * b,
                        Instruction::Divide => a / b,
                        Instruction::Power => libm::pow(a, b),
                        Instruction::Less => truth(a < b),
                        Instruction::AtMost => truth(a <= b),
                        Instruction::More => truth(a > b),
                        Instruction::AtLeast => truth(a >= b),
                        Instruction::Equal => truth(a == b),
                        Instruction::NotEqual => truth(a != b),
                        Instruction::And => truth(a != 0.0 && b != 0.0),
                        _ => truth(a != 0.0 || b != 0.0),
                    }
                }
            };
            stack.push(value);
        }
        pop(stack)
    }
}

/// Removes the top of the stack; the parser ensures that there is one.
fn pop(stack: &mut Vec<f64>) -> f64 {
    stack.pop().unwrap_or(f64::NAN)
}

/// Value of a function with at least one argument.
#[must_use]
pub fn call(function: Function, arguments: &[f64]) -> f64 {
    let (a, b) = (arguments[0], arguments[arguments.len() - 1]);
    // NaN in any argument makes the result NaN
    let fold = |pick: fn(f64, f64) -> f64| {
        let step = |kept: f64, next: &f64| if kept.is_nan() || next.is_nan() { f64::NAN } else { pick(kept, *next) };
        arguments[1..].iter().fold(a, step)
    };
    match function {
        Function::Abs => a.abs(),
        Function::Sqrt => libm::sqrt(a),
        Function::Exp => libm::exp(a),
        Function::Ln => libm::log(a),
        Function::Log10 => libm::log10(a),
        Function::Sin => libm::sin(a),
        Function::Cos => libm::cos(a),
        Function::Tan => libm::tan(a),
        Function::Asin => libm::asin(a),
        Function::Acos => libm::acos(a),
        Function::Atan => libm::atan(a),
        Function::Atan2 => libm::atan2(a, b),
        Function::Hypot => libm::hypot(a, b),
        Function::Floor => libm::floor(a),
        Function::Min => fold(|a, b| if b < a { b } else { a }),
        Function::Max => fold(|a, b| if b > a { b } else { a }),
    }
}
