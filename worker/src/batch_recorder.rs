//! The desk of a batch: where a solver says what it begins and hands in what came out.
//!
//! It keeps the book of who is under way and who is done, which the heartbeat, the hooks of tests and the CPU time of each sample go by,
//! and looks at every outcome before it may leave.

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
    /// Its number.
    pub number: u64,
    /// Its values, in the order of the plan.
    pub params: &'a [f64],
}

/// A sample under way, given by [`BatchRecorder::begin`] and taken by [`BatchRecorder::finish`]: so none is finished twice, or without having been begun.
#[derive(Debug)]
#[must_use = "a sample that is begun has to be finished"]
pub struct Begun<'a> {
    at: usize,
    /// Which it is.
    pub sample: Sample<'a>,
}

/// The run is over for this worker, or the rest of the batch is with others: nothing that is handed in from now on is taken. Only a desk says so.
#[derive(Debug)]
pub struct Stopped(());

/// Where finished samples go; `Break` if no more are taken.
type HandIn<'a> = &'a mut dyn FnMut(SampleReport) -> ControlFlow<()>;

/// The book of one batch.
pub struct BatchRecorder<'a> {
    batch: BatchId,
    samples: &'a [Sample<'a>],
    /// Those that the solver has been given this time, by their places in the batch.
    call: Vec<usize>,
    is_done: Vec<bool>,
    n_left: usize,
    /// Begun and not finished, in this order.
    under_way: Vec<usize>,
    /// CPU time \[s\] of each sample while it was under way.
    spent: Vec<f64>,
    /// CPU time \[s\] of each sample while none was.
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

    /// A sample is in work from now on; `index` is its place among those that the solver was given. Several may be under way: the
    /// heartbeat names the one begun last, and CPU time is shared out evenly among them. CPU time in which none is under way (a
    /// preparation) is shared by all that have no outcome yet.
    ///
    /// # Panics
    /// For a sample that is under way or done, and for an index beyond the last: faults of the solver, which cost it what any
    /// panic costs (see [`Solver`](crate::Solver)).
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

    /// A sample has its outcome. One that may not leave (a value that is not finite, too many of them) is made a failure.
    ///
    /// # Errors
    /// [`Stopped`]: the solver is to return; what is not finished yet is computed by another worker or run.
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

    /// CPU time since this was called before goes to whom it was used for.
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

    /// Samples of the batch.
    pub(crate) fn len(&self) -> usize {
        self.samples.len()
    }

    /// The number of a sample.
    pub(crate) fn number(&self, at: usize) -> u64 {
        self.samples[at].number
    }

    /// These samples are what the solver is given next; none of them is under way.
    pub(crate) fn open(&mut self, call: &[usize]) -> Vec<Sample<'a>> {
        self.account();
        self.under_way.clear();
        self.call = call.to_vec();
        call.iter().map(|&at| self.samples[at]).collect()
    }

    /// Samples under way, and all that were given to the solver and have no outcome.
    pub(crate) fn unfinished(&self) -> (Vec<usize>, Vec<usize>) {
        (self.under_way.clone(), self.call.iter().copied().filter(|&at| !self.is_done[at]).collect())
    }

    /// A sample that the solver has no outcome of.
    pub(crate) fn give_up(&mut self, at: usize) {
        // Whether it is still taken is seen by `has_stopped`.
        let _ = self.conclude(at, failed(Cause::Panicked));
    }

    /// Whether nothing more is taken.
    pub(crate) fn has_stopped(&self) -> bool {
        self.has_stopped
    }

    /// Whether a panic came from under the desk, so that it is none of the solver.
    pub(crate) fn is_handing_in(&self) -> bool {
        self.is_handing_in
    }
}

/// An outcome that messages can carry.
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

/// A result without values.
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
