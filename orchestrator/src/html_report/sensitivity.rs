//! Influence of the parameters: bars of sensitivity indices with their intervals, and Morris's plot.

use super::words::{group, unit_of};
use crate::run::TableColumn;
use bladeoff_answers::ask::{Answer, Question, Sensitivities};
use bladeoff_answers::figures::Scale;
use bladeoff_answers::page::chart::{Axis, Chart, Series, Shape, Symbol, shown};
use bladeoff_answers::page::{Block, Table};
use bladeoff_answers::sensitivity::{Index, OfParameter};

/// Largest number of parameters whose names are shown in Morris's plot.
const MOST_NAMES: usize = 10;

/// One kind of index: name, colour, and access function.
type Kind = (&'static str, &'static str, fn(&OfParameter) -> Option<Index>);

/// Charts of every group.
pub(super) fn sensitivity(question: &Question, answers: &[&Answer], columns: &[TableColumn]) -> Vec<Block> {
    let mut blocks = Vec::new();
    for answer in answers {
        let Some(found) = &answer.sensitivity else { continue };
        let of = group(&answer.group);
        let name = if of.is_empty() { question.name.clone() } else { format!("{}, {of}", question.name) };
        let kinds: &[Kind] = match found.estimator {
            "morris" => &[("mu*", "c0", |of| of.mu_star)],
            "sobol" => &[("first order", "c0", |of| of.first), ("total", "c1", |of| of.total)],
            _ => &[("first order, by ranks", "c0", |of| of.first), ("rank correlation", "c1", |of| of.spearman)],
        };
        // for an output that does not vary nothing is drawn
        let is_there =
            |index: Option<Index>| index.and_then(|index| index.estimate).is_some_and(|estimate| estimate != 0.0);
        if !found.indices.of.iter().any(|(_, of)| kinds.iter().any(|(.., index)| is_there(index(of)))) {
            continue;
        }
        let what = match found.estimator {
            "morris" => "mean size of its effects: mu*",
            "sobol" => "share of the variance: first order, total",
            _ => "first order by ranks (share of the variance); rank correlation",
        };
        let scale = scale(found, columns);
        blocks.push(bars(&name, found, (kinds, what), &scale));
        if found.estimator == "morris" {
            blocks.extend(plot(&name, found, &scale));
        }
        if !answer.lines.is_empty() {
            let text: String = answer.lines.iter().map(|line| format!("{line}\n")).collect();
            blocks.push(Block::Details("In words".to_owned(), vec![Block::Verbatim(text)]));
        }
    }
    blocks
}

/// Scale of the indices: elementary effects have the unit of the output; the other indices are fractions of 1.
fn scale(found: &Sensitivities, columns: &[TableColumn]) -> Scale {
    if found.estimator != "morris" {
        return Scale { factor: 1.0, unit: String::new() };
    }
    let effects = found.indices.of.iter().filter_map(|(_, of)| of.mu_star?.estimate);
    Scale::of(unit_of(columns, &found.output), effects.fold(0.0_f64, f64::max))
}

/// An index in the unit of its scale.
fn scaled(index: Index, scale: &Scale) -> Index {
    let of = |value: Option<f64>| value.map(|value| value * scale.factor);
    Index { estimate: of(index.estimate), low: of(index.low), high: of(index.high) }
}

