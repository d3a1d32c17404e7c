//! Samples added during a run: chunks of a shard, because other shards may compute those that have not begun.

use std::time::Duration;

use super::scheduler::Scheduler;
use super::slot::Effect;
use super::todo::Todo;

/// Computing time that should be waiting, so that no worker is idle.
const AHEAD: Duration = Duration::from_secs(2);

impl Scheduler {
    /// Whether more samples are needed, because the waiting ones are done soon.
    #[must_use]
    pub fn wants_more(&self) -> bool {
        let workers = self.settings.workers.max(1) as u64;
        self.settings.is_fed
            && !self.ending.has_begun()
            && self.queue.todo.left() < self.batches.within(AHEAD).saturating_mul(workers)
    }

    /// Adds samples. None of them may have been added before.
    pub fn on_more(&mut self, now: Duration, more: Todo, effects: &mut Vec<Effect>) {
        self.clock.advance(now);
        self.counts.total += more.left();
        self.queue.todo.append(more);
        self.give_work_to_all(effects);
    }

    /// Ends the supply of samples.
    pub fn on_no_more(&mut self, now: Duration, effects: &mut Vec<Effect>) {
        self.clock.advance(now);
        self.settings.is_fed = false;
        self.end_if_complete(effects);
    }
}
