//! `bladeoff-dev chaos`: studies whose runs are killed and stopped, compared with undisturbed ones.

use crate::chaos::{ChaosError, Storm, WATCHDOG};
use bladeoff::cli::{CliError, Exit, TemporaryFolder, load, print, remark};
use bladeoff_system::with_causes;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Kill and stop runs of a small study at random, and compare every table with the undisturbed one
///
/// A study of 20 samples is run by this very program, two workers at a time, and disturbed by a plan that the seed decides:
/// orchestrator and workers are killed and stopped as samples are claimed, begun, sent and recorded, and at random moments. A
/// killed run is continued by the same command until the study is complete. Then its results.parquet must be that of an
/// undisturbed run, byte for byte, and nothing may be left in /dev/shm and /tmp; then comes the next study. At the end
/// the figures: what was tried and what happened. Which of the planned faults is reached first is the system's to say.
///
/// The exit code is 1 when a table differs (its directory is kept), something is left behind, or a process hangs.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bladeoff-dev chaos --seed 1 --minutes 5\n\n  One study:\n  bladeoff-dev chaos --minutes 0"
)]
pub struct Args {
    /// Decides what is planned
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// After this time no further study is begun; one there is in any case
    #[arg(long, value_name = "N", default_value_t = 5)]
    minutes: u64,
}

/// Number of studies between two lines of progress.
const REMARK_EVERY: u64 = 10;

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let folder = TemporaryFolder::new()?;
    let load_before = load();
    remark(&format!("seed {}; what hangs is given up after {} s", args.seed, WATCHDOG.as_secs()));
    // By the executable file of this process, so that every run uses this build.
    let program = PathBuf::from(format!("/proc/{}/exe", std::process::id()));
    let mut storm = match Storm::new(&program, &folder.0, args.seed) {
        Ok(storm) => storm,
        Err(error) => return Ok(found(&error)),
    };
    let (start, time) = (Instant::now(), Duration::from_secs(args.minutes.saturating_mul(60)));
    while storm.figures().studies == 0 || start.elapsed() < time {
        if let Err(error) = storm.study() {
            print(&format!("so far: {}", storm.figures().text()))?;
            return Ok(found(&error));
        }
        let studies = storm.figures().studies;
        if studies.is_multiple_of(REMARK_EVERY) {
            remark(&format!("{studies} studies, every table equal"));
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let text = storm.figures().text();
    print(&format!("seed {}, {seconds:.0} s, load before and after: {load_before}, {}\n{text}", args.seed, load()))?;
    Ok(Exit::Ok)
}

/// Prints the error that ended the storm; returns the exit code.
fn found(error: &ChaosError) -> Exit {
    remark(&format!("error: {}", with_causes(error)));
    match error {
        ChaosError::File(_) => Exit::Io,
        // An error of the program.
        _ => Exit::Bug,
    }
}