/// Bars of the indices, the most influential parameter at the top, in the order of the sentences: by the total-order index, otherwise by the first
/// kind. Parameters without an interval follow in the order of the study.
fn bars(name: &str, found: &Sensitivities, (kinds, what): (&[Kind], &str), scale: &Scale) -> Block {
    let size = |of: &OfParameter| {
        let kind = if found.estimator == "sobol" { kinds.last() } else { kinds.first() };
        let leading = kind.and_then(|(.., index)| index(of)).and_then(|index| index.ranking());
        leading.unwrap_or(f64::NEG_INFINITY)
    };
    let mut parameters: Vec<&(String, OfParameter)> = found.indices.of.iter().collect();
    parameters.sort_by(|a, b| size(&b.1).total_cmp(&size(&a.1)));
    let thick = 0.72 / kinds.len() as f64;
    let mut series = Vec::new();
    let mut values = vec![0.0];
    let mut table = Table { head: vec!["parameter".to_owned()], ..Table::default() };
    table.rows = parameters.iter().map(|(parameter, _)| vec![parameter.clone()]).collect();
    for (at, (kind, colour, index)) in kinds.iter().enumerate() {
        let off = thick * (at as f64 - (kinds.len() as f64 - 1.0) / 2.0);
        let of = || parameters.iter().enumerate().filter_map(|(row, (_, of))| Some((row, scaled(index(of)?, scale))));
        let bars = of().filter_map(|(row, index)| Some((row as f64 + off, index.estimate?))).collect();
        let whiskers = of().filter(|(_, index)| index.low.is_some() || index.high.is_some());
        let whiskers = whiskers.map(|(row, index)| (row as f64 + off, index.low, index.high)).collect();
        values.extend(of().flat_map(|(_, index)| [index.estimate, index.low, index.high].into_iter().flatten()));
        series.push(Series { name: (*kind).to_owned(), colour, shape: Shape::Bars(bars, 0.9 * thick) });
        let interval = if at == 0 { "interval" } else { "" };
        series.push(Series { name: interval.to_owned(), colour: "ink", shape: Shape::Across(whiskers) });
        table.head.extend([scale.label(kind), "from".to_owned(), "to".to_owned()]);
        for (row, (_, of)) in parameters.iter().enumerate() {
            let cell = |value: Option<f64>| value.map_or(String::new(), shown);
            let index = scaled(index(of).unwrap_or_default(), scale);
            table.rows[row].extend([cell(index.estimate), cell(index.low), cell(index.high)]);
        }
    }
    let chart = Chart {
        x: Axis::numbers(scale.label(what), values.into_iter()),
        y: Axis::words(parameters.iter().map(|(parameter, _)| parameter.clone()).collect()),
        series,
        height: 30 + 34 * parameters.len() as u32,
    };
    chart.figure(format!("{name}: drivers of {}.", found.output), Some(table)).into()
}

/// Plot of mu* against sigma: a large mu* means influence, a large sigma means a nonlinear effect or an interaction.
fn plot(name: &str, found: &Sensitivities, scale: &Scale) -> Option<Block> {
    let of = |(parameter, of): &(String, OfParameter)| {
        Some((parameter.clone(), scaled(of.mu_star?, scale), scaled(of.sigma?, scale)))
    };
    let all: Vec<(String, Index, Index)> = found.indices.of.iter().filter_map(of).collect();
    let place = |(_, mu, sigma): &(String, Index, Index)| Some((mu.estimate?, sigma.estimate?));
    let points: Vec<(f64, f64)> = all.iter().filter_map(place).collect();
    if points.is_empty() {
        return None;
    }
    let words = all.iter().filter(|one| place(one).is_some()).map(|(parameter, ..)| parameter.clone()).collect();
    // the parameters with the largest mu*: more names would overlap
    let mut ranked: Vec<&(String, Index, Index)> = all.iter().collect();
    ranked.sort_by(|a, b| b.1.ranking().unwrap_or(0.0).total_cmp(&a.1.ranking().unwrap_or(0.0)));
    let named = ranked.iter().take(MOST_NAMES);
    let labels = named.filter_map(|one| place(one).map(|(x, y)| (x, y, one.0.clone()))).collect();
    let across =
        all.iter().filter_map(|(_, mu, sigma)| Some((sigma.estimate?, Some(mu.low?), Some(mu.high?)))).collect();
    let upright =
        all.iter().filter_map(|(_, mu, sigma)| Some((mu.estimate?, Some(sigma.low?), Some(sigma.high?)))).collect();
    let ends = |pick: fn(&(String, Index, Index)) -> Index| {
        all.iter().flat_map(move |one| [pick(one).estimate, pick(one).low, pick(one).high]).flatten().chain([0.0])
    };
    let most = points.iter().fold(0.0_f64, |most, (x, y)| most.max(*x).max(*y));
    let chart = Chart {
        x: Axis::numbers(scale.label("mu*: how much it matters"), ends(|one| one.1)),
        y: Axis::numbers(scale.label("sigma"), ends(|one| one.2)),
        series: vec![
            Series {
                name: "sigma = mu*".into(),
                colour: "quiet",
                shape: Shape::Line(vec![(0.0, 0.0), (most, most)], true),
            },
            Series { name: "interval".into(), colour: "quiet", shape: Shape::Across(across) },
            Series { name: String::new(), colour: "quiet", shape: Shape::Upright(upright) },
            Series { name: "parameter".into(), colour: "c0", shape: Shape::Dots(points, words, Symbol::Disc) },
            Series { name: String::new(), colour: "ink", shape: Shape::Labels(labels) },
        ],
        height: 320,
    };
    let rest = if all.len() > MOST_NAMES {
        format!(
            " The {MOST_NAMES} with the largest mu* of {} are named; all are in the numbers of the figure before.",
            all.len()
        )
    } else {
        String::new()
    };
    let caption = format!(
        "{name}: a parameter far to the right has a large effect; high up, its effect depends on other parameters or \
         is not linear.{rest}"
    );
    Some(chart.figure(caption, None).into())
}
