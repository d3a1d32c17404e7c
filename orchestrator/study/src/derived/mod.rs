//! `[[derived]]`: variables computed by formulas of others, in any order of the file.
//!
//! Each formula is evaluated after those that it refers to; of several possible ones, the first in the file comes first (the order changes no
//! value). A circle is rejected with its names. A value that is not finite is an error of the sample, with the values that led to it.

mod names;

pub use names::{NameError, Variable, find, meant, name_mistakes};

use bladeoff_text::document::units::format_digits;
use bladeoff_text::formula::{Kind, Program, parse_measured};
use std::ops::Range;
use thiserror::Error;

/// Error of a formula; [`DerivedError::formula`] returns its index.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DerivedError {
    /// An invalid formula or unknown name.
    #[error("{message}")]
    Formula {
        /// Index of the formula.
        formula: usize,
        /// Byte range in the formula.
        place: Range<usize>,
        /// Reason.
        message: String,
    },
    /// A formula with a variable whose values are words.
    #[error("`{name}` holds words, not numbers")]
    Words {
        /// Index of the formula.
        formula: usize,
        /// The variable.
        name: String,
    },
    /// Formulas that depend on each other in a circle.
    #[error("derived in a circle: {}", circle.join(" needs "))]
    Circle {
        /// Index of the first formula of the circle.
        formula: usize,
        /// The names, the first again at the end.
        circle: Vec<String>,
    },
}

impl DerivedError {
    /// The formula at fault.
    #[must_use]
    pub fn formula(&self) -> usize {
        match self {
            DerivedError::Formula { formula, .. }
            | DerivedError::Words { formula, .. }
            | DerivedError::Circle { formula, .. } => *formula,
        }
    }
}

/// A derived value that is not finite.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} = {value}, derived from {}", from.join(", "))]
pub struct NotFinite {
    /// The variable.
    pub name: String,
    /// NaN or an infinity.
    pub value: f64,
    /// "gap = 0.4 mm" for each variable of the formula.
    pub from: Vec<String>,
}

/// The formulas of a study.
#[derive(Debug, Clone, Default)]
pub struct Derived {
    /// All variables, the derived ones last.
    variables: Vec<Variable>,
    programs: Vec<Program>,
    /// Order of evaluation.
    order: Vec<usize>,
}

impl Derived {
    /// Formulas for the last of the variables, one each.
    ///
    /// # Errors
    /// All mistakes.
    pub fn new(variables: Vec<Variable>, formulas: &[String]) -> Result<Self, Vec<DerivedError>> {
        assert!(formulas.len() <= variables.len(), "a variable for each formula");
        let (mut errors, mut programs) = (Vec::new(), Vec::new());
        for (formula, text) in formulas.iter().enumerate() {
            let known = |name: &str| find(&variables, name);
            let measure = |number: usize| variables[number].measure();
            match parse_measured(text, Kind::Number, &known, &|name| meant(&variables, name), &measure) {
                Ok((program, found)) => {
                    let target = &variables[variables.len() - formulas.len() + formula];
                    if let (Some(found), Some(wanted)) = (found, target.measure())
                        && !found.fits(&wanted)
                    {
                        let (found, wanted, name) = (found.shown(), wanted.shown(), target.shown());
                        let message = format!("the formula is {found}, and `{name}` is {wanted}");
                        errors.push(DerivedError::Formula { formula, place: 0..text.len(), message });
                    }
                    let words = program.variables().iter().filter(|number| variables[**number].has_words);
                    errors.extend(
                        words
                            .map(|number| DerivedError::Words { formula, name: variables[*number].shown().to_owned() }),
                    );
                    programs.push(Some(program));
                }
                Err(error) => {
                    errors.push(DerivedError::Formula { formula, place: error.place, message: error.message });
                    programs.push(None);
                }
            }
        }
        let first = variables.len() - formulas.len();
        let order = order(&programs, first, &variables, &mut errors);
        if !errors.is_empty() {
            errors.sort_by_key(DerivedError::formula);
            return Err(errors);
        }
        Ok(Self { variables, programs: programs.into_iter().flatten().collect(), order })
    }

    /// No formulas.
    #[must_use]
    pub fn none(variables: Vec<Variable>) -> Self {
        Self { variables, ..Self::default() }
    }

    /// All variables, the derived ones last.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Number of derived variables.
    #[must_use]
    pub fn count(&self) -> usize {
        self.programs.len()
    }

    /// Appends the derived values to those of the other variables; `stack` is scratch memory.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn extend(&self, values: &mut Vec<f64>, stack: &mut Vec<f64>) -> Result<(), NotFinite> {
        let first = self.variables.len() - self.programs.len();
        assert_eq!(values.len(), first, "a value for each variable");
        values.resize(self.variables.len(), f64::NAN);
        for &formula in &self.order {
            let value = self.programs[formula].value(|number| values[number], stack);
            if !value.is_finite() {
                return Err(self.not_finite(formula, value, values));
            }
            values[first + formula] = value;
        }
        Ok(())
    }

    fn not_finite(&self, formula: usize, value: f64, values: &[f64]) -> NotFinite {
        let first = self.variables.len() - self.programs.len();
        let from = self.programs[formula].variables().iter().map(|&number| {
            let variable = &self.variables[number];
            format!("{} = {}", variable.shown(), format_digits(values[number], &variable.unit, 6))
        });
        NotFinite { name: self.variables[first + formula].shown().to_owned(), value, from: from.collect() }
    }
}

/// Order of evaluation in which each formula follows those that it depends on; circles are reported.
fn order(
    programs: &[Option<Program>],
    first: usize,
    variables: &[Variable],
    errors: &mut Vec<DerivedError>,
) -> Vec<usize> {
    let needs = |formula: usize| {
        // an unreadable formula depends on nothing
        let needed = programs[formula].as_ref().map_or(&[][..], Program::variables);
        needed.iter().filter_map(|number| number.checked_sub(first))
    };
    let mut done = vec![false; programs.len()];
    let mut order = Vec::with_capacity(programs.len());
    while order.len() < programs.len() {
        let ready = (0..programs.len()).find(|&formula| !done[formula] && needs(formula).all(|needed| done[needed]));
        if let Some(ready) = ready {
            done[ready] = true;
            order.push(ready);
            continue;
        }
        // each remaining formula depends on a remaining one, so following the dependencies leads into a circle
        let start = (0..programs.len()).find(|&formula| !done[formula]).expect("some are left");
        let mut way = vec![start];
        let circle = loop {
            let next = needs(way[way.len() - 1]).find(|needed| !done[*needed]).expect("one is left");
            if let Some(place) = way.iter().position(|seen| *seen == next) {
                break way.split_off(place);
            }
            way.push(next);
        };
        let names = circle.iter().chain(&circle[..1]).map(|formula| variables[first + formula].shown().to_owned());
        let least = circle.iter().copied().min().expect("a circle has a formula");
        errors.push(DerivedError::Circle { formula: least, circle: names.collect() });
        // continue with further circles
        for formula in circle {
            done[formula] = true;
            order.push(formula);
        }
    }
    order
}
