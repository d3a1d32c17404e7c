//! The end of a run: all samples done, a signal, a budget.

use std::time::Duration;

use super::scheduler::Scheduler;
use super::slot::{Effect, KillReason, State};

/// Time for a worker that was told to stop.
const FAREWELL: Duration = Duration::from_secs(5);

impl Scheduler {
    /// The run is to end before it is complete. What is in work may finish within the grace; a second call ends it at once.
    pub fn on_stop(&mut self, now: Duration, effects: &mut Vec<Effect>) {
        let now = self.clock.advance(now);
        if self.ending.is_some() {
            return self.end_now(effects);
        }
        self.begin_ending(now + self.settings.grace, effects);
    }

    /// Ends the run: no worker is started or given work any more, and what lives is killed.
    pub(super) fn end_now(&mut self, effects: &mut Vec<Effect>) {
        self.ending = Some(Duration::ZERO);
        self.close_gone();
        (0..self.slots.len()).for_each(|at| self.kill(at, KillReason::Ending, effects));
    }

    fn begin_ending(&mut self, deadline: Duration, effects: &mut Vec<Effect>) {
        self.ending = Some(deadline);
        self.close_gone();
        // Whoever is starting is told when it says hello: to kill it in the middle of making its memory is what the hub
        // likes least.
        for at in 0..self.slots.len() {
            if matches!(self.slots[at].state, State::Idle) {
                self.tell_to_stop(at, effects);
            }
        }
    }

    /// Slots whose worker has died stay empty.
    pub(super) fn close_gone(&mut self) {
        for slot in &mut self.slots {
            if matches!(slot.state, State::Gone { .. }) {
                slot.state = State::Closed;
            }
        }
    }

    /// Answers a worker's open request with the order to stop.
    pub(super) fn tell_to_stop(&mut self, at: usize, effects: &mut Vec<Effect>) {
        let now = self.clock.now();
        let slot = &mut self.slots[at];
        let work = match std::mem::replace(&mut slot.state, State::Idle) {
            State::Busy(work) => Some(work),
            _ => None,
        };
        slot.enter(State::Leaving { work }, now);
        effects.push(Effect::Stop(slot.worker));
    }

    /// After the last sample nobody is needed.
    pub(super) fn end_if_complete(&mut self, effects: &mut Vec<Effect>) {
        if self.is_complete() && self.ending.is_none() {
            self.begin_ending(self.clock.now() + FAREWELL, effects);
        }
    }

    /// Stops a run with too many failures.
    pub(super) fn check_failures(&mut self, effects: &mut Vec<Effect>) {
        if self.has_too_many_failures() && self.ending.is_none() {
            self.begin_ending(self.clock.now() + self.settings.grace, effects);
        }
    }

    /// Kills what has not left in time.
    pub(super) fn check_ending(&mut self, effects: &mut Vec<Effect>) {
        let now = self.clock.now();
        let Some(deadline) = self.ending else { return };
        for at in 0..self.slots.len() {
            let slot = &self.slots[at];
            let is_late = match slot.state {
                State::Leaving { .. } => now >= deadline.max(slot.since + FAREWELL),
                _ => now >= deadline,
            };
            if is_late {
                self.kill(at, KillReason::Ending, effects);
            }
        }
    }
}
