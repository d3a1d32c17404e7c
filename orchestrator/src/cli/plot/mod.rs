//! `bladeoff plot`: pictures of histories.

mod kinds;

use crate::cli::error::CliError;
use crate::cli::exit::Exit;
use crate::cli::json::pretty;
use crate::cli::output::{print, print_json, remark};
use crate::history::{HistoryError, read};
use bladeoff_answers::figures::Figure;
use bladeoff_answers::history::History;
use bladeoff_answers::summary::counted;
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::shown;
use bladeoff_text::document::units::{format_quantity, parse_bare_or_quantity};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Draw histories: lines over time, orbits, an animation, contact forces, spectra over time and speed
///
/// `time` has one panel for each kind of channel (same name after the last dot) and one line for each channel and file.
/// Several runs are therefore in one figure. Energies that are always 0 are left out, with a message.
///
/// `orbit` draws the rotor centre inside the clearance, one figure per file and contact. `animation` is the same as one
/// HTML file with a slider and a play button, with the clearance of each instant and marks for the first contact and the
/// critical speeds. For the deformed ring record MCAP or Parquet with `--channels rotor,contact,ring`; CSV has no geometry.
/// `contact` draws the contact force around the ring over time.
///
/// `spectrogram`, `order` and `waterfall` draw one figure for each channel and file. A waterfall has the spectra over the
/// spin speed. `response-spectrum` draws the largest response of oscillators to the pedestal forces (or to other channels)
/// over the frequency of the oscillator, one figure for each file.
///
/// In a directory a figure is named after its file: turbine.mcap gives turbine-time, turbine-orbit,
/// turbine-order-bearing-rear-y. Files of the same name get the names of their directories. A figure of two or three
/// files is named after all of them, a figure of more files after the first one and the number of the others. An
/// existing figure is replaced, with a message.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff plot turbine.mcap --out figures
  bladeoff plot hyp1.mcap hyp2.mcap --from 3 --to 3.5 \\
    --channels contact.gap,rotor.speed --out compare.svg
  bladeoff plot turbine.mcap --kind orbit \\
    --at \"3.2 s\" --at \"3.9 s\" --out orbit.png
  bladeoff plot turbine.mcap --kind animation \\
    --from 3 --to 3.5 --out orbit.html
  bladeoff plot turbine.mcap --kind contact --out rub.png
  bladeoff plot turbine.mcap --kind waterfall \\
    --channels bearing.rear.y --out figures
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

    /// Kind of picture
    #[arg(long, value_parser = ["time", "orbit", "animation", "contact", "spectrogram", "order", "waterfall", "response-spectrum"], default_value = "time")]
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

    /// Highest frequency in Hz, or highest order [default: what the signal contains; of orders 3 to 10; of a response spectrum
    /// a twentieth of the record rate, which is also the most]
    #[arg(long, value_name = "NUMBER", value_parser = above_zero)]
    top: Option<f64>,

    /// Damping ratio of the oscillators of a response spectrum
    #[arg(long, value_name = "NUMBER", value_parser = damping_ratio, default_value_t = 0.05)]
    damping: f64,

    /// A file (.svg or .png; .html for an animation) for one figure, or a directory, which gets each figure as SVG and PNG
    #[arg(long, value_name = "DIR|FILE")]
    out: PathBuf,

    /// Print JSON: the kind, the histories, and the paths of the figures
    #[arg(long)]
    json: bool,
}

/// A history with its name: as figures show it, and as messages show it.
struct Named {
    name: String,
    shown: String,
    history: History,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let is_animation = args.kind == "animation";
    refuse_other_formats(&args.out, "--out", if is_animation { &["html"] } else { &FORMATS })?;
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
        let wrong = |detail| HistoryError::NotAHistory { path: path.clone(), detail };
        let (Some(&first), Some(&last)) = (history.time.first(), history.time.last()) else {
            return Err(wrong("it has no instant").into());
        };
        if !is_ascending(&history.time) {
            return Err(wrong("its times are not ascending numbers").into());
        }
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
                message: format!("{} has no record in this range: it covers {}", shown(path), span(first, last)),
                allowed: None,
            });
        }
        without_extremes(&mut history, &shown(path));
        histories.push(Named { shown: shown(&name), name, history });
    }
    let files = if is_animation {
        save_pages(&kinds::animations(&histories)?, &args.out)?
    } else {
        save(&kinds::figures(args, &histories)?, &args.out)?
    };
    if args.json {
        let histories: Vec<String> = args.files.iter().map(shown).collect();
        print_json(&pretty(&json!({ "kind": args.kind, "histories": histories, "files": files })))?;
    } else {
        print(&(files.join("\n") + "\n"))?;
    }
    Ok(Exit::Ok)
}

/// Names for the files: the file stem, preceded by as many directories as are needed to distinguish the files.
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

fn time(text: Option<&String>, option: &str) -> Result<Option<f64>, CliError> {
    let Some(text) = text else { return Ok(None) };
    parse_bare_or_quantity(text, "s").map(Some).map_err(|error| CliError::Argument {
        argument: format!("{option} {text}"),
        message: error.to_string(),
        allowed: Some("a time such as \"3.2 s\", or a number of seconds".to_owned()),
    })
}

/// The options of the time range as they were given.
fn asked(from: Option<&String>, to: Option<&String>) -> String {
    let given = [("--from", from), ("--to", to)].map(|(option, text)| text.map(|text| format!("{option} {text}")));
    given.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// A time range in words.
fn span(first: f64, last: f64) -> String {
    format!("from {} to {}", format_quantity(first, "s"), format_quantity(last, "s"))
}

fn above_zero(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "must be a number above 0".to_owned())
}

/// Largest value that is drawn: the pixel coordinates of larger values are not finite.
const LARGEST: f64 = 1e100;

