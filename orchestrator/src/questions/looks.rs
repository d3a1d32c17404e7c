//! Development of each answer for the report, from the first points to all.

use super::vocabulary::Vocabulary;
use super::{Answering, AnsweringError, note_related, read};
use bladeoff_answers::ask::{Answer, Answers, Ask, Question, SCHEMA, answer, answer_all};
use bladeoff_answers::estimate::input::{Cells, Column, Design, Study};
use bladeoff_answers::gate::{Decision, FIRST_LOOK, Gate};
use bladeoff_study::{Samples, is_blocked};
use std::path::Path;

/// Answers and decisions from all points, and answers from increasing numbers of points.
#[derive(Debug, Clone)]
pub struct Looked {
    /// Answers from all points that count.
    pub answering: Answering,
    /// Numbers of points, with the answers to questions for one number and to sensitivities.
    pub looks: Vec<(u64, Vec<Answer>)>,
    /// Decisions of the gates, in order.
    pub decisions: Vec<Decision>,
}

/// Columns used by questions and gates, each once, in order.
#[must_use]
pub fn columns_asked(samples: &Samples, questions: &[Question], gates: &[Gate]) -> Vec<String> {
    let Some(vocabulary) = Vocabulary::of(samples) else { return Vec::new() };
    let of_questions = questions.iter().flat_map(|question| question.columns(&vocabulary.names));
    let mut columns: Vec<String> = Vec::new();
    for column in of_questions.chain(gates.iter().flat_map(|gate| gate.condition.columns.clone())) {
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    columns
}

/// [`super::answer`] and [`super::judge`], and the answers from increasing numbers of points.
///
/// # Errors
/// As [`super::answer`] and [`super::judge`].
pub fn answer_at_looks(
    directory: &Path,
    samples: &Samples,
    questions: &[Question],
    gates: &[Gate],
) -> Result<Looked, AnsweringError> {
    let vocabulary = Vocabulary::of(samples).ok_or(AnsweringError::Unread)?;
    let mut columns: Vec<String> = questions.iter().flat_map(|question| question.columns(&vocabulary.names)).collect();
    columns.extend(questions.iter().filter_map(|question| vocabulary.axis_of(question)));
    columns.extend(gates.iter().flat_map(|gate| gate.condition.columns.clone()));
    let is_design = samples.layout().is_some();
    if !is_design && (!gates.is_empty() || questions.iter().any(|question| !matches!(question.ask, Ask::Map(_)))) {
        return Err(AnsweringError::NoDesign);
    }
    let (rows, is_known) = read(directory, samples, &vocabulary, columns)?;
    let (points, of, design, is_open) = (rows.points(), rows.of(), samples.points(), rows.are_open());
    if points == 0 {
        let answers = Answers { schema: SCHEMA, complete: false, answers: Vec::new() };
        let answering = Answering { answers, curves: Vec::new(), points, of, design, is_open, is_design, is_known };
        return Ok(Looked { answering, looks: Vec::new(), decisions: Vec::new() });
    }
    let study = rows.study();
    let (mut answers, curves) = answer_all(&study, questions)?;
    note_related(samples, points, &mut answers);
    let mut decisions = Vec::new();
    for gate in gates {
        decisions.extend(gate.judge(&study)?);
    }
    let mut looks: Vec<(u64, Vec<Answer>)> = Vec::new();
    let numbers: Vec<&Question> = questions
        .iter()
        .filter(|question| matches!(question.ask, Ask::One(_) | Ask::Difference(..) | Ask::Sensitivity(_)))
        .collect();
    let mut at = first_look(samples);
    while at < points && !numbers.is_empty() {
        let part = first(&study, at as usize);
        // the answers from all points report the error of a question that cannot be answered
        looks.push((
            at,
            numbers
                .iter()
                .filter_map(|question| answer(&part, question).ok())
                .flat_map(|answered| answered.answers)
                .collect(),
        ));
        at *= 2;
    }
    let is_number = |answer: &&Answer| numbers.iter().any(|question| question.name == answer.name);
    looks.push((points, answers.answers.iter().filter(is_number).cloned().collect()));
    Ok(Looked {
        answering: Answering { answers, curves, points, of, design, is_open, is_design, is_known },
        looks,
        decisions,
    })
}

/// Number of blocks (trajectories or base points) in the first step: few studies have 256 of them, and 10 suffice for an interval.
const FIRST_BLOCKS: u64 = 16;

/// Number of points in the first step; each further step doubles it.
fn first_look(samples: &Samples) -> u64 {
    let blocks = samples.layout().filter(|layout| is_blocked(layout)).map(|layout| FIRST_BLOCKS * layout.rows());
    blocks.unwrap_or(FIRST_LOOK)
}

/// The first points of a study.
fn first<'a>(study: &Study<'a>, points: usize) -> Study<'a> {
    let rows = points * study.groups.len();
    let column = |column: &Column<'a>| {
        let cells = match column.cells {
            Cells::Numbers(values, nature) => Cells::Numbers(&values[..rows], nature.with(|held| &held[..rows])),
            Cells::Words(words, list) => Cells::Words(&words[..rows], list),
        };
        Column { name: column.name.clone(), unit: column.unit.clone(), cells, unjudged: column.unjudged }
    };
    Study {
        columns: study.columns.iter().map(column).collect(),
        status: &study.status[..rows],
        causes: &study.causes[..rows],
        ends: &study.ends[..rows],
        groups: study.groups.clone(),
        design: Design { replicate: &study.design.replicate[..points], complete: false, ..study.design.clone() },
    }
}
