//! `bladeoff plot`: pictures of histories.

use super::error::CliError;
use super::exit::Exit;
use super::json::pretty;
use super::output::{print, print_json, remark};
use crate::history::{HistoryError, read, unknown_in};
use bladeoff_answers::figures::{
    Figure, Line, Panel, Ring, Scale, orbits, order_map, panels, plain_name, response_spectrum, ring_of, spectrogram,
};
use bladeoff_answers::history::{History, Series};
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use bladeoff_text::document::units::{format_quantity, parse_bare_or_quantity};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Draw histories: lines over time, orbits in the deformed ring, spectrograms, orders, response spectra
///
/// `time` has one panel for each kind of channel (same name after the last dot) and one line for each channel and file.
/// Several runs are therefore in one figure. Energies that are always 0 are left out, with a message. `orbit` draws the
/// rotor centre inside the clearance, one figure per file. For the deformed ring record MCAP or Parquet with `--channels
/// rotor,contact,ring`; CSV has no geometry. `spectrogram` and `order` draw one map for each channel and file.
/// `response-spectrum` draws the largest response of oscillators to the pedestal forces (or to other channels) over the
/// frequency of the oscillator, one figure for each file.
///
/// In a directory a figure is named after its file: turbine.mcap gives turbine-time, turbine-orbit,
/// turbine-order-bearing-rear-y. Files of the same name get the names of their directories. The figure of several files
/// has the names of all, of more than three that of the first and the number of the others. An existing figure is
/// replaced, with a message.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff plot turbine.mcap --out figures
  bladeoff plot hyp1.mcap hyp2.mcap --from 3 --to 3.5 \\
    --channels contact.gap,rotor.speed --out compare.svg
  bladeoff plot turbine.mcap --kind orbit \\
    --at \"3.2 s\" --at \"3.9 s\" --out orbit.png
  bladeoff plot turbine.mcap --kind spectrogram \\
    --channels bearing.rear.y --top 100 --out figures
  bladeoff plot turbine.mcap --kind order \\
    --channels bearing.rear.y --out figures
  bladeoff plot turbine.mcap --kind response-spectrum \\
    --damping 0.02 --top 200 --out spectrum.svg")]
pub struct Args {
    /// Histories (.mcap, .csv, .parquet)
    #[arg(required = true)]
    files: Vec<PathBuf>,

    /// Channels, separated by commas: names, beginnings of names ("contact.gap") or patterns ("bearing.*.load*") [default:
    /// speed, bearing loads, eccentricity, gap, filtered contact force; for maps the first bearing's y; for response
    /// spectra the pedestal forces along X and Y]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    channels: Vec<String>,

    /// What to draw
    #[arg(long, value_parser = ["time", "orbit", "spectrogram", "order", "response-spectrum"], default_value = "time")]
    kind: String,

    /// Only from this time on, in seconds or with a unit
    #[arg(long, value_name = "TIME")]
    from: Option<String>,

    /// Only up to this time
    #[arg(long, value_name = "TIME")]
    to: Option<String>,

    /// Instant of an orbit; may be given several times [default: a quarter, a half and all of the time]
    #[arg(long, value_name = "TIME")]
    at: Vec<String>,

    /// Highest frequency of a spectrogram or response spectrum in Hz, or highest order [default: a fifth of the highest
    /// frequency in the records; a twentieth of the record rate, which is also the most; 10]
    #[arg(long, value_name = "NUMBER", value_parser = above_zero)]
    top: Option<f64>,

    /// Damping ratio of the oscillators of a response spectrum
    #[arg(long, value_name = "NUMBER", value_parser = damping_ratio, default_value_t = 0.05)]
    damping: f64,

    /// A file (.svg or .png) for one figure, or a directory, which gets each figure as SVG and PNG
    #[arg(long, value_name = "DIR|FILE")]
    out: PathBuf,

    /// Print JSON: the kind, the histories, and the paths of the figures
    #[arg(long)]
    json: bool,
}

