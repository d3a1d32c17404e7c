//! Errors that a storm of kills finds.

use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// What a storm found, or why it could not be raised.
#[derive(Debug, thiserror::Error)]
pub enum ChaosError {
    /// The table is not the undisturbed one.
    #[error(
        "study {study}: its table is not the undisturbed one; the result directory is kept as {}",
        shown(directory)
    )]
    Differs {
        /// Number of the study in the storm, from 1.
        study: u64,
        /// Where it is.
        directory: PathBuf,
    },
    /// Something is left in shared memory or in the temporary folder.
    #[error("study {study} has left {}", left.iter().map(shown).collect::<Vec<_>>().join(", "))]
    Left {
        /// Number of the study in the storm, from 1.
        study: u64,
        /// What.
        left: Vec<PathBuf>,
    },
    /// A process that should have ended.
    #[error("{what} does not end\n{said}")]
    Hangs {
        /// Which.
        what: &'static str,
        /// What it said.
        said: String,
    },
    /// A run that nobody killed failed.
    #[error("a run ended with {status}\n{said}")]
    Failed {
        /// How it ended.
        status: String,
        /// What it said.
        said: String,
    },
    /// A file, or a process that cannot be started.
    #[error(transparent)]
    File(#[from] FileError),
}
