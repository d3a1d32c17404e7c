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
mod error;
mod event;
mod hub;
mod keys;
mod log;
mod records;
mod signals;
mod start;

use std::ffi::OsString;

pub use bladeoff_protocol::domain::Domain;

pub use crate::schedule::{Activity, KillReason, Snapshot, TimeOfDay, TimeOfDayError, Todo, Until, WorkerView};
pub use api::{
    DispatchOptions, DispatchReport, Ended, Notice, Observer, SampleResult, Samples, Signal, Sink, SinkError,
};
pub use clock::next as next_time_of_day;
pub use error::DispatchError;
pub use signals::watch_afterwards;

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
