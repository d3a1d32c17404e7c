//! Samples that come while the run goes on: of a shard, chunk by chunk, because others may take what it has not begun.

use std::time::Duration;

use super::scheduler::Scheduler;
use super::slot::Effect;
use super::todo::Todo;

/// Work that is to wait for the workers, so that none of them does.
const AHEAD: Duration = Duration::from_secs(2);

impl Scheduler {
    /// Whether more samples are wanted: those that wait are done within moments.
    #[must_use]
    pub fn wants_more(&self) -> bool {
        let workers = self.settings.workers.max(1) as u64;
        self.settings.is_fed
            && !self.ending.has_begun()
            && self.queue.todo.left() < self.batches.within(AHEAD).saturating_mul(workers)
    }

    /// Here are more. None of them may have been given before.
    pub fn on_more(&mut self, now: Duration, more: Todo, effects: &mut Vec<Effect>) {
        self.clock.advance(now);
        self.counts.total += more.left();
        self.queue.todo.append(more);
        self.give_work_to_all(effects);
    }

    /// No more will come.
    pub fn on_no_more(&mut self, now: Duration, effects: &mut Vec<Effect>) {
        self.clock.advance(now);
        self.settings.is_fed = false;
        self.end_if_complete(effects);
    }
}
