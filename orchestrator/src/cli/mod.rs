//! Command line: one file per subcommand, common errors and exit codes.

mod answer;
mod bench;
mod beside;
mod budget;
mod check;
mod check_json;
mod compare;
mod compared;
mod completions;
mod design;
mod doctor;
mod error;
mod estimate;
mod excerpt;
mod exit;
mod export;
mod extent;
mod forecast;
mod functions;
mod gate;
mod hints;
mod history;
mod import;
mod json;
mod machine;
mod man;
mod map;
mod merge;
mod modes;
mod new;
mod output;
mod paths;
mod place;
mod plot;
mod recover;
mod refusals;
mod render;
mod replay;
mod report;
mod run;
mod sample_words;
mod schema;
mod shard;
mod shards;
mod shared;
mod simulate;
mod status;
mod stop;
mod submit;
mod verify;
mod watch;
mod why;

pub use bench::host::{Folder as TemporaryFolder, load};
pub use error::CliError;
pub use exit::{EXIT_CODES, Exit};
pub use history::watched;
pub use machine::set as set_parameter;
pub use output::{print, remark};
pub use plot::{refuse_other_formats, replacing};
pub use status::text as status_text;
pub use why::text as why_text;

use bladeoff_numerics::linalg::lanes::Width;
use bladeoff_system::threads::check_address_space;
use bladeoff_text::document::visible;
use bladeoff_worker::fault::Faults;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;
use std::thread;

/// Blade-off transients of turbine shaft lines with rub against flexible diaphragms.
///
/// A machine file describes a shaft line; a study file varies parameters of a machine; `run` computes the study on
/// all cores and writes one table, results.parquet, with one row per sample.
#[derive(Debug, Parser)]
#[command(name = "bladeoff", version = crate::version::VERSION.as_str(), max_term_width = 100, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Args),
    Submit(submit::Args),
    Merge(merge::Args),
    Status(status::Args),
    Watch(watch::Args),
    Why(why::Args),
    Check(check::Args),
    Simulate(simulate::Args),
    Modes(modes::Args),
    Paths(paths::Args),
    New(new::Args),
    Import(import::Args),
    Answer(answer::Args),
    Map(map::Args),
    Gate(gate::Args),
    Report(report::Args),
    Compare(compare::Args),
    Design(design::Args),
    Export(export::Args),
    Verify(verify::Args),
    Replay(replay::Args),
    Plot(plot::Args),
    Recover(recover::Args),
    Bench(bench::Args),
    Doctor(doctor::Args),
    Schema(schema::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// Parses the command line, runs the subcommand, returns the exit code. `faults`: [`NoFaults`](bladeoff_worker::fault::NoFaults), except
/// in the binary of the developers' tools.
#[must_use]
pub fn main(faults: &'static dyn Faults) -> ExitCode {
    // worker process, started by `run` and therefore not in the help
    if std::env::args_os().nth(1).is_some_and(|first| first == "worker") {
        return on_a_stack_of_its_own(move || bladeoff_worker::worker_main(std::env::args_os().skip(2), faults));
    }
    on_a_stack_of_its_own(move || command(faults).into())
}

/// Runs a subcommand of another binary with the stack, the report of panics and the exit codes of this command line.
#[must_use]
pub fn run_subcommand(work: fn() -> Result<Exit, CliError>) -> ExitCode {
    on_a_stack_of_its_own(move || guarded(work).into())
}

/// Stack size of commands, independent of `ulimit -s`: parsing the command line alone takes more than 64 kB.
const STACK: usize = 8 << 20;

fn on_a_stack_of_its_own(work: impl Fn() -> ExitCode + Copy + Send + 'static) -> ExitCode {
    bladeoff_worker::process::fail_writes_beyond_the_limit();
    match thread::Builder::new().name("main".to_owned()).stack_size(STACK).spawn(work) {
        Ok(working) => working.join().unwrap_or(Exit::Bug.into()),
        // no further thread (ulimit -u): the first thread's stack is nearly always sufficient
        Err(_) => work(),
    }
}

fn command(faults: &'static dyn Faults) -> Exit {
    // clap ends the program itself: 0 after --help and --version, 2 after a wrong command line.
    let matches = command_line().try_get_matches().unwrap_or_else(|error| refuse(&error));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| refuse(&error));
    guarded(|| dispatch(cli.command, faults))
}

fn guarded(work: impl FnOnce() -> Result<Exit, CliError>) -> Exit {
    panic::set_hook(Box::new(|info| {
        if bladeoff_system::guarded::is_guarded() {
            return;
        }
        output::remark(&format!(
            "internal error: {info}\nThis is a bug. Please report it with the command and its files."
        ));
    }));
    if let Err(error) = Width::chosen() {
        output::remark(&format!("error: {error}"));
        return Exit::Usage;
    }
    panic::catch_unwind(AssertUnwindSafe(|| concluded(work()))).unwrap_or(Exit::Bug)
}

/// The command line for clap: commands, options, help texts.
#[must_use]
pub fn commands() -> clap::Command {
    Cli::command()
}

/// The command line, with the name by which the program was called in the examples.
fn command_line() -> clap::Command {
    let program = bladeoff_system::call::program();
    let understood = numbers_with_a_sign(Cli::command());
    if program == "bladeoff" {
        return understood;
    }
    understood.mut_subcommands(|command| {
        let Some(help) = command.get_after_help().map(ToString::to_string) else { return command };
        command.after_help(format!("{help}\n\nHere `bladeoff` is called as: {program}"))
    })
}

