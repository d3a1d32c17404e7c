//! Answers, decisions, and their development with the number of points.

use super::narrowing::narrowing;
use super::words::{Quantity, group, group_or_all, numbers};
use super::{Ahead, curves, sensitivity};
use crate::questions::Answering;
use crate::run::TableColumn;
use bladeoff_answers::ask::{Answer, Ask, Figure, Question, in_words};
use bladeoff_answers::gate::{Decision, Verdict};
use bladeoff_answers::map::Map;
use bladeoff_answers::page::chart::{Axis, COLOURS, Chart, Series, Shape, Symbol};
use bladeoff_answers::page::{self, Block, Table};

/// Largest number of groups of a question that a chart shows.
const MOST_GROUPS: usize = 24;
const MOST_CURVES: usize = 5;

/// Every question with its answers in sentences; several groups in one chart side by side.
pub(super) fn answers(
    answering: &Answering,
    questions: &[Question],
    columns: &[TableColumn],
    is_of_machine: bool,
) -> Vec<Block> {
    let mut blocks = Vec::new();
    let is_probability = |question: &Question| {
        matches!(
            question.ask,
            Ask::One(Figure::Probability(_))
                | Ask::Difference(Figure::Probability(_), ..)
                | Ask::Exceedance(_)
                | Ask::Fragility(..)
        )
    };
    if is_of_machine && questions.iter().any(is_probability) {
        let text = "A probability is that of one event as the study describes it (one lost blade), not a rate per year of operation.";
        blocks.push(Block::Text(text.to_owned()));
    }
    let all_maps = answering.answers.answers.iter().filter(|answer| answer.map.is_some()).count();
    for question in questions {
        let of: Vec<&Answer> = answering.answers.answers.iter().filter(|answer| answer.name == question.name).collect();
        blocks.push(Block::Heading(in_words(question)));
        if of.is_empty() {
            blocks.push(Block::Text("No answer yet: no point is finished in every group.".to_owned()));
            continue;
        }
        match &of[..] {
            [one] => blocks.push(Block::Text(one.sentence.clone())),
            several => blocks.push(Block::List(several.iter().map(|answer| answer.sentence.clone()).collect())),
        }
        let mut notes: Vec<&String> = Vec::new();
        of.iter().flat_map(|answer| &answer.notes).for_each(|note| {
            if !notes.contains(&note) {
                notes.push(note)
            }
        });
        blocks.extend(notes.into_iter().map(|note| Block::Note(note.clone())));
        blocks.extend(curves::curve(answering, question, columns));
        blocks.extend(sensitivity::sensitivity(question, &of, columns));
        blocks.extend(maps(question, &of, all_maps));
        if of.len() > 1 && of.len() <= MOST_GROUPS && !matches!(question.ask, Ask::Map(_)) {
            blocks.extend(side_by_side(question, columns, &of));
        }
    }
    blocks
}

/// A figure for each panel and each difference of a map.
fn maps(question: &Question, answers: &[&Answer], all: usize) -> Vec<Block> {
    let maps: Vec<Map> = answers.iter().filter_map(|answer| answer.map.as_deref().cloned()).collect();
    page::map_figures(&question.name, &maps, all).into_iter().map(Block::from).collect()
}

