//! Figures for each kind of plot.

use super::{Args, Named, span, time};
use crate::cli::error::CliError;
use crate::cli::output::remark;
use crate::history::unknown_in;
use bladeoff_answers::figures::{
    Contact, Figure, Line, Panel, Ring, Scale, contact_map, contacts, critical_passages, orbits, order_map,
    panels_marked, plain_name, response_spectrum, ring_of, spectrogram, waterfall,
};
use bladeoff_answers::history::{History, Series};
use bladeoff_answers::page::animation;

/// Figures with their file names.
type Pictures<T> = Vec<(String, T)>;

/// The figures of a kind other than an animation.
///
/// # Errors
/// A channel or an instant does not exist, or a figure cannot be made.
pub fn figures(args: &Args, histories: &[Named]) -> Result<Pictures<Figure>, CliError> {
    match args.kind.as_str() {
        "orbit" => orbit(args, histories),
        "contact" => contact_forces(histories),
        "spectrogram" | "order" | "waterfall" => spectra(args, histories),
        "response-spectrum" => response_spectra(args, histories),
        _ => Ok(vec![(format!("{}-time", together(histories)), over_time(args, histories)?)]),
    }
}

/// The animations of all files, one page for each.
///
/// # Errors
/// A history has no rotor position at a contact.
pub fn animations(histories: &[Named]) -> Result<Pictures<String>, CliError> {
    let mut pages = Vec::new();
    for named in histories {
        for contact in contacts_of(named, "contact.rotor_x_m")? {
            let title = format!("{}, orbit{}", title(std::slice::from_ref(named)), contact.of());
            let page = animation(&named.history, &title, &contact)
                .ok_or_else(|| unknown_in(&named.history, "contact.rotor_x_m"))?;
            warn_of_ring(named, &contact);
            pages.push((name(named, "animation", &contact), page));
        }
    }
    Ok(pages)
}

/// The contacts of a history; an error if the history has none.
fn contacts_of(named: &Named, channel: &str) -> Result<Vec<Contact>, CliError> {
    let found = contacts(&named.history);
    if found.is_empty() { Err(unknown_in(&named.history, channel).into()) } else { Ok(found) }
}

/// Name of the figure of a contact.
fn name(named: &Named, kind: &str, contact: &Contact) -> String {
    let of = if contact.name.is_empty() { String::new() } else { format!("-{}", contact.name) };
    format!("{}-{kind}{of}", named.name)
}

/// Prints a warning about missing channels or missing geometry of a ring.
fn warn_of_ring(named: &Named, contact: &Contact) {
    match ring_of(&named.history, contact) {
        Ring::Deformed => {}
        Ring::AtRest => remark(&format!(
            "{}: the history has no motion of the ring, so the clearance is drawn at rest; of a flexible ring, \
             `--channels` rotor, contact and ring (with several diaphragms contact.* and ring.*) record it",
            named.shown
        )),
        Ring::Unknown => remark(&format!(
            "{}: a CSV carries no geometry, so that no clearance is drawn; record .mcap or .parquet",
            named.shown
        )),
    }
}

/// Figures of the contact force around the ring over time.
fn contact_forces(histories: &[Named]) -> Result<Pictures<Figure>, CliError> {
    let mut figures = Vec::new();
    for named in histories {
        for contact in contacts_of(named, "contact.filtered_force_N")? {
            let figure = contact_map(&named.history, &named.name, &contact)?
                .ok_or_else(|| unknown_in(&named.history, "contact.filtered_force_N"))?;
            figures.push((name(named, "contact", &contact), figure));
        }
    }
    Ok(figures)
}

/// Name of a figure that shows all files.
fn together(histories: &[Named]) -> String {
    let names: Vec<&str> = histories.iter().map(|named| named.name.as_str()).collect();
    if names.len() > 3 { format!("{}-and-{}-more", names[0], names.len() - 1) } else { names.join("-") }
}

/// Title of a figure: the files, and for a single file its machine, engine and detection if the file has them.
fn title(histories: &[Named]) -> String {
    let names: Vec<&str> = histories.iter().map(|named| named.name.as_str()).collect();
    let [only] = histories else { return names.join(", ") };
    let about = |key: &str| only.history.about.get(key).cloned();
    let engine = about("engine").map(|engine| format!("{engine} engine"));
    let said: Vec<String> = [about("machine"), engine, about("detection")].into_iter().flatten().collect();
    if said.is_empty() { names.join(", ") } else { format!("{}: {}", only.name, said.join(", ")) }
}

