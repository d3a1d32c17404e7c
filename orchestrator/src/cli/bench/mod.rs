//! `bladeoff bench`: cost of the program on this machine.

mod answers;
mod cost;
mod dispatch;
mod engines;
mod figures;
pub(super) mod host;
mod lengths;
mod stages;
mod stand_in;

use super::error::CliError;
use super::exit::Exit;

/// Measure the cost of the program apart from the simulations
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff bench dispatch
  bladeoff bench dispatch --samples 1000000 --json
  bladeoff bench answers
  bladeoff bench engines --against ./bladeoff-of-yesterday")]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Dispatch(dispatch::Args),
    Answers(answers::Args),
    Engines(engines::Args),
    #[command(hide = true)]
    Stage(stages::Args),
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    match &args.what {
        What::Dispatch(args) => dispatch::main(args),
        What::Answers(args) => answers::main(args),
        What::Engines(args) => engines::main(args),
        What::Stage(args) => stages::main(args),
    }
}