/// A history and its name, which figures show as they show any text; and the same for messages.
struct Named {
    name: String,
    shown: String,
    history: History,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    refuse_other_formats(&args.out, "--out", true)?;
    let (from, to) = (time(args.from.as_ref(), "--from")?, time(args.to.as_ref(), "--to")?);
    if let (Some(from), Some(to)) = (from, to)
        && to < from
    {
        let argument = asked(args.from.as_ref(), args.to.as_ref());
        return Err(CliError::Argument { argument, message: "--to lies before --from".to_owned(), allowed: None });
    }
    let mut histories = Vec::new();
    for (path, name) in args.files.iter().zip(names(&args.files)?) {
        let mut history = read(path)?;
        let (Some(&first), Some(&last)) = (history.time.first(), history.time.last()) else {
            return Err(HistoryError::NotAHistory { path: path.clone(), detail: "it has no instant" }.into());
        };
        cut(&mut history, from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY));
        if history.time.is_empty() {
            let is_after = from.is_some_and(|from| from > last);
            let is_before = to.is_some_and(|to| to < first);
            return Err(CliError::Argument {
                argument: match (is_after, is_before) {
                    (true, _) => asked(args.from.as_ref(), None),
                    (_, true) => asked(None, args.to.as_ref()),
                    _ => asked(args.from.as_ref(), args.to.as_ref()),
                },
                message: format!("{} has no instant there: it goes {}", shown(path), span(first, last)),
                allowed: None,
            });
        }
        histories.push(Named { shown: shown(&name), name, history });
    }
    let figures = match args.kind.as_str() {
        "orbit" => orbit(args, &histories)?,
        "spectrogram" | "order" => maps(args, &histories)?,
        "response-spectrum" => response_spectra(args, &histories)?,
        _ => vec![(format!("{}-time", together(&histories)), over_time(args, &histories)?)],
    };
    let files = save(&figures, &args.out)?;
    if args.json {
        let histories: Vec<String> = args.files.iter().map(shown).collect();
        print_json(&pretty(&json!({ "kind": args.kind, "histories": histories, "files": files })))?;
    } else {
        print(&(files.join("\n") + "\n"))?;
    }
    Ok(Exit::Ok)
}

/// Names for the files: their stems, with as many of their directories before them as it takes to tell them apart.
fn names(files: &[PathBuf]) -> Result<Vec<String>, CliError> {
    let parts = |path: &Path| -> Vec<String> {
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let mut parts: Vec<String> = absolute.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        if let (Some(last), Some(stem)) = (parts.last_mut(), path.file_stem()) {
            *last = stem.to_string_lossy().into_owned();
        }
        parts
    };
    let parts: Vec<Vec<String>> = files.iter().map(|path| parts(path)).collect();
    let named = |of: &[String], count: usize| of[of.len().saturating_sub(count)..].join("-").replace('/', "");
    let mut names = Vec::new();
    for (at, own) in parts.iter().enumerate() {
        let others = || parts.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, other)| other);
        let alone = |count: &usize| !others().any(|other| named(other, *count) == named(own, *count));
        let Some(count) = (1..=own.len()).find(alone) else {
            return Err(CliError::Argument {
                argument: shown(&files[at]),
                message: "is given twice, or differs from another file in its extension alone".to_owned(),
                allowed: Some("files whose names without extension differ".to_owned()),
            });
        };
        names.push(named(own, count));
    }
    Ok(names)
}

/// Name of a figure of all files.
fn together(histories: &[Named]) -> String {
    let names: Vec<&str> = histories.iter().map(|named| named.name.as_str()).collect();
    if names.len() > 3 { format!("{}-and-{}-more", names[0], names.len() - 1) } else { names.join("-") }
}

