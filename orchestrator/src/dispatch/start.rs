//! Parts of a run: settings, shared memory and hub, event loop.

use bladeoff_protocol::domain::{Domain, foreign_files};
use bladeoff_protocol::messages::{MAX_PARAMS, batch_capacity};
use tokio::runtime::Runtime;
use tokio::sync::mpsc::UnboundedSender;

use super::api::{DispatchOptions, Parameters};
use super::error::DispatchError;
use super::event::Event;
use super::hub::Hub;
use crate::schedule::Settings;

/// Largest number of names tried if another process takes them.
const TRIES: u32 = 20;

/// Timers, signals and child processes.
pub(super) fn event_loop() -> Result<Runtime, DispatchError> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|source| DispatchError::System { doing: "starting timers and signals", source })
}

/// Creates shared memory and the hub in it. A process that watches /dev/shm can take the names of a run after its first file:
/// then new names are tried.
pub(super) fn connect(
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

/// Settings of the scheduler, with batches that fit into a message.
pub(super) fn settings(options: &DispatchOptions, n_params: usize) -> Settings {
    let mut settings = options.schedule.clone();
    settings.workers = settings.workers.max(1);
    settings.max_batch = settings.max_batch.clamp(1, batch_capacity(n_params));
    settings
}

/// Number of parameters of every sample, from the first.
pub(super) fn count_params(parameters: &dyn Parameters, first: Option<u64>) -> Result<usize, DispatchError> {
    let Some(sample) = first else { return Ok(0) };
    let mut params = Vec::new();
    parameters.params(sample, &mut params);
    let found = params.len();
    if found > MAX_PARAMS {
        return Err(DispatchError::Parameters { sample, found, expected: found });
    }
    Ok(found)
}
