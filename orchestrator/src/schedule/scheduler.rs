//! The state machine: samples, reports, assignments. Workers' lives are in `workers`, the end in `ending`.

use std::time::Duration;

use bladeoff_protocol::messages::{Report, WorkerId};

use super::batch::Batches;
use super::clock::Clock;
use super::counts::Counts;
use super::ended::Ending;
use super::queue::Queue;
use super::rate::Rate;
use super::settings::Settings;
use super::slot::{Effect, Slot, Starts, State, Work};
use super::todo::Todo;

/// Assigns the samples of one run. Every method that is told an event takes its time, which never influences results, and
/// appends what is to be done to `effects`, in order.
#[derive(Debug)]
pub struct Scheduler {
    pub(super) settings: Settings,
    pub(super) clock: Clock,
    pub(super) counts: Counts,
    pub(super) rate: Rate,
    pub(super) queue: Queue,
    pub(super) slots: Vec<Slot>,
    pub(super) starts: Starts,
    pub(super) batches: Batches,
    pub(super) ending: Ending,
}

impl Scheduler {
    /// A scheduler for these samples. Nothing happens before [`Scheduler::start`].
    #[must_use]
    pub fn new(settings: Settings, todo: Todo) -> Self {
        Self {
            clock: Clock::default(),
            counts: Counts::new(todo.total()),
            rate: Rate::default(),
            queue: Queue::new(todo, &settings.sample),
            slots: Vec::new(),
            starts: Starts::default(),
            batches: Batches::default(),
            ending: Ending::new(&settings.run),
            settings,
        }
    }

    /// Whether every process has ended and none will be started.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.slots.iter().all(|slot| matches!(slot.state, State::Closed))
    }

    /// Whether every sample is done, and no more come.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.counts.done == self.counts.total && !self.settings.is_fed
    }

    /// Samples done.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.counts.done
    }

    /// Workers that died or were killed while they should have lived.
    #[must_use]
    pub fn worker_deaths(&self) -> u64 {
        self.counts.worker_deaths
    }

    /// Results and requests that were late, doubled or lies.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.counts.dropped
    }

    /// A worker reports, asks, or both. Returns whether its request is to be answered, now or later; if not, it is to be
    /// dropped.
    pub fn on_report(&mut self, now: Duration, worker: WorkerId, report: &Report, effects: &mut Vec<Effect>) -> bool {
        let now = self.clock.advance(now);
        let Some(at) = self.slot_of(worker) else { return self.drop_report(report) };
        self.slots[at].heard = now;
        let is_answerable = match (&self.slots[at].state, report.batch) {
            (State::Starting { greeted: true }, None) => {
                self.starts.failed = 0;
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
        } else if self.ending.has_begun() {
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
        self.counts.dropped += (report.samples.len() as u64).max(1);
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
                    self.counts.dropped += 1;
                }
                continue;
            };
            work.left.remove(found);
            work.current = None;
            slot.deaths = 0;
            effects.push(Effect::Record { index, attempt: work.attempt, worker: slot.worker });
            self.counts.add(result.outcome.status, result.outcome.cause);
            self.queue.ended(result.sample);
        }
    }

    /// A worker says its batch is over: measures it, and retries what it left out.
    fn finish_batch(&mut self, at: usize) {
        let State::Busy(work) = &self.slots[at].state else { return };
        let took = self.clock.now().saturating_sub(work.assigned);
        let (size, left) = (work.size, work.left.clone());
        if left.is_empty() && work.taken_back.is_empty() {
            self.batches.measured(size, took);
        }
        for sample in left {
            self.counts.dropped += 1;
            self.queue.send_back(sample);
        }
    }

    /// Gives an idle worker the next samples, if there are any.
    pub(super) fn give_work(&mut self, at: usize, effects: &mut Vec<Effect>) {
        // Whoever is being killed only finishes dying.
        if !matches!(self.slots[at].state, State::Idle) || self.slots[at].killed.is_some() {
            return;
        }
        if self.ending.has_begun() {
            return self.tell_to_stop(at, effects);
        }
        let size = |left| self.batches.next(self.settings.max_batch, left, self.settings.workers);
        let (samples, attempt) = self.queue.next(size);
        if samples.is_empty() {
            return;
        }
        let batch = self.batches.number();
        let assigned = self.clock.now();
        self.rate.begin(assigned);
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