/// Title of a figure: the files, and for one file its machine, engine and detection where it says them.
fn title(histories: &[Named]) -> String {
    let names: Vec<&str> = histories.iter().map(|named| named.name.as_str()).collect();
    let [only] = histories else { return names.join(", ") };
    let about = |key: &str| only.history.about.get(key).cloned();
    let engine = about("engine").map(|engine| format!("{engine} engine"));
    let said: Vec<String> = [about("machine"), engine, about("detection")].into_iter().flatten().collect();
    if said.is_empty() { names.join(", ") } else { format!("{}: {}", only.name, said.join(", ")) }
}

fn time(text: Option<&String>, option: &str) -> Result<Option<f64>, CliError> {
    let Some(text) = text else { return Ok(None) };
    parse_bare_or_quantity(text, "s").map(Some).map_err(|error| CliError::Argument {
        argument: format!("{option} {text}"),
        message: error.to_string(),
        allowed: Some("a time such as \"3.2 s\", or a number of seconds".to_owned()),
    })
}

/// The options of a time as they were given.
fn asked(from: Option<&String>, to: Option<&String>) -> String {
    let given = [("--from", from), ("--to", to)].map(|(option, text)| text.map(|text| format!("{option} {text}")));
    given.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// From where to where, in words.
fn span(first: f64, last: f64) -> String {
    format!("from {} to {}", format_quantity(first, "s"), format_quantity(last, "s"))
}

fn above_zero(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "must be a number above 0".to_owned())
}

fn cut(history: &mut History, from: f64, to: f64) {
    let (first, last) = (history.time.partition_point(|t| *t < from), history.time.partition_point(|t| *t <= to));
    let range = first.min(last)..last;
    history.time = history.time[range.clone()].to_vec();
    for channel in &mut history.channels {
        channel.values = channel.values[range.clone()].to_vec();
    }
}

/// Channels asked for, of one history.
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

const TIME_CHANNELS: [&str; 5] =
    ["rotor.speed", "bearing.*.load_N", "contact.eccentricity", "contact.gap", "contact.filtered_force"];

/// A line: its label, where it is from, what it shows.
type Drawn<'a> = (String, &'a History, &'a Series);

/// One panel for each quantity, one line for each channel and file.
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
        remark(&format!("not drawn, because it is 0 all the time: {}", silent.join(", ")));
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
                Line::new(if alone { "" } else { &label }, history.time.iter().copied().zip(values).collect())
            })
            .collect();
        Panel { y_label: scale.label(&name), lines, y_range: None, thin: true }
    };
    let shown: Vec<Panel> = quantities.into_iter().map(panel).collect();
    if shown.is_empty() {
        // none of the default channels was recorded
        return Err(unknown_in(&histories[0].history, TIME_CHANNELS[0]).into());
    }
    Ok(panels(&title(histories), "time [s]", &shown)?)
}

/// Takes out the energies that are zero in every history (of dampers and brakes that a machine has not), unless they were asked for
/// by their whole names or nothing else is left; gives their names.
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
        if channel.starts_with("bearing") { format!("{file}, {group}") } else { file.to_owned() }
    } else {
        group
    }
}

