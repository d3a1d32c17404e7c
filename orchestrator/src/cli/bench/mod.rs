//! `bladeoff bench`: what the program costs, and what it withstands, on this machine.

mod chaos;
mod dispatch;
mod stages;

use super::error::CliError;
use super::exit::Exit;
use crate::files::FileError;
use std::fs;
use std::path::PathBuf;

/// Measure what the program costs beside the simulations, and what it withstands
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff bench dispatch
  bladeoff bench dispatch --samples 1000000 --json
  bladeoff bench chaos --seed 1 --minutes 5")]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Dispatch(dispatch::Args),
    Chaos(chaos::Args),
    #[command(hide = true)]
    Stage(stages::Args),
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    match &args.what {
        What::Dispatch(args) => dispatch::main(args),
        What::Chaos(args) => chaos::main(args),
        What::Stage(args) => stages::main(args),
    }
}

/// A folder on a real disk, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, CliError> {
        let path = std::env::temp_dir().join(format!("bladeoff-bench-{}", std::process::id()));
        fs::create_dir(&path).map_err(FileError::at("create", &path))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left in a temporary folder hurts nobody.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The load of the machine over the last minute, as the system says it.
fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().next().unwrap_or("?").to_owned()
}
