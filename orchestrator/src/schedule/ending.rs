//! The end of a run: all samples done, a signal, a budget.

use std::time::Duration;

use super::ended::{Ended, Signal};
use super::scheduler::Scheduler;
use super::slot::{Effect, KillReason, State};
use super::until::Moment;

/// Time for a worker that was told to stop.
const FAREWELL: Duration = Duration::from_secs(5);

impl Scheduler {
    /// Why the run ended or is ending; `None` as long as it is not, and where its workers did not start.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        if self.is_complete() { Some(Ended::Complete) } else { self.ending.why }
    }

    /// A signal: the run is to end before it is complete. What is in work may finish within the grace; a second call ends it at once.
    pub fn on_stop(&mut self, now: Duration, signal: Signal, effects: &mut Vec<Effect>) {
        self.stop(now, Ended::Signalled(signal), effects);
    }

    /// Ends the run at its time by either clock. `now` is real time: that it slept prolongs no run.
    pub(super) fn check_time(&mut self, now: Duration, moment: Moment, effects: &mut Vec<Effect>) {
        let is_past_wall = self.settings.run.wall.is_some_and(|wall| now >= wall);
        // Asked each time, so that a clock that is set is seen.
        let is_past_until = self.ending.until.as_mut().is_some_and(|until| until.is_reached(moment));
        if (is_past_wall || is_past_until) && self.ended().is_none() {
            self.stop(now, if is_past_wall { Ended::Wall } else { Ended::Until }, effects);
        }
    }

    /// Ends the run in order; at once, if it is ending already.
    fn stop(&mut self, now: Duration, why: Ended, effects: &mut Vec<Effect>) {
        let now = self.clock.advance(now);
        self.say_why(why, effects);
        if self.ending.has_begun() {
            self.end_now(effects);
        } else {
            self.begin_ending(now + self.settings.grace, effects);
        }
    }

    /// The first reason is the one; a complete run needs none.
    fn say_why(&mut self, why: Ended, effects: &mut Vec<Effect>) {
        if self.ended().is_none() {
            self.ending.why = Some(why);
            effects.push(Effect::Stopping(why));
        }
    }

    /// Ends the run: no worker is started or given work any more, and what lives is killed.
    pub(super) fn end_now(&mut self, effects: &mut Vec<Effect>) {
        self.ending.deadline = Some(Duration::ZERO);
        self.close_gone();
        (0..self.slots.len()).for_each(|at| self.kill(at, KillReason::Ending, effects));
    }

    fn begin_ending(&mut self, deadline: Duration, effects: &mut Vec<Effect>) {
        self.ending.deadline = Some(deadline);
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
        if self.is_complete() && !self.ending.has_begun() {
            self.begin_ending(self.clock.now() + FAREWELL, effects);
        }
    }

    /// Stops a run with too many failures of the study.
    pub(super) fn check_failures(&mut self, effects: &mut Vec<Effect>) {
        if !self.settings.run.are_too_many(self.settings.failed_before + self.counts.failed()) {
            return;
        }
        self.say_why(Ended::TooManyFailures, effects);
        if !self.ending.has_begun() {
            self.begin_ending(self.clock.now() + self.settings.grace, effects);
        }
    }

    /// Kills what has not left in time.
    pub(super) fn check_ending(&mut self, effects: &mut Vec<Effect>) {
        let now = self.clock.now();
        let Some(deadline) = self.ending.deadline else { return };
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
