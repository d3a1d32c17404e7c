//! Errors of a study that prevent its run.

use super::input::InputError;
use super::sampling::combinations::CombinationError;
use bladeoff_system::threads::ThreadsError;
use bladeoff_system::{call, shown};
use bladeoff_text::document::Problems;
use std::ffi::OsStr;
use std::path::PathBuf;

/// A rotor file of ROSS in place of a study or a machine.
#[derive(Debug, thiserror::Error)]
#[error("{} is a rotor saved by ROSS; convert it to a machine file: {}", shown(path), import(path))]
pub struct OfRoss {
    /// The file.
    pub path: PathBuf,
}

/// The command that converts a rotor.
fn import(path: &std::path::Path) -> String {
    call::command([OsStr::new("import"), OsStr::new("ross"), call::path_word(path).as_os_str()])
}

/// Error of a study that prevents its run.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Problems in the study, its machine or its points file.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Problems(Vec<Problems>),
    /// A machine file in place of a study.
    #[error(
        "{} is a machine file, not a study\n  one run of it: {}\n  a study names it with `machine`; a template: {}",
        shown(path),
        call::command([OsStr::new("simulate"), call::path_word(path).as_os_str()]),
        call::command(["new", "study"])
    )]
    AMachine {
        /// The file.
        path: PathBuf,
    },
    /// A rotor file of another program.
    #[error(transparent)]
    OfRoss(#[from] OfRoss),
    /// A file that cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Too many samples, or a scale out of range.
    #[error(transparent)]
    Combinations(#[from] CombinationError),
    /// Threads for building the machines cannot be started.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
}
