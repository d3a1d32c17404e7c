//! Why a study could not be run to its end.

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

/// Why a study could not be run to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The directory holds something else.
    #[error("{path:?} is not a result directory: it holds {file:?} and no record of a run; choose another --out")]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// The first file that no run begins with.
        file: OsString,
    },
    /// Others could write in the directory.
    #[error(transparent)]
    Untrusted(#[from] Untrusted),
    /// The directory was taken from the run.
    #[error(transparent)]
    Lost(#[from] Lost),
    /// A file stands where the directory should be.
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
        /// Finished samples that the present study does not have.
        lost: u64,
        /// Finished samples.
        total: u64,
        /// What differs.
        changes: Vec<Change>,
    },
    /// There is no run whose samples could be computed again.
    #[error("{} has no finished samples to be computed again", shown(path))]
    NothingToRerun {
        /// The directory.
        path: PathBuf,
    },
    /// Another run works in the directory, or that cannot be found out.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// The machine of the study.
    #[error(transparent)]
    Machine(#[from] Problems),
    /// The solver refused the machine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
    /// The record of finished samples.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Whether the study is precise enough.
    #[error(transparent)]
    Looking(#[from] super::end::LookingError),
    /// The plan that workers read.
    #[error(transparent)]
    Plan(#[from] JobSpecError),
    /// Workers, shared memory, messages.
    #[error(transparent)]
    Dispatch(#[from] DispatchError),
}

impl RunError {
    /// Whether the directory is there and may not be written.
    pub(super) fn is_write_protection(&self) -> bool {
        let (Self::File(error) | Self::Lock(LockError::File(error))) = self else { return false };
        matches!(error.source.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
    }

    /// Whether the run was refused before anything of it was done: the same command will not do better.
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

/// One key with its values then and now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// Path of a parameter, or a setting of the study.
    pub key: String,
    /// In the directory.
    pub from: String,
    /// Now.
    pub to: String,
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} -> {}", self.key, self.from, self.to)
    }
}

/// How a run ended whose directory was taken from it.
#[derive(Debug, thiserror::Error)]
pub enum Lost {
    /// It is elsewhere.
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
    /// It is where it was, and cannot be entered.
    #[error(
        "{} was closed to this user during the run; {} {} kept in it: open it (`chmod u+rwx`), and the same command resumes",
        shown(path),
        counted(*done, "finished sample"),
        are(*done)
    )]
    Closed {
        /// The directory.
        path: PathBuf,
        /// Samples recorded in it.
        done: u64,
        /// What could not be done.
        #[source]
        source: Box<RunError>,
    },
    /// It is gone, what was finished is not.
    #[error("{what} {} was removed during the run: the run has stopped; {} {} kept in {}", shown(path), counted(*done, "finished sample"), are(*done), shown(kept))]
    Kept {
        /// "the result directory" or the record in it.
        what: &'static str,
        /// Where it was.
        path: PathBuf,
        /// Samples kept.
        done: u64,
        /// Where they are.
        kept: PathBuf,
    },
    /// It is gone with what was finished.
    #[error("{what} {} was removed during the run: the run has stopped; {} could not be kept", shown(path), counted(*done, "finished sample"))]
    Gone {
        /// "the result directory" or the record in it.
        what: &'static str,
        /// Where it was.
        path: PathBuf,
        /// Samples that were finished.
        done: u64,
        /// Why they are lost.
        #[source]
        source: Box<RunError>,
    },
}

impl Lost {
    /// Where the study can go on.
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
