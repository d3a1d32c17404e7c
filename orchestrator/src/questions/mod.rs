//! Questions and gates of a study file, answered from its table.
//!
//! ```text
//! text of the file --meant--> questions, gates           by the names of the table's columns (vocabulary)
//! results.parquet or parts --rows--> points in order     the required columns, for the complete prefix of the points
//!   --answer--> answers.json, answers/NAME.parquet (kept), text (to_text)     --judge--> decisions of gates
//! ```
//! [`bladeoff_answers`] defines the figures, [`bladeoff_study`] the study file. Questions do not change the samples of a study.

mod checked;
mod drawn;
mod forecast;
mod kept;
mod looks;
mod refining;
mod resolve;
mod rows;
mod shortfall;
mod streaming;
mod to_text;
mod verified;
mod vocabulary;
mod waiting;

pub use checked::check_asked;
pub use drawn::drawn;
pub use forecast::{Awaited, Forecast, Forecasts, Later, forecasts, group_in_words, pace};
pub use kept::{KeepError, keep};
pub use looks::{Looked, answer_at_looks, columns_asked};
pub use refining::{Refinement, Unrefined};
pub use resolve::{Meant, Source, meant, only_gates};
pub use rows::AnsweringError;
pub use to_text::{decided, told};
pub use verified::known_probabilities;
pub use waiting::Waiting;

use crate::run::directory::{RESULTS, read_current};
use crate::run::shards::row_files;
use crate::run::{chosen_of_table, end_of_table, refuse_changed};
use bladeoff_answers::ask::{
    Answered, Answers, Ask, Correlated, Problem, Question, QuestionDef, SCHEMA, Streamed, answer_each, collected,
};
use bladeoff_answers::estimate::curve::Curve;
use bladeoff_answers::gate::{Decision, Gate};
use bladeoff_study::{Origin, Samples};
use rows::Rows;
use std::path::Path;
use streaming::stream;
use vocabulary::Vocabulary;

/// Answers of a study from the rows computed so far.
#[derive(Debug, Clone)]
pub struct Answering {
    /// Content of `answers.json`.
    pub answers: Answers,
    /// Contents of `answers/NAME.parquet`.
    pub curves: Vec<(String, Curve)>,
    /// Number of points used: the first ones.
    pub points: u64,
    /// Final number of points: those of the study, or up to its end by `[stop]`.
    pub of: u64,
    /// Points of the design.
    pub design: u64,
    /// Whether `[refine]` may still add combinations.
    pub is_open: bool,
    /// Whether the points are those of a design; otherwise each sample is a point, and all computed samples are used.
    pub is_design: bool,
    /// Whether the table has a recorded checksum, or is not finished.
    pub is_known: bool,
}

/// Answers questions from the rows of these samples in a directory.
///
/// # Errors
/// The table has changed since it was written, cannot be read, or lacks a required column.
pub fn answer(directory: &Path, samples: &Samples, questions: &[Question]) -> Result<Answering, AnsweringError> {
    let vocabulary = Vocabulary::of(samples).ok_or(AnsweringError::Unread)?;
    let is_design = samples.layout().is_some();
    if !is_design && questions.iter().any(|question| !matches!(question.ask, Ask::Map(_))) {
        return Err(AnsweringError::NoDesign);
    }
    let small: Vec<&Question> = questions.iter().filter(|question| Streamed::takes(question)).collect();
    let passed = if small.is_empty() { None } else { pass(directory, samples, &vocabulary, &small)? };
    let is_passed = |question: &Question| passed.is_some() && Streamed::takes(question);
    let held: Vec<&Question> = questions.iter().filter(|question| !is_passed(question)).collect();
    if let Some(Passed { answered, points, is_known }) = &passed
        && held.is_empty()
    {
        let (answers, curves) = collected(small.iter().copied().zip(answered.iter().cloned()), true);
        let (design, is_open, is_known) = (samples.points(), false, *is_known);
        return Ok(Answering { answers, curves, points: *points, of: *points, design, is_open, is_design, is_known });
    }
    let mut columns: Vec<String> = held.iter().flat_map(|question| question.columns(&vocabulary.names)).collect();
    // the axis of a curve, for its unit
    columns.extend(held.iter().filter_map(|question| vocabulary.axis_of(question)));
    let (rows, is_known) = read(directory, samples, &vocabulary, columns)?;
    let (mut answers, curves) = match rows.points() {
        0 => (Answers { schema: SCHEMA, complete: false, answers: Vec::new() }, Vec::new()),
        _ => {
            let study = rows.study();
            let mut of_held = answer_each(&study, held.iter().copied())?.into_iter();
            let mut of_passed = passed.into_iter().flat_map(|passed| passed.answered);
            let all = questions.iter().filter_map(|question| {
                let is_held = held.iter().any(|one| std::ptr::eq(*one, question));
                Some((question, if is_held { of_held.next() } else { of_passed.next() }?))
            });
            collected(all, study.design.complete)
        }
    };
    note_related(samples, rows.points(), &mut answers);
    Ok(Answering {
        answers,
        curves,
        points: rows.points(),
        of: rows.of(),
        design: samples.points(),
        is_open: rows.are_open(),
        is_design,
        is_known,
    })
}

