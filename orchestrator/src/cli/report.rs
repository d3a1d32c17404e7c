//! `bladeoff report`: report on a study as one HTML page.

use super::answer::{asked_of, forecast_of, short_of};
use super::error::CliError;
use super::exit::Exit;
use super::gate::name;
use super::output::remark;
use super::place::default_directory;
use super::plot::replacing;
use super::replay::computed_again;
use crate::html_report::{Ahead, Subject, report};
use crate::questions::{Answering, Meant};
use crate::run::directory::{MANIFEST, RESULTS};
use crate::run::shards::row_files;
use crate::run::{RunState, directory_status};
use crate::terminal::with_word;
use bladeoff_answers::summary::counted;
use bladeoff_study::parse_duration;
use bladeoff_system::files::write_whole;
use bladeoff_system::shown;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Write one HTML page about a study
///
/// A verdict, answers as sentences, curves with their limits, distributions, failed runs by cause, the worst runs with the
/// commands that compute them again, and the provenance. The worst run is computed again for its history. The page needs
/// no network and no other file. Without scripts, and in print, it shows the same figures. The same results give the
/// same page, byte for byte.
///
/// An incomplete study is reported as such at the top of the page. The charts of a long table show a selection
/// of its rows, with all failures of a rare cause. All numbers use every row.
///
/// With --refresh the page is written again while the study runs, and a browser that shows it loads it again. The command
/// ends with the study.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff report runs/blade-off-risk
  bladeoff report runs/blade-off-risk \\
    --out blade-off-risk.html
  bladeoff report runs/blade-off-risk \\
    --study other-questions.toml
  bladeoff report runs/blade-off-risk --refresh 30s")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if it contains a study, otherwise the newest one
    /// below runs/]
    directory: Option<PathBuf>,

    /// Write the page to this file; an existing file is replaced
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,

    /// Use the [[question]]s and [[gate]]s of this study file instead of those of the directory
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,

    /// Omit the history of the worst run. Without this option the run is computed again, which takes the time of one run
    #[arg(long)]
    no_history: bool,

    /// Write the page again after this time until the run of the study has ended
    #[arg(long, value_name = "TIME", value_parser = refresh_time)]
    refresh: Option<Duration>,
}

/// Parses the time between two pages; browsers count whole seconds.
fn refresh_time(text: &str) -> Result<Duration, String> {
    let time = parse_duration(text)?;
    if time < Duration::from_secs(1) {
        return Err("must be at least 1 s".to_owned());
    }
    Ok(time)
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    refuse_other_formats(&args.out)?;
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    let (samples, _, Meant { questions, gates }) = asked_of(&directory, args.study.as_deref())?;
    let name = name(&directory, &samples);
    let subject =
        Subject { directory: &directory, samples: &samples, name: &name, questions: &questions, gates: &gates };
    let Some(every) = args.refresh else {
        if row_files(&directory).is_empty() {
            return Err(CliError::no_results(&directory));
        }
        write(args, subject, None)?;
        return Ok(Exit::Ok);
    };
    loop {
        // checked before the page is made, so that the last page has all rows
        let is_running = is_running(&directory)?;
        if !row_files(&directory).is_empty() {
            write(args, subject, is_running.then_some(every))?;
        } else if !is_running {
            return Err(CliError::no_results(&directory));
        }
        if !is_running {
            return Ok(Exit::Ok);
        }
        std::thread::sleep(every);
    }
}

/// Whether a run may add rows to the directory.
fn is_running(directory: &Path) -> Result<bool, CliError> {
    let status = directory_status(directory)?;
    Ok(status.is_some_and(|status| matches!(status.state, RunState::Running { .. } | RunState::Unknown { .. })))
}

/// Number of runs that have ended, as the last run of the directory reported it.
fn ended(directory: &Path) -> Option<u64> {
    let status = directory_status(directory).ok().flatten()?;
    status.last_report?.get("done")?.as_u64()
}

/// Writes one page; `again_after`: interval at which a browser reloads it.
fn write(args: &Args, subject: Subject<'_>, again_after: Option<Duration>) -> Result<(), CliError> {
    let Subject { directory, samples, .. } = subject;
    let is_function = samples.study().function().is_some();
    let ahead = |answering: &Answering| Ahead {
        forecasts: forecast_of(directory, samples, answering),
        // [stop] does not apply to the questions of another file
        short: if args.study.is_none() { short_of(samples, answering) } else { Vec::new() },
    };
    // the page of a running study takes little processor time from the run
    let wants_history = !args.no_history && !is_function && again_after.is_none();
    let again = |sample| {
        let compute = || computed_again(directory, sample).map_err(|error| error.to_string());
        wants_history.then(|| with_word(|| format!("computing sample {sample} again for its history"), compute))
    };
    let mut made = report(subject, ahead, again)?;
    made.page.reload = again_after.map(|time| time.as_secs_f64().ceil() as u64);
    if !made.is_known {
        let table = shown(directory.join(RESULTS));
        remark(&format!("warning: {table} cannot be verified: {MANIFEST} has no checksum of it"));
    }
    replacing(&args.out, || write_whole(args.out.as_path(), made.page.html().as_bytes()))?;
    let (rows, of) = made.rows;
    let about = if rows < of { format!("{rows} of {}", counted(of, "run")) } else { counted(of, "run") };
    // rows are added to the tables in parts
    let ended = ended(directory).filter(|ended| rows < of && *ended > rows);
    let ended = ended.map_or(String::new(), |ended| format!("; {ended} have ended, the rows of the newest follow"));
    remark(&format!("wrote {} about {about}{ended}", shown(&args.out)));
    Ok(())
}

/// Rejects other file formats, so that a table is not overwritten by mistake.
fn refuse_other_formats(out: &Path) -> Result<(), CliError> {
    let extension = out.extension().and_then(|extension| extension.to_str());
    if matches!(extension, Some("html" | "htm")) && !out.is_dir() {
        return Ok(());
    }
    Err(CliError::Argument {
        argument: format!("--out {}", shown(out)),
        message: "a report is one HTML page".to_owned(),
        allowed: Some("a file that ends in .html".to_owned()),
    })
}
