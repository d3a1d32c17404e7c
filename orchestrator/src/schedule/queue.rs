//! The samples that are with no worker and have not ended, and what the few among them went through that lost a worker.

use std::collections::{BTreeMap, VecDeque};

use bladeoff_model::outcome::Cause;
use bladeoff_study::SampleLimits;

use super::slot::Trouble;
use super::todo::Todo;

/// Samples that wait to be assigned.
#[derive(Debug)]
pub(super) struct Queue {
    /// Not assigned yet, or taken back as if they had never been.
    pub todo: Todo,
    /// To be retried one by one.
    pub retry: VecDeque<u64>,
    /// Those whose workers were killed in an earlier run: one by one, when there is nothing else.
    pub suspects: VecDeque<u64>,
    /// Of the few samples that lost a worker.
    troubles: BTreeMap<u64, Trouble>,
}

impl Queue {
    pub fn new(mut todo: Todo, limits: &SampleLimits) -> Self {
        let suspects: VecDeque<u64> = todo.take_suspects().into();
        // The next kill is the last.
        let trouble = Trouble { kills: limits.kills.max(1) - 1, ..Trouble::default() };
        let troubles = suspects.iter().map(|&sample| (sample, trouble)).collect();
        Self { todo, retry: VecDeque::new(), suspects, troubles }
    }

    /// Whether suspects alone are left, or nothing.
    pub fn is_used_up(&self) -> bool {
        self.retry.is_empty() && self.todo.left() == 0
    }

    /// Takes the next samples, all of one attempt, with its number: 1 for the first. `size`: of a batch, where so many are left.
    pub fn next(&mut self, size: impl FnOnce(u64) -> usize) -> (Vec<u64>, u32) {
        let samples = match self.retry.pop_front() {
            Some(sample) => vec![sample],
            None if self.todo.left() > 0 => self.todo.take(size(self.todo.left())),
            None => self.suspects.pop_front().into_iter().collect(),
        };
        // Retried samples and suspects come alone, the others have no trouble yet.
        let trouble = samples.first().and_then(|first| self.troubles.get(first));
        let attempts = trouble.map_or(0, |trouble| trouble.attempts);
        (samples, 1 + attempts)
    }

    /// An attempt ended without a result and without a death to blame: the sample is retried.
    pub fn send_back(&mut self, sample: u64) {
        self.troubles.entry(sample).or_default().attempts += 1;
        self.retry.push_back(sample);
    }

    /// A death counts against a sample that was alone with its worker, which has been sent back. Returns the attempts made if that
    /// was one too many: then it is to be tried no more.
    pub fn blame(&mut self, sample: u64, cause: Cause, limits: &SampleLimits) -> Option<u32> {
        let trouble = self.troubles.entry(sample).or_default();
        let (deaths, limit) = match cause {
            Cause::WorkerKilled => (&mut trouble.kills, limits.kills),
            _ => (&mut trouble.crashes, limits.crashes),
        };
        *deaths += 1;
        if *deaths < limit.max(1) {
            return None;
        }
        let attempts = trouble.attempts;
        self.troubles.remove(&sample);
        self.retry.retain(|&waiting| waiting != sample);
        Some(attempts)
    }

    /// A sample has ended: what it went through is no matter any more.
    pub fn ended(&mut self, sample: u64) {
        self.troubles.remove(&sample);
    }
}
