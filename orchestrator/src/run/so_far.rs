//! Worst value and first answer of a run in progress, for the progress line: from ok rows in the order in which they end.
//!
//! Short runs end first, so this is no estimate. `answer` uses the points up to the first missing one.

use crate::questions::{Source, columns_asked, meant};
use bladeoff_answers::ask::{Ask, Figure};
use bladeoff_answers::estimate::formula::Formula;
use bladeoff_answers::estimate::truth::{Truth, truth_of_known};
use bladeoff_answers::figures::plain_name;
use bladeoff_answers::tables::Field;
use bladeoff_model::outcome::{Outcome, Status};
use bladeoff_study::Samples;
use bladeoff_text::document::units::format_digits;

/// Result that is watched in a study without questions.
const DEFAULT: &str = "max_bearing_load_N";

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
    /// Among the values of an outcome.
    place: usize,
    largest: Option<f64>,
}

/// The first question for a probability of results alone.
#[derive(Debug)]
struct FirstAnswer {
    name: String,
    formula: Formula,
    /// Place of each column of the formula among the values of an outcome.
    places: Vec<usize>,
    events: u64,
    rows: u64,
}

impl SoFar {
    /// For the rows of these samples, whose outcomes have the values `fields`.
    pub fn new(samples: &Samples, fields: &[Field]) -> Self {
        let study = samples.study();
        let source = Source { file: &study.file, text: &study.text, asked: &study.asked };
        // questions with mistakes were refused before the run
        let questions = meant(samples, source).map(|meant| meant.questions).unwrap_or_default();
        let place = |column: &str| fields.iter().position(|field| field.name == column);
        let asked = columns_asked(samples, &questions, &[]);
        let watched = asked.iter().map(String::as_str).chain([DEFAULT]).find_map(place);
        let worst = watched.map(|place| Worst {
            name: plain_name(&fields[place].name, &fields[place].unit),
            unit: fields[place].unit.clone(),
            place,
            largest: None,
        });
        let answer = questions.into_iter().find_map(|question| {
            let Ask::One(Figure::Probability(formula)) = question.ask else { return None };
            let places: Option<Vec<usize>> = formula.columns.iter().map(|column| place(column)).collect();
            Some(FirstAnswer { name: question.name, formula, places: places?, events: 0, rows: 0 })
        });
        Self { worst, answer }
    }

    /// Takes the outcome of a sample.
    pub fn see(&mut self, outcome: &Outcome) {
        if outcome.status != Status::Ok {
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

    /// "largest max bearing load 1.2 MN, overload 3 of 40"; empty before the first ok row.
    pub fn text(&self) -> String {
        let worst = self.worst.iter().filter_map(|worst| {
            Some(format!(
                "largest {} {}",
                worst.name.trim_start_matches("max "),
                format_digits(worst.largest?, &worst.unit, 3)
            ))
        });
        let answer = self.answer.iter().filter(|answer| answer.rows > 0);
        let answer = answer.map(|answer| format!("{} {} of {}", answer.name, answer.events, answer.rows));
        worst.chain(answer).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_answers::tables::FieldKind;
    use bladeoff_model::outcome::{CauseSet, EndCause};
    use bladeoff_study::load;
    use std::path::Path;

    #[test]
    fn ok_rows_alone_are_counted() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/blade-off-risk.toml");
        let samples = Samples::new(load(&file, |_| Vec::new()).expect("a study"), None, None).expect("samples");
        let field =
            |name: &str| Field { name: name.into(), unit: "N".into(), meaning: String::new(), kind: FieldKind::Real };
        let mut known = SoFar::new(&samples, &[field("other_N"), field(DEFAULT)]);
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
        assert_eq!(known.text(), "largest bearing load 1.6 MN, bearing-overload 1 of 2");
    }
}