/// Value names of numeric options in the help.
const NUMBERS: [&str; 8] = ["N", "F", "NUMBER", "TIME", "HH:MM", "SIZE", "STEP", "SPEED"];

/// Allows negative numbers as option values, so that their own parser reports errors.
fn numbers_with_a_sign(command: clap::Command) -> clap::Command {
    let is_number = |arg: &clap::Arg| {
        arg.get_value_names().is_some_and(|names| names.iter().any(|name| NUMBERS.contains(&name.as_str())))
    };
    command
        .mut_args(|arg| if is_number(&arg) { arg.allow_hyphen_values(true) } else { arg })
        .mut_subcommands(numbers_with_a_sign)
}

/// Prints the error and ends the program as clap does: 0 after --help and --version, 2 after a wrong command line. Quoted arguments may
/// contain any characters (`bladeoff check *`).
fn refuse(error: &clap::Error) -> ! {
    let arguments: Vec<String> =
        std::env::args_os().map(|text| visible(&text.to_string_lossy()).into_owned()).collect();
    // clap's suggestion concerns options; a number is not an option, with or without dashes
    if let (ErrorKind::UnknownArgument, Some(ContextValue::String(word))) =
        (error.kind(), error.get(ContextKind::InvalidArg))
        && let Ok(number) = word.trim_start_matches('-').parse::<u64>()
    {
        let told = word
            .starts_with('-')
            .then(|| format!("{word} is not an option; write the number without dashes: {number}"));
        if let Some(told) = told {
            output::remark(&format!("error: {told}"));
            std::process::exit(error.exit_code());
        }
    }
    let meant = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(word))) => {
            hints::hint(&command_line(), &arguments, &visible(word))
        }
        _ => None,
    };
    match command_line().try_get_matches_from(arguments) {
        Err(mut same) if same.kind() == error.kind() => {
            let Some(meant) = meant else { same.exit() };
            // replaces clap's suggestion
            same.insert(ContextKind::Suggested, ContextValue::None);
            let _ = same.print();
            output::remark(&meant);
            std::process::exit(same.exit_code())
        }
        _ => {
            output::remark(error.to_string().trim_end());
            std::process::exit(error.exit_code())
        }
    }
}

fn dispatch(command: Command, faults: &'static dyn Faults) -> Result<Exit, CliError> {
    let computes_nothing = matches!(
        command,
        Command::Status(_)
            | Command::Why(_)
            | Command::Paths(_)
            | Command::Recover(_)
            | Command::Doctor(_)
            | Command::New(_)
            | Command::Import(_)
            | Command::Schema(_)
            | Command::Completions(_)
            | Command::Man(_)
    );
    if !computes_nothing {
        check_address_space()?;
    }
    match command {
        Command::Run(args) => run::main(&args, faults),
        Command::Submit(args) => submit::main(&args),
        Command::Merge(args) => merge::main(&args),
        Command::Status(args) => status::main(&args),
        Command::Watch(args) => watch::main(&args),
        Command::Why(args) => why::main(&args),
        Command::Check(args) => check::main(&args),
        Command::Simulate(args) => simulate::main(&args),
        Command::Modes(args) => modes::main(&args),
        Command::Paths(args) => paths::main(&args),
        Command::New(args) => new::main(&args),
        Command::Import(args) => import::main(&args),
        Command::Answer(args) => answer::main(&args),
        Command::Map(args) => map::main(&args),
        Command::Gate(args) => gate::main(&args),
        Command::Report(args) => report::main(&args),
        Command::Compare(args) => compare::main(&args),
        Command::Design(args) => design::main(&args),
        Command::Export(args) => export::main(&args),
        Command::Verify(args) => verify::main(&args),
        Command::Replay(args) => replay::main(&args),
        Command::Plot(args) => plot::main(&args),
        Command::Recover(args) => recover::main(&args),
        Command::Bench(args) => bench::main(&args),
        Command::Doctor(args) => doctor::main(&args),
        Command::Schema(args) => schema::main(&args),
        Command::Completions(args) => completions::main(&args),
        Command::Man(args) => man::main(&args),
    }
}

/// Removes temporary files, prints the error, returns the exit code.
fn concluded(result: Result<Exit, CliError>) -> Exit {
    // removes tables converted from the rows of unmerged shards
    crate::run::shards::forget();
    result.unwrap_or_else(|error| {
        if !matches!(error, CliError::ReaderLeft) {
            output::rendered(&render::render(&error));
        }
        error.exit()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command_line().debug_assert();
    }

    /// clap breaks lines wider than the terminal and does not indent the rest: at 80 columns, the table of exit codes and commands to be copied
    /// were broken.
    #[test]
    fn indented_lines_of_the_help_fit_a_terminal_of_60_columns() {
        fn check(command: &clap::Command) -> usize {
            let texts = [command.get_after_help(), command.get_after_long_help(), command.get_long_about()];
            let text: String = texts.into_iter().flatten().map(|text| format!("{text}\n")).collect();
            let indented: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
            for line in &indented {
                assert!(line.chars().count() <= 60, "{}: {line:?}", command.get_name());
            }
            indented.len() + command.get_subcommands().map(check).sum::<usize>()
        }
        assert!(check(&Cli::command()) > 80, "examples and tables");
    }
}
