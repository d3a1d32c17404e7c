//! `bladeoff recover`: a readable history from the file that a killed run left.

use super::error::CliError;
use super::exit::Exit;
use super::output::print;
use crate::history::{RecoveredEnd, recover};
use bladeoff_answers::summary::counted;
use bladeoff_system::shown;
use bladeoff_text::document::units::format_quantity;
use std::path::{Path, PathBuf};

/// Recover the MCAP history of a killed run
///
/// A history is written to FILE.mcap.tmp and renamed when it is complete. If the run was killed, the .tmp file is left.
/// This command copies its complete messages into a valid file that Foxglove and PlotJuggler open.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff recover turbine.mcap.tmp
  bladeoff recover turbine.mcap.tmp --out saved.mcap")]
pub struct Args {
    /// The incomplete file, FILE.mcap.tmp
    file: PathBuf,

    /// The file to write [default: FILE without .tmp, or with .recovered.mcap if it does not end in .tmp]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let out = args.out.clone().unwrap_or_else(|| beside(&args.file));
    if out.symlink_metadata().is_ok() {
        return Err(CliError::Exists { path: out });
    }
    let saved = recover(&args.file, &out)?;
    let end = match saved.end {
        RecoveredEnd::Whole => "nothing was cut in the middle",
        RecoveredEnd::Cut => "the rest ends in the middle of a record",
        RecoveredEnd::Damaged => "what follows is damaged and was not copied",
    };
    let (messages, last) = (counted(saved.messages, "message"), format_quantity(saved.last, "s"));
    print(&format!("{}: {messages}, the last at {last}; {end}\n", shown(&out)))?;
    Ok(Exit::Ok)
}

fn beside(file: &Path) -> PathBuf {
    if file.extension().is_some_and(|extension| extension == "tmp") {
        file.with_extension("")
    } else {
        file.with_extension("recovered.mcap")
    }
}