/// The requested channels of one history.
fn chosen<'a>(history: &'a History, patterns: &[String], defaults: &[&str]) -> Result<Vec<&'a Series>, CliError> {
    let defaults: Vec<String> = defaults.iter().map(|name| (*name).to_owned()).collect();
    let asked = !patterns.is_empty();
    let mut found: Vec<&Series> = Vec::new();
    for pattern in if asked { patterns } else { &defaults } {
        let fitting = history.fitting(pattern);
        if fitting.is_empty() && asked {
            return Err(unknown_in(history, pattern).into());
        }
        found.extend(
            fitting.into_iter().filter(|new| !found.iter().any(|old| old.name == new.name)).collect::<Vec<_>>(),
        );
    }
    Ok(found)
}

/// Channels of a time history by default; with several diaphragms the contact channels carry their names.
const TIME_CHANNELS: [&str; 8] = [
    "rotor.speed",
    "bearing.*.load_N",
    "contact.eccentricity",
    "contact.*.eccentricity_m",
    "contact.gap",
    "contact.*.gap_m",
    "contact.filtered_force",
    "contact.*.filtered_force_N",
];

/// A line of a figure: its label, its history, and its channel.
type Drawn<'a> = (String, &'a History, &'a Series);

/// Figure with one panel for each quantity and one line for each channel and file.
fn over_time(args: &Args, histories: &[Named]) -> Result<Figure, CliError> {
    let mut quantities: Vec<(String, Vec<Drawn<'_>>)> = Vec::new();
    for named in histories {
        for channel in chosen(&named.history, &args.channels, &TIME_CHANNELS)? {
            let quantity = channel.name.rsplit('.').next().unwrap_or(&channel.name).to_owned();
            let label = label(&channel.name, &named.name, histories.len());
            match quantities.iter_mut().find(|(known, _)| *known == quantity) {
                Some((_, lines)) => lines.push((label, &named.history, channel)),
                None => quantities.push((quantity, vec![(label, &named.history, channel)])),
            }
        }
    }
    let silent = leave_out_zeros(&mut quantities, &args.channels);
    if !silent.is_empty() {
        remark(&format!("not drawn, because it is always 0: {}", silent.join(", ")));
    }
    let panel = |(_, lines): (String, Vec<Drawn<'_>>)| {
        let largest = lines.iter().flat_map(|line| &line.2.values).fold(0.0_f64, |max, value| max.max(value.abs()));
        let first = lines[0].2;
        let scale = Scale::of(&first.unit, largest);
        let quantity = first.name.rsplit('.').next().unwrap_or(&first.name);
        let alone = lines.len() == 1;
        let name = if alone { plain_name(&first.name, &first.unit) } else { plain_name(quantity, &first.unit) };
        let lines = lines
            .into_iter()
            .map(|(label, history, channel)| {
                let values = channel.values.iter().map(|value| value * scale.factor);
                let points = history.time.iter().copied().zip(values).filter(|point| point.1.is_finite());
                Line::new(if alone { "" } else { &label }, points.collect())
            })
            .collect();
        Panel { y_label: scale.label(&name), lines, thin: true, ..Panel::default() }
    };
    let shown: Vec<Panel> = quantities.into_iter().map(panel).collect();
    if shown.is_empty() {
        // none of the default channels was recorded
        return Err(unknown_in(&histories[0].history, TIME_CHANNELS[0]).into());
    }
    Ok(panels_marked(&title(histories), "time [s]", &shown, &marks(histories)))
}

/// Marks of the first contacts and critical speeds of a single history: time and label.
fn marks(histories: &[Named]) -> Vec<(f64, String)> {
    let [Named { history, .. }] = histories else { return Vec::new() };
    let touched = contacts(history)
        .into_iter()
        .filter_map(|contact| Some((contact.first_contact(history)?, format!("first contact{}", contact.of()))));
    let rpm = |speed: f64| (speed * 30.0 / std::f64::consts::PI).round();
    let passed = critical_passages(history).into_iter();
    let passed = passed.map(|(at, speed)| (at, format!("critical speed {} rpm", rpm(speed))));
    let mut all: Vec<(f64, String)> = touched.chain(passed).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Removes the energies that are zero in every history (of dampers and brakes that the machine does not have), unless they were requested by
/// their full names or nothing else is left; returns their names.
fn leave_out_zeros(quantities: &mut Vec<(String, Vec<Drawn<'_>>)>, asked: &[String]) -> Vec<String> {
    let is_silent = |(_, lines): &(String, Vec<Drawn<'_>>)| {
        lines.iter().all(|(_, _, channel)| {
            channel.name.starts_with("energy.")
                && !asked.contains(&channel.name)
                && channel.values.iter().all(|value| *value == 0.0)
        })
    };
    if quantities.iter().all(is_silent) {
        return Vec::new();
    }
    let silent = quantities.iter().filter(|quantity| is_silent(quantity));
    let names = silent.map(|(_, lines)| lines[0].2.name.clone()).collect();
    quantities.retain(|quantity| !is_silent(quantity));
    names
}

fn label(channel: &str, file: &str, files: usize) -> String {
    let group = channel.rsplit_once('.').map_or("", |(group, _)| group).replace('.', " ");
    if files > 1 {
        let is_single = ["rotor", "contact", "energy"].contains(&group.as_str());
        if is_single { file.to_owned() } else { format!("{file}, {group}") }
    } else {
        group
    }
}

fn orbit(args: &Args, histories: &[Named]) -> Result<Pictures<Figure>, CliError> {
    let mut figures = Vec::new();
    for named in histories {
        let (first, last) = (named.history.time[0], named.history.time[named.history.time.len() - 1]);
        let mut instants = Vec::new();
        for text in &args.at {
            let instant = time(Some(text), "--at")?.unwrap_or(first);
            // a difference of up to two records at the ends is rounding
            let slack = 2.0 * (last - first) / named.history.time.len() as f64;
            if !(first - slack..=last + slack).contains(&instant) {
                return Err(CliError::Argument {
                    argument: format!("--at {text}"),
                    message: format!("{} has no instant there", named.shown),
                    allowed: Some(span(first, last)),
                });
            }
            instants.push(instant);
        }
        if instants.is_empty() {
            instants = [0.25, 0.5, 1.0].iter().map(|share| first + share * (last - first)).collect();
        }
        for contact in contacts_of(named, "contact.rotor_x_m")? {
            let figure = orbits(&named.history, &named.name, &contact, &instants)
                .ok_or_else(|| unknown_in(&named.history, "contact.rotor_x_m"))?;
            warn_of_ring(named, &contact);
            figures.push((name(named, "orbit", &contact), figure));
        }
    }
    Ok(figures)
}

fn spectra(args: &Args, histories: &[Named]) -> Result<Pictures<Figure>, CliError> {
    let mut figures = Vec::new();
    for named in histories {
        let mut channels = chosen(&named.history, &args.channels, &["bearing.*.y_m"])?;
        if args.channels.is_empty() {
            channels.truncate(1);
        }
        if channels.is_empty() {
            return Err(unknown_in(&named.history, "bearing.*.y_m").into());
        }
        for channel in channels {
            let figure = match args.kind.as_str() {
                "order" => order_map(&named.history, &named.name, channel, args.top)?,
                "waterfall" => waterfall(&named.history, &named.name, channel, args.top)?,
                _ => spectrogram(&named.history, &named.name, channel, args.top)?,
            };
            let channel = plain_name(&channel.name, &channel.unit).replace(' ', "-");
            figures.push((format!("{}-{}-{channel}", named.name, args.kind), figure));
        }
    }
    Ok(figures)
}

fn response_spectra(args: &Args, histories: &[Named]) -> Result<Pictures<Figure>, CliError> {
    let mut figures = Vec::new();
    for named in histories {
        let channels = chosen(&named.history, &args.channels, &["pedestal.*.load_x_N", "pedestal.*.load_y_N"])?;
        if channels.is_empty() {
            return Err(unknown_in(&named.history, "pedestal.*.load_x_N").into());
        }
        let figure = response_spectrum(&named.history, &named.name, &channels, args.damping, args.top)?;
        figures.push((format!("{}-response-spectrum", named.name), figure));
    }
    Ok(figures)
}
