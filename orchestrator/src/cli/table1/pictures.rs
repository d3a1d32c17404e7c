//! Figures like figures 7 to 13 of the paper, the three detections together.

use super::runs::Case;
use crate::cli::error::CliError;
use crate::cli::history::watched;
use crate::engine;
use crate::figures::{COLOURS, Figure, Line, Panel, Scale, panels};
use crate::history::{Decimation, History, Settings, read};
use std::path::Path;

/// Recorded interval \[s\].
const EVERY: f64 = 1e-4;
/// Length of the pictures of the first impacts \[s\].
const FIRST_IMPACTS: f64 = 0.15;

/// Runs each detection once more from the machine's own start, with its history, and draws; what to say.
pub(super) fn draw(cases: &[Case], out: &Path) -> Result<Vec<String>, CliError> {
    // the quick engine where both were run
    let engine = cases.first().map_or("reduced", |case| case.engine);
    let mut said = Vec::new();
    let mut histories = Vec::new();
    for case in cases.iter().filter(|case| case.engine == engine && case.start == 0) {
        let structure = engine::build(&case.machine)?;
        let plan = engine::plan(&case.machine, &structure)?;
        let path = out.join(format!("{}.mcap", case.detection));
        let settings = Settings { path: path.clone(), channels: Vec::new(), decimation: Decimation::Every(EVERY) };
        let (_, written) = watched(&case.machine, &structure, &plan, Some(&settings))?;
        said.extend(written);
        if path.is_file() {
            histories.push((case.detection, read(&path)?));
        }
    }
    if histories.is_empty() {
        said.push("warning: there are no histories, hence no figures".to_owned());
        return Ok(said);
    }
    let first = histories.iter().filter_map(|(_, history)| first_contact(history)).fold(f64::INFINITY, f64::min);
    let impacts = (first - 0.02, first + FIRST_IMPACTS);
    let whole = (0.0, f64::INFINITY);
    let bearing = worst_bearing(&histories);
    let place = bearing.replace("load_N", "x_m");
    let about = format!("our turbine, {engine} engine");
    let mut figures = vec![
        ("fig07-speed", over(&histories, "rotor.speed_rad_s", "speed", whole, &format!("Rotating speed: {about}"))?),
        (
            "fig08-bearing-displacement",
            over(
                &histories[..1],
                &place,
                "displacement x",
                whole,
                &format!("Displacement at the bearing, hyp1: {about}"),
            )?,
        ),
        ("fig09-bearing-load", apart(&histories, &bearing, "load", whole, &format!("Bearing loads: {about}"))?),
    ];
    if first.is_finite() {
        let rub = (first - 0.1, f64::INFINITY);
        figures.extend([
            (
                "fig10-contact-force",
                apart(
                    &histories,
                    "contact.peak_force_N",
                    "force",
                    rub,
                    &format!("Contact forces (largest of 0.1 ms): {about}"),
                )?,
            ),
            (
                "fig11-first-impacts",
                apart(
                    &histories,
                    "contact.peak_force_N",
                    "force",
                    impacts,
                    &format!("Contact forces at the first impacts: {about}"),
                )?,
            ),
            ("fig12-gap", apart(&histories, "contact.gap_m", "gap", whole, &format!("Gap: {about}"))?),
            (
                "fig13-gap-first-impacts",
                over(&histories, "contact.gap_m", "gap", impacts, &format!("Gap at the first impacts: {about}"))?,
            ),
        ]);
    }
    for (name, figure) in figures {
        figure.write_both(out, name)?;
        said.push(format!("{}", out.join(format!("{name}.png")).display()));
    }
    Ok(said)
}

fn first_contact(history: &History) -> Option<f64> {
    let force = history.channel("contact.peak_force_N")?;
    let at = force.values.iter().position(|force| *force > 0.0)?;
    Some(history.time[at])
}

/// Channel of the bearing with the largest load.
fn worst_bearing(histories: &[(&str, History)]) -> String {
    let loads = histories.iter().flat_map(|(_, history)| history.fitting("bearing.*.load_N"));
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let worst = loads.max_by(|a, b| largest(&a.values).total_cmp(&largest(&b.values)));
    worst.map_or_else(String::new, |series| series.name.clone())
}

type Named<'a> = (&'a str, History);

fn line(history: &History, channel: &str, label: &str, scale: &Scale, (from, to): (f64, f64)) -> Line {
    let values = history.channel(channel).map_or(&[][..], |series| &series.values);
    let points = history.time.iter().zip(values).filter(|(time, _)| (from..=to).contains(*time));
    Line::new(label, points.map(|(time, value)| (*time, value * scale.factor)).collect())
}

fn scale(histories: &[Named<'_>], channel: &str) -> Scale {
    let series = histories.iter().filter_map(|(_, history)| history.channel(channel));
    let unit = series.clone().next().map_or("", |series| series.unit.as_str());
    Scale::of(unit, series.flat_map(|series| &series.values).fold(0.0_f64, |max, value| max.max(value.abs())))
}

/// All detections in one panel.
fn over(
    histories: &[Named<'_>],
    channel: &str,
    name: &str,
    range: (f64, f64),
    title: &str,
) -> Result<Figure, CliError> {
    let scale = scale(histories, channel);
    let lines = histories.iter().map(|(detection, history)| line(history, channel, detection, &scale, range)).collect();
    Ok(panels(title, "time [s]", &[Panel { y_label: scale.label(name), lines, y_range: None, thin: true }])?)
}

/// One panel for each detection, all on one scale.
fn apart(
    histories: &[Named<'_>],
    channel: &str,
    name: &str,
    range: (f64, f64),
    title: &str,
) -> Result<Figure, CliError> {
    let scale = scale(histories, channel);
    let lines: Vec<Line> =
        histories.iter().map(|(detection, history)| line(history, channel, detection, &scale, range)).collect();
    let values = lines.iter().flat_map(|line| &line.points).map(|point| point.1);
    let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    // room for the legend
    let y_range = Some((low - 0.04 * (high - low), high + 0.25 * (high - low)));
    // the colours of the pictures with all detections in one panel
    let panel = |(at, line): (usize, Line)| {
        let lines = vec![Line { colour: Some(COLOURS[at % COLOURS.len()]), ..line }];
        Panel { y_label: scale.label(name), lines, y_range, thin: true }
    };
    Ok(panels(title, "time [s]", &lines.into_iter().enumerate().map(panel).collect::<Vec<_>>())?)
}
