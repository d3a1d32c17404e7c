//! The end of a run: all samples done, a signal, a budget.

use std::time::Duration;

use super::ended::{Ended, Signal};
use super::scheduler::Scheduler;
use super::slot::{Effect, KillReason, State};
use super::until::Moment;

/// Time for a worker to obey the order to stop.
const FAREWELL: Duration = Duration::from_secs(5);

impl Scheduler {
    /// Reason of the end; `None` before it, and when the workers did not start.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        if self.is_complete() { Some(Ended::Complete) } else { self.ending.why }
    }

    /// Handles a signal that ends the run early. Samples in progress may finish within the grace time; a second signal ends the
    /// run at once.
    pub fn on_stop(&mut self, now: Duration, signal: Signal, effects: &mut Vec<Effect>) {
        self.stop(now, Ended::Signalled(signal), effects);
    }

    /// Ends the run at its time by either clock. `now` is real time, so sleep of the machine does not prolong a run.
    pub(super) fn check_time(&mut self, now: Duration, moment: Moment, effects: &mut Vec<Effect>) {
        let is_past_wall = self.settings.run.wall.is_some_and(|wall| now >= wall);
        // Read at each call, so that a change of the clock is noticed.
        let is_past_until = self.ending.until.as_mut().is_some_and(|until| until.is_reached(moment));
        if (is_past_wall || is_past_until) && self.ended().is_none() {
            self.stop(now, if is_past_wall { Ended::Wall } else { Ended::Until }, effects);
        }
    }

    /// Ends the run in order, or at once if it is already ending.
    fn stop(&mut self, now: Duration, why: Ended, effects: &mut Vec<Effect>) {
        let now = self.clock.advance(now);
        self.say_why(why, effects);
        if self.ending.has_begun() {
            self.end_now(effects);
        } else {
            self.begin_ending(now + self.settings.grace, effects);
        }
    }

    /// Sets the reason of the end; the first one counts, and a complete run needs none.
    fn say_why(&mut self, why: Ended, effects: &mut Vec<Effect>) {
        if self.ended().is_none() {
            self.ending.why = Some(why);
            effects.push(Effect::Stopping(why));
        }
    }

    /// Ends the run: starts no worker, assigns nothing and kills all live workers.
    pub(super) fn end_now(&mut self, effects: &mut Vec<Effect>) {
        self.ending.deadline = Some(Duration::ZERO);
        self.close_gone();
        (0..self.slots.len()).for_each(|at| self.kill(at, KillReason::Ending, effects));
    }

    fn begin_ending(&mut self, deadline: Duration, effects: &mut Vec<Effect>) {
        self.ending.deadline = Some(deadline);
        self.close_gone();
        // A starting worker gets the order when it connects: a kill while it creates its shared memory would disturb the hub.
        for at in 0..self.slots.len() {
            if matches!(self.slots[at].state, State::Idle) {
                self.tell_to_stop(at, effects);
            }
        }
    }

    /// Leaves the slots of dead workers empty.
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

    /// Stops idle workers after the last sample.
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

    /// Kills the workers that have not stopped in time.
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
