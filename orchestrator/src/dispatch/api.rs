//! Interface of [`run`](super::run): plain data and three traits.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use bladeoff_protocol::domain::Domain;
use bladeoff_system::place::Place;
use bladeoff_worker::fault::{Faults, NoFaults};

use crate::schedule::{Ended, KillReason, Settings, Snapshot, Todo};
use bladeoff_record::Entry;

/// Options of a dispatch.
#[derive(Debug, Clone)]
pub struct DispatchOptions {
    /// Workers, limits of the run and of a sample.
    pub schedule: Settings,
    /// Program and first arguments of a worker, e.g. [`self_command`](super::self_command); `worker` arguments follow.
    pub worker_command: Vec<OsString>,
    /// Result directory: workers read the frozen plan there.
    pub run_dir: PathBuf,
    /// blake3 of the frozen plan, as [`JobSpec::write`](bladeoff_worker::job_spec::JobSpec::write) returned it.
    pub plan_hash: String,
    /// File that collects the workers' messages; appended to, a worker number before each line.
    pub worker_log: Place,
    /// Longest time between calls of [`Sink::flush`] while there is something to flush.
    pub flush_every: Duration,
    /// Identity of the program that workers must be, see [`build_id`](bladeoff_worker::process::build_id); `None`: any.
    pub build: Option<u64>,
    /// Time that each sample takes without computing \[us\], for measurements and tests of the dispatch.
    pub noop: Option<u64>,
    /// Whether `s` and Enter on a terminal print what the workers do.
    pub keyboard: bool,
    /// Directory for the sockets of the run, in which it also cleans up after dead runs; `None`: by the environment.
    pub runtime: Option<PathBuf>,
    /// Fault hooks of the orchestrator, passed in by the binary.
    pub faults: &'static dyn Faults,
}

impl DispatchOptions {
    /// Options with the usual [`Settings`].
    #[must_use]
    pub fn new(workers: usize, worker_command: Vec<OsString>, run_dir: PathBuf, plan_hash: String) -> Self {
        let worker_log = run_dir.join("workers.log").into();
        Self {
            schedule: Settings::new(workers),
            worker_command,
            run_dir,
            plan_hash,
            worker_log,
            flush_every: Duration::from_millis(500),
            build: None,
            noop: None,
            keyboard: false,
            runtime: None,
            faults: &NoFaults,
        }
    }
}

/// Parameters of the samples of a study.
pub trait Parameters {
    /// Appends the parameters of a sample to `out`, always the same number: values in SI, or the index into the choices of the
    /// plan.
    fn params(&self, sample: u64, out: &mut Vec<f64>);
}

/// Error of a sink; ends the run.
#[derive(Debug, thiserror::Error)]
#[error("{what}")]
pub struct SinkError {
    /// Failed action.
    pub what: String,
    /// Cause.
    #[source]
    pub source: Option<Box<dyn std::error::Error + Send + Sync>>,
}

/// Further samples of a run that is fed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum More {
    /// Further samples, none of which was supplied before.
    Samples(Todo),
    /// Not known yet: ask again.
    Later,
    /// No further samples.
    Nothing,
}

/// Destination of results. Every sample is recorded exactly once.
pub trait Sink {
    /// Takes an ended sample; it counts when [`flush`](Sink::flush) has returned. A quarantined one has status and cause, no
    /// values and no CPU time.
    ///
    /// # Errors
    /// Ends the run.
    fn record(&mut self, sample: u64, entry: Entry) -> Result<(), SinkError>;

    /// Takes the results of one message.
    ///
    /// # Errors
    /// Ends the run.
    fn record_all(&mut self, results: Vec<(u64, Entry)>) -> Result<(), SinkError> {
        results.into_iter().try_for_each(|(sample, entry)| self.record(sample, entry))
    }

    /// Makes everything recorded so far durable. Called at least every `flush_every` and at the end.
    ///
    /// # Errors
    /// Ends the run.
    fn flush(&mut self) -> Result<(), SinkError>;

    /// Supplies further samples if [`Settings::is_fed`](crate::schedule::Settings::is_fed) is set and the waiting samples are
    /// done soon. Does not block.
    ///
    /// # Errors
    /// Ends the run.
    fn more(&mut self) -> Result<More, SinkError> {
        Ok(More::Nothing)
    }

    /// Checks five times a second whether results can still be recorded.
    ///
    /// # Errors
    /// Ends the run.
    fn check(&mut self) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Observer of a run.
pub trait Observer {
    /// Called about ten times a second at most, and once at the end.
    fn progress(&mut self, snapshot: &Snapshot);

    /// Called when the user asked what each worker does (SIGUSR1, or the key).
    fn asked(&mut self, snapshot: &Snapshot) {
        let _ = snapshot;
    }

    /// Called when a line was typed, before its request is handled: a terminal with echo is then on its next line.
    fn typed(&mut self) {}

    /// Called at every event that is not a result.
    fn noticed(&mut self, notice: &Notice) {
        let _ = notice;
    }
}

/// Event of the workers or of the run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Notice {
    /// A process was started.
    WorkerStarted {
        /// Number over all workers started.
        worker: u32,
        /// Process id.
        pid: u32,
    },
    /// A process is killed by this program.
    WorkerKilled {
        /// Which.
        worker: u32,
        /// Why.
        why: KillReason,
    },
    /// A process has ended.
    WorkerEnded {
        /// Which.
        worker: u32,
        /// Exit code or signal, in words.
        how: String,
        /// Whether it had no order to stop.
        died: bool,
    },
    /// No sample is assigned any more, though the run is not complete.
    Stopping(Ended),
    /// Shared memory could not be removed completely.
    NotRemoved {
        /// Remaining files and the reason.
        what: String,
    },
}

/// Report of a dispatch.
#[derive(Debug)]
pub struct DispatchReport {
    /// Samples recorded in this run.
    pub done: u64,
    /// Reason of the end.
    pub ended: Ended,
    /// Workers that died or were killed without an order to stop.
    pub worker_deaths: u64,
    /// Foreign, damaged, late and duplicate messages.
    pub dropped_messages: u64,
    /// Wall time \[s\].
    pub wall_s: f64,
    /// Time from the start of the run until the first worker requested work \[s\].
    pub first_ask_s: f64,
    /// Shared memory, for [`give_back`](super::give_back) after everything is written.
    pub memory: Option<Domain>,
}

impl DispatchReport {
    /// Report of a run that needed no worker.
    #[must_use]
    pub fn nothing(ended: Ended) -> Self {
        Self { done: 0, ended, worker_deaths: 0, dropped_messages: 0, wall_s: 0.0, first_ask_s: 0.0, memory: None }
    }
}
