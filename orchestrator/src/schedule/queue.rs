//! Waiting samples, and the attempts at the few samples that lost a worker.

use std::collections::{BTreeMap, VecDeque};

use bladeoff_model::outcome::Cause;
use bladeoff_study::SampleLimits;

use super::slot::Trouble;
use super::todo::Todo;

/// Samples that wait to be assigned.
#[derive(Debug)]
pub(super) struct Queue {
    /// Not assigned, or taken back.
    pub todo: Todo,
    /// To be retried singly.
    pub retry: VecDeque<u64>,
    /// Samples whose workers were killed in an earlier run: assigned singly, after all others.
    pub suspects: VecDeque<u64>,
    /// Attempts at samples that lost a worker.
    troubles: BTreeMap<u64, Trouble>,
}

impl Queue {
    pub fn new(mut todo: Todo, limits: &SampleLimits) -> Self {
        let suspects: VecDeque<u64> = todo.take_suspects().into();
        // The next kill quarantines the sample.
        let trouble = Trouble { kills: limits.kills.max(1) - 1, ..Trouble::default() };
        let troubles = suspects.iter().map(|&sample| (sample, trouble)).collect();
        Self { todo, retry: VecDeque::new(), suspects, troubles }
    }

    /// Whether only suspects are left, or nothing.
    pub fn is_used_up(&self) -> bool {
        self.retry.is_empty() && self.todo.left() == 0
    }

    /// Takes the next samples, all with the same attempt number, 1 for the first. `size`: size of a batch.
    pub fn next(&mut self, size: impl FnOnce(u64) -> usize) -> (Vec<u64>, u32) {
        let samples = match self.retry.pop_front() {
            Some(sample) => vec![sample],
            None if self.todo.left() > 0 => self.todo.take(size(self.todo.left())),
            None => self.suspects.pop_front().into_iter().collect(),
        };
        // Retried samples and suspects are assigned singly.
        let trouble = samples.first().and_then(|first| self.troubles.get(first));
        let attempts = trouble.map_or(0, |trouble| trouble.attempts);
        (samples, 1 + attempts)
    }

    /// Retries a sample whose attempt ended without a result and without its fault.
    pub fn send_back(&mut self, sample: u64) {
        self.troubles.entry(sample).or_default().attempts += 1;
        self.retry.push_back(sample);
    }

    /// Counts a death against a sample that was alone with its worker and has been returned. Returns the number of attempts if
    /// the sample must not be tried again.
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

    /// Forgets the attempts at an ended sample.
    pub fn ended(&mut self, sample: u64) {
        self.troubles.remove(&sample);
    }
}
