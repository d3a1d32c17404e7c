//! Small synthetic studies, and questions to them.

pub mod made;

use bladeoff_answers::ask::{Answer, Answered, Known, Names, Question, QuestionDef, answer};
use bladeoff_answers::estimate::input::{DesignKind, Label};
use made::Made;

/// Names in these studies: y, u, and the axis `way`.
pub fn names() -> Names {
    let axis = ("way".to_owned(), vec![Label::Word("a".into()), Label::Word("b".into())]);
    let known = Known { columns: vec![("y".into(), true), ("u".into(), true)], ..Known::default() };
    Names { known, uncertain: vec!["u".into()], varied: vec![axis], ..Names::default() }
}

pub fn asked(def: QuestionDef) -> Question {
    Question::new(&QuestionDef { name: "q".into(), ..def }, &names()).expect("a question")
}

/// A study with these values of y, NaN for a missing one; u is the row number.
pub fn made(values: &[f64]) -> Made {
    let cells = values.iter().map(|value| (!value.is_nan()).then_some(*value)).collect();
    let mut made = Made::new(vec![("y", cells), ("u", (0..values.len()).map(|row| Some(row as f64)).collect())]);
    made.columns[1].nature = 'g';
    made
}

/// A study with y = 0, 1, 2 ...
pub fn ramp(count: usize) -> Made {
    made(&(0..count).map(|row| row as f64).collect::<Vec<_>>())
}

pub fn replicated(made: Made, kind: DesignKind, replicates: usize) -> Made {
    let replicate = (0..made.replicate.len()).map(|point| (point % replicates) as u32).collect();
    Made { kind, replicates, replicate, ..made }
}

pub fn ask(made: &Made, def: QuestionDef) -> Answered {
    let study = made.study();
    study.check().expect("a study");
    answer(&study, &asked(def)).expect("an answer")
}

pub fn one(made: &Made, def: QuestionDef) -> Answer {
    ask(made, def).answers.remove(0)
}

pub fn probability(text: &str) -> QuestionDef {
    QuestionDef { probability: Some(text.into()), ..QuestionDef::default() }
}
pub fn quantile(u: f64) -> QuestionDef {
    QuestionDef { quantile: Some(u), of: Some("y".into()), ..QuestionDef::default() }
}
pub fn mean() -> QuestionDef {
    QuestionDef { mean: Some("y".into()), ..QuestionDef::default() }
}
pub fn exceedance() -> QuestionDef {
    QuestionDef { exceedance: Some("y".into()), ..QuestionDef::default() }
}
/// A difference: value a minus value b of `way`.
pub fn less(def: QuestionDef) -> QuestionDef {
    let labels = [Label::Word("a".into()), Label::Word("b".into())];
    QuestionDef { difference: Some(labels), vary: Some("way".into()), ..def }
}

#[track_caller]
pub fn near(found: Option<f64>, expected: f64) {
    let found = found.expect("a number");
    assert!((found - expected).abs() <= 1e-8 * expected.abs().max(1e-3), "{found} is not {expected}");
}
