//! Samples that wait behind a long one go to workers that have nothing to do.
//!
//! A batch is sized by what samples cost on average; among free flights of ten milliseconds a rub may take ten seconds. While there is other
//! work, what waits behind it loses nothing. At the end of a run it would: two long ones in a batch, one after the other, while others
//! wait. So it is taken back, to be assigned anew, and the worker is told to leave it when it next reports. What it may have
//! begun of it meanwhile (a solver may have several under way) is computed twice, and counts once: from whom it is assigned to.

use std::time::Duration;

use super::scheduler::Scheduler;
use super::slot::State;

/// So long in one sample by heartbeats, what is behind it is taken back. Longer than from one heartbeat to the next, of which the second
/// confirms the first; many times what a whole batch is to take.
const LONG: Duration = Duration::from_millis(600);

impl Scheduler {
    /// Takes back what waits behind long samples, if somebody has nothing to do and there is nothing else to give.
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
