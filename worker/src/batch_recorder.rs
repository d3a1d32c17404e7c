//! Recorder of a batch: a solver reports here which sample it begins and its outcome.
//!
//! The recorder knows which samples are in progress and which are done. Heartbeats, fault hooks and the CPU time of each sample
//! use that. It checks every outcome before it is sent.

use std::ops::ControlFlow;
use std::time::Duration;

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::messages::{BatchId, MAX_VALUES, SampleReport};

use crate::fault::{At, Faults};
use crate::heartbeat::Heartbeat;
use crate::process::thread_cpu_time;

/// A sample to compute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<'a> {
    /// Sample number.
    pub number: u64,
    /// Parameter values, in the order of the plan.
    pub params: &'a [f64],
}

/// Sample in progress, created by [`BatchRecorder::begin`] and consumed by [`BatchRecorder::finish`], so that no sample is
/// finished twice or without a beginning.
#[derive(Debug)]
#[must_use = "a sample that is begun has to be finished"]
pub struct Begun<'a> {
    at: usize,
    /// Place of the sample in the batch.
    pub sample: Sample<'a>,
}

/// Signal that no further outcome is accepted: the run is over for this worker, or the rest of the batch belongs to others. Only
/// a recorder creates it.
#[derive(Debug)]
pub struct Stopped(());

/// Destination of finished samples; `Break` if no more are accepted.
type HandIn<'a> = &'a mut dyn FnMut(SampleReport) -> ControlFlow<()>;

/// Recorder of one batch.
pub struct BatchRecorder<'a> {
    batch: BatchId,
    samples: &'a [Sample<'a>],
    /// Samples of the present call of the solver, by their places in the batch.
    call: Vec<usize>,
    is_done: Vec<bool>,
    n_left: usize,
    /// Samples in progress, in the order of their beginning.
    under_way: Vec<usize>,
    /// CPU time \[s\] of each sample in progress.
    spent: Vec<f64>,
    /// CPU time \[s\] of each sample from times without any sample in progress.
    between: f64,
    last: Duration,
    heartbeat: &'a Heartbeat,
    faults: &'a dyn Faults,
    hand_in: HandIn<'a>,
    is_handing_in: bool,
    has_stopped: bool,
}

impl<'a> BatchRecorder<'a> {
    pub(crate) fn new(
        batch: BatchId,
        samples: &'a [Sample<'a>],
        heartbeat: &'a Heartbeat,
        faults: &'a dyn Faults,
        hand_in: HandIn<'a>,
    ) -> Self {
        let n = samples.len();
        Self {
            batch,
            samples,
            call: Vec::new(),
            is_done: vec![false; n],
            n_left: n,
            under_way: Vec::new(),
            spent: vec![0.0; n],
            between: 0.0,
            last: thread_cpu_time(),
            heartbeat,
            faults,
            hand_in,
            is_handing_in: false,
            has_stopped: false,
        }
    }

    /// Begins a sample; `index` is its place among those of the present call. Several samples may be in progress: the heartbeat
    /// names the last one, and CPU time is shared evenly among them. CPU time without a sample in progress (a preparation) is
    /// shared by all samples without outcome.
    ///
    /// # Panics
    /// The sample is in progress or done, or the index is too large: faults of the solver, which have the effect of any panic
    /// (see [`Solver`](crate::Solver)).
    pub fn begin(&mut self, index: usize) -> Begun<'a> {
        let at = self.call[index];
        let sample = self.samples[at];
        let is_new = !self.is_done[at] && !self.under_way.contains(&at);
        assert!(is_new, "sample {} is begun a second time", sample.number);
        self.account();
        self.under_way.push(at);
        self.show();
        self.faults.reached(At::Running, sample.number, None);
        Begun { at, sample }
    }

    /// Finishes a sample with its outcome. An invalid one (a value that is not finite, too many values) becomes a failure.
    ///
    /// # Errors
    /// [`Stopped`]: the solver must return; another worker or run computes the unfinished samples.
    pub fn finish(&mut self, begun: Begun<'a>, outcome: Outcome) -> Result<(), Stopped> {
        let outcome = presentable(begun.sample.number, outcome);
        self.conclude(begun.at, outcome)
    }

    fn conclude(&mut self, at: usize, outcome: Outcome) -> Result<(), Stopped> {
        self.account();
        self.under_way.retain(|&other| other != at);
        self.is_done[at] = true;
        self.n_left -= 1;
        if !self.has_stopped {
            let cpu_s = self.spent[at] + self.between;
            self.is_handing_in = true;
            let next = (self.hand_in)(SampleReport { sample: self.samples[at].number, cpu_s, outcome });
            self.is_handing_in = false;
            self.has_stopped = next.is_break();
        }
        self.show();
        if self.has_stopped { Err(Stopped(())) } else { Ok(()) }
    }

    /// Assigns the CPU time since the last call to the samples that used it.
    fn account(&mut self) {
        let now = thread_cpu_time();
        let used = now.saturating_sub(self.last).as_secs_f64();
        self.last = now;
        if self.under_way.is_empty() {
            self.between += used / self.n_left.max(1) as f64;
        }
        for &at in &self.under_way {
            self.spent[at] += used / self.under_way.len() as f64;
        }
    }

    fn show(&self) {
        if let Some(&at) = self.under_way.last() {
            self.heartbeat.working(self.batch, self.samples[at].number);
        }
    }

    /// Number of samples of the batch.
    pub(crate) fn len(&self) -> usize {
        self.samples.len()
    }

    /// Number of a sample.
    pub(crate) fn number(&self, at: usize) -> u64 {
        self.samples[at].number
    }

    /// Sets the samples of the next call of the solver; none of them is in progress.
    pub(crate) fn open(&mut self, call: &[usize]) -> Vec<Sample<'a>> {
        self.account();
        self.under_way.clear();
        self.call = call.to_vec();
        call.iter().map(|&at| self.samples[at]).collect()
    }

    /// Returns the samples in progress, and all samples of the call without outcome.
    pub(crate) fn unfinished(&self) -> (Vec<usize>, Vec<usize>) {
        (self.under_way.clone(), self.call.iter().copied().filter(|&at| !self.is_done[at]).collect())
    }

    /// Gives up a sample without outcome of the solver.
    pub(crate) fn give_up(&mut self, at: usize) {
        // `has_stopped` reports whether the outcome was accepted.
        let _ = self.conclude(at, failed(Cause::Panicked));
    }

    /// Whether no further outcome is accepted.
    pub(crate) fn has_stopped(&self) -> bool {
        self.has_stopped
    }

    /// Whether a panic came from the recorder and not from the solver.
    pub(crate) fn is_handing_in(&self) -> bool {
        self.is_handing_in
    }
}

/// Converts an outcome to one that messages can carry.
fn presentable(sample: u64, outcome: Outcome) -> Outcome {
    if outcome.values.iter().flatten().any(|value| !value.is_finite()) {
        eprintln!("sample {sample}: the solver returned a value that is not finite");
        return failed(Cause::NonFinite);
    }
    if outcome.values.len() > MAX_VALUES {
        eprintln!("sample {sample}: {} values, at most {MAX_VALUES} fit", outcome.values.len());
        return failed(Cause::Panicked);
    }
    outcome
}

/// Creates an outcome without values.
pub(crate) fn failed(cause: Cause) -> Outcome {
    let mut causes = CauseSet::default();
    causes.insert(cause);
    Outcome {
        status: Status::Failed,
        cause: Some(cause),
        causes,
        notes: CauseSet::default(),
        end_cause: EndCause::Failure,
        values: Vec::new(),
    }
}
