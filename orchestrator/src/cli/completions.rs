//! `bladeoff completions`: scripts by which a shell completes commands and options.

use super::commands;
use super::error::CliError;
use super::exit::Exit;
use super::output::print;
use clap_complete::{Shell, generate};

/// Print a completion script for a shell
///
/// The script completes subcommands, options, their values and file names. Save it where the shell looks for completions,
/// and open a new shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff completions bash \\
    > ~/.local/share/bash-completion/completions/bladeoff
  bladeoff completions zsh > ~/.zfunc/_bladeoff
  bladeoff completions fish \\
    > ~/.config/fish/completions/bladeoff.fish")]
pub struct Args {
    /// Shell of the script
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    print(&script(args.shell))?;
    Ok(Exit::Ok)
}

fn script(shell: Shell) -> String {
    let mut script = Vec::new();
    generate(shell, &mut commands(), "bladeoff", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    #[test]
    fn each_script_names_every_command_and_long_options() {
        for &shell in Shell::value_variants() {
            let script = script(shell);
            for command in commands().get_subcommands() {
                assert!(script.contains(command.get_name()), "{shell}: {}", command.get_name());
            }
            assert!(script.contains("max-failures") && script.contains("json-events"), "{shell}");
        }
    }
}
