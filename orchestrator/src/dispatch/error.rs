//! Errors of a dispatch.

use std::io;
use std::path::PathBuf;

use bladeoff_protocol::domain::DomainError;
use bladeoff_protocol::link::LinkError;
use bladeoff_system::shown;

use super::api::SinkError;

/// Error of a dispatch. Samples recorded before remain recorded.
#[derive(Debug, thiserror::Error)]
pub enum DispatchError {
    /// Shared memory.
    #[error("nothing can be exchanged with workers")]
    Domain(#[from] DomainError),
    /// The connection to the workers, or a sample whose parameters cannot be sent.
    #[error("the connection to the workers failed")]
    Link(#[from] LinkError),
    /// The hub thread does not answer.
    #[error(
        "no message could be exchanged for {seconds} s; recorded samples are kept; rerun the same command to resume"
    )]
    Stuck {
        /// Waiting time.
        seconds: u64,
    },
    /// Shared memory could not be created in time.
    #[error(
        "creating shared memory did not finish within {seconds} s. Files of other users under its name: {}",
        list(foreign)
    )]
    MemoryStuck {
        /// Waiting time.
        seconds: u64,
        /// Foreign files with the name of the run.
        foreign: Vec<String>,
    },
    /// Another process takes every name.
    #[error(
        "files of another user have the names of this run's shared memory ({tries} names were tried), the last one {}",
        list(foreign)
    )]
    NamesTaken {
        /// Number of names or workers tried.
        tries: u32,
        /// Foreign files with the last name.
        foreign: Vec<String>,
        /// Failed action.
        source: LinkError,
    },
    /// Workers do not start.
    #[error("{deaths} workers in a row ended before they asked for work; last message: {last_words}")]
    WorkersDoNotStart {
        /// Number of workers tried.
        deaths: u32,
        /// Last line of the last worker's output, or its exit.
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
        /// Sample.
        sample: u64,
        /// Number of its parameters.
        found: usize,
        /// Number of parameters of the first sample.
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
    /// The system refused threads, timers or signals.
    #[error("{doing} failed")]
    System {
        /// Failed action.
        doing: &'static str,
        /// Why.
        #[source]
        source: io::Error,
    },
}

fn list(words: &[String]) -> String {
    if words.is_empty() { "none".to_owned() } else { words.join(", ") }
}
