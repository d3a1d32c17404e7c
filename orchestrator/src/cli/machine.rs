//! Machine file and overrides, as used by several subcommands.

use super::error::CliError;
use bladeoff_model::machine::{Machine, MachineDef, ValueError};
use bladeoff_study::{FileKind, OfRoss, StudyError, kind_of, read_input, show, with_tables};
use bladeoff_system::call::word;
use bladeoff_text::document::{MAX_FILE_BYTES, Problems};
use std::path::PathBuf;

/// Arguments that name a machine.
#[derive(Debug, clap::Args)]
pub struct MachineArgs {
    /// Machine file (TOML; format in docs/machines.md)
    pub machine: PathBuf,

    /// Override a parameter, named by a path of `bladeoff paths MACHINE` or its unique ending. A number is SI; a unit
    /// follows the number. May be given several times; the last value counts
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub set: Vec<String>,
}

impl MachineArgs {
    /// The machine definition with its overrides.
    pub fn load(&self) -> Result<MachineDef, CliError> {
        let text = with_tables(&self.machine, read_input(&self.machine, MAX_FILE_BYTES as u64)?)?;
        let parsed = MachineDef::parse(&self.machine.to_string_lossy(), &text);
        let mut machine = parsed.map_err(|problems| match kind_of(&text) {
            Some(FileKind::Study(machine)) => CliError::AStudy { path: self.machine.clone(), machine },
            Some(FileKind::Ross) => StudyError::from(OfRoss { path: self.machine.clone() }).into(),
            _ => problems.into(),
        })?;
        for argument in &self.set {
            let shown = format!("--set {argument}");
            let Some((path, value)) = argument.split_once('=') else {
                let message = "there is no `=`".to_owned();
                return Err(CliError::Argument { argument: shown, message, allowed: Some("PATH=VALUE".to_owned()) });
            };
            set(&mut machine, path.trim(), value.trim(), &shown)?;
        }
        Ok(machine)
    }

    /// Parameters changed by `--set`, with their values; the last value of a path that is set several times.
    pub fn changed(&self, machine: &MachineDef) -> Vec<(String, String)> {
        let mut changed: Vec<(String, String)> = Vec::new();
        for (path, value) in self.set.iter().filter_map(|argument| argument.split_once('=')) {
            let (path, value) = (path.trim(), value.trim());
            let known = machine.resolve(path).ok();
            let known =
                known.and_then(|info| Some((info.path.clone(), show(&info, &machine.parse_value(&info, value).ok()?))));
            let (path, value) = known.unwrap_or_else(|| (path.to_owned(), value.to_owned()));
            changed.retain(|(before, _)| *before != path);
            changed.push((path, value));
        }
        changed
    }

    /// The `--set` options as given.
    pub fn given(&self) -> Vec<String> {
        self.set.iter().map(|argument| format!("--set {}", word(argument))).collect()
    }
}

/// Sets one parameter; `argument`: text of the option.
pub fn set(machine: &mut MachineDef, path: &str, value: &str, argument: &str) -> Result<(), CliError> {
    let refused = |message: String, allowed| CliError::Argument { argument: argument.to_owned(), message, allowed };
    let info = machine.resolve(path).map_err(|error| refused(error.to_string(), None))?;
    let value = machine.parse_value(&info, value).map_err(|error| {
        // other errors name the allowed values themselves
        let allowed = matches!(error, ValueError::Quantity { .. }).then(|| info.allowed.clone());
        refused(error.to_string(), allowed)
    })?;
    machine.set(&info, &value).map_err(|error| refused(error.to_string(), None))
}

/// Builds and validates the machine; `given`: options that override its file.
pub fn build(machine: &MachineDef, given: &[String]) -> Result<Machine, CliError> {
    machine.build().map_err(|problems| refused(problems, given))
}

/// Error with the problems of a machine, and the options that override its file.
pub fn refused(problems: Problems, given: &[String]) -> CliError {
    match given {
        [] => problems.into(),
        given => CliError::Overridden { problems, given: given.join(" ") },
    }
}
