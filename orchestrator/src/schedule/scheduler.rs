//! State machine of a run: samples, reports, assignments. `workers` has the life of workers, `ending` the end.

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

/// Assigns the samples of one run. Event methods take the time of their event, which never influences results, and append the
/// actions to `effects` in order.
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
    /// Creates the scheduler of these samples. It does nothing before [`Scheduler::start`].
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

    /// Whether all processes have ended and no other one will be started.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.slots.iter().all(|slot| matches!(slot.state, State::Closed))
    }

    /// Whether all samples are done and no more will be added.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.counts.done == self.counts.total && !self.settings.is_fed
    }

    /// Samples done.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.counts.done
    }

    /// Number of workers that died or were killed without an order to stop.
    #[must_use]
    pub fn worker_deaths(&self) -> u64 {
        self.counts.worker_deaths
    }

    /// Number of late, duplicate and invalid messages.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.counts.dropped
    }

    /// Takes a report, a request, or both. Returns whether the request will be answered; otherwise it is to be discarded.
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
                // The worker has the order to stop, unless it was killed before.
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

    /// Records the expected results and discards the others.
    fn take_results(&mut self, at: usize, report: &Report, effects: &mut Vec<Effect>) {
        for (index, result) in report.samples.iter().enumerate() {
            let slot = &mut self.slots[at];
            let (State::Busy(work) | State::Leaving { work: Some(work) }) = &mut slot.state else { return };
            // Results come in the order of the batch, so it is nearly always the first one.
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

    /// Ends a batch: measures its cost and retries the samples without result.
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

    /// Assigns the next samples to an idle worker.
    pub(super) fn give_work(&mut self, at: usize, effects: &mut Vec<Effect>) {
        // A worker that is being killed gets no samples.
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

    /// Assigns samples to all waiting workers.
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
