//! `bladeoff import`: rotors of other programs as machine files.

use super::error::CliError;
use super::exit::Exit;
use super::output::{print, remark};
use bladeoff_import::{Imported, from_ross};
use bladeoff_study::read_input;
use bladeoff_system::call::{self, command};
use bladeoff_system::files::write_new;
use bladeoff_system::shown;
use bladeoff_text::document::MAX_FILE_BYTES;
use std::ffi::OsStr;
use std::path::PathBuf;

/// Convert a rotor of another program to a machine file
///
/// `ross` reads a rotor saved by ROSS (`Rotor.save`, TOML or JSON): shaft elements with tapers and layers, discs, point masses, bearings and seals with constant or
/// speed-dependent coefficients, supports. Lines with FILL IN mark what such a rotor does not have: unbalance, braking, diaphragms. What cannot be converted is
/// listed on standard error and at the head of the machine file. An existing file is not overwritten.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bladeoff import ross rotor.toml --out my_turbine.toml\n  bladeoff import ross rotor.json > my_turbine.toml"
)]
pub struct Args {
    /// Program that wrote the file
    #[arg(value_enum)]
    program: Program,

    /// The file, at most 1 MiB
    file: PathBuf,

    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Program {
    /// ROSS: Rotordynamic Open Source Software
    Ross,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    if let Some(path) = args.out.as_ref().filter(|path| path.symlink_metadata().is_ok()) {
        return Err(CliError::Exists { path: path.clone() });
    }
    let text = read_input(&args.file, MAX_FILE_BYTES as u64)?;
    let Imported { machine, notes } = match args.program {
        Program::Ross => from_ross(&args.file.to_string_lossy(), &text)?,
    };
    match &args.out {
        None => print(&machine)?,
        Some(path) => {
            write_new(path, machine.as_bytes())?;
            let modes = command([OsStr::new("modes"), call::path_word(path).as_os_str()]);
            remark(&format!("wrote {}; fill in the marked lines. The modes: {modes}", shown(path)));
        }
    }
    for note in &notes {
        remark(&format!("not converted, or not as in ROSS: {note}"));
    }
    Ok(Exit::Ok)
}
