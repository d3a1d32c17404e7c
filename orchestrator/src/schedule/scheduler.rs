//! The state machine: samples, reports, assignments. Workers' lives are in `workers`, the end in `ending`.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use bladeoff_model::outcome::{Cause, Outcome, Status};
use bladeoff_protocol::messages::{BatchId, Report, WorkerId};

use super::batch::BatchSize;
use super::clock::Clock;
use super::rate::Rate;
use super::settings::Settings;
use super::slot::{Effect, Slot, State, Trouble, Work};
use super::todo::Todo;

/// Assigns the samples of one run. Every method that is told an event takes its time, which never influences results, and
/// appends what is to be done to `effects`, in order.
#[derive(Debug)]
pub struct Scheduler {
    pub(super) settings: Settings,
    pub(super) clock: Clock,
    pub(super) total: u64,
    pub(super) done: u64,
    pub(super) by_status: [u64; Status::ALL.len()],
    pub(super) by_cause: [u64; Cause::ALL.len()],
    pub(super) rate: Rate,
    /// When samples were assigned first.
    pub(super) begun: Option<Duration>,
    pub(super) todo: Todo,
    /// Samples to be retried one by one.
    pub(super) retry: VecDeque<u64>,
    /// Samples whose workers were killed in an earlier run: one by one, when there is nothing else.
    pub(super) suspects: VecDeque<u64>,
    /// Of the few samples that lost a worker.
    pub(super) troubles: BTreeMap<u64, Trouble>,
    pub(super) slots: Vec<Slot>,
    pub(super) next_worker: u32,
    pub(super) next_batch: u64,
    pub(super) batch_size: BatchSize,
    pub(super) worker_deaths: u64,
    /// Workers in a row that died before they asked.
    pub(super) failed_starts: u32,
    pub(super) dropped: u64,
    /// No assignments any more; what is unfinished is killed then.
    pub(super) ending: Option<Duration>,
    pub(super) has_given_up: bool,
}

impl Scheduler {
    /// A scheduler for these samples. Nothing happens before [`Scheduler::start`].
    #[must_use]
    pub fn new(settings: Settings, mut todo: Todo) -> Self {
        let total = todo.total();
        let suspects: VecDeque<u64> = todo.take_suspects().into();
        // The next kill is the last.
        let trouble = Trouble { kills: settings.sample.kills.max(1) - 1, ..Trouble::default() };
        let troubles = suspects.iter().map(|&sample| (sample, trouble)).collect();
        Self {
            settings,
            clock: Clock::default(),
            total,
            done: 0,
            by_status: [0; Status::ALL.len()],
            by_cause: [0; Cause::ALL.len()],
            rate: Rate::default(),
            begun: None,
            todo,
            retry: VecDeque::new(),
            suspects,
            troubles,
            slots: Vec::new(),
            next_worker: 0,
            next_batch: 0,
            batch_size: BatchSize::default(),
            worker_deaths: 0,
            failed_starts: 0,
            dropped: 0,
            ending: None,
            has_given_up: false,
        }
    }

