//! Work stealing: samples behind a long one go to idle workers.
//!
//! The size of a batch follows from the mean cost of samples, but among free runs of ten milliseconds a rub may take ten seconds.
//! While other work waits, nothing is lost. At the end of a run two long samples in one batch would be computed one after the
//! other while other workers idle. So waiting samples are taken back and assigned again, and the worker is ordered to leave them
//! at its next report. Samples that it has begun meanwhile are computed twice and count once, for the worker to which they are
//! assigned.

use std::time::Duration;

use super::scheduler::Scheduler;
use super::slot::State;

/// Time in one sample, by heartbeats, after which the samples behind it are taken back. It is longer than two heartbeats and many
/// times the target of a batch.
const LONG: Duration = Duration::from_millis(600);

impl Scheduler {
    /// Takes back the samples that wait behind long ones if a worker is idle and no other sample waits.
    pub(super) fn relieve(&mut self) {
        let is_idle = self.slots.iter().any(|slot| matches!(slot.state, State::Idle) && slot.killed.is_none());
        if !is_idle || !self.queue.is_used_up() || self.ending.has_begun() {
            return;
        }
        let now = self.clock.now();
        for slot in self.slots.iter_mut().filter(|slot| slot.killed.is_none()) {
            let State::Busy(work) = &mut slot.state else { continue };
            let Some((current, since)) = work.current else { continue };
            if now.saturating_sub(since) < LONG {
                continue;
            }
            let behind: Vec<u64> = work.left.iter().copied().filter(|&sample| sample != current).collect();
            work.left.retain(|&sample| sample == current);
            self.queue.todo.put_back(&behind);
            work.taken_back.extend(behind);
        }
    }
}
