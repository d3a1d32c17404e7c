//! Errors of shards and of their merge.

use super::super::error::{Change, RunError};
use super::super::trust::Untrusted;
use bladeoff_answers::summary::{are, counted};
use bladeoff_answers::tables::TableError;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

/// Error of a shard or of a merge.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// The directory contains files that no shard has written.
    #[error("{} contains {file:?}, which is not a file of a shard; choose another --out", shown(path))]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// First foreign file.
        file: OsString,
    },
    /// The directory has no `shards.json`.
    #[error(
        "{} is neither a directory of shards nor a result directory; `bladeoff submit` and `run --shard` create a \
         directory of shards",
        shown(path)
    )]
    None {
        /// The directory.
        path: PathBuf,
    },
    /// The file system of the scratch directory grants no locks.
    #[error(
        "the file system of the scratch directory {} grants no locks (flock); choose a --scratch on a local disk of the node",
        shown(path)
    )]
    ScratchWithoutLocks {
        /// The scratch directory.
        path: PathBuf,
        /// Error of the system.
        #[source]
        source: std::io::Error,
    },
    /// Other users may write to the directory.
    #[error(transparent)]
    Untrusted(#[from] Untrusted),
    /// The directory was begun with another study, program or chunk size.
    #[error(
        "{} was begun with another study, program or chunk\n{}\nCompute a study that has grown in a new directory, \
         which takes over the finished samples: --out NEW --reuse {}",
        shown(path),
        changes.iter().map(|change| format!("  {change}")).collect::<Vec<_>>().join("\n"),
        shown(path)
    )]
    Changed {
        /// The directory.
        path: PathBuf,
        /// Differences.
        changes: Vec<Change>,
    },
    /// A shared file is damaged or missing.
    #[error("{}: {why}", shown(path))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// `[refine]` chooses samples by results, so they are not known in advance.
    #[error(
        "{}: [refine] chooses samples by earlier results, but shards divide samples that are known beforehand: leave \
         [refine] out, or use `bladeoff run` on one machine",
        shown(study)
    )]
    Refined {
        /// The study file.
        study: PathBuf,
    },
    /// The chunk size gives chunks that are too large or too many.
    #[error("--chunk {size}: {why}")]
    Chunk {
        /// Chunk size of the command line.
        size: u64,
        /// Reason.
        why: String,
    },
    /// The shared file system stayed unavailable.
    #[error(
        "{} could not be written for {}: given up; samples finished there are kept; rerun the same command to resume",
        shown(path),
        bladeoff_answers::summary::duration(*waited)
    )]
    Away {
        /// The directory.
        path: PathBuf,
        /// Waiting time.
        waited: Duration,
        /// First error.
        #[source]
        source: FileError,
    },
    /// The directory was removed or begun again by another study.
    #[error("{} was removed or replaced while this shard computed: the shard stops writing to it", shown(path))]
    Replaced {
        /// The directory.
        path: PathBuf,
    },
    /// Chunks are missing or damaged.
    #[error("{}: {missing} of {} {} missing: {}{aside}", shown(path), counted(*total, "chunk"), are(*missing), list)]
    Missing {
        /// The directory.
        path: PathBuf,
        /// Number of missing and damaged chunks.
        missing: u64,
        /// Number of chunks.
        total: u64,
        /// Their ranges.
        list: String,
        /// One line per kind of chunk that was set aside.
        aside: String,
    },
    /// The publisher thread could not be started.
    #[error("cannot start the thread that publishes chunks")]
    Thread(#[source] std::io::Error),
    /// File error.
    #[error(transparent)]
    File(#[from] FileError),
    /// Table error.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Error of the run on this node.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl ShardError {
    /// Whether the command was rejected before any work, so that repeating it cannot succeed.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Foreign { .. }
            | Self::None { .. }
            | Self::Untrusted(_)
            | Self::Changed { .. }
            | Self::Refined { .. }
            | Self::Chunk { .. } => true,
            Self::Run(error) => error.is_refusal(),
            _ => false,
        }
    }
}
