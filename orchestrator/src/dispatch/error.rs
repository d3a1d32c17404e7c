//! Why the samples could not be computed to their end.

use std::io;
use std::path::PathBuf;

use bladeoff_protocol::domain::DomainError;
use bladeoff_protocol::link::LinkError;
use bladeoff_system::shown;

use super::api::SinkError;

/// Why a run could not be carried out. What was recorded before stays recorded.
#[derive(Debug, thiserror::Error)]
pub enum DispatchError {
    /// Shared memory.
    #[error("nothing can be exchanged with workers")]
    Domain(#[from] DomainError),
    /// The connection to the workers, or a sample whose parameters cannot be sent.
    #[error("the connection to the workers failed")]
    Link(#[from] LinkError),
    /// The thread that exchanges messages hangs.
    #[error("no message could be exchanged for {seconds} s; what was recorded is kept; rerun the command to resume")]
    Stuck {
        /// For how long.
        seconds: u64,
    },
    /// Shared memory could not be made in any time.
    #[error(
        "making shared memory does not end: after {seconds} s something still waits. Files of other users under its name: {}",
        list(foreign)
    )]
    MemoryStuck {
        /// For how long.
        seconds: u64,
        /// Files that are not ours under the run's name.
        foreign: Vec<String>,
    },
    /// Somebody takes every name.
    #[error(
        "another user takes the names of this run's shared memory ({tries} were tried), the last time with {}",
        list(foreign)
    )]
    NamesTaken {
        /// How many.
        tries: u32,
        /// Files that are not ours under the last name.
        foreign: Vec<String>,
        /// What failed.
        source: LinkError,
    },
    /// Workers do not start.
    #[error("{deaths} workers in a row ended before they asked for work; the last one said: {last_words}")]
    WorkersDoNotStart {
        /// How many.
        deaths: u32,
        /// The last line of the last of them, or how it ended.
        last_words: String,
    },
    /// A worker process could not be started.
    #[error("starting a worker ({}) failed", shown(program))]
    Spawn {
        /// The program.
        program: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// More parameters than a message holds, or not the same number for every sample.
    #[error(
        "sample {sample} has {found} parameters, expected {expected}, at most {}",
        bladeoff_protocol::messages::MAX_PARAMS
    )]
    Parameters {
        /// Which sample.
        sample: u64,
        /// Its parameters.
        found: usize,
        /// Those of the first sample.
        expected: usize,
    },
    /// Results could not be recorded.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The worker log could not be written.
    #[error("writing {} failed", shown(path))]
    Log {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The system refused what every program needs: threads, timers, signals.
    #[error("{doing} failed")]
    System {
        /// What was being done.
        doing: &'static str,
        /// Why.
        #[source]
        source: io::Error,
    },
}

fn list(words: &[String]) -> String {
    if words.is_empty() { "none".to_owned() } else { words.join(", ") }
}
