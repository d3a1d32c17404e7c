//! Dispatch: runs the samples of a study on worker processes; the loop between scheduler and system.
//!
//! ```text
//! hub thread          iceoryx2 ports, poll           ┐
//! children            wait, heartbeats, stderr       ├─ events ─> loop ─> schedule ─> effects ─> hub, children, sink
//! signals, timers     tokio                          ┘
//! ```
//! The loop passes events to [`schedule`](crate::schedule) and executes its effects; it decides nothing. iceoryx2's ports cannot
//! leave their thread, and releasing the resources of a dead worker takes about ten milliseconds, so they have a thread of their
//! own. Everything else runs on the calling thread, which must live as long as the run: the kernel kills workers with the thread
//! that started them.
//!
//! Signals during a run: SIGINT, SIGTERM, and SIGHUP unless it is ignored, end it in order, a second one at once; SIGUSR1
//! asks what the workers do. They stay caught afterwards, so that the table is written to its end; [`watch_afterwards`] answers them
//! there, and [`watch_before`] while a run is prepared.

mod api;
mod child;
mod clock;
mod driver;
mod entries;
mod error;
mod event;
mod flushing;
mod hub;
mod hub_watch;
mod keyboard;
mod log;
mod preparation;
mod processes;
mod signals;
mod start;

use bladeoff_system::shown;
use std::ffi::OsString;

use bladeoff_protocol::domain::Domain;
use tokio::sync::mpsc::unbounded_channel;

use crate::schedule::Scheduler;
use driver::{Driver, Parts};
use log::Log;
use start::count_params;

pub use crate::schedule::{
    Activity, Ended, KillReason, Signal, Snapshot, TimeOfDay, TimeOfDayError, Todo, Until, WorkerView,
};
pub use api::{DispatchOptions, DispatchReport, More, Notice, Observer, Parameters, Sink, SinkError};
pub use clock::{left as time_left, next as next_time_of_day};
pub use error::DispatchError;
pub use preparation::{limit_preparation, nothing_to_compute};
pub use signals::{watch_afterwards, watch_before};

/// Checks before a study begins whether its workers can use shared memory.
///
/// # Errors
/// [`DispatchError::Domain`].
pub fn preflight(workers: usize) -> Result<(), DispatchError> {
    Ok(Domain::check(workers)?)
}

/// Command that starts this program as a worker. It uses the running executable instead of its path, so that workers started later are of the same
/// build even if the file was replaced.
///
/// # Errors
/// The system does not report the running executable.
pub fn self_command() -> Result<Vec<OsString>, DispatchError> {
    let running = "/proc/self/exe";
    std::fs::metadata(running)
        .map_err(|source| DispatchError::System { doing: "finding the running program", source })?;
    Ok(vec![running.into(), "worker".into()])
}

/// Computes samples on worker processes and hands the results to the sink, each sample once.
///
/// `todo`: the samples, a count for all from 0 or a [`Todo`] of ranges. Returns when every sample is done, or when a signal or a limit ended the run,
/// immediately if too many have failed before; all processes have then ended. The shared memory exists until [`give_back`], or until the report is
/// dropped.
///
/// # Errors
/// See [`DispatchError`].
pub fn run(
    options: &DispatchOptions,
    parameters: &dyn Parameters,
    todo: impl Into<Todo>,
    sink: &mut dyn Sink,
    observer: &mut dyn Observer,
) -> Result<DispatchReport, DispatchError> {
    let todo = todo.into();
    let begins = todo.total() > 0 || options.schedule.is_fed;
    if begins && options.schedule.run.are_too_many(options.schedule.failed_before) {
        return Ok(DispatchReport::nothing(Ended::TooManyFailures));
    }
    let first = if options.schedule.is_fed { Some(0) } else { todo.first() };
    let n_params = count_params(parameters, first)?;
    let settings = start::settings(options, n_params);
    let mut log = Log::open(&options.worker_log)?;
    // Created in this order and released in reverse order: first processes, with the event loop, then the hub, then the shared memory.
    let (send, events) = unbounded_channel();
    let (domain, mut hub) = start::connect(options, settings.workers, &send)?;
    log.line(None, &format!("run {} with shared memory in {}", domain.run(), shown(&domain.address().root)))?;
    let runtime = start::event_loop()?;
    let result = {
        let _inside = runtime.enter();
        signals::watch(&send)?;
        preparation::is_over();
        if options.keyboard {
            keyboard::watch(&send);
        }
        let scheduler = Scheduler::new(settings, todo);
        let (domain, hub) = (&domain, &hub);
        let parts = Parts { options, parameters, sink, observer, domain, hub, log, n_params, send };
        runtime.block_on(Driver::new(parts, scheduler).run(events))
    };
    drop(runtime);
    if matches!(result, Err(DispatchError::Stuck { .. })) {
        hub.abandon();
    }
    drop(hub);
    Ok(DispatchReport { memory: Some(domain), ..result? })
}

/// Removes the shared memory of a run. Remaining files are reported and are not an error of the run.
pub fn give_back(memory: Option<Domain>, observer: &mut dyn Observer) {
    for left in memory.map(Domain::close).unwrap_or_default() {
        observer.noticed(&Notice::NotRemoved { what: left.to_string() });
    }
}
