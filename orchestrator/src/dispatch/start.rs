//! What a run needs, made in this order and given back in the other: log, event loop, shared memory, hub.

use std::time::Duration;

use bladeoff_protocol::domain::{Domain, foreign_files};
use bladeoff_protocol::messages::{MAX_PARAMS, batch_capacity};
use bladeoff_system::shown;
use bladeoff_worker::fault::{Faults, Who};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::DispatchError;
use super::api::{DispatchOptions, DispatchReport, Observer, Samples, Sink};
use super::driver::{Driver, Parts};
use super::event::Event;
use super::hub::Hub;
use super::log::Log;
use super::{keys, signals};
use crate::schedule::{Scheduler, Settings, Todo};

/// Names that are tried where somebody takes them.
const TRIES: u32 = 20;

/// Runs the samples; the shared memory is still there, in `kept`, when all is well. Processes have ended.
pub(super) fn run(
    options: &DispatchOptions,
    samples: &dyn Samples,
    todo: Todo,
    sink: &mut dyn Sink,
    observer: &mut dyn Observer,
    kept: &mut Option<Domain>,
) -> Result<DispatchReport, DispatchError> {
    let faults = Faults::from_environment(Who::Orchestrator)?;
    let n_params = count_params(samples, &todo)?;
    let settings = settings(options, n_params);
    let mut log = Log::open(&options.worker_log)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|source| DispatchError::System { doing: "starting timers and signals", source })?;
    // Dropped in reverse: processes with the runtime, then the hub, then the domain.
    let (send, events) = unbounded_channel();
    let (domain, mut hub) = connect(options, settings.workers, &send)?;
    log.line(None, &format!("run {} with shared memory in {}", domain.run(), shown(&domain.address().root)))?;
    let result = {
        let _inside = runtime.enter();
        signals::watch(&send)?;
        if options.keys {
            keys::watch(&send);
        }
        let scheduler = Scheduler::new(settings, todo);
        let (domain, hub) = (&domain, &hub);
        let parts = Parts { options, samples, sink, observer, domain, hub, log, faults, n_params, send };
        runtime.block_on(Driver::new(parts, scheduler).run(events))
    };
    drop(runtime);
    if matches!(result, Err(DispatchError::Stuck { .. })) {
        hub.abandon();
    }
    drop(hub);
    let report = result?;
    *kept = Some(domain);
    Ok(report)
}

/// Shared memory and the hub in it. Whoever watches /dev/shm can take the names of a run as soon as its first file betrays them:
/// then another run's names are tried.
fn connect(
    options: &DispatchOptions,
    workers: usize,
    events: &UnboundedSender<Event>,
) -> Result<(Domain, Hub), DispatchError> {
    let mut tries = 0;
    loop {
        let domain = match &options.runtime {
            Some(base) => Domain::create_below(base, workers)?,
            None => Domain::create(workers)?,
        };
        let error = match Hub::start(domain.address(), domain.run(), workers, events.clone()) {
            Ok(hub) => return Ok((domain, hub)),
            Err(error) => error,
        };
        let foreign = foreign_files(&domain.address().prefix);
        tries += 1;
        match error {
            DispatchError::Link(_) if !foreign.is_empty() && tries < TRIES => {}
            DispatchError::Link(source) if !foreign.is_empty() => {
                return Err(DispatchError::NamesTaken { tries, foreign, source });
            }
            error => return Err(error),
        }
    }
}

fn settings(options: &DispatchOptions, n_params: usize) -> Settings {
    let seconds = |limit: f64| Duration::try_from_secs_f64(limit).unwrap_or(Duration::MAX);
    Settings {
        workers: options.workers.max(1),
        max_batch: options.max_batch.clamp(1, batch_capacity(n_params)),
        crash_limit: options.crash_limit,
        kill_limit: options.kill_limit,
        time_limit: options.time_limit_s.map(seconds),
        stale_after: options.stale_after,
        replace_after: options.replace_after,
        grace: options.grace,
        max_failures: options.max_failures,
    }
}

/// Number of parameters of every sample, from the first.
fn count_params(samples: &dyn Samples, todo: &Todo) -> Result<usize, DispatchError> {
    let Some(sample) = todo.first() else { return Ok(0) };
    let mut params = Vec::new();
    samples.params(sample, &mut params);
    let found = params.len();
    if found > MAX_PARAMS {
        return Err(DispatchError::Parameters { sample, found, expected: found });
    }
    Ok(found)
}
