//! A condition over columns of numbers: `max_bearing_load_N > 1.2 MN and end_speed_rad_s < 50`.

use bladeoff_text::document::nearest;
use bladeoff_text::formula::{FormulaError, Kind, Measure, Program, parse_measured};
use std::cell::RefCell;

/// Columns of a table, and their aliases.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// Names of the columns, including parameters, and whether they are numeric.
    pub columns: Vec<(String, bool)>,
    /// Aliases and their columns: paths, endings of paths, short names. An ambiguous alias has one entry for each of its columns.
    pub aliases: Vec<(String, String)>,
    /// Units of columns; a column without an entry accepts any unit.
    pub units: Vec<(String, String)>,
    /// Columns that are empty in every run of the study, and the part or key that the machine lacks.
    pub lacking: Vec<(String, String)>,
}

impl Known {
    /// Columns that a name may refer to: one if it is unique, none if it is unknown.
    #[must_use]
    pub fn meant(&self, name: &str) -> Vec<&str> {
        if let Some((column, _)) = self.columns.iter().find(|(column, _)| column == name) {
            return vec![column];
        }
        self.aliases.iter().filter(|(alias, _)| alias == name).map(|(_, column)| column.as_str()).collect()
    }

    /// Whether a column is numeric.
    #[must_use]
    pub fn is_number(&self, column: &str) -> bool {
        self.columns.iter().any(|(name, is_number)| name == column && *is_number)
    }

    /// Dimension of a column, if known.
    fn measure(&self, column: &str) -> Option<Measure> {
        let (_, unit) = self.units.iter().find(|(name, _)| name == column)?;
        Measure::of_unit(unit)
    }

    /// Reason why a column cannot be used in questions: the machine lacks the measured part, or ok runs have no value.
    #[must_use]
    pub fn lacks(&self, column: &str) -> Option<String> {
        let (_, reason) = self.lacking.iter().find(|(name, _)| name == column)?;
        Some(format!("`{column}` is empty in {reason}"))
    }

    /// The numeric column that a name refers to.
    fn number(&self, name: &str) -> Option<&str> {
        match self.meant(name)[..] {
            [column] if self.is_number(column) && self.lacks(column).is_none() => Some(column),
            _ => None,
        }
    }

    /// The most similar name of a numeric column, for an unknown name.
    #[must_use]
    pub fn near(&self, name: &str) -> Option<&str> {
        let columns = self.columns.iter().filter(|(_, is_number)| *is_number).map(|(column, _)| column.as_str());
        let others = self.aliases.iter().filter(|(_, column)| self.is_number(column)).map(|(alias, _)| alias.as_str());
        nearest(name, columns.chain(others))
    }

    /// Reason why a known name does not refer to one numeric column.
    #[must_use]
    pub fn why_not(&self, name: &str) -> Option<String> {
        match self.meant(name)[..] {
            [] => None,
            [column] if self.is_number(column) => self.lacks(column),
            [_] => Some(format!("`{name}` is a column of words; a formula takes columns of numbers")),
            ref several => Some(format!("`{name}` could be {}", several.join(" or "))),
        }
    }
}

/// A formula and its columns: the n-th column is variable n of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// Text as written.
    pub text: String,
    /// Compiled formula.
    pub program: Program,
    /// Columns of the variables.
    pub columns: Vec<String>,
}

impl Formula {
    /// Parses a condition over the columns of a table.
    ///
    /// # Errors
    /// The first error, with its place.
    pub fn condition(text: &str, known: &Known) -> Result<Self, FormulaError> {
        let columns = RefCell::new(Vec::<String>::new());
        let number = |name: &str| {
            let name = known.number(name)?;
            let mut columns = columns.borrow_mut();
            Some(columns.iter().position(|column| column == name).unwrap_or_else(|| {
                columns.push(name.to_owned());
                columns.len() - 1
            }))
        };
        let near = |name: &str| known.near(name).map(str::to_owned);
        let measure = |number: usize| known.measure(&columns.borrow()[number]);
        let (program, _) = parse_measured(text, Kind::Truth, &number, &near, &measure).map_err(|mut error| {
            let name = text.get(error.place.clone()).unwrap_or("").trim_matches('`');
            // an existing name must not be reported as unknown
            if let Some(why) = known.why_not(name).filter(|_| known.number(name).is_none()) {
                error.message = why;
            }
            error
        })?;
        Ok(Self { text: text.trim().to_owned(), program, columns: columns.into_inner() })
    }
}

/// Length of the text before the parenthesis that closes an open one; names in backquotes are skipped.
pub(crate) fn closing(text: &str) -> Option<usize> {
    let (mut depth, mut quoted) = (1, false);
    for (at, c) in text.char_indices() {
        match c {
            '`' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(at);
        }
    }
    None
}
