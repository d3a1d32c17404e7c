//! Worst value and first answer of a run in progress, for the progress line: from ok rows in the order in which they end.
//!
//! Short runs end first, so these values are not estimates. `answer` uses the points up to the first missing one.

use bladeoff_answers::estimate::formula::Formula;
use bladeoff_answers::estimate::truth::{Truth, truth_of_known};
use bladeoff_answers::figures::plain_name;
use bladeoff_answers::tables::Field;
use bladeoff_model::outcome::{Outcome, Status};
use bladeoff_text::document::units::format_digits;

/// Result that is shown for a study without questions.
const DEFAULT: &str = "max_bearing_load_N";

/// Quantities that the progress line shows.
#[derive(Debug, Clone, Default)]
pub struct Watched {
    /// Columns that questions name, in their order; the first one with numbers in the outcome is shown.
    pub columns: Vec<String>,
    /// Names and conditions of the questions for a probability; the first one of results alone is shown.
    pub probabilities: Vec<(String, Formula)>,
}

/// Results of the run so far.
#[derive(Debug, Default)]
pub(super) struct SoFar {
    worst: Option<Worst>,
    answer: Option<FirstAnswer>,
}

/// Largest value of a result in the ok rows of this run.
#[derive(Debug)]
struct Worst {
    name: String,
    unit: String,
    /// Index among the values of an outcome.
    place: usize,
    largest: Option<f64>,
}

/// The first question for a probability of results alone.
#[derive(Debug)]
struct FirstAnswer {
    name: String,
    formula: Formula,
    /// Index of each column of the formula among the values of an outcome.
    places: Vec<usize>,
    events: u64,
    rows: u64,
    /// Number of rows that are not ok, whose event is not counted.
    others: u64,
}

impl SoFar {
    /// Creates the state for outcomes with the values `fields`.
    pub fn new(watched: &Watched, fields: &[Field]) -> Self {
        let place = |column: &str| fields.iter().position(|field| field.name == column);
        let shown = watched.columns.iter().map(String::as_str).chain([DEFAULT]).find_map(place);
        let worst = shown.map(|place| Worst {
            name: plain_name(&fields[place].name, &fields[place].unit),
            unit: fields[place].unit.clone(),
            place,
            largest: None,
        });
        let answer = watched.probabilities.iter().find_map(|(name, formula)| {
            let places: Option<Vec<usize>> = formula.columns.iter().map(|column| place(column)).collect();
            Some(FirstAnswer {
                name: name.clone(),
                formula: formula.clone(),
                places: places?,
                events: 0,
                rows: 0,
                others: 0,
            })
        });
        Self { worst, answer }
    }

    /// Adds the outcome of a sample.
    pub fn see(&mut self, outcome: &Outcome) {
        if outcome.status != Status::Ok {
            self.answer.iter_mut().for_each(|answer| answer.others += 1);
            return;
        }
        let value = |place: usize| outcome.values.get(place).copied().flatten();
        if let Some(worst) = &mut self.worst {
            worst.largest = value(worst.place).into_iter().chain(worst.largest).reduce(f64::max);
        }
        if let Some(FirstAnswer { formula, places, events, rows, .. }) = &mut self.answer {
            let known = |variable: usize| places.get(variable).and_then(|place| value(*place)).unwrap_or(f64::NAN);
            *rows += 1;
            *events += u64::from(truth_of_known(&formula.program, known, &mut Vec::new()) == Truth::Yes);
        }
    }

    /// The values in words: "largest max bearing load 1.2 MN, overload 3 of 40 ok runs (2 not ok)"; empty before the first ok row.
    pub fn text(&self) -> String {
        let worst = self.worst.iter().filter_map(|worst| {
            Some(format!(
                "largest {} {}",
                worst.name.trim_start_matches("max "),
                format_digits(worst.largest?, &worst.unit, 3)
            ))
        });
        let answer = self.answer.iter().filter(|answer| answer.rows > 0);
        let answer = answer.map(|FirstAnswer { name, events, rows, others, .. }| match others {
            0 => format!("{name} {events} of {rows} ok runs"),
            _ => format!("{name} {events} of {rows} ok runs ({others} not ok)"),
        });
        worst.chain(answer).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_answers::estimate::formula::Known;
    use bladeoff_answers::tables::FieldKind;
    use bladeoff_model::outcome::{CauseSet, EndCause};

    #[test]
    fn ok_rows_alone_are_counted() {
        let known = Known { columns: vec![(DEFAULT.to_owned(), true)], ..Known::default() };
        let formula = Formula::condition("max_bearing_load_N > 1.5e6", &known).expect("a condition");
        let watched = Watched { columns: Vec::new(), probabilities: vec![("overload".to_owned(), formula)] };
        let field =
            |name: &str| Field { name: name.into(), unit: "N".into(), meaning: String::new(), kind: FieldKind::Real };
        let mut known = SoFar::new(&watched, &[field("other_N"), field(DEFAULT)]);
        assert_eq!(known.text(), "");
        for (status, load) in [(Status::Ok, 1.6e6), (Status::Ok, 0.2e6), (Status::Invalid, 9e9)] {
            known.see(&Outcome {
                status,
                cause: None,
                causes: CauseSet::default(),
                notes: CauseSet::default(),
                end_cause: EndCause::EndTime,
                values: vec![None, Some(load)],
            });
        }
        assert_eq!(known.text(), "largest bearing load 1.6 MN, overload 1 of 2 ok runs (1 not ok)");
    }
}
