//! `bladeoff-dev table1`: the paper's Table 1 compared with the results of this program, and figures like its figures 7 to 13.

mod pictures;
mod runs;

use crate::table1::{Done, csv, report};
use bladeoff::cli::{CliError, Exit, print, refuse_other_formats, remark, replacing};
use bladeoff::run::own_columns;
use bladeoff_model::outcome::Status;
use bladeoff_study::{Samples, load};
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::shown;
use std::path::PathBuf;

/// The paper's comparison of the three contact detections, beside ours
///
/// Runs the turbine with each detection from several slightly different starts (phase of the lost blade, 1 % of its mass),
/// with the chosen engines, and prints the paper's Table 1 beside ours with the scatter over the starts. An ordering of two
/// detections is claimed only where all values of one lie below all of the other, at so many starts that this is no
/// accident (four or more), and where every engine agrees. Measurements about the causes follow. The machine is ours,
/// not the paper's. Writes table1.md, runs.csv (every run), histories and figures like figures 7 to 13 of the paper into a
/// directory; the figures are of the first engine of the study, from the machine's own start.
///
/// CPU time is that of the computing thread; a busy machine makes it longer and its order less sure.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff-dev table1
  bladeoff-dev table1 --engine reduced --out runs/reduced")]
pub struct Args {
    /// The study with detections, engines and starts
    #[arg(default_value = "studies/table1.toml")]
    study: PathBuf,

    /// Engines to run: a run takes a minute or two with full, seconds with reduced, a quarter of a second with exponential
    #[arg(long, value_parser = ["all", "exponential", "full", "reduced"], default_value = "all")]
    engine: String,

    /// Starts for each detection and engine, the first N of the study: the machine's own and slight changes of it
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    scatter: u64,

    /// End the runs at this simulated time, in seconds or with a unit (the heavy rub begins after 3 s)
    #[arg(long, value_name = "TIME")]
    end_time: Option<String>,

    /// Directory for the table, the runs and the figures
    #[arg(long, value_name = "DIR", default_value = "runs/table1")]
    out: PathBuf,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    refuse_other_formats(&args.out, "--out", &[])?;
    let samples = Samples::new(load(&args.study, own_columns)?, None, None)?;
    if samples.study().function().is_some() {
        return Err(CliError::Formulas { path: args.study.clone(), what: "table1 compares contact detections" });
    }
    let cases = runs::cases(&samples, &args.engine, args.scatter, args.end_time.as_deref())?;
    let starts = 1 + cases.iter().map(|case| case.start).max().unwrap_or(0);
    if (starts as u64) < args.scatter {
        remark(&format!("{} has {starts} starts, not {}", shown(&args.study), args.scatter));
    }
    std::fs::create_dir_all(&args.out).map_err(FileError::at("create", &args.out))?;
    remark(&format!("{} runs; then 3 more with their histories", cases.len()));
    let done = runs::compute(&cases)?;
    let text = report(&done);
    print(&text)?;
    for (name, text) in [("table1.md", text.as_str()), ("runs.csv", csv(&done).as_str())] {
        let path = args.out.join(name);
        replacing(&path, || write_whole(&path, text.as_bytes()))?;
    }
    let figures = pictures::draw(&cases, &args.out)?;
    write_whole(args.out.join("table1.md"), (text + &figures).as_bytes())?;
    let finished = |run: &Done| matches!(run.status(), Status::Ok | Status::Beyond | Status::Invalid);
    Ok(if done.iter().all(finished) { Exit::Ok } else { Exit::Failures })
}
