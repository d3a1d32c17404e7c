//! `bladeoff table1`: the paper's Table 1 beside ours, and figures like its figures 7 to 13.

mod pictures;
mod runs;
mod verdict;

use super::error::CliError;
use super::exit::Exit;
use super::output::{print, remark};
use crate::files::{FileError, write_whole};
use crate::study::{Samples, load};
use std::path::PathBuf;

/// The paper's comparison of the three contact detections, beside ours
///
/// Runs the turbine with each detection from several slightly different starts (phase of the lost blade, 1 % of its mass),
/// with the chosen engines, and prints the paper's Table 1 beside ours with the scatter over the starts. An ordering of two
/// detections is claimed only where their ranges over the starts do not overlap. The machine is ours, not the paper's.
/// Writes the table, every run, histories and figures like figures 7 to 13 of the paper into a directory.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff table1
  bladeoff table1 --engine reduced --scatter 5 --out runs/table1-reduced")]
pub struct Args {
    /// The study with detections, engines and starts
    #[arg(default_value = "studies/table1.toml")]
    study: PathBuf,

    /// Engines to run: full takes minutes for each run, reduced seconds
    #[arg(long, value_parser = ["full", "reduced", "both"], default_value = "both")]
    engine: String,

    /// Starts for each detection and engine: the machine's own and slight changes of it
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..))]
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
    let samples = Samples::new(load(&args.study)?, None, None)?;
    let cases = runs::cases(&samples, args)?;
    std::fs::create_dir_all(&args.out).map_err(FileError::at("create", &args.out))?;
    remark(&format!("{} runs; then 3 more with their histories", cases.len()));
    let done = runs::compute(&cases)?;
    let text = verdict::report(&done);
    print(&text)?;
    write_whole(&args.out.join("table1.md"), text.as_bytes())?;
    write_whole(&args.out.join("runs.csv"), runs::csv(&done).as_bytes())?;
    for line in pictures::draw(&cases, &args.out)? {
        remark(&line);
    }
    Ok(if done.iter().all(runs::Done::finished) { Exit::Ok } else { Exit::Failures })
}
