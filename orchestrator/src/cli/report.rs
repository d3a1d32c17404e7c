//! `bladeoff report`: one page about a study, to hand over.

use super::answer::{asked_of, forecast_of, short_of};
use super::error::CliError;
use super::exit::Exit;
use super::gate::name;
use super::output::remark;
use super::place::default_directory;
use super::plot::replacing;
use crate::html_report::{Ahead, Subject, report};
use crate::questions::Meant;
use crate::run::directory::{MANIFEST, RESULTS};
use crate::run::shards::row_files;
use bladeoff_answers::summary::counted;
use bladeoff_system::files::write_whole;
use bladeoff_system::shown;
use std::path::{Path, PathBuf};

/// Write one HTML page about a study
///
/// Answers as sentences, curves with their limits, failed runs by cause, the worst runs with the commands that compute
/// them again, and the provenance. The page needs no network and no other file. Without scripts, and in print, it shows
/// the same figures. The same results give the same page, byte for byte.
///
/// An incomplete study is reported as such at the top of the page. If a table has many rows, some are drawn, and all that
/// failed by a rare cause. Every number is from all rows.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff report runs/blade-off-risk
  bladeoff report runs/blade-off-risk \\
    --out blade-off-risk.html
  bladeoff report runs/blade-off-risk \\
    --study other-questions.toml")]
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
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    refuse_other_formats(&args.out)?;
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    let (samples, _, Meant { questions, gates }) = asked_of(&directory, args.study.as_deref())?;
    if row_files(&directory).is_empty() {
        return Err(CliError::no_results(&directory));
    }
    let name = name(&directory, &samples);
    let subject =
        Subject { directory: &directory, samples: &samples, name: &name, questions: &questions, gates: &gates };
    let made = report(subject, |answering| Ahead {
        forecasts: forecast_of(&directory, &samples, answering),
        // other questions are not what was waited for
        short: if args.study.is_none() { short_of(&samples, answering) } else { Vec::new() },
    })?;
    if !made.is_known {
        let table = shown(directory.join(RESULTS));
        remark(&format!("warning: {table} cannot be verified: {MANIFEST} has no checksum of it"));
    }
    replacing(&args.out, || write_whole(args.out.as_path(), made.page.html().as_bytes()))?;
    let (rows, of) = made.rows;
    let so_far = if rows < of { format!(", of the {rows} that have ended so far") } else { String::new() };
    remark(&format!("wrote {} about {}{so_far}", shown(&args.out), counted(of, "run")));
    Ok(Exit::Ok)
}

/// A page is no table: whoever names one by mistake keeps it.
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
