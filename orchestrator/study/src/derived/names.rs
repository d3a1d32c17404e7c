//! The variables of a study with a design, and their names in formulas.

use bladeoff_text::document::nearest;
use bladeoff_text::formula::{Measure, is_reserved};
use thiserror::Error;

/// One variable: an uncertain parameter, one of `[[vary]]`, or a derived one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// A parameter's path, or the name of an auxiliary variable.
    pub name: String,
    /// Short name, `as`.
    pub short: Option<String>,
    /// SI unit; "" for none.
    pub unit: String,
    /// Whether the values are words, which formulas cannot use.
    pub has_words: bool,
}

impl Variable {
    /// A numeric variable.
    #[must_use]
    pub fn number(name: &str, short: Option<&str>, unit: &str) -> Self {
        Self { name: name.to_owned(), short: short.map(str::to_owned), unit: unit.to_owned(), has_words: false }
    }

    /// Column in a result table: the short name or the path, with the SI unit appended as in every column.
    #[must_use]
    pub fn column(&self) -> String {
        let unit: String = self.unit.chars().filter(|c| *c != ' ').map(|c| if c == '/' { '_' } else { c }).collect();
        if unit.is_empty() || self.has_words { self.shown().to_owned() } else { format!("{}_{unit}", self.shown()) }
    }

    /// Dimension of the variable. A variable of formulas, whose name has no dot, has none and fits any dimension.
    #[must_use]
    pub fn measure(&self) -> Option<Measure> {
        let has_one = !self.has_words && self.name.contains('.');
        if has_one { Measure::of_unit(&self.unit) } else { None }
    }

    /// The name shown to the user: the short name if there is one.
    #[must_use]
    pub fn shown(&self) -> &str {
        self.short.as_deref().unwrap_or(&self.name)
    }
}

/// Reason for rejecting a name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NameError {
    /// The name has characters that formulas do not allow in names.
    #[error(
        "{name:?} cannot be a name; allowed: letters of the English alphabet, digits and `_`, the first no digit, at most 64"
    )]
    Letters {
        /// Index of the variable.
        variable: usize,
        /// The name.
        name: String,
    },
    /// The name is a word of the formula language.
    #[error("`{name}` is a word of formulas; allowed: another name")]
    Reserved {
        /// Index of the variable.
        variable: usize,
        /// The name.
        name: String,
    },
    /// Another variable has the same name.
    #[error("`{name}` is already the name of {first}; allowed: another name")]
    Taken {
        /// Index of the variable.
        variable: usize,
        /// The name.
        name: String,
        /// Variable that has the name already.
        first: String,
    },
}

/// All invalid names: short names, and names that are not paths. `is_path` identifies the variables named by a path.
#[must_use]
pub fn name_mistakes(variables: &[Variable], is_path: impl Fn(usize) -> bool) -> Vec<NameError> {
    let mut errors = Vec::new();
    for (number, variable) in variables.iter().enumerate() {
        let own = (!is_path(number)).then_some(&variable.name);
        for name in own.into_iter().chain(&variable.short) {
            let letters = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && name.len() <= 64
                && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
            if !letters {
                errors.push(NameError::Letters { variable: number, name: name.chars().take(80).collect() });
            } else if is_reserved(name) {
                errors.push(NameError::Reserved { variable: number, name: name.clone() });
            }
        }
        let earlier = &variables[..number];
        let has = |other: &Variable, name: &String| other.name == *name || other.short.as_ref() == Some(name);
        let names = std::iter::once(&variable.name).chain(&variable.short);
        errors.extend(names.filter_map(|name| {
            let first = earlier.iter().find(|other| has(other, name))?;
            Some(NameError::Taken { variable: number, name: name.clone(), first: first.name.clone() })
        }));
    }
    errors
}

/// The variable of a name: a short name, a full name, or an unambiguous ending of a path from a dot on.
#[must_use]
pub fn find(variables: &[Variable], name: &str) -> Option<usize> {
    let exact = |variable: &Variable| variable.short.as_deref() == Some(name) || variable.name == name;
    if let Some(found) = variables.iter().position(exact) {
        return Some(found);
    }
    let mut found = endings(variables, name);
    let (number, _) = found.next()?;
    found.next().is_none().then_some(number)
}

fn endings<'a>(variables: &'a [Variable], name: &'a str) -> impl Iterator<Item = (usize, &'a Variable)> {
    let ends_so = move |variable: &Variable| {
        !name.is_empty() && variable.name.strip_suffix(name).is_some_and(|rest| rest.ends_with('.'))
    };
    variables.iter().enumerate().filter(move |(_, variable)| ends_so(variable))
}

/// The name most likely meant by an unknown name.
#[must_use]
pub fn meant(variables: &[Variable], name: &str) -> Option<String> {
    if let Some((_, variable)) = endings(variables, name).next() {
        return Some(variable.name.clone());
    }
    let names = variables.iter().flat_map(|variable| std::iter::once(&variable.name).chain(&variable.short));
    nearest(name, names.map(String::as_str)).map(str::to_owned)
}
