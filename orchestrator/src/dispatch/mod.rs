//! Runs a study's samples on worker processes: the loop between the scheduler and the world.
//!
//! ```text
//! hub thread          iceoryx2 ports, poll           ┐
//! children            wait, heartbeats, stderr       ├─ events ─> loop ─> schedule ─> effects ─> hub, children, sink
//! signals, timers     tokio                          ┘
//! ```
//! The loop takes no decisions: it tells [`schedule`](crate::schedule) what happened and does what it says. iceoryx2's ports
//! cannot leave the thread that made them, and releasing what a dead worker held takes some ten milliseconds, so they live
//! on a thread of their own. Everything else runs on the calling thread, which must live as long as the run: the
//! kernel kills workers with the thread that started them.
//!
//! Signals during a run: SIGINT, SIGTERM, and SIGHUP unless it is ignored, end it in order, a second one at once; SIGUSR1
//! asks what the workers do. They stay caught afterwards, so that the table is written to its end; [`watch_afterwards`] answers them
//! there.

mod api;
mod child;
mod clock;
mod driver;
mod hub;
mod keys;
mod log;
mod records;
mod signals;
mod start;

use std::ffi::OsString;
use std::io;
use std::path::PathBuf;

pub use bladeoff_protocol::domain::Domain;
use bladeoff_protocol::domain::DomainError;
use bladeoff_protocol::link::LinkError;
use bladeoff_worker::fault::FaultError;

pub use crate::schedule::{Activity, KillReason, Snapshot, TimeOfDay, TimeOfDayError, Todo, Until, WorkerView};
pub use api::{
    DispatchOptions, DispatchReport, Ended, Notice, Observer, SampleResult, Samples, Signal, Sink, SinkError,
};
pub use clock::next as next_time_of_day;
pub use signals::watch_afterwards;

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
    #[error("no message could be exchanged for {seconds} s; what was recorded is kept, run again to go on")]
    Stuck {
        /// For how long.
        seconds: u64,
    },
    /// Shared memory could not be made in any time.
    #[error(
        "making shared memory does not end: after {seconds} s something still waits. Somebody else's files under its name: {}",
        list(foreign)
    )]
    MemoryStuck {
        /// For how long.
        seconds: u64,
        /// Files that are not ours under the run's name.
        foreign: Vec<String>,
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
    #[error("starting a worker ({}) failed", program.display())]
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
    #[error("writing {} failed", path.display())]
    Log {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The environment asks for faults in a way that cannot be read.
    #[error(transparent)]
    Fault(#[from] FaultError),
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

/// Says before a study begins whether its workers would have shared memory.
///
/// # Errors
/// [`DispatchError::Domain`].
pub fn preflight(workers: usize) -> Result<(), DispatchError> {
    Ok(Domain::check(workers)?)
}

/// The command that starts this very program as a worker. It goes by the running file and not by its path, so that
/// workers started late are the same build even when the path has been overwritten meanwhile.
///
/// # Errors
/// The system does not say what is running.
pub fn self_command() -> Result<Vec<OsString>, DispatchError> {
    let running = "/proc/self/exe";
    std::fs::metadata(running)
        .map_err(|source| DispatchError::System { doing: "finding the running program", source })?;
    Ok(vec![running.into(), "worker".into()])
}

/// Computes samples on worker processes and hands the results to the sink, each sample once.
///
/// `todo`: the samples, a count for all from 0 or a [`Todo`] of ranges. Returns when every sample is done, or when a
/// signal or a budget ended the run; then all processes have ended and the shared memory is gone, but for what the observer was told of.
///
/// # Errors
/// See [`DispatchError`].
pub fn run(
    options: &DispatchOptions,
    samples: &dyn Samples,
    todo: impl Into<Todo>,
    sink: &mut dyn Sink,
    observer: &mut dyn Observer,
) -> Result<DispatchReport, DispatchError> {
    let mut kept = None;
    let report = run_keeping(options, samples, todo, sink, observer, &mut kept)?;
    give_back(kept, observer);
    Ok(report)
}

/// The same, with the shared memory left in `kept` for [`give_back`]: so that whatever has to be written is written first.
///
/// # Errors
/// See [`DispatchError`].
pub fn run_keeping(
    options: &DispatchOptions,
    samples: &dyn Samples,
    todo: impl Into<Todo>,
    sink: &mut dyn Sink,
    observer: &mut dyn Observer,
    kept: &mut Option<Domain>,
) -> Result<DispatchReport, DispatchError> {
    start::run(options, samples, todo.into(), sink, observer, kept)
}

/// Removes the shared memory of a run. What cannot be removed is told, and no error of the run: its results are there.
pub fn give_back(kept: Option<Domain>, observer: &mut dyn Observer) {
    for left in kept.map(Domain::close).unwrap_or_default() {
        observer.noticed(&Notice::NotRemoved { what: left.to_string() });
    }
}
