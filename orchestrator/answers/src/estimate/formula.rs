//! A condition over columns of numbers: `max_bearing_load_N > 1.2 MN and end_speed_rad_s < 50`.

use bladeoff_model::document::nearest;
use bladeoff_model::formula::{FormulaError, Kind, Program, parse};
use std::cell::RefCell;

/// A formula and the columns that it needs: the n-th is variable n of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// As written.
    pub text: String,
    /// To be evaluated.
    pub program: Program,
    /// Its columns.
    pub columns: Vec<String>,
}

impl Formula {
    /// A condition; `known`: columns of the table, and whether they have numbers.
    ///
    /// # Errors
    /// The first mistake, with its place.
    pub fn condition(text: &str, known: &[(String, bool)]) -> Result<Self, FormulaError> {
        let columns = RefCell::new(Vec::<String>::new());
        let number = |name: &str| {
            known.iter().find(|(column, is_number)| column == name && *is_number)?;
            let mut columns = columns.borrow_mut();
            Some(columns.iter().position(|column| column == name).unwrap_or_else(|| {
                columns.push(name.to_owned());
                columns.len() - 1
            }))
        };
        let near = |name: &str| nearest(name, numbers(known)).map(str::to_owned);
        let program = parse(text, Kind::Truth, &number, &near).map_err(|error| with_words(error, text, known))?;
        Ok(Self { text: text.trim().to_owned(), program, columns: columns.into_inner() })
    }
}

/// A column of words is no variable: it is said to be there.
fn with_words(mut error: FormulaError, text: &str, known: &[(String, bool)]) -> FormulaError {
    let name = text.get(error.place.clone()).unwrap_or("").trim_matches('`');
    if known.iter().any(|(column, is_number)| column == name && !is_number) {
        error.message = format!("`{name}` is a column of words; a formula takes columns of numbers");
    }
    error
}

/// Names of the columns of numbers.
pub fn numbers(known: &[(String, bool)]) -> impl Iterator<Item = &str> {
    known.iter().filter(|(_, is_number)| *is_number).map(|(name, _)| name.as_str())
}
