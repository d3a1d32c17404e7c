//! What the caller of [`run`](super::run) gives and gets: plain data and three traits.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use bladeoff_protocol::domain::Domain;
use bladeoff_system::place::Place;
use bladeoff_worker::fault::{Faults, NoFaults};

use crate::schedule::{Ended, KillReason, Settings, Snapshot, Todo};
use bladeoff_record::Entry;

/// How a study is run.
#[derive(Debug, Clone)]
pub struct DispatchOptions {
    /// Worker processes, what they and the run may take.
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
    /// Workers compute nothing, for this many microseconds a sample; for measurements and tests of the dispatch.
    pub noop: Option<u64>,
    /// Whoever types `s` and Enter asks what the workers do, where standard input is a terminal.
    pub keyboard: bool,
    /// Directory below which the run has its sockets, and cleans up after dead ones; `None`: as the environment says.
    pub runtime: Option<PathBuf>,
    /// Faults of the orchestrator, as the binary passes them in.
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

/// The parameters of every sample of a study, by number.
pub trait Parameters {
    /// Appends those of a sample to `out`, always the same number of them: values in SI, or the index into the choices of the plan.
    fn params(&self, sample: u64, out: &mut Vec<f64>);
}

/// Why a sink could not take a result; ends the run.
#[derive(Debug, thiserror::Error)]
#[error("{what}")]
pub struct SinkError {
    /// What the sink was doing.
    pub what: String,
    /// Why it failed.
    #[source]
    pub source: Option<Box<dyn std::error::Error + Send + Sync>>,
}

/// What there is to do beyond what was given at first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum More {
    /// These samples, none of which was given before.
    Samples(Todo),
    /// Not known yet: to be asked again.
    Later,
    /// Nothing any more.
    Nothing,
}

/// Where results go. Every sample is recorded exactly once.
pub trait Sink {
    /// Takes the end of one sample; it counts once [`flush`](Sink::flush) has returned. Of a quarantined one: status, cause, no values,
    /// no CPU time.
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

    /// Asked where [`Settings::is_fed`](crate::schedule::Settings::is_fed) says so, when what waits is done within moments. Does not wait.
    ///
    /// # Errors
    /// Ends the run.
    fn more(&mut self) -> Result<More, SinkError> {
        Ok(More::Nothing)
    }

    /// Called five times a second: whether results still have a place to go to.
    ///
    /// # Errors
    /// Ends the run.
    fn check(&mut self) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Sees how the run goes.
pub trait Observer {
    /// Called about ten times a second at most, and once at the end.
    fn progress(&mut self, snapshot: &Snapshot);

    /// Called when the user asked what each worker does (SIGUSR1, or the key).
    fn asked(&mut self, snapshot: &Snapshot) {
        let _ = snapshot;
    }

    /// Called when a line was typed, before what it asks for: a terminal that shows what is typed has gone to its next line.
    fn typed(&mut self) {}

    /// Called when something has happened that is not a result.
    fn noticed(&mut self, notice: &Notice) {
        let _ = notice;
    }
}

/// What happened to the workers and to the run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Notice {
    /// A process was started.
    WorkerStarted {
        /// Number over all workers started.
        worker: u32,
        /// Process id.
        pid: u32,
    },
    /// A process is being killed by us.
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
        /// It should have lived.
        died: bool,
    },
    /// No sample is assigned any more, though the run is not complete.
    Stopping(Ended),
    /// Shared memory could not be given back whole.
    NotRemoved {
        /// What is left, and why.
        what: String,
    },
}

/// How a run went.
#[derive(Debug)]
pub struct DispatchReport {
    /// Samples recorded in this run.
    pub done: u64,
    /// Why it ended.
    pub ended: Ended,
    /// Workers that died or were killed while they should have lived.
    pub worker_deaths: u64,
    /// Messages that were not ours, damaged, late or duplicated.
    pub dropped_messages: u64,
    /// Wall time \[s\].
    pub wall_s: f64,
    /// From the start of the run until the first worker asked for work \[s\].
    pub first_ask_s: f64,
    /// Its shared memory, for [`give_back`](super::give_back): so that whatever has to be written is written first.
    pub memory: Option<Domain>,
}

impl DispatchReport {
    /// Of a run that had no reason to begin.
    #[must_use]
    pub fn nothing(ended: Ended) -> Self {
        Self { done: 0, ended, worker_deaths: 0, dropped_messages: 0, wall_s: 0.0, first_ask_s: 0.0, memory: None }
    }
}