fn is_ascending(time: &[f64]) -> bool {
    time.iter().all(|time| time.abs() <= LARGEST) && time.windows(2).all(|pair| pair[0] <= pair[1])
}

/// Replaces values of a history that are not finite, or too large to draw, by gaps and prints a message. A diverging run has such values at its
/// end.
fn without_extremes(history: &mut History, shown: &str) {
    for channel in &mut history.channels {
        let is_drawn = |value: &f64| value.abs() <= LARGEST;
        let count = channel.values.iter().filter(|value| !is_drawn(value)).count();
        if count > 0 {
            let first = channel.values.iter().position(|value| !is_drawn(value)).map_or(0.0, |at| history.time[at]);
            remark(&format!(
                "{shown}: {} of {} are not drawn, from {} on: no finite number, or beyond 1e100",
                counted(count as u64, "value"),
                channel.name,
                format_quantity(first, "s")
            ));
            channel.values.iter_mut().filter(|value| !is_drawn(value)).for_each(|value| *value = f64::NAN);
        }
    }
}

fn cut(history: &mut History, from: f64, to: f64) {
    let (first, last) = (history.time.partition_point(|t| *t < from), history.time.partition_point(|t| *t <= to));
    let range = first.min(last)..last;
    history.time = history.time[range.clone()].to_vec();
    for channel in &mut history.channels {
        channel.values = channel.values[range.clone()].to_vec();
    }
}

/// Parses the damping ratio of an oscillator.
fn damping_ratio(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(ratio) if (0.0..1.0).contains(&ratio) => Ok(ratio),
        _ => Err("allowed: a number from 0 to below 1, such as 0.05".to_owned()),
    }
}

/// Formats of a figure in one file.
pub const FORMATS: [&str; 2] = ["svg", "png"];

/// Whether a path has the extension of one of these formats.
fn is_one_file(out: &Path, formats: &[&str]) -> bool {
    let extension = out.extension().and_then(|extension| extension.to_str());
    !out.is_dir() && extension.is_some_and(|extension| formats.contains(&extension))
}

/// Rejects a path that looks like a file of an unsupported format, because a directory of this name would be created. `formats`: the formats of
/// one figure in one file; if empty, only a directory is possible.
///
/// # Errors
/// [`CliError::Argument`], with the permitted formats.
pub fn refuse_other_formats(out: &Path, option: &str, formats: &[&str]) -> Result<(), CliError> {
    let is_folder = out.is_dir() || out.as_os_str().as_encoded_bytes().ends_with(b"/");
    let extension = out.extension().map(|extension| extension.to_string_lossy().into_owned()).unwrap_or_default();
    // "v1.2" is a directory.
    if is_folder || is_one_file(out, formats) || !extension.starts_with(|c: char| c.is_alphabetic()) {
        return Ok(());
    }
    let out = shown(out);
    let (file, what) = match formats {
        [] => (String::new(), "this is a directory for figures (svg and png), not a file"),
        ["html"] => ("a file .html, or ".to_owned(), "animations are not written as"),
        _ => ("a file .svg or .png, or ".to_owned(), "figures are not written as"),
    };
    Err(CliError::Argument {
        argument: format!("{option} {out}"),
        message: format!("{what} .{extension}"),
        allowed: Some(format!("{file}a directory (one with such a name ends in /: {out}/)")),
    })
}

/// Writes figures to a file or a directory; returns their paths as they are printed.
///
/// # Errors
/// Several figures were requested in one file, or a file cannot be written.
pub(in crate::cli) fn save(figures: &[(String, Figure)], out: &Path) -> Result<Vec<String>, CliError> {
    if is_one_file(out, &FORMATS) {
        let figure = only(figures, out)?;
        replacing(out, || figure.write(out))?;
        return Ok(vec![shown(out)]);
    }
    std::fs::create_dir_all(out).map_err(FileError::at("create", out))?;
    let mut files = Vec::new();
    for (name, figure) in figures {
        for extension in FORMATS {
            let path = out.join(format!("{name}.{extension}"));
            replacing(&path, || figure.write(&path))?;
            files.push(shown(path));
        }
    }
    Ok(files)
}

/// Writes pages to a file or a directory; returns their paths as they are printed.
fn save_pages(pages: &[(String, String)], out: &Path) -> Result<Vec<String>, CliError> {
    let mut files = Vec::new();
    if is_one_file(out, &["html"]) {
        let page = only(pages, out)?;
        replacing(out, || write_whole(out, page.as_bytes()))?;
        return Ok(vec![shown(out)]);
    }
    std::fs::create_dir_all(out).map_err(FileError::at("create", out))?;
    for (name, page) in pages {
        let path = out.join(format!("{name}.html"));
        replacing(&path, || write_whole(&path, page.as_bytes()))?;
        files.push(shown(path));
    }
    Ok(files)
}

/// The only figure of a list that is to be written to one file.
fn only<'a, T>(pictures: &'a [(String, T)], out: &Path) -> Result<&'a T, CliError> {
    match pictures {
        [(_, picture)] => Ok(picture),
        _ => Err(CliError::Argument {
            argument: format!("--out {}", shown(out)),
            message: format!("{} figures do not go into one file", pictures.len()),
            allowed: Some("a directory".to_owned()),
        }),
    }
}

/// Writes a file, and prints a message if it replaced an existing one.
///
/// # Errors
/// The error of writing; the existing file is then unchanged.
pub fn replacing<E>(path: &Path, write: impl FnOnce() -> Result<(), E>) -> Result<(), E> {
    let was_there = path.symlink_metadata().is_ok();
    write()?;
    if was_there {
        remark(&format!("{} is replaced", shown(path)));
    }
    Ok(())
}
