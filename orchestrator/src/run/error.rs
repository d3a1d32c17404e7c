//! Errors of a run.

use super::lock::LockError;
use super::trust::Untrusted;
use crate::dispatch::DispatchError;
use crate::engine::EngineError;
use bladeoff_answers::summary::{are, counted};
use bladeoff_answers::tables::TableError;
use bladeoff_record::RecordError;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use bladeoff_text::document::Problems;
use bladeoff_worker::job_spec::JobSpecError;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

/// Error of a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The directory contains files that no run has written.
    #[error("{path:?} is not a result directory: it contains {file:?} and no record of a run; choose another --out")]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// First foreign file.
        file: OsString,
    },
    /// Other users may write to the directory.
    #[error(transparent)]
    Untrusted(#[from] Untrusted),
    /// The directory was removed or moved during the run.
    #[error(transparent)]
    Lost(#[from] Lost),
    /// The path of the directory is a file.
    #[error("{path:?} is not a directory; choose another --out")]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// The directory was computed with another study or machine.
    #[error(
        "{} was computed with another study: {lost} of its {} {} not in this one\n{}\n\
         A study that only grows (more points, a larger --limit or run.step_limit, other [limits]) is continued. For this \
         one choose another --out, or remove the directory",
        shown(path),
        counted(*total, "finished sample"),
        are(*lost),
        changes.iter().map(|change| format!("  {change}")).collect::<Vec<_>>().join("\n")
    )]
    Changed {
        /// The directory.
        path: PathBuf,
        /// Finished samples that the present study does not contain.
        lost: u64,
        /// Finished samples.
        total: u64,
        /// Differences.
        changes: Vec<Change>,
    },
    /// `--rerun` without an earlier run.
    #[error("{} has no finished samples to be computed again", shown(path))]
    NothingToRerun {
        /// The directory.
        path: PathBuf,
    },
    /// Another run uses the directory, or this cannot be determined.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// Invalid machine of the study.
    #[error(transparent)]
    Machine(#[from] Problems),
    /// Machine that the solver rejects.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// File error.
    #[error(transparent)]
    File(#[from] FileError),
    /// Error of the record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Table error.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Error of an interim analysis.
    #[error(transparent)]
    Precision(#[from] super::end::PrecisionError),
    /// Error of the plan file.
    #[error(transparent)]
    Plan(#[from] JobSpecError),
    /// Error of workers, shared memory or messages.
    #[error(transparent)]
    Dispatch(#[from] DispatchError),
}

impl RunError {
    /// Whether the directory exists but cannot be written.
    pub(super) fn is_write_protection(&self) -> bool {
        let (Self::File(error) | Self::Lock(LockError::File(error))) = self else { return false };
        matches!(error.source.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
    }

    /// Whether the run was rejected before any work, so that repeating the command cannot succeed.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Foreign { .. }
                | Self::Untrusted(_)
                | Self::NotADirectory { .. }
                | Self::Changed { .. }
                | Self::NothingToRerun { .. }
                | Self::Lock(LockError::Held { .. } | LockError::Theirs { .. })
                | Self::Record(RecordError::Version { .. })
                | Self::Machine(_)
                | Self::Engine(_)
        )
    }
}

/// Changed key with both values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// Path of a parameter, or a setting of the study.
    pub key: String,
    /// Value in the directory.
    pub from: String,
    /// Present value.
    pub to: String,
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} -> {}", self.key, self.from, self.to)
    }
}

/// End of a run whose directory was lost.
#[derive(Debug, thiserror::Error)]
pub enum Lost {
    /// The directory was moved.
    #[error(
        "{} was moved during the run, {}: the run has stopped; {} {} in it",
        shown(path),
        to.as_ref().map_or("to an unknown place".to_owned(), |to| format!("to {}", shown(to))),
        counted(*done, "finished sample"),
        are(*done)
    )]
    Moved {
        /// Where it was.
        path: PathBuf,
        /// Where it is.
        to: Option<PathBuf>,
        /// Samples recorded in it.
        done: u64,
    },
    /// The directory is in place, but its permissions are missing.
    #[error(
        "{} was closed to this user during the run; {} {} kept in it: open it (`chmod u+rwx`) and rerun the same \
         command to resume",
        shown(path),
        counted(*done, "finished sample"),
        are(*done)
    )]
    Closed {
        /// The directory.
        path: PathBuf,
        /// Samples recorded in it.
        done: u64,
        /// Failed operation.
        #[source]
        source: Box<RunError>,
    },
    /// The directory was removed; the finished samples are kept elsewhere.
    #[error("{what} {} was removed during the run: the run has stopped; {} {} kept in {}", shown(path), counted(*done, "finished sample"), are(*done), shown(kept))]
    Kept {
        /// "the result directory" or the record in it.
        what: &'static str,
        /// Where it was.
        path: PathBuf,
        /// Samples kept.
        done: u64,
        /// Path of the kept samples.
        kept: PathBuf,
    },
    /// The directory was removed with the finished samples.
    #[error("{what} {} was removed during the run: the run has stopped; {} could not be kept", shown(path), counted(*done, "finished sample"))]
    Gone {
        /// "the result directory" or the record in it.
        what: &'static str,
        /// Where it was.
        path: PathBuf,
        /// Samples that were finished.
        done: u64,
        /// Reason of the loss.
        #[source]
        source: Box<RunError>,
    },
}

impl Lost {
    /// Directory from which the study can be continued.
    #[must_use]
    pub fn goes_on_in(&self) -> Option<&Path> {
        match self {
            Self::Moved { to, .. } => to.as_deref(),
            Self::Kept { kept, .. } => Some(kept),
            Self::Closed { path, .. } => Some(path),
            Self::Gone { .. } => None,
        }
    }
}
