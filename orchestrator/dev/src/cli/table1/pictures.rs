//! Figures corresponding to figures 7 to 13 of the paper, with the three detections together.

use super::runs::Case;
use bladeoff::cli::{CliError, remark, replacing, watched};
use bladeoff::engine;
use bladeoff::history::{Decimation, Settings, read};
use bladeoff_answers::figures::{COLOURS, Figure, Line, Panel, Scale, panels};
use bladeoff_answers::history::History;
use bladeoff_answers::tables::CsvStyle;
use bladeoff_model::machine::Engine;
use bladeoff_system::shown;
use std::path::Path;

/// Recorded interval \[s\].
const EVERY: f64 = 1e-4;
/// Beginning before, and end after, the first contact in the pictures of the first impacts \[s\].
const FIRST_IMPACTS: (f64, f64) = (5e-3, 0.15);

/// Definition of a picture.
struct Picture {
    file: &'static str,
    title: String,
    channel: String,
    quantity: String,
    range: (f64, f64),
}

/// Runs each detection again from the machine's own start, with its history, and draws the pictures; returns the report section that shows
/// them.
pub(super) fn draw(cases: &[Case], out: &Path) -> Result<String, CliError> {
    // the faster engine if both were run
    let engine = cases.first().map_or(Engine::Reduced.word(), |case| case.engine);
    let mut histories = Vec::new();
    for case in cases.iter().filter(|case| case.engine == engine && case.start == 0) {
        let structure = engine::build(&case.machine)?;
        let path = out.join(format!("{}.mcap", case.detection));
        let settings = Settings {
            path: path.clone(),
            channels: Vec::new(),
            decimation: Decimation::Every(EVERY),
            csv: CsvStyle::Point,
        };
        let (_, written) = watched(&case.machine, &structure, Some(&settings), false)?;
        if let Some(written) = written {
            remark(&written);
        }
        if path.is_file() {
            histories.push((case.detection, read(&path)?));
        }
    }
    if histories.is_empty() {
        remark("warning: there are no histories, hence no figures");
        return Ok(String::new());
    }
    let mut section = "\n## Figures\n".to_owned();
    for picture in pictures(&histories, &format!("our turbine, {engine} engine")) {
        let (figure, png) = (figure(&histories, &picture), out.join(format!("{}.png", picture.file)));
        replacing(&png, || figure.write_both(out, picture.file))?;
        remark(&shown(&png));
        section.push_str(&format!("\n![{}]({}.png)\n", picture.title, picture.file));
    }
    Ok(section)
}

type Named = (&'static str, History);

/// Figures 7 to 13 of the paper; without contact, only those before the first contact.
fn pictures(histories: &[Named], about: &str) -> Vec<Picture> {
    let first = histories.iter().filter_map(|(_, history)| first_contact(history)).fold(f64::INFINITY, f64::min);
    let whole = (0.0, f64::INFINITY);
    let (rub, impacts) = ((first - 0.1, f64::INFINITY), (first - FIRST_IMPACTS.0, first + FIRST_IMPACTS.1));
    let load = worst_bearing(histories);
    let bearing = load.trim_end_matches(".load_N").replace('.', " ");
    let place = load.replace("load_N", "x_m");
    let picture = |file, title: &str, channel: &str, quantity: &str, range| Picture {
        file,
        title: format!("{title}: {about}"),
        channel: channel.to_owned(),
        quantity: quantity.to_owned(),
        range,
    };
    let force = "contact.peak_force_N";
    let mut all = vec![
        picture("fig07-speed", "Rotating speed", "rotor.speed_rad_s", "speed", whole),
        picture(
            "fig08-bearing-displacement",
            &format!("Displacement of the shaft at {bearing}"),
            &place,
            "displacement x",
            whole,
        ),
        picture("fig09-bearing-load", &format!("Load of {bearing}"), &load, "load", whole),
    ];
    if first.is_finite() {
        all.extend([
            picture("fig10-contact-force", "Contact force (largest of 0.1 ms)", force, "force", rub),
            picture(
                "fig11-first-impacts",
                "Contact force at the first impacts (largest of 0.1 ms)",
                force,
                "force",
                impacts,
            ),
            picture("fig12-gap", "Gap", "contact.gap_m", "gap", whole),
            picture("fig13-gap-first-impacts", "Gap at the first impacts", "contact.gap_m", "gap", impacts),
        ]);
    }
    all
}

fn first_contact(history: &History) -> Option<f64> {
    let force = history.channel("contact.peak_force_N")?;
    let at = force.values.iter().position(|force| *force > 0.0)?;
    Some(history.time[at])
}

/// Channel of the bearing with the largest load.
fn worst_bearing(histories: &[Named]) -> String {
    let loads = histories.iter().flat_map(|(_, history)| history.fitting("bearing.*.load_N"));
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let worst = loads.max_by(|a, b| largest(&a.values).total_cmp(&largest(&b.values)));
    worst.map_or_else(String::new, |series| series.name.clone())
}

fn figure(histories: &[Named], picture: &Picture) -> Figure {
    let (from, to) = picture.range;
    let shown = |history: &History| -> Vec<(f64, f64)> {
        let values = history.channel(&picture.channel).map_or(&[][..], |series| &series.values);
        let points = history.time.iter().copied().zip(values.iter().copied());
        points.filter(|(time, _)| (from..=to).contains(time)).collect()
    };
    let all: Vec<(&str, Vec<(f64, f64)>)> = histories.iter().map(|(name, history)| (*name, shown(history))).collect();
    let values = || all.iter().flat_map(|(_, points)| points).map(|point| point.1);
    let unit = histories.iter().find_map(|(_, history)| history.channel(&picture.channel));
    let scale =
        Scale::of(unit.map_or("", |series| &series.unit), values().fold(0.0, |max, value| max.max(value.abs())));
    // one panel for each detection, all with one scale: equal curves would hide each other in one panel
    let (low, high) =
        values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let (low, high) = if low <= high { (low * scale.factor, high * scale.factor) } else { (0.0, 0.0) };
    let room = if high > low { 0.05 * (high - low) } else { 1.0 };
    let panel = |(at, (name, points)): (usize, &(&str, Vec<(f64, f64)>))| {
        let points = points.iter().map(|(time, value)| (*time, value * scale.factor)).collect();
        let line = Line { colour: Some(COLOURS[at % COLOURS.len()]), width: 1, ..Line::new(name, points) };
        Panel {
            y_label: scale.label(&picture.quantity),
            lines: vec![line],
            y_range: Some((low - room, high + room)),
            thin: true,
            is_log: false,
        }
    };
    let shown: Vec<Panel> = all.iter().enumerate().map(panel).collect();
    panels(&picture.title, "time [s]", &shown)
}
