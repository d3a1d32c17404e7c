//! Errors found by a chaos test.

use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// Error found by a chaos test, or reason why it could not run.
#[derive(Debug, thiserror::Error)]
pub enum ChaosError {
    /// A table that differs from the undisturbed one.
    #[error(
        "study {study}: its table is not the undisturbed one; the result directory is kept as {}",
        shown(directory)
    )]
    Differs {
        /// Number of the study, from 1.
        study: u64,
        /// Path of the kept result directory.
        directory: PathBuf,
    },
    /// Files left in shared memory or in the temporary folder.
    #[error("study {study} has left {}", left.iter().map(shown).collect::<Vec<_>>().join(", "))]
    Left {
        /// Number of the study, from 1.
        study: u64,
        /// Paths of the files.
        left: Vec<PathBuf>,
    },
    /// A process that does not end.
    #[error("{what} does not end\n{said}")]
    Hangs {
        /// Name of the process.
        what: &'static str,
        /// Standard error of the process.
        said: String,
    },
    /// A run that failed without being killed.
    #[error("a run ended with {status}\n{said}")]
    Failed {
        /// Exit status.
        status: String,
        /// Standard error of the run.
        said: String,
    },
    /// A file operation that failed, or a process that cannot be started.
    #[error(transparent)]
    File(#[from] FileError),
}
