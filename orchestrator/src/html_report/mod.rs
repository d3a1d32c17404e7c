//! Report on a result directory as one HTML page: `bladeoff report`.
//!
//! ```text
//! table or parts --rows--> counts, the worst, some rows of every kind      questions --answering--> answers, curves, interim answers
//!   --answered, failing, worst, provenance--> sections --bladeoff_answers::page--> HTML
//! ```
//! A report is reproducible: the same directory gives the same bytes at any time.

mod answered;
mod assumed;
mod bearings;
mod curves;
mod distributions;
mod failing;
mod horizon;
mod limit_values;
mod limits;
mod narrowing;
mod provenance;
mod regimes;
mod reservations;
mod rows;
mod sensitivity;
mod stability;
mod usable;
mod verdict;
mod words;
mod worst;
mod worst_history;

use crate::questions::{Answering, AnsweringError, Forecasts, Looked, answer_at_looks, columns_asked};
use crate::run::directory::{RESULTS, read_current};
use crate::run::shards::row_files;
use crate::run::{columns_of, end_of_table, refuse_changed};
pub use assumed::{assumed, assumed_of_machine};
pub use bearings::bearings_of;
use bladeoff_answers::ask::Question;
use bladeoff_answers::gate::Gate;
use bladeoff_answers::page::{Block, Figure, Page, Section};
use bladeoff_answers::summary::{FunctionSummary, Summary, counted};
use bladeoff_answers::tables::TableError;
use bladeoff_model::machine::{Machine, Reservation};
use bladeoff_model::outcome::Status;
use bladeoff_study::Samples;
pub use horizon::Horizon;
pub use limit_values::{limits_of, limits_of_machine};
pub use limits::{LimitTable, above_max_beyond, too_many_beyond};
pub use provenance::LIMITS;
use reservations::reservations_of_page;
pub use reservations::{reservations, reservations_of};
use rows::Seen;
pub use stability::unstable_of;
use std::path::{Path, PathBuf};
use usable::Circumstances;
pub use worst_history::Envelope;

/// Input of a report.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// Result directory.
    pub directory: &'a Path,
    /// Samples of the study.
    pub samples: &'a Samples,
    /// Name of the study.
    pub name: &'a str,
    /// Questions to answer.
    pub questions: &'a [Question],
    /// Gates to judge.
    pub gates: &'a [Gate],
}

/// A report.
#[derive(Debug, Clone)]
pub struct Report {
    /// HTML page.
    pub page: Page,
    /// Number of rows in the report, and their number in the finished table.
    pub rows: (u64, u64),
    /// Whether the table has a recorded checksum, or is not finished.
    pub is_known: bool,
}

/// Expected precision of a study.
#[derive(Debug, Clone, Default)]
pub struct Ahead {
    /// Forecast of the intervals with more points.
    pub forecasts: Option<Forecasts>,
    /// Figures that are less precise than `[stop]` requires, with the reason.
    pub short: Vec<String>,
}

/// A recomputed sample, or the reason why it could not be recomputed.
pub type Again = Result<Computed, String>;

/// A recomputed sample.
#[derive(Debug)]
pub struct Computed {
    /// Machine of the sample.
    pub machine: Machine,
    /// Largest values over time.
    pub envelope: Envelope,
    /// Difference between the recomputed row and the row of the table; `None` if they are equal bit for bit.
    pub differs: Option<String>,
}