/// Chart of the estimates of all groups with their intervals.
fn side_by_side(question: &Question, columns: &[TableColumn], answers: &[&Answer]) -> Option<Block> {
    let quantity = Quantity::of(question, columns, answers)?;
    let show = |value: Option<f64>| value.map(|value| quantity.show(value));
    let zero = matches!(question.ask, Ask::Difference(..)).then_some(0.0);
    let values = answers.iter().flat_map(|answer| numbers(answer)).map(|value| quantity.show(value)).chain(zero);
    let dots = |of: fn(&Answer) -> Option<f64>| {
        answers.iter().enumerate().filter_map(|(at, answer)| Some((show(of(answer))?, at as f64))).collect::<Vec<_>>()
    };
    let said: Vec<String> =
        answers.iter().filter(|answer| answer.estimate.is_some()).map(|answer| answer.sentence.clone()).collect();
    let harmful: Vec<(f64, f64)> = answers
        .iter()
        .enumerate()
        .filter(|(_, answer)| answer.estimate_if_bad_harmful != answer.estimate)
        .filter_map(|(at, answer)| Some((show(answer.estimate_if_bad_harmful)?, at as f64)))
        .collect();
    let intervals = answers.iter().enumerate().filter(|(_, answer)| answer.low.is_some() || answer.high.is_some());
    let intervals = intervals.map(|(at, answer)| (at as f64, show(answer.low), show(answer.high))).collect();
    let ends = [-0.5, answers.len() as f64 - 0.5];
    let mut series = Vec::new();
    let mut add = |name: &str, colour, shape| series.push(Series { name: name.to_owned(), colour, shape });
    if zero.is_some() {
        add("", "quiet", Shape::Line(ends.map(|y| (0.0, y)).to_vec(), true));
    }
    add("interval", "c0", Shape::Across(intervals));
    add("estimate", "c0", Shape::Dots(dots(|answer| answer.estimate), said, Symbol::Disc));
    if !harmful.is_empty() {
        add("if bad runs are harmful", "c1", Shape::Dots(harmful, Vec::new(), Symbol::Ring));
    }
    let chart = Chart {
        x: Axis::numbers(quantity.label(), values),
        y: Axis::words(answers.iter().map(|answer| group_or_all(&answer.group, columns)).collect()),
        series,
        height: 30 + 30 * answers.len() as u32,
    };
    Some(chart.figure(format!("{}: {} by group.", question.name, quantity.name), None).into())
}

/// The result of each gate.
pub(super) fn decisions(decisions: &[Decision], answering: &Answering) -> Vec<Block> {
    if decisions.is_empty() {
        return Vec::new();
    }
    let word = |verdict| match verdict {
        Verdict::Passed => "passed",
        Verdict::Open => "open",
        Verdict::Failed => "FAILED",
    };
    let head = ["gate", "group", "result", "reason"].map(str::to_owned).to_vec();
    let rows = decisions.iter().map(|decision| {
        vec![
            decision.gate.clone(),
            group(&decision.group),
            word(decision.verdict).to_owned(),
            decision.sentence.clone(),
        ]
    });
    let mut blocks = vec![Block::Table(Table { head, rows: rows.collect(), verbatim: Vec::new() })];
    if answering.points < answering.of {
        blocks.push(Block::Note(
            "Before the end of a study a gate is judged at its first 256, 512, 1024 ... points only. This keeps its error probability, however often it is asked.".to_owned(),
        ));
    }
    blocks
}

