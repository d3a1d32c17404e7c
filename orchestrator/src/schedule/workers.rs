//! Life of workers: start, heartbeats, death, replacement.

use std::time::Duration;

use bladeoff_model::outcome::{Cause, Status};
use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::messages::{BatchId, WorkerId};

use super::scheduler::Scheduler;
use super::slot::{Death, Effect, KillReason, Slot, State};
use super::until::Moment;

/// Time for which heartbeats may report waiting while a batch is open. An answer takes microseconds.
const LOST_AFTER: Duration = Duration::from_secs(10);
/// Pause before the second replacement in a row; doubled with every further one.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// Number of workers in a row that must die before they ask for work to end the run.
const FAILED_STARTS: u32 = 4;

impl Scheduler {
    /// Begins the run with as many workers as can be used.
    pub fn start(&mut self, now: Duration, effects: &mut Vec<Effect>) {
        let now = self.clock.advance(now);
        let useful = if self.settings.is_fed { u64::MAX } else { self.counts.total };
        let useful = usize::try_from(useful).unwrap_or(usize::MAX);
        for _ in 0..self.settings.workers.min(useful) {
            let worker = self.starts.next();
            let state = State::Starting { greeted: false };
            let slot = Slot { worker, pid: None, state, since: now, heard: now, killed: None, deaths: 0 };
            self.slots.push(slot);
            effects.push(Effect::Spawn(worker));
        }
    }

    /// Takes the start of a worker's process.
    pub fn on_spawned(&mut self, now: Duration, worker: WorkerId, pid: u32) {
        let now = self.clock.advance(now);
        if let Some(at) = self.slot_of(worker) {
            self.slots[at].pid = Some(pid);
            self.slots[at].heard = now;
        }
    }

    /// Takes the greeting of a worker. Returns whether it is answered; an unknown worker is not.
    pub fn on_hello(&mut self, now: Duration, worker: WorkerId, pid: u32, effects: &mut Vec<Effect>) -> bool {
        let now = self.clock.advance(now);
        let found = self.slot_of(worker).filter(|&at| self.slots[at].pid == Some(pid));
        let Some(at) = found else {
            self.counts.dropped += 1;
            return false;
        };
        self.slots[at].heard = now;
        match &mut self.slots[at].state {
            State::Starting { greeted } if !*greeted => {
                *greeted = true;
                if self.ending.has_begun() {
                    self.tell_to_stop(at, effects);
                } else {
                    effects.push(Effect::Continue(worker));
                }
                true
            }
            _ => {
                self.counts.dropped += 1;
                false
            }
        }
    }

    /// Takes a heartbeat.
    pub fn on_beat(&mut self, now: Duration, worker: WorkerId, beat: Beat) {
        let now = self.clock.advance(now);
        let Some(at) = self.slot_of(worker) else { return };
        let slot = &mut self.slots[at];
        slot.heard = now;
        let State::Busy(work) = &mut slot.state else { return };
        let waits = beat.batch == BatchId(0) && beat.sample.is_none();
        work.waiting = if waits { work.waiting.or(Some(now)) } else { None };
        // A heartbeat about another batch is old; one about another worker's sample is invalid.
        let sample = beat.sample.filter(|sample| beat.batch == work.batch && work.left.contains(sample));
        if work.current.map(|(sample, _)| sample) != sample {
            work.current = sample.map(|sample| (sample, now));
        }
    }

