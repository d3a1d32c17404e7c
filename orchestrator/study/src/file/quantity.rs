//! Numbers of one law with their units: those of a parameter in its unit; those of a variable in any, but all of one dimension.

use bladeoff_text::document::cut;
use bladeoff_text::document::units::{parse_any_quantity, parse_bare_or_quantity, parse_quantity, unit_of};
use bladeoff_text::formula::Measure;

/// Reads the numbers of a law.
pub(super) struct Quantities {
    /// SI unit of the parameter; `None`: a variable, which has the unit that it is given.
    unit: Option<&'static str>,
    /// Unit of a variable: the first one that a number has.
    first: Option<(String, Measure)>,
}

impl Quantities {
    pub fn new(unit: &'static str, is_variable: bool) -> Self {
        Self { unit: (!is_variable).then_some(unit), first: None }
    }

    /// A number with its unit, or what is wrong with it and the unit most likely meant.
    pub fn quoted(&mut self, text: &str) -> Result<f64, (String, Option<String>)> {
        match self.unit {
            Some(unit) => parse_quantity(text, unit).map_err(|error| error.parts()),
            None => self.of_variable(text),
        }
    }

    /// Reads a number with a unit, or a number without one, which is in SI.
    pub fn cell(&mut self, text: &str) -> Result<f64, (String, Option<String>)> {
        match self.unit {
            Some(unit) => parse_bare_or_quantity(text, unit).map_err(|error| error.parts()),
            None => self.of_variable(text),
        }
    }

    /// Bare numbers are SI and fit any dimension, as in formulas.
    fn of_variable(&mut self, text: &str) -> Result<f64, (String, Option<String>)> {
        let number = parse_any_quantity(text).map_err(|error| error.parts())?;
        let unit = unit_of(text);
        if unit.is_empty() {
            return Ok(number);
        }
        match &self.first {
            Some((first, _)) if first == unit => Ok(number),
            Some((first, measure)) if Measure::of_unit(unit).is_none_or(|found| !found.fits(measure)) => {
                let [unit, first] = [unit, first].map(|unit| cut(unit, 60));
                Err((
                    format!("the unit `{unit}` does not fit: other numbers of the same distribution are in `{first}`"),
                    None,
                ))
            }
            Some(_) => Ok(number),
            None => {
                self.first = Measure::of_unit(unit).map(|measure| (unit.to_owned(), measure));
                Ok(number)
            }
        }
    }
}