/// How each number and its interval developed with the number of points.
pub(super) fn precision(
    looks: &[(u64, Vec<Answer>)],
    questions: &[Question],
    columns: &[TableColumn],
    Ahead { forecasts, short }: &Ahead,
) -> Vec<Block> {
    let mut blocks = Vec::new();
    for question in questions {
        let of = |answers: &'_ [Answer]| {
            answers.iter().filter(|answer| answer.name == question.name).cloned().collect::<Vec<_>>()
        };
        let steps: Vec<(u64, Vec<Answer>)> = looks.iter().map(|(points, answers)| (*points, of(answers))).collect();
        if matches!(question.ask, Ask::Sensitivity(_)) {
            blocks.extend(narrowing(question, &steps, columns, forecasts.as_ref()));
            continue;
        }
        // a single evaluation gives no course
        if looks.len() < 2 {
            continue;
        }
        let all: Vec<&Answer> = steps.iter().flat_map(|(_, answers)| answers).collect();
        let Some(quantity) = Quantity::of(question, columns, &all) else { continue };
        let groups = steps.last().map_or(0, |(_, answers)| answers.len());
        if groups == 0 {
            continue;
        }
        let mut series = Vec::new();
        for at in 0..groups.min(MOST_CURVES) {
            let steps: Vec<(f64, &Answer)> =
                steps.iter().filter_map(|(points, answers)| Some((*points as f64, answers.get(at)?))).collect();
            let name = steps.last().map_or(String::new(), |(_, answer)| group(&answer.group));
            let colour = COLOURS[at];
            let band = steps.iter().filter_map(|(points, answer)| {
                Some((*points, quantity.show(answer.low?), quantity.show(answer.high?)))
            });
            let band: Vec<(f64, f64, f64)> = band.collect();
            // an interval may have one limit only
            let open = steps.iter().filter(|(_, answer)| answer.low.is_some() != answer.high.is_some());
            let open: Vec<_> = open
                .map(|(points, answer)| {
                    (
                        *points,
                        answer.low.map(|value| quantity.show(value)),
                        answer.high.map(|value| quantity.show(value)),
                    )
                })
                .collect();
            let line =
                steps.iter().filter_map(|(points, answer)| Some((*points, quantity.show(answer.estimate?)))).collect();
            let harmful: Vec<(f64, f64)> = steps
                .iter()
                .filter(|(_, answer)| answer.estimate_if_bad_harmful != answer.estimate)
                .filter_map(|(points, answer)| Some((*points, quantity.show(answer.estimate_if_bad_harmful?))))
                .collect();
            let named = |what: &str| if name.is_empty() { what.to_owned() } else { format!("{name}: {what}") };
            // the legend entry stands for one-sided intervals if no interval has two sides
            let of_open = if band.is_empty() && !open.is_empty() { named("interval") } else { String::new() };
            if !band.is_empty() {
                series.push(Series { name: named("interval"), colour, shape: Shape::Band(band) });
            }
            series.push(Series { name: of_open, colour, shape: Shape::Upright(open) });
            series.push(Series { name: named("estimate"), colour, shape: Shape::Line(line, false) });
            if !harmful.is_empty() {
                series.push(Series {
                    name: named("if bad runs are harmful"),
                    colour,
                    shape: Shape::Line(harmful, true),
                });
            }
        }
        let values = all.iter().flat_map(|answer| numbers(answer)).map(|value| quantity.show(value));
        let chart = Chart {
            x: Axis::log("points", steps.iter().map(|(points, _)| *points as f64))
                .at(steps.iter().map(|(points, _)| *points as f64).collect()),
            y: Axis::numbers(quantity.short(), values),
            series,
            height: 220,
        };
        let caption = format!(
            "{}: {} and its interval after the first 256, 512, ... points and after all.",
            question.name, quantity.name
        );
        let table = (groups == 1).then(|| numbers_of(&steps, &quantity));
        blocks.push(chart.figure(caption, table).into());
        if groups > MOST_CURVES {
            blocks.push(Block::Note(format!("The first {MOST_CURVES} of {groups} groups are drawn.")));
        }
    }
    if !blocks.is_empty() {
        blocks.insert(
            0,
            Block::Text("Four times the points halve an interval. The part that bad runs leave open stays.".to_owned()),
        );
    }
    if !short.is_empty() {
        blocks.push(Block::Heading("Not as precise as [stop] asks".to_owned()));
        blocks.push(Block::List(short.clone()));
    }
    if let Some(ahead) = forecasts {
        blocks.push(Block::Heading(ahead.head()));
        blocks.push(Block::List(ahead.lines()));
    }
    blocks
}

fn numbers_of(steps: &[(u64, Vec<Answer>)], quantity: &Quantity) -> Table {
    let head = ["points".to_owned(), quantity.label(), "from".to_owned(), "to".to_owned()];
    let cell = |value: Option<f64>| {
        value.map_or(String::new(), |value| bladeoff_answers::page::chart::shown(quantity.show(value)))
    };
    let rows = steps.iter().filter_map(|(points, answers)| {
        let answer = answers.first()?;
        Some(vec![points.to_string(), cell(answer.estimate), cell(answer.low), cell(answer.high)])
    });
    Table { head: head.to_vec(), rows: rows.collect(), verbatim: Vec::new() }
}
