//! What the caller of [`run`](super::run) gives and gets: plain data and three traits.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use bladeoff_model::outcome::Outcome;
use bladeoff_system::place::Place;

use crate::schedule::{KillReason, Snapshot, Until};

/// How a study is run.
#[derive(Debug, Clone)]
pub struct DispatchOptions {
    /// Worker processes, at least 1.
    pub workers: usize,
    /// Program and first arguments of a worker, e.g. [`self_command`](super::self_command); `worker` arguments follow.
    pub worker_command: Vec<OsString>,
    /// Result directory: workers read the frozen plan there.
    pub run_dir: PathBuf,
    /// blake3 of the frozen plan, as [`WorkPlan::write`](bladeoff_worker::plan::WorkPlan::write) returned it.
    pub plan_hash: String,
    /// File that collects the workers' messages; appended to, a worker number before each line.
    pub worker_log: Place,
    /// A sample in which its worker crashes alone this many times is quarantined.
    pub crash_limit: u32,
    /// A sample in which its worker is killed from outside, alone, this many times is quarantined.
    pub kill_limit: u32,
    /// Longest wall time of one sample \[s\]; a longer one has its worker killed, which counts as a crash.
    pub time_limit_s: Option<f64>,
    /// Silence of a worker after which it is shown as stale.
    pub stale_after: Duration,
    /// Silence of a worker after which it is replaced.
    pub replace_after: Duration,
    /// Longest batch, at most what a message holds; 1 sends samples one by one.
    pub max_batch: usize,
    /// After a signal: how long samples in work may finish before their workers are killed.
    pub grace: Duration,
    /// Longest time between calls of [`Sink::flush`] while there is something to flush.
    pub flush_every: Duration,
    /// Stop assigning after this time by the monotonic clock; what is in work finishes within `grace`.
    pub wall: Option<Duration>,
    /// Stop assigning when the clock on the wall says so.
    pub until: Option<Until>,
    /// Stop once more than this many samples have failed or been quarantined.
    pub max_failures: Option<u64>,
    /// Memory a worker may allocate after its start \[bytes\].
    pub memory_limit: Option<u64>,
    /// Identity of the program that workers must be, see [`build_id`](bladeoff_worker::process::build_id); `None`: any.
    pub build: Option<u64>,
    /// Workers compute nothing, for this many microseconds a sample; for measurements and tests of the dispatch.
    pub noop: Option<u64>,
    /// Whoever types `s` and Enter asks what the workers do, where standard input is a terminal.
    pub keys: bool,
    /// Directory below which the run has its sockets, and cleans up after dead ones; `None`: as the environment says.
    pub runtime: Option<PathBuf>,
}

impl DispatchOptions {
    /// Options with the documented defaults: crash limit 2, kill limit 5, stale after 5 s, replaced after 30 s, grace 2 s.
    #[must_use]
    pub fn new(workers: usize, worker_command: Vec<OsString>, run_dir: PathBuf, plan_hash: String) -> Self {
        let worker_log = run_dir.join("workers.log").into();
        Self {
            workers,
            worker_command,
            run_dir,
            plan_hash,
            worker_log,
            crash_limit: 2,
            kill_limit: 5,
            time_limit_s: None,
            stale_after: Duration::from_secs(5),
            replace_after: Duration::from_secs(30),
            max_batch: bladeoff_protocol::messages::MAX_BATCH,
            grace: Duration::from_secs(2),
            flush_every: Duration::from_millis(500),
            wall: None,
            until: None,
            max_failures: None,
            memory_limit: None,
            build: None,
            noop: None,
            keys: false,
            runtime: None,
        }
    }
}

/// The parameters of every sample of a study, by number.
pub trait Samples {
    /// Appends the parameters of a sample to `out`, always the same number of them: values in SI, or the index into the
    /// choices of the plan.
    fn params(&self, sample: u64, out: &mut Vec<f64>);
}

/// The end of one sample. `attempt`, `worker`, `cpu_s` may differ between equal runs and stay out of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleResult {
    /// Sample number.
    pub sample: u64,
    /// What the solver reported; of a quarantined sample: status, cause and no values (`values` is empty).
    pub outcome: Outcome,
    /// CPU time of the solve \[s\]; 0 for a quarantined sample.
    pub cpu_s: f64,
    /// Worker that computed it, counted over all processes started.
    pub worker: u32,
    /// 1 for the first attempt.
    pub attempt: u32,
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

/// Where results go. Every sample is recorded exactly once.
pub trait Sink {
    /// Takes one result; it counts once [`flush`](Sink::flush) has returned.
    ///
    /// # Errors
    /// Ends the run.
    fn record(&mut self, result: SampleResult) -> Result<(), SinkError>;

    /// Takes the results of one message.
    ///
    /// # Errors
    /// Ends the run.
    fn record_all(&mut self, results: &mut Vec<SampleResult>) -> Result<(), SinkError> {
        results.drain(..).try_for_each(|result| self.record(result))
    }

    /// Makes everything recorded so far durable. Called at least every `flush_every` and at the end.
    ///
    /// # Errors
    /// Ends the run.
    fn flush(&mut self) -> Result<(), SinkError>;

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

/// A signal that ended a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, or SIGHUP unless it is ignored.
    Terminate,
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Every sample is done.
    Complete,
    /// A signal came.
    Signalled(Signal),
    /// `wall` was reached.
    Wall,
    /// `until` was reached.
    Until,
    /// `max_failures` was exceeded.
    TooManyFailures,
}

impl Ended {
    /// The word of it, the same in events, status and manifest.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Ended::Complete => "complete",
            Ended::Signalled(Signal::Interrupt) => "interrupted",
            Ended::Signalled(Signal::Terminate) => "terminated",
            Ended::Wall => "wall",
            Ended::Until => "until",
            Ended::TooManyFailures => "max_failures",
        }
    }
}

/// How a run went.
#[derive(Debug, Clone, PartialEq)]
pub struct DispatchReport {
    /// Samples recorded in this run.
    pub done: u64,
    /// Why it ended.
    pub ended: Ended,
    /// The signal, if one ended it.
    pub interrupted: Option<Signal>,
    /// Workers that died or were killed while they should have lived.
    pub worker_deaths: u64,
    /// Messages that were not ours, damaged, late or duplicated.
    pub dropped_messages: u64,
    /// Wall time \[s\].
    pub wall_s: f64,
    /// From the start of the run until the first worker asked for work \[s\].
    pub first_ask_s: f64,
}

impl DispatchReport {
    /// Of a run that had no reason to begin.
    #[must_use]
    pub fn nothing(ended: Ended) -> Self {
        Self { done: 0, ended, interrupted: None, worker_deaths: 0, dropped_messages: 0, wall_s: 0.0, first_ask_s: 0.0 }
    }
}
