//! Why a study cannot be run as it is.

use super::input::InputError;
use super::sampling::combinations::CombinationError;
use bladeoff_system::threads::ThreadsError;
use bladeoff_system::{call, shown};
use bladeoff_text::document::Problems;
use std::ffi::OsStr;
use std::path::PathBuf;

/// A rotor as ROSS saves it, where a study or a machine was asked for.
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

/// Why a study cannot be run as it is.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Problems in the study, its machine or its points file.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Problems(Vec<Problems>),
    /// A machine instead of a study.
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
    /// A rotor of another program.
    #[error(transparent)]
    OfRoss(#[from] OfRoss),
    /// A file that cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Too many samples, or a scale out of range.
    #[error(transparent)]
    Combinations(#[from] CombinationError),
    /// Its machines could not be built in parallel.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
}
