//! Assumptions, limits and expected contact, as `check` prints them.

use crate::html_report::{assumed, assumed_of_machine, limits_of, limits_of_machine};
use crate::terminal::{CAVEAT, Forecasts, Stability, forecast_lines, in_words, is_expected, matrices_of, with_word};
use bladeoff_answers::summary::{counted, wrapped};
use bladeoff_model::machine::{Machine, MachineDef};
use bladeoff_study::{Chosen, Samples};

/// Largest number of samples of a study for which a forecast is made.
const MOST: u64 = 8;

/// Assumptions, limits and forecast of a single machine.
pub(super) fn of_machine(
    definition: &MachineDef,
    machine: &Machine,
    stability: &mut Stability,
    width: Option<usize>,
) -> String {
    let text = block("Assumptions", &assumed_of_machine(definition, machine), width)
        + &limits_of_machine(definition, machine, width);
    let mut lines = forecast_lines(machine, stability);
    if lines.is_empty() {
        return text;
    }
    lines.push(CAVEAT.to_owned());
    text + &block("Contact", &lines, width)
}

/// Assumptions, limits and forecast of a study: its machine as the file defines it, and samples at corners of the varied parameters.
pub(super) fn of_study(samples: &Samples, width: Option<usize>) -> String {
    block("Assumptions", &assumed(samples), width)
        + &limits_of(samples, width)
        + &block("Contact", &forecast(samples), width)
}

fn block(heading: &str, lines: &[String], width: Option<usize>) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines = lines.iter().map(|line| wrapped(line, width.unwrap_or(usize::MAX), "  ", "    "));
    format!("\n{heading}:\n{}", lines.collect::<String>())
}

fn forecast(samples: &Samples) -> Vec<String> {
    let Some(machine) = samples.study().machine() else { return Vec::new() };
    let Ok(built) = machine.def.build() else { return Vec::new() };
    let look = || {
        let mut stability = Stability::default();
        let mut lines = forecast_lines(&built, &mut stability);
        if !samples.parameters().is_empty() {
            lines.extend(between(samples, &mut stability));
        }
        lines
    };
    let mut lines = with_word(|| format!("{}, to forecast contact", matrices_of(&built)), look);
    if !lines.is_empty() {
        lines.push(CAVEAT.to_owned());
    }
    lines
}

/// The largest ratio of amplitude to gap of a sample, in words.
struct Looked {
    share: f64,
    text: String,
}

/// Smallest and largest result over samples at the extremes of the study: corners of the axes, or evenly spread points of a design.
fn between(samples: &Samples, stability: &mut Stability) -> Vec<String> {
    let chosen = Chosen::new(samples, MOST);
    let all = chosen.count();
    // the samples at corners come last
    let corners = 1_u64 << samples.study().axes.len().min(CORNERED);
    let from = if samples.layout().is_some() { 0 } else { all.saturating_sub(corners) };
    let most = (all - from).min(MOST);
    let mut forecasts = Forecasts::default();
    let (mut looked, mut expected) = (Vec::new(), 0);
    let (mut unstable, mut first) = (0, None);
    for at in 0..most {
        let place = from + if most > 1 { at * (all - from - 1) / (most - 1) } else { 0 };
        let Ok(machine) = chosen.machine(place).build() else { continue };
        if machine.diaphragms.is_empty() {
            continue;
        }
        if let Some(range) = stability.unstable(&machine) {
            unstable += 1;
            first.get_or_insert_with(|| format!("{range}, with {}", chosen.describe(place)));
            continue;
        }
        let found = forecasts.of(&machine);
        let Some(largest) = found.iter().max_by(|a, b| a.share().total_cmp(&b.share())) else { continue };
        expected += u64::from(is_expected(largest));
        let name = machine.diaphragms.get(largest.diaphragm).map_or("", |diaphragm| diaphragm.name.as_str());
        let text = format!("{}, {name}: {}", chosen.describe(place), in_words(largest));
        looked.push(Looked { share: largest.share(), text });
    }
    let order = |a: &&Looked, b: &&Looked| a.share.total_cmp(&b.share);
    let mut lines: Vec<String> = first
        .map(|first| format!("no forecast for {}: {first}", counted(unstable, "unstable sample")))
        .into_iter()
        .collect();
    let (Some(least), Some(largest)) = (looked.iter().min_by(order), looked.iter().max_by(order)) else {
        return lines;
    };
    lines.push(format!("contact expected in {expected} of {} samples that were checked", looked.len()));
    lines.push(format!("largest, with {}", largest.text));
    if least.share < largest.share {
        lines.push(format!("least, with {}", least.text));
    }
    lines
}

/// Number of axes for which [`Chosen`] makes corners.
const CORNERED: usize = 12;