    /// Whether every process has ended and none will be started.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.slots.iter().all(|slot| matches!(slot.state, State::Closed))
    }

    /// Whether every sample is done.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.done == self.total
    }

    /// Samples done.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Whether more samples of the study have failed or been quarantined than may.
    #[must_use]
    pub fn has_too_many_failures(&self) -> bool {
        let of = |status: Status| self.by_status[usize::from(status.code())];
        let failed = of(Status::Failed) + of(Status::Quarantined);
        self.settings.run.are_too_many(self.settings.failed_before + failed)
    }

    /// Workers that died or were killed while they should have lived.
    #[must_use]
    pub fn worker_deaths(&self) -> u64 {
        self.worker_deaths
    }

    /// Results and requests that were late, doubled or lies.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// A worker reports, asks, or both. Returns whether its request is to be answered, now or later; if not, it is to be
    /// dropped.
    pub fn on_report(&mut self, now: Duration, worker: WorkerId, report: &Report, effects: &mut Vec<Effect>) -> bool {
        let now = self.clock.advance(now);
        let Some(at) = self.slot_of(worker) else { return self.drop_report(report) };
        self.slots[at].heard = now;
        let is_answerable = match (&self.slots[at].state, report.batch) {
            (State::Starting { greeted: true }, None) => {
                self.failed_starts = 0;
                report.asks
            }
            (State::Busy(work), Some(named)) if named == (work.batch, work.attempt) => {
                self.take_results(at, report, effects);
                true
            }
            (State::Leaving { work: Some(work) }, Some(named)) if named == (work.batch, work.attempt) => {
                self.take_results(at, report, effects);
                // Told to stop already, unless it was killed before it could be.
                false
            }
            _ => return self.drop_report(report),
        };
        if !is_answerable {
            return false;
        }
        if report.asks {
            self.finish_batch(at);
            self.slots[at].enter(State::Idle, now);
            self.give_work(at, effects);
        } else if self.ending.is_some() {
            self.tell_to_stop(at, effects);
        } else if self.slots[at].work().is_some_and(|work| work.left.is_empty() && !work.taken_back.is_empty()) {
            effects.push(Effect::Leave(worker));
        } else {
            effects.push(Effect::Continue(worker));
        }
        self.check_failures(effects);
        self.end_if_complete(effects);
        true
    }

    fn drop_report(&mut self, report: &Report) -> bool {
        self.dropped += (report.samples.len() as u64).max(1);
        false
    }

    /// Records the results that are due and drops the others.
    fn take_results(&mut self, at: usize, report: &Report, effects: &mut Vec<Effect>) {
        for (index, result) in report.samples.iter().enumerate() {
            let slot = &mut self.slots[at];
            let (State::Busy(work) | State::Leaving { work: Some(work) }) = &mut slot.state else { return };
            // They come in the order of the batch, so it is nearly always the first.
            let Some(found) = work.left.iter().position(|&sample| sample == result.sample) else {
                if let Some(taken) = work.taken_back.iter().position(|&sample| sample == result.sample) {
                    work.taken_back.remove(taken);
                } else {
                    self.dropped += 1;
                }
                continue;
            };
            work.left.remove(found);
            work.current = None;
            slot.deaths = 0;
            effects.push(Effect::Record { index, attempt: work.attempt, worker: slot.worker });
            self.count(&result.outcome);
            self.troubles.remove(&result.sample);
        }
    }

    /// A worker says its batch is over: measures it, and retries what it left out.
    fn finish_batch(&mut self, at: usize) {
        let State::Busy(work) = &self.slots[at].state else { return };
        let took = self.clock.now().saturating_sub(work.assigned);
        let (size, left) = (work.size, work.left.clone());
        if left.is_empty() && work.taken_back.is_empty() {
            self.batch_size.measured(size, took);
        }
        for sample in left {
            self.dropped += 1;
            self.send_back(sample);
        }
    }

    /// Counts an ended sample.
    pub(super) fn count(&mut self, outcome: &Outcome) {
        self.count_words(outcome.status, outcome.cause);
    }

    pub(super) fn count_words(&mut self, status: Status, cause: Option<Cause>) {
        self.done += 1;
        self.by_status[usize::from(status.code())] += 1;
        if let Some(cause) = cause {
            self.by_cause[usize::from(cause.code())] += 1;
        }
    }

    /// An attempt ended without a result and without a death to blame: the sample is retried.
    pub(super) fn send_back(&mut self, sample: u64) {
        self.troubles.entry(sample).or_default().attempts += 1;
        self.retry.push_back(sample);
    }

    /// Gives an idle worker the next samples, if there are any.
    pub(super) fn give_work(&mut self, at: usize, effects: &mut Vec<Effect>) {
        // Whoever is being killed only finishes dying.
        if !matches!(self.slots[at].state, State::Idle) || self.slots[at].killed.is_some() {
            return;
        }
        if self.ending.is_some() {
            return self.tell_to_stop(at, effects);
        }
        let samples = match self.retry.pop_front() {
            Some(sample) => vec![sample],
            None if self.todo.left() > 0 => {
                let left = self.todo.left();
                self.todo.take(self.batch_size.next(self.settings.max_batch, left, self.settings.workers))
            }
            None => self.suspects.pop_front().into_iter().collect(),
        };
        let Some(&first) = samples.first() else { return };
        // Retried samples and suspects come alone, the others have no trouble yet.
        let attempt = 1 + self.troubles.get(&first).map_or(0, |trouble| trouble.attempts);
        self.next_batch += 1;
        let batch = BatchId(self.next_batch);
        let assigned = self.clock.now();
        self.begun.get_or_insert(assigned);
        let work = Work {
            batch,
            attempt,
            size: samples.len(),
            left: samples.iter().copied().collect(),
            taken_back: Vec::new(),
            assigned,
            current: None,
            waiting: None,
        };
        let worker = self.slots[at].worker;
        self.slots[at].enter(State::Busy(work), assigned);
        effects.push(Effect::Assign { worker, batch, attempt, samples });
    }

    /// Gives work to whoever waits for it.
    pub(super) fn give_work_to_all(&mut self, effects: &mut Vec<Effect>) {
        self.relieve();
        for at in 0..self.slots.len() {
            self.give_work(at, effects);
        }
    }

    pub(super) fn slot_of(&self, worker: WorkerId) -> Option<usize> {
        self.slots.iter().position(|slot| slot.worker == worker && slot.lives())
    }
}
