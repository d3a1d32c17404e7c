//! Samples not yet assigned, as ranges.

use std::collections::VecDeque;
use std::ops::Range;

/// Samples to compute, in the order in which they are assigned; each at most once.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Todo {
    ranges: VecDeque<Range<u64>>,
    left: u64,
}

impl Todo {
    /// How many are left.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.left
    }

    /// The next one.
    #[must_use]
    pub fn first(&self) -> Option<u64> {
        self.ranges.front().map(|range| range.start)
    }

    /// Takes up to `n` samples from the front.
    pub fn take(&mut self, n: usize) -> Vec<u64> {
        let mut taken = Vec::with_capacity(n.min(usize::try_from(self.left).unwrap_or(n)));
        while taken.len() < n
            && let Some(range) = self.ranges.front_mut()
        {
            let wanted = (n - taken.len()) as u64;
            let end = range.start.saturating_add(wanted).min(range.end);
            taken.extend(range.start..end);
            range.start = end;
            if range.is_empty() {
                self.ranges.pop_front();
            }
        }
        self.left -= taken.len() as u64;
        taken
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
        Self { ranges, left }
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
    }
}
