//! `bladeoff paths`: every parameter of a machine.

use super::error::CliError;
use super::exit::Exit;
use super::machine::MachineArgs;
use super::output::print;
use crate::report::{Align, TextTable};

/// List every parameter path of a machine with its value, unit and meaning
///
/// These are the paths that `[set]` and `[[vary]]` of a study and `--set` of simulate and modes take. Any ending of a
/// path that no other path shares does as well: `contact.gap` for `diaphragms.seal.contact.gap`.
///
/// Columns: path, value as it stands (or its default), what is allowed, meaning.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bladeoff paths studies/machines/lab_rig.toml\n  bladeoff paths studies/machines/lab_rig.toml | grep contact"
)]
pub struct Args {
    #[command(flatten)]
    machine: MachineArgs,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let machine = args.machine.load()?;
    let header = [
        ("path", Align::Left),
        ("value", Align::Left),
        ("unit", Align::Left),
        ("allowed", Align::Left),
        ("meaning", Align::Left),
    ];
    let mut table = TextTable::new(&header);
    for info in machine.paths() {
        table.row(vec![info.path, info.shown, info.unit.to_string(), info.allowed, info.meaning.to_string()]);
    }
    print(&table.render(""))?;
    Ok(Exit::Ok)
}
