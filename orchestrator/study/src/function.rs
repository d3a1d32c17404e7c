//! `model = "function"`: what a study without a machine computes, formulas of its variables (`[function] g = "x^2 - y"`).
//!
//! The variables are those of the study's table, in their order: what is uncertain, what varies, what is derived. No formula names
//! another's output; what several share is a derived variable. Each output is a column, so it cannot have the name of another one.

use super::axis::MOST_VARIED;
use super::derived::{Variable, find, meant};
use bladeoff_model::machine::ParamValue;
use bladeoff_text::formula::{Kind, Program, is_reserved, parse};
use std::ops::Range;
use thiserror::Error;

/// Most outputs of a function study.
pub const MOST_OUTPUTS: usize = 100;

/// Columns that tables of studies have by themselves: no variable and no output can have such a name.
pub const OWN_COLUMNS: [&str; 9] =
    ["sample", "status", "cause", "causes", "end_cause", "notes", "detection", "replicate", "block"];

/// One formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name, and that of its column.
    pub name: String,
    /// The formula as it stands in the file.
    pub text: String,
    /// Formula as a program.
    pub program: Program,
}

/// Formulas of a function study.
#[derive(Debug, Clone, PartialEq)]
pub struct FunctionModel {
    /// In the order of the file, at least one.
    pub outputs: Vec<Output>,
}

/// Error of `[function]`, with its key by [`FunctionError::output`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FunctionError {
    /// A formula that cannot be read, or names what is not there.
    #[error("{message}")]
    Formula {
        /// Name of the formula.
        output: usize,
        /// Place in the formula \[bytes\].
        place: Range<usize>,
        /// Why.
        message: String,
    },
    /// A formula with a variable whose values are words.
    #[error("`{name}` holds words, not numbers")]
    Words {
        /// Name of the formula.
        output: usize,
        /// The variable.
        name: String,
    },
    /// A name that is no word of formulas.
    #[error(
        "{name:?} cannot be a name; allowed: letters of the English alphabet, digits and `_`, the first no digit, at most 64"
    )]
    Letters {
        /// Output.
        output: usize,
        /// The name, cut.
        name: String,
    },
    /// A word that formulas have already.
    #[error("`{name}` is a word of formulas; allowed: another name")]
    Reserved {
        /// Output.
        output: usize,
        /// The name.
        name: String,
    },
    /// A column of that name is there already.
    #[error("{what} has the name `{name}`; allowed: another name, for each output is a column of the table")]
    Taken {
        /// Output.
        output: usize,
        /// The name.
        name: String,
        /// Holder of the name.
        what: String,
    },
    /// There is nothing to compute.
    #[error("no formula; allowed: 1 to {MOST_OUTPUTS}, such as g = \"3 - x\"")]
    Nothing,
    /// More formulas than a message has room for.
    #[error("{count} formulas; allowed: at most {MOST_OUTPUTS}")]
    TooMany {
        /// Number found.
        count: usize,
    },
    /// More variables than a message has room for.
    #[error("{count} variables; allowed: at most {MOST_VARIED}")]
    TooManyVariables {
        /// Number found.
        count: usize,
    },
}

impl FunctionError {
    /// The output at fault; `None`: all of them together.
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
    /// The model of these outputs (name and formula), in their order, over these variables.
    ///
    /// # Errors
    /// Every mistake, in the order of the outputs.
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

    /// Identity of what is computed, without the values of the variables: equal for equal names and texts in their order.
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