fn orbit(args: &Args, histories: &[Named]) -> Result<Vec<(String, Figure)>, CliError> {
    let mut figures = Vec::new();
    for named in histories {
        let (first, last) = (named.history.time[0], named.history.time[named.history.time.len() - 1]);
        let mut instants = Vec::new();
        for text in &args.at {
            let instant = time(Some(text), "--at")?.unwrap_or(first);
            // a record or two beside the ends is rounding
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
        let figure = orbits(&named.history, &named.name, &instants)?
            .ok_or_else(|| unknown_in(&named.history, "contact.rotor_x_m"))?;
        match ring_of(&named.history) {
            Ring::Deformed => {}
            Ring::AtRest => remark(&format!(
                "{}: without the channels of the ring the clearance is drawn at rest; record with --channels \
                 rotor,contact,ring",
                named.shown
            )),
            Ring::Unknown => remark(&format!(
                "{}: a CSV carries no geometry, so that no clearance is drawn; record .mcap or .parquet",
                named.shown
            )),
        }
        figures.push((format!("{}-orbit", named.name), figure));
    }
    Ok(figures)
}

fn maps(args: &Args, histories: &[Named]) -> Result<Vec<(String, Figure)>, CliError> {
    let mut figures = Vec::new();
    for named in histories {
        let mut channels = chosen(&named.history, &args.channels, &["bearing.*.y_m"])?;
        if args.channels.is_empty() {
            channels.truncate(1);
        }
        for channel in channels {
            let figure = match args.kind.as_str() {
                "order" => order_map(&named.history, &named.name, channel, args.top.unwrap_or(10.0))?,
                _ => spectrogram(&named.history, &named.name, channel, args.top)?,
            };
            let channel = plain_name(&channel.name, &channel.unit).replace(' ', "-");
            figures.push((format!("{}-{}-{channel}", named.name, args.kind), figure));
        }
    }
    Ok(figures)
}

fn response_spectra(args: &Args, histories: &[Named]) -> Result<Vec<(String, Figure)>, CliError> {
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

/// A damping ratio of an oscillator.
fn damping_ratio(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(ratio) if (0.0..1.0).contains(&ratio) => Ok(ratio),
        _ => Err("allowed: a number from 0 to below 1, such as 0.05".to_owned()),
    }
}

/// Whether a name is that of one figure.
fn is_figure(out: &Path) -> bool {
    !out.is_dir() && out.extension().is_some_and(|extension| extension == "svg" || extension == "png")
}

/// Refuses a name that looks like a file of a format that is not written: it would become a directory. `may_be_one`: whether
/// one figure into a file is a choice.
///
/// # Errors
/// [`CliError::Argument`], with what is allowed.
pub fn refuse_other_formats(out: &Path, option: &str, may_be_one: bool) -> Result<(), CliError> {
    let is_folder = out.is_dir() || out.as_os_str().as_encoded_bytes().ends_with(b"/");
    let extension = out.extension().map(|extension| extension.to_string_lossy().into_owned()).unwrap_or_default();
    // "v1.2" is a folder.
    if is_folder || may_be_one && is_figure(out) || !extension.starts_with(|c: char| c.is_alphabetic()) {
        return Ok(());
    }
    let out = shown(out);
    let file = if may_be_one { "a file .svg or .png, or " } else { "" };
    let what = if may_be_one {
        "figures are not written as"
    } else {
        "this is a directory for figures (svg and png), not a file"
    };
    Err(CliError::Argument {
        argument: format!("{option} {out}"),
        message: format!("{what} .{extension}"),
        allowed: Some(format!("{file}a directory (one with such a name ends in /: {out}/)")),
    })
}

/// Writes figures into a file or a directory; returns their paths as they are printed.
///
/// # Errors
/// Several figures for one file, or a file that cannot be written.
pub(super) fn save(figures: &[(String, Figure)], out: &Path) -> Result<Vec<String>, CliError> {
    if is_figure(out) {
        if figures.len() != 1 {
            return Err(CliError::Argument {
                argument: format!("--out {}", shown(out)),
                message: format!("{} figures do not go into one file", figures.len()),
                allowed: Some("a directory".to_owned()),
            });
        }
        replacing(out, || figures[0].1.write(out))?;
        return Ok(vec![shown(out)]);
    }
    std::fs::create_dir_all(out).map_err(FileError::at("create", out))?;
    let mut files = Vec::new();
    for (name, figure) in figures {
        for extension in ["svg", "png"] {
            let path = out.join(format!("{name}.{extension}"));
            replacing(&path, || figure.write(&path))?;
            files.push(shown(path));
        }
    }
    Ok(files)
}

/// Writes a file; says afterwards if it took the place of one.
///
/// # Errors
/// That of writing: then nothing was replaced.
pub fn replacing<E>(path: &Path, write: impl FnOnce() -> Result<(), E>) -> Result<(), E> {
    let was_there = path.symlink_metadata().is_ok();
    write()?;
    if was_there {
        remark(&format!("{} is replaced", shown(path)));
    }
    Ok(())
}
