//! Samples not yet assigned, as ranges.

use std::collections::VecDeque;
use std::ops::Range;

/// Samples to compute, in the order in which they are assigned; each at most once.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Todo {
    ranges: VecDeque<Range<u64>>,
    left: u64,
    /// Samples that an earlier run gave up because their workers were killed: assigned singly after all others, for one attempt.
    suspects: Vec<u64>,
}

impl Todo {
    /// Number of samples left, without suspects.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Number of samples, including suspects.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.left + self.suspects.len() as u64
    }

    /// Number of the next sample.
    #[must_use]
    pub fn first(&self) -> Option<u64> {
        self.ranges.front().map(|range| range.start).or(self.suspects.first().copied())
    }

    /// Adds suspects, which must not be among the other samples; each is tried once more.
    #[must_use]
    pub fn with_suspects(mut self, suspects: Vec<u64>) -> Self {
        self.suspects = suspects;
        self
    }

    /// Appends samples that are not in the list yet; `more` has no suspects.
    pub fn append(&mut self, mut more: Self) {
        self.left += more.left;
        self.ranges.append(&mut more.ranges);
    }

    /// Takes the suspects.
    pub fn take_suspects(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.suspects)
    }

    /// Takes up to `n` samples from the front.
    pub fn take(&mut self, n: usize) -> Vec<u64> {
        self.cut(n as u64).into_iter().flatten().collect()
    }

    /// Returns taken samples to the front.
    pub fn put_back(&mut self, samples: &[u64]) {
        samples.iter().rev().for_each(|&sample| self.ranges.push_front(sample..sample + 1));
        self.left += samples.len() as u64;
    }

    /// Takes all samples below a number, if the ranges are ascending.
    pub fn below(&mut self, end: u64) -> Self {
        let ranges: Vec<Range<u64>> = self.ranges.iter().map(|range| range.start..range.end.min(end)).collect();
        let found = Self::from_iter(ranges.into_iter().take_while(|range| range.start < end));
        self.cut(found.left);
        let (suspects, rest) = std::mem::take(&mut self.suspects).into_iter().partition(|sample| *sample < end);
        self.suspects = rest;
        found.with_suspects(suspects)
    }

    /// Takes all samples for which `is_one` is true, in their order.
    pub fn those(&mut self, is_one: impl Fn(u64) -> bool) -> Self {
        let (mut taken, mut left): (Vec<Range<u64>>, Vec<Range<u64>>) = (Vec::new(), Vec::new());
        for sample in self.ranges.iter().cloned().flatten() {
            let ranges = if is_one(sample) { &mut taken } else { &mut left };
            match ranges.last_mut() {
                Some(range) if range.end == sample => range.end += 1,
                _ => ranges.push(sample..sample + 1),
            }
        }
        let (suspects, rest) = std::mem::take(&mut self.suspects).into_iter().partition(|sample| is_one(*sample));
        *self = Self::from_iter(left).with_suspects(rest);
        Self::from_iter(taken).with_suspects(suspects)
    }

    /// Takes up to `n` samples from the front, as ranges.
    pub fn cut(&mut self, n: u64) -> Vec<Range<u64>> {
        let mut cut = Vec::new();
        let mut wanted = n;
        while wanted > 0
            && let Some(range) = self.ranges.front_mut()
        {
            let end = range.start.saturating_add(wanted).min(range.end);
            cut.push(range.start..end);
            wanted -= end - range.start;
            range.start = end;
            if range.is_empty() {
                self.ranges.pop_front();
            }
        }
        self.left -= n - wanted;
        cut
    }
}

/// All samples from 0 to a count.
impl From<u64> for Todo {
    fn from(count: u64) -> Self {
        Todo::from_iter(std::iter::once(0..count))
    }
}

impl FromIterator<Range<u64>> for Todo {
    fn from_iter<I: IntoIterator<Item = Range<u64>>>(ranges: I) -> Self {
        let ranges: VecDeque<_> = ranges.into_iter().filter(|range| !range.is_empty()).collect();
        let left = ranges.iter().map(|range| range.end - range.start).sum();
        Self { ranges, left, suspects: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_come_in_order_across_ranges() {
        let mut todo = Todo::from_iter([3..5, 9..9, 0..2]);
        assert_eq!((todo.left(), todo.take(3), todo.left()), (4, vec![3, 4, 0], 1));
        assert_eq!((todo.take(9), todo.left(), todo.take(1)), (vec![1], 0, vec![]));
        assert_eq!(Todo::from(2).take(9), [0, 1]);
        let mut todo = Todo::from_iter([3..5, 0..2, 7..8]);
        assert_eq!((todo.cut(3), todo.left(), todo.cut(9)), (vec![3..5, 0..1], 2, vec![1..2, 7..8]));
        let mut todo = Todo::from_iter([2..5, 7..9, 11..12]).with_suspects(vec![1, 10]);
        assert_eq!(todo.below(8), Todo::from_iter([2..5, 7..8]).with_suspects(vec![1]));
        assert_eq!((todo.below(8).total(), todo.below(9).take(9), todo.total()), (0, vec![8], 2));
        let mut todo = Todo::from_iter([2..5, 9..11, 6..8]).with_suspects(vec![1, 12]);
        let even = todo.those(|sample| sample % 2 == 0);
        assert_eq!(even, Todo::from_iter([2..3, 4..5, 10..11, 6..7]).with_suspects(vec![12]));
        assert_eq!(todo, Todo::from_iter([3..4, 9..10, 7..8]).with_suspects(vec![1]));
        let mut todo = Todo::from_iter([7..9, 0..2]);
        let taken = todo.take(3);
        todo.put_back(&taken[1..]);
        assert_eq!((todo.left(), todo.take(2), todo.take(9)), (3, vec![8, 0], vec![1]));
        let mut todo = Todo::from_iter(std::iter::once(7..9));
        todo.append(Todo::from_iter(std::iter::once(0..2)));
        assert_eq!((todo.left(), todo.take(9)), (4, vec![7, 8, 0, 1]));
    }
}