/// Builds the report. `again` recomputes a sample for its history; it returns `None` if no history is wanted.
///
/// # Errors
/// The table has changed since it was written, cannot be read, or lacks a required column.
pub fn report(
    subject: Subject<'_>,
    ahead: impl Fn(&Answering) -> Ahead,
    again: impl FnOnce(u64) -> Option<Again>,
) -> Result<Report, AnsweringError> {
    let Subject { directory, samples, questions, gates, .. } = subject;
    let columns = columns_of(samples).ok_or(AnsweringError::Unread)?;
    let asked = columns_asked(samples, questions, gates);
    let coordinates = rows::coordinates(samples, &columns, &asked);
    let (mut is_known, mut is_table, mut end) = (true, false, None);
    let ask = || -> Result<Option<Looked>, AnsweringError> {
        if questions.is_empty() && gates.is_empty() {
            return Ok(None);
        }
        answer_at_looks(directory, samples, questions, gates).map(Some)
    };
    // answers first: in a running study, the rows counted later are then never fewer than those of the answers
    let mut looked = ask()?;
    let (seen, found, (summary, sensitive), (limits, horizon), too_many) =
        read_current(directory, row_files, |files| {
            is_table = files.first().is_some_and(|first| first.ends_with(RESULTS));
            is_known = refuse_changed(directory)? || !is_table;
            end = files.first().filter(|_| is_table).map(|table| end_of_table(table)).transpose()?.flatten();
            Ok((
                rows::read(files, coordinates.clone(), &columns)?,
                distributions::histograms(files, &coordinates)?,
                summary(samples, files)?,
                (LimitTable::of(samples, files)?, Horizon::of(files)?),
                too_many_beyond(samples, files)?,
            ))
        })?;
    // the study ended meanwhile: all of the page must come from the same table
    if is_table && looked.as_ref().is_some_and(|looked| !looked.answering.answers.complete) {
        looked = ask()?;
    }
    // a table is complete even if [stop] ended the study early
    let of = if is_table { seen.rows } else { samples.count() };
    let mut sections = Vec::new();
    let mut add = |id, heading: &str, blocks: Vec<Block>| {
        if !blocks.is_empty() {
            sections.push(Section { id, heading: heading.to_owned(), blocks });
        }
    };
    let bearings = bearings_of(samples);
    let mut reservations = reservations_of_page(samples);
    reservations.extend(bearings.iter().map(|text| Reservation {
        topic: "peak bearing loads",
        text: text.clone(),
        columns: &["bearing"],
    }));
    let horizon = horizon.sentences();
    let is_sensitive = |sentence: &&str| !sentence.starts_with("0 of ");
    let sensitive_runs = sensitive.as_deref().map(|sentence| sentence.trim_end_matches('.')).filter(is_sensitive);
    let circumstances =
        Circumstances { limits: &limits, reservations: &reservations, horizon: &horizon, sensitive: sensitive_runs };
    let usable = usable::usable(&seen, of, looked.as_ref(), questions, &circumstances);
    add("use", "What may be used for design", usable);
    if let Some(Looked { answering, looks, decisions }) = &looked {
        add("gates", "Decisions", answered::decisions(decisions, answering));
        add(
            "answers",
            "Answers",
            answered::answers(answering, questions, &columns, samples.study().function().is_none()),
        );
        let results = distributions::results(&asked, (questions, gates), &coordinates, &found);
        add("distributions", "Distributions of the results", results);
        add("precision", "Precision over samples", answered::precision(looks, questions, &columns, &ahead(answering)));
    }
    add("results", "Results", came_out(summary));
    add("assumptions", "Machine and assumptions", machine(samples));
    add("model-limits", "Limits of the model", limits.blocks());
    add("regimes", "Regimes", regimes::regimes(&seen, &columns));
    add("failures", "Where runs fail", failing::failures(&seen, subject));
    let mut worst = worst::worst(&seen, subject);
    worst.extend(history(&seen, again));
    add("worst", "The worst runs", worst);
    add("inputs", "Inputs as they were drawn", distributions::inputs(samples, &coordinates, &found));
    let provenance = provenance::provenance(subject);
    add(
        "provenance",
        "Provenance",
        vec![Block::Details("Program, engine, times and checksums".to_owned(), provenance)],
    );
    add("limits", "What this page does not cover", provenance::limits(samples));
    let ended = end.map(|end| end.words(samples));
    let mut lead = vec![verdict::verdict(&seen, of, looked.as_ref(), &limits, too_many.as_deref())];
    lead.extend(self::lead(&seen, of, looked.as_ref(), ended));
    lead.extend(horizon.iter().map(|line| Block::Text(format!("{line}."))));
    lead.extend(sensitive.map(Block::Text));
    lead.extend(too_many.map(|line| Block::Warning(format!("{line}."))));
    lead.extend(limits.unjudged().map(|text| Block::Warning(format!("Model limits: {text}."))));
    lead.extend(limits.noted().into_iter().map(|line| Block::Warning(format!("{line}."))));
    lead.extend(bearings.into_iter().map(|note| Block::Warning(format!("Peak bearing loads: {note}."))));
    lead.extend(unstable_of(samples).into_iter().map(|range| Block::Warning(format!("Whirl is {range}."))));
    let page = Page { title: subject.name.to_owned(), lead, sections, reload: None };
    Ok(Report { page, rows: (seen.rows, of), is_known })
}

