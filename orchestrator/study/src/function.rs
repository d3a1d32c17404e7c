//! `model = "function"`: a study without a machine, which computes formulas of its variables (`[function] g = "x^2 - y"`).
//!
//! The variables are those of the study's table, in order: uncertain, varied, derived. A formula cannot refer to the output of another one;
//! common parts are derived variables. Each output is a column, so its name must differ from those of all other columns.

use super::axis::MOST_VARIED;
use super::derived::{Variable, find, meant};
use bladeoff_model::machine::ParamValue;
use bladeoff_text::formula::{Kind, Program, is_reserved, parse};
use std::ops::Range;
use thiserror::Error;

/// Most outputs of a function study.
pub const MOST_OUTPUTS: usize = 100;

/// Standard columns of every study's table: variables and outputs must not have these names.
pub const OWN_COLUMNS: [&str; 9] =
    ["sample", "status", "cause", "causes", "end_cause", "notes", "detection", "replicate", "block"];

/// One formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Name of the output and of its column.
    pub name: String,
    /// The formula as written.
    pub text: String,
    /// Formula as a program.
    pub program: Program,
}

/// The formulas of a study without a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct FunctionModel {
    /// Outputs in the order of the file, at least one.
    pub outputs: Vec<Output>,
}

/// Error of `[function]`; [`FunctionError::output`] returns the output concerned.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FunctionError {
    /// A formula that is invalid or has an unknown name.
    #[error("{message}")]
    Formula {
        /// Index of the output.
        output: usize,
        /// Byte range in the formula.
        place: Range<usize>,
        /// Reason.
        message: String,
    },
    /// A formula with a variable whose values are words.
    #[error("`{name}` holds words, not numbers")]
    Words {
        /// Index of the output.
        output: usize,
        /// The variable.
        name: String,
    },
    /// The name has characters that formulas do not allow in names.
    #[error(
        "{name:?} cannot be a name; allowed: letters of the English alphabet, digits and `_`, the first no digit, at most 64"
    )]
    Letters {
        /// Index of the output.
        output: usize,
        /// The name, shortened.
        name: String,
    },
    /// The name is a word of the formula language.
    #[error("`{name}` is a word of formulas; allowed: another name")]
    Reserved {
        /// Index of the output.
        output: usize,
        /// The name.
        name: String,
    },
    /// Another column has the same name.
    #[error("{what} has the name `{name}`; allowed: another name, for each output is a column of the table")]
    Taken {
        /// Index of the output.
        output: usize,
        /// The name.
        name: String,
        /// Column that has the name already.
        what: String,
    },
    /// There are no formulas.
    #[error("no formula; allowed: 1 to {MOST_OUTPUTS}, such as g = \"3 - x\"")]
    Nothing,
    /// More formulas than fit in a message.
    #[error("{count} formulas; allowed: at most {MOST_OUTPUTS}")]
    TooMany {
        /// Number found.
        count: usize,
    },
    /// More variables than fit in a message.
    #[error("{count} variables; allowed: at most {MOST_VARIED}")]
    TooManyVariables {
        /// Number found.
        count: usize,
    },
}

impl FunctionError {
    /// Index of the output at fault; `None`: the error concerns all outputs.
    #[must_use]
    pub fn output(&self) -> Option<usize> {
        match self {
            Self::Formula { output, .. }
            | Self::Words { output, .. }
            | Self::Letters { output, .. }
            | Self::Reserved { output, .. }
            | Self::Taken { output, .. } => Some(*output),
            Self::TooMany { .. } => Some(MOST_OUTPUTS),
            Self::Nothing | Self::TooManyVariables { .. } => None,
        }
    }
}

impl FunctionModel {
    /// The model with these outputs (name and formula), in order, and these variables.
    ///
    /// # Errors
    /// All mistakes, in the order of the outputs.
    pub fn new(outputs: &[(String, String)], variables: &[Variable]) -> Result<Self, Vec<FunctionError>> {
        let mut errors = Vec::new();
        if variables.len() > MOST_VARIED {
            errors.push(FunctionError::TooManyVariables { count: variables.len() });
        }
        if outputs.is_empty() {
            errors.push(FunctionError::Nothing);
        }
        let mut made = Vec::with_capacity(outputs.len());
        for (output, (name, text)) in outputs.iter().enumerate().take(MOST_OUTPUTS) {
            errors.extend(name_mistake(output, name, &outputs[..output], variables));
            let nearest_name = |name: &str| meant(variables, name);
            match parse(text, Kind::Number, &|name| find(variables, name), &nearest_name) {
                Ok(program) => {
                    let words = program.variables().iter().filter(|number| variables[**number].has_words);
                    errors.extend(words.map(|number| {
                        let name = variables[*number].shown().to_owned();
                        FunctionError::Words { output, name }
                    }));
                    made.push(Output { name: name.clone(), text: text.clone(), program });
                }
                Err(error) => {
                    errors.push(FunctionError::Formula { output, place: error.place, message: error.message })
                }
            }
        }
        if outputs.len() > MOST_OUTPUTS {
            errors.push(FunctionError::TooMany { count: outputs.len() });
        }
        if errors.is_empty() { Ok(Self { outputs: made }) } else { Err(errors) }
    }

    /// Identity of the formulas without the values of the variables: equal for equal names and texts in the same order.
    #[must_use]
    pub fn identity(&self) -> u128 {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"function");
        for word in self.outputs.iter().flat_map(|output| [&output.name, &output.text]) {
            hasher.update(&(word.len() as u64).to_le_bytes()).update(word.as_bytes());
        }
        cut(&hasher)
    }

    /// Term of a variable's value in the identity of a sample (wrapping sum), as for the parameters of a machine.
    #[must_use]
    pub fn identity_of(variable: &str, value: &ParamValue) -> u128 {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"variable").update(variable.as_bytes());
        match value {
            ParamValue::Number(number) => hasher.update(&[0, 1]).update(&number.to_bits().to_le_bytes()),
            ParamValue::Choice(word) => hasher.update(&[0, 2]).update(word.as_bytes()),
        };
        cut(&hasher)
    }
}

fn cut(hasher: &blake3::Hasher) -> u128 {
    u128::from_le_bytes(*hasher.finalize().as_bytes().first_chunk().expect("a hash has 32 bytes"))
}

fn name_mistake(
    output: usize,
    name: &str,
    earlier: &[(String, String)],
    variables: &[Variable],
) -> Option<FunctionError> {
    let letters = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.len() <= 64
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    if !letters {
        return Some(FunctionError::Letters { output, name: name.chars().take(80).collect() });
    }
    let name = name.to_owned();
    if is_reserved(&name) {
        return Some(FunctionError::Reserved { output, name });
    }
    let is_of = |variable: &&Variable| {
        variable.name == name || variable.short.as_ref() == Some(&name) || variable.column() == name
    };
    let what = if OWN_COLUMNS.contains(&name.as_str()) {
        "a column of every table".to_owned()
    } else if let Some(variable) = variables.iter().find(is_of) {
        format!("the variable {}", variable.shown())
    } else if earlier.iter().any(|(other, _)| *other == name) {
        "an output before it".to_owned()
    } else {
        return None;
    };
    Some(FunctionError::Taken { output, name, what })
}