/// Answers obtained from a stream of the rows of a finished table.
struct Passed {
    answered: Vec<Answered>,
    points: u64,
    is_known: bool,
}

/// Answers questions from a stream of the rows of a finished table; `None` without such a table, so that
/// rows have to be collected.
fn pass(
    directory: &Path,
    samples: &Samples,
    vocabulary: &Vocabulary<'_>,
    questions: &[&Question],
) -> Result<Option<Passed>, AnsweringError> {
    let mut found = Ok(None);
    read_current(directory, row_files, |files| {
        let Some(table) = files.first().filter(|first| first.ends_with(RESULTS)) else { return Ok(()) };
        let is_known = refuse_changed(directory)?;
        if chosen_of_table(table, samples)?.is_some() {
            return Ok(());
        }
        let end = end_of_table(table)?;
        let points = end.map_or(samples.points(), |end| end.points);
        let answered = stream(table, samples, vocabulary, end, questions)?;
        found = answered.map(|answered| answered.map(|answered| Passed { answered, points, is_known }));
        Ok(())
    })?;
    found
}

/// Warning if a design has too few points for its number of parameters, so that values of two columns are correlated.
#[must_use]
pub fn related(samples: &Samples) -> Option<String> {
    related_in(samples, samples.points())
}

fn related_in(samples: &Samples, points: u64) -> Option<String> {
    let uncertain = samples.parameters().iter().filter(|parameter| matches!(parameter.origin, Origin::Uncertain(_)));
    let names: Vec<&str> = uncertain.map(|one| one.short.as_deref().unwrap_or(one.info.path.as_str())).collect();
    samples.layout()?.related(points, &names)
}

/// Adds a note and the correlated parameters to answers from `points` points of a Saltelli design; the correlation biases total indices.
fn note_related(samples: &Samples, points: u64, answers: &mut Answers) {
    if samples.layout().is_none_or(|layout| layout.saltelli().is_none()) {
        return;
    }
    let Some(note) = related_in(samples, points) else { return };
    let found = samples
        .layout()
        .and_then(|layout| Some(layout.saltelli()?.related(points / layout.rows())))
        .unwrap_or_default();
    for answer in &mut answers.answers {
        let Some(sensitivity) = &mut answer.sensitivity else { continue };
        let of = |&(place, correlation): &(usize, f64)| {
            let (parameter, _) = sensitivity.indices.of.get(place)?;
            Some(Correlated { parameter: parameter.clone(), correlation })
        };
        sensitivity.correlated = found.iter().filter_map(of).collect();
        answer.notes.push(note.clone());
    }
}

/// A question about these samples from the command line instead of a file.
///
/// # Errors
/// The machine cannot be built; the inner error lists the errors of the question.
pub fn question_of(samples: &Samples, def: &QuestionDef) -> Result<Result<Question, Vec<Problem>>, AnsweringError> {
    let vocabulary = Vocabulary::of(samples).ok_or(AnsweringError::Unread)?;
    Ok(Question::new(def, &vocabulary.names))
}

/// Judges gates by the rows of these samples in a directory. Also returns the number of points used, and that of the study.
///
/// # Errors
/// As [`answer`]; also for points that are not independent.
pub fn judge(directory: &Path, samples: &Samples, gates: &[Gate]) -> Result<(Vec<Decision>, u64, u64), AnsweringError> {
    if samples.layout().is_none() {
        return Err(AnsweringError::NoDesign);
    }
    let vocabulary = Vocabulary::of(samples).ok_or(AnsweringError::Unread)?;
    let columns = gates.iter().flat_map(|gate| gate.condition.columns.clone()).collect();
    let (rows, _) = read(directory, samples, &vocabulary, columns)?;
    if rows.are_refined() {
        return Err(AnsweringError::Refined);
    }
    let study = rows.study();
    study.check()?;
    let mut decisions = Vec::new();
    for gate in gates {
        decisions.extend(gate.judge(&study)?);
    }
    Ok((decisions, rows.points(), rows.of()))
}

/// The rows to use, and whether the checksum of their table was verified or does not apply.
fn read(
    directory: &Path,
    samples: &Samples,
    vocabulary: &Vocabulary<'_>,
    mut columns: Vec<String>,
) -> Result<(Rows, bool), AnsweringError> {
    columns.sort();
    columns.dedup();
    let mut rows = None;
    let mut is_known = true;
    read_current(directory, row_files, |files| {
        let is_table = files.first().is_some_and(|first| first.ends_with(RESULTS));
        is_known = refuse_changed(directory)? || !is_table;
        let end = files.first().filter(|_| is_table).map(|table| end_of_table(table)).transpose()?.flatten();
        let table = files.first().filter(|_| is_table);
        let refinement = if is_table { None } else { Refinement::of_study(samples) };
        if let Some(refinement) = refinement {
            rows = Some(refinement.so_far(files, vocabulary, &columns)?);
            return Ok(());
        }
        let chosen = table.map(|table| chosen_of_table(table, samples)).transpose()?.flatten();
        rows = Some(Rows::read(files, samples, vocabulary, (&columns, end, chosen.as_ref()))?);
        Ok(())
    })?;
    let rows = rows.expect("set where reading did not fail")?;
    Ok((rows, is_known))
}
