//! The command line of the developers' tools: their own commands, and every command of `bladeoff`.

mod chaos;
mod table1;

use crate::faults::{EnvironmentFaults, Who};
use bladeoff::cli::{CliError, EXIT_CODES, Exit, remark, run_subcommand};
use clap::{CommandFactory, Parser, Subcommand};
use std::process::ExitCode;

/// Tools of the developers of bladeoff, which are not released
///
/// Every command of bladeoff runs here as well (run, worker, check, ...), with the faults that the environment variable
/// BLADEOFF_FAULT describes.
#[derive(Debug, Parser)]
#[command(name = "bladeoff-dev", version = bladeoff::version::VERSION.as_str(), max_term_width = 100, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Chaos(chaos::Args),
    Table1(table1::Args),
}

/// Runs a command of the tools, or a command of `bladeoff` with faults from the environment; returns the exit code.
#[must_use]
pub fn main() -> ExitCode {
    let first = std::env::args_os().nth(1);
    let word = first.as_ref().and_then(|word| word.to_str()).unwrap_or_default();
    let is_own =
        word.is_empty() || word.starts_with('-') || word == "help" || Cli::command().find_subcommand(word).is_some();
    if is_own {
        return run_subcommand(own_command);
    }
    let who = if word == "worker" { Who::Worker } else { Who::Orchestrator };
    match EnvironmentFaults::of_process(who) {
        Ok(faults) => bladeoff::cli::main(faults),
        Err(error) => {
            remark(&format!("error: {error}"));
            Exit::Usage.into()
        }
    }
}

fn own_command() -> Result<Exit, CliError> {
    match Cli::parse().command {
        Command::Chaos(args) => chaos::main(&args),
        Command::Table1(args) => table1::main(&args),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    /// clap breaks a longer line, and an example can then no longer be copied.
    #[test]
    fn examples_fit_a_terminal_of_60_columns() {
        let mut seen = 0;
        for command in Cli::command().get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in help.lines().filter(|line| line.starts_with("  ")) {
                assert!(line.chars().count() <= 60, "{}: {line:?}", command.get_name());
                seen += 1;
            }
        }
        assert!(seen >= 4, "examples: {seen}");
    }
}
