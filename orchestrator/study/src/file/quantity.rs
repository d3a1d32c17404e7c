//! Numbers of one distribution with their units: those of a parameter in its unit; those of a variable in any units of one dimension.

use bladeoff_text::document::cut;
use bladeoff_text::document::units::{parse_any_quantity, parse_bare_or_quantity, parse_quantity, unit_of};
use bladeoff_text::formula::Measure;

/// Reads the numbers of a distribution.
pub(super) struct Quantities {
    /// SI unit of the parameter; `None`: a variable, whose unit is that of its first number.
    unit: Option<&'static str>,
    /// Unit of a variable: that of the first number with a unit.
    first: Option<(String, Measure)>,
}

impl Quantities {
    pub fn new(unit: &'static str, is_variable: bool) -> Self {
        Self { unit: (!is_variable).then_some(unit), first: None }
    }

    /// Reads a number with its unit; an error has the reason and the unit most likely meant.
    pub fn quoted(&mut self, text: &str) -> Result<f64, (String, Option<String>)> {
        match self.unit {
            Some(unit) => parse_quantity(text, unit).map_err(|error| error.parts()),
            None => self.of_variable(text),
        }
    }

    /// Reads a number with a unit, or a bare number in SI units.
    pub fn cell(&mut self, text: &str) -> Result<f64, (String, Option<String>)> {
        match self.unit {
            Some(unit) => parse_bare_or_quantity(text, unit).map_err(|error| error.parts()),
            None => self.of_variable(text),
        }
    }

    /// Bare numbers are in SI units and fit any dimension, as in formulas.
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
