//! Why a shard could not be computed, or shards not be merged.

use super::super::error::{Change, RunError};
use super::super::trust::Untrusted;
use bladeoff_answers::summary::{are, counted};
use bladeoff_answers::tables::TableError;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

/// Why a shard could not be computed, or shards not be merged.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// The directory holds something else.
    #[error("{} holds {file:?}, which no shard has put there; choose another --out", shown(path))]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// The first file of somebody else.
        file: OsString,
    },
    /// No shard has begun it.
    #[error(
        "{} is no directory of shards, nor of results: `bladeoff submit`, or `run --shard`, begins one",
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
        /// The system's answer.
        #[source]
        source: std::io::Error,
    },
    /// Others could write in the directory.
    #[error(transparent)]
    Untrusted(#[from] Untrusted),
    /// It was begun with another study, program or chunk.
    #[error(
        "{} was begun with another study, program or chunk\n{}\nWhat a study has grown by is computed in a new directory, \
         which takes over what is there: --out NEW --reuse {}",
        shown(path),
        changes.iter().map(|change| format!("  {change}")).collect::<Vec<_>>().join("\n"),
        shown(path)
    )]
    Changed {
        /// The directory.
        path: PathBuf,
        /// What differs.
        changes: Vec<Change>,
    },
    /// A file of it is not what it should be.
    #[error("{}: {why}", shown(path))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// In words.
        why: String,
    },
    /// Which samples there are is decided by results.
    #[error(
        "{}: [refine] chooses samples by the results of those before, shards share out what is known beforehand: leave [refine] out, or \
         use `bladeoff run` on one machine",
        shown(study)
    )]
    Refined {
        /// The study file.
        study: PathBuf,
    },
    /// The chunks would be too large or too many.
    #[error("--chunk {size}: {why}")]
    Chunk {
        /// As asked.
        size: u64,
        /// What is wrong with it.
        why: String,
    },
    /// The shared file system did not come back.
    #[error(
        "{} could not be written for {}: given up; what was finished there is kept, and the same command resumes",
        shown(path),
        bladeoff_answers::summary::duration(*waited)
    )]
    Away {
        /// The directory.
        path: PathBuf,
        /// How long.
        waited: Duration,
        /// What the system said first.
        #[source]
        source: FileError,
    },
    /// It was removed or is another one by now.
    #[error("{} was removed or begun anew while this shard computed: nothing more of it goes there", shown(path))]
    Replaced {
        /// The directory.
        path: PathBuf,
    },
    /// Not all chunks are there.
    #[error("{}: {missing} of {} {} missing: {}{aside}", shown(path), counted(*total, "chunk"), are(*missing), list)]
    Missing {
        /// The directory.
        path: PathBuf,
        /// Chunks that are not there, or damaged.
        missing: u64,
        /// Chunks.
        total: u64,
        /// Which, in words.
        list: String,
        /// Those of them that were there and were put aside, a line for each kind.
        aside: String,
    },
    /// A thread could not be started.
    #[error("cannot start the thread that publishes chunks")]
    Thread(#[source] std::io::Error),
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
    /// A table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The run below it.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl ShardError {
    /// Whether it was refused before anything was done: the same command will not do better.
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