/// Blocks at the top of the page: end of the study, incompleteness, failed runs.
fn lead(seen: &Seen, of: u64, looked: Option<&Looked>, ended: Option<String>) -> Vec<Block> {
    let mut blocks: Vec<Block> =
        ended.map(|ended| Block::Text(format!("The study ended: {ended}."))).into_iter().collect();
    if seen.rows < of {
        let mut text = format!(
            "This study is not complete: the tables have the rows of {} of {} so far.",
            seen.rows,
            counted(of, "run")
        );
        if let Some(Looked { answering, .. }) = looked {
            text += &format!(
                " Counts, regimes and lists of runs cover these. Answers cover the first {} of {}, up to the first \
                 unfinished sample, because the samples that end first are not random.",
                answering.points,
                counted(answering.of, "point")
            );
        }
        blocks.push(Block::Warning(text));
    }
    let bad = seen.rows - seen.ok();
    let runs = counted(seen.rows, "run");
    blocks.push(match bad {
        0 => Block::Text(format!("{runs}, all of them ok.")),
        _ => {
            let mut counts = rows::ByStatus::new();
            seen.kinds.iter().for_each(|of| *counts.entry(of.kind.0.clone()).or_default() += of.count);
            let beyond = counts.get(Status::Beyond.word()).copied().unwrap_or_default();
            let how = if looked.is_some() {
                "The sentence of each answer states how it counts them. Causes:"
            } else {
                "Causes:"
            };
            Block::Text(format!(
                "{runs}: {}.{} {how} \u{201c}Where runs fail\u{201d}.",
                words::by_status(&counts),
                not_for_design(beyond, bad - beyond, seen.rows)
            ))
        }
    });
    blocks
}

/// Why the values of runs that are not ok must not be used for design; one sentence each for runs beyond the model and bad runs.
fn not_for_design(beyond: u64, failing: u64, of: u64) -> String {
    let share = |count: u64| {
        let are = if count == 1 { "is" } else { "are" };
        format!(" {} ({}) {are}", counted(count, "run"), words::percent(count as f64 / of as f64))
    };
    let mut text = String::new();
    if beyond > 0 {
        text += &share(beyond);
        text += " beyond the model: the values reached before the limit are lower bounds, not for design.";
    }
    if failing > 0 {
        text += &share(failing);
        text += " failed, invalid or quarantined: values are not for design.";
    }
    text
}

/// Summary text, and number of runs whose twin differs.
fn summary(samples: &Samples, files: &[PathBuf]) -> Result<(String, Option<String>), TableError> {
    let study = samples.study();
    if let Some(model) = study.function() {
        let outputs = model.outputs.iter().map(|output| output.name.clone());
        return Ok((FunctionSummary::of(files, outputs)?.text(None), None));
    }
    let summary = Summary::of(files)?.with_twin(study.twin_keys());
    Ok((summary.text(None), summary.sensitive()))
}

/// Drawing and assumptions of the machine of the first sample.
fn machine(samples: &Samples) -> Vec<Block> {
    let first = samples.try_machine(0).ok().flatten().and_then(|machine| machine.build().ok());
    let drawn = first.and_then(|machine| bladeoff_answers::figures::machine(&machine));
    let figure = drawn.map(|drawn| Figure {
        caption: "The machine of sample 0 from the side and its diaphragm from the front.".to_owned(),
        drawing: drawn.svg().to_owned(),
        plot: None,
        table: None,
    });
    let assumptions = assumed(samples);
    let lines = (!assumptions.is_empty()).then_some(Block::List(assumptions));
    figure.map(Block::from).into_iter().chain(lines).collect()
}

/// History of the worst run, or the reason why it is missing.
fn history(seen: &Seen, again: impl FnOnce(u64) -> Option<Again>) -> Vec<Block> {
    let Some((name, worst)) = worst_history::worst_run(seen) else { return Vec::new() };
    match again(worst.sample) {
        None => Vec::new(),
        Some(Ok(computed)) => worst_history::blocks(name, worst, &computed),
        Some(Err(why)) => {
            vec![Block::Note(format!("The history of sample {} is not shown: {why}.", worst.sample))]
        }
    }
}

fn came_out(summary: String) -> Vec<Block> {
    vec![Block::Verbatim(summary)]
}