    /// Takes the end of a worker's process, after all its messages have been passed to [`Scheduler::on_report`].
    pub fn on_exit(&mut self, now: Duration, worker: WorkerId, death: Death, effects: &mut Vec<Effect>) {
        let now = self.clock.advance(now);
        let Some(at) = self.slot_of(worker) else { return };
        let state = std::mem::replace(&mut self.slots[at].state, State::Closed);
        let killed = self.slots[at].killed;
        let was_told = matches!(state, State::Leaving { .. }) || killed == Some(KillReason::Ending);
        let failed_to_start = matches!(state, State::Starting { .. }) && !was_told;
        if let State::Busy(work) | State::Leaving { work: Some(work) } = state {
            let was_alone = work.size == 1;
            let is_to_blame = was_alone && !was_told && killed != Some(KillReason::Lost);
            for sample in work.left {
                self.queue.send_back(sample);
                if is_to_blame {
                    let cause = match killed {
                        Some(KillReason::TimeLimit) => Cause::TimeLimit,
                        // Heartbeats come from a thread of their own: a silent worker was stopped or got no CPU time.
                        Some(KillReason::Silent) => Cause::WorkerKilled,
                        _ if death.out_of_memory => Cause::OutOfMemory,
                        _ if death.from_outside => Cause::WorkerKilled,
                        _ => Cause::WorkerCrashed,
                    };
                    self.blame(sample, cause, worker, effects);
                }
            }
        }
        if !was_told {
            self.counts.worker_deaths += 1;
            let slot = &mut self.slots[at];
            let pause = match slot.deaths {
                0 => Duration::ZERO,
                n => FIRST_PAUSE.saturating_mul(1 << (n - 1).min(16)).min(LONGEST_PAUSE),
            };
            slot.deaths += 1;
            slot.enter(State::Gone { due: now + pause }, now);
        }
        if failed_to_start {
            self.starts.failed += 1;
            let too_many = FAILED_STARTS.max(2 * self.slots.len() as u32);
            if self.starts.failed >= too_many && !self.ending.has_given_up {
                self.ending.has_given_up = true;
                effects.push(Effect::GiveUp { deaths: self.starts.failed });
                self.end_now(effects);
            }
        }
        if self.ending.has_begun() {
            self.close_gone();
        }
        self.check_failures(effects);
        self.end_if_complete(effects);
        self.replace_dead(effects);
        self.give_work_to_all(effects);
    }

    /// Counts a death against a sample that was alone with its worker.
    fn blame(&mut self, sample: u64, cause: Cause, worker: WorkerId, effects: &mut Vec<Effect>) {
        let Some(attempt) = self.queue.blame(sample, cause, &self.settings.sample) else { return };
        self.counts.add(Status::Quarantined, Some(cause));
        effects.push(Effect::Quarantine { sample, cause, worker, attempt });
    }

    /// Advances the time; called several times a second. `moment`: readings of the system clocks.
    pub fn on_tick(&mut self, now: Duration, moment: Moment, effects: &mut Vec<Effect>) {
        self.rate.note(now, self.counts.done);
        self.check_time(now, moment, effects);
        let now = self.clock.advance(now);
        for at in 0..self.slots.len() {
            let slot = &self.slots[at];
            if !slot.lives() || slot.killed.is_some() {
                continue;
            }
            let silent = now.saturating_sub(slot.heard);
            let why = match &slot.state {
                _ if silent >= self.settings.replace_after => Some(KillReason::Silent),
                State::Busy(work) => {
                    let passed =
                        |since: Option<Duration>, limit| since.is_some_and(|since| now.saturating_sub(since) >= limit);
                    if self.settings.sample.time.is_some_and(|limit| passed(work.current.map(|(_, t)| t), limit)) {
                        Some(KillReason::TimeLimit)
                    } else if passed(work.waiting, LOST_AFTER) {
                        Some(KillReason::Lost)
                    } else {
                        None
                    }
                }
                // It connected and only sends heartbeats: a message was lost.
                State::Starting { .. } if now.saturating_sub(slot.since) >= self.settings.replace_after => {
                    Some(KillReason::Lost)
                }
                _ => None,
            };
            if let Some(why) = why {
                self.kill(at, why, effects);
            }
        }
        self.check_ending(effects);
        self.replace_dead(effects);
        self.give_work_to_all(effects);
    }

    pub(super) fn kill(&mut self, at: usize, why: KillReason, effects: &mut Vec<Effect>) {
        let slot = &mut self.slots[at];
        if slot.lives() && slot.killed.is_none() {
            slot.killed = Some(why);
            effects.push(Effect::Kill { worker: slot.worker, why });
        }
    }

    /// Starts the workers that are due.
    fn replace_dead(&mut self, effects: &mut Vec<Effect>) {
        let now = self.clock.now();
        if self.ending.has_begun() {
            return;
        }
        for at in 0..self.slots.len() {
            if !matches!(self.slots[at].state, State::Gone { due } if due <= now) {
                continue;
            }
            let worker = self.starts.next();
            let slot = &mut self.slots[at];
            *slot = Slot { worker, pid: None, heard: now, killed: None, ..slot.clone() };
            slot.enter(State::Starting { greeted: false }, now);
            effects.push(Effect::Spawn(worker));
        }
    }
}
