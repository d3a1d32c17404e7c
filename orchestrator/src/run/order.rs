//! Order in which samples are assigned: shuffled, so that the finished samples represent the whole study at any time.
//!
//! In a grid the cost of a sample changes along the slowest axis, from runs in permanent contact to runs without contact. In
//! ascending order the first half would predict neither the time nor the results of the second half. No result depends on the
//! order.

use crate::schedule::Todo;
use bladeoff_study::Samples;
use bladeoff_study::sampling::Shuffle;

/// Largest number of blocks of successive missing samples. Up to this number samples are shuffled singly; with more, neighbours
/// stay together, which saves pages of the record.
const MOST_BLOCKS: u64 = 1024;
/// Seed of the order, the same for all studies, so that every order is reproducible.
const SEED: u64 = 0;

/// Orders the missing samples of a study: points of a random design in ascending order, so that half a study has its first
/// points; all others shuffled.
#[must_use]
pub fn ordered(todo: Todo, samples: &Samples) -> Todo {
    if samples.layout().is_some() { todo } else { shuffled(todo) }
}

/// Shuffles blocks of equal length; suspects stay at the end. The order depends only on the set of samples.
#[must_use]
pub fn shuffled(mut todo: Todo) -> Todo {
    let suspects = todo.take_suspects();
    let length = todo.left().div_ceil(MOST_BLOCKS);
    let mut blocks = Vec::new();
    while todo.left() > 0 {
        blocks.push(todo.cut(length));
    }
    let shuffle = Shuffle::new(SEED, blocks.len() as u64);
    let blocks = (0..blocks.len() as u64).flat_map(|place| std::mem::take(&mut blocks[shuffle.apply(place) as usize]));
    Todo::from_iter(blocks).with_suspects(suspects)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_missing_sample_is_handed_out_once(
            count in 1u64..20_000, gaps in prop::collection::vec((0u64..2_000, 1u64..50), 0..60),
        ) {
            // Missing samples after an interruption at any point.
            let mut next = 0;
            let ranges = gaps.into_iter().map(|(skipped, length)| {
                let start = next + skipped;
                next = start + length;
                start..next
            });
            let ranges: Vec<_> = ranges.chain(std::iter::once(200_000..200_000 + count)).collect();
            let order = shuffled(Todo::from_iter(ranges.clone())).take(usize::MAX);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert!(sorted.into_iter().eq(ranges.iter().cloned().flatten()));
            prop_assert_eq!(shuffled(Todo::from_iter(ranges)).take(usize::MAX), order);
        }
    }

    #[test]
    fn up_to_1024_samples_are_shuffled_one_by_one_and_of_more_neighbours_stay_together() {
        let steps = |count| {
            let order = shuffled(Todo::from(count)).take(usize::MAX);
            order.windows(2).filter(|pair| pair[1] == pair[0] + 1).count()
        };
        assert!(steps(1024) < 10, "{}", steps(1024));
        assert!(steps(1_000_000) >= 1_000_000 - 1024, "{}", steps(1_000_000));
    }

    #[test]
    fn many_gaps_do_not_become_more_blocks() {
        // Every second sample, as after a rerun of scattered failures.
        let mut todo = shuffled(Todo::from_iter((0..100_000).map(|i| 2 * i..2 * i + 1)));
        let first = todo.take(98);
        assert!(first.windows(2).all(|pair| pair[1] == pair[0] + 2), "a block goes across gaps: {first:?}");
        assert_eq!(todo.left(), 100_000 - 98);
    }

    #[test]
    fn any_beginning_is_like_the_whole() {
        let count = 240;
        let order = shuffled(Todo::from(count)).take(usize::MAX);
        for part in [24, 60, 120] {
            let mean = order[..part].iter().sum::<u64>() as f64 / part as f64;
            // Four standard deviations of the mean of as many random numbers.
            let spread = count as f64 / 12f64.sqrt() / (part as f64).sqrt();
            assert!((mean - (count - 1) as f64 / 2.0).abs() < 4.0 * spread, "{part}: {mean}");
        }
    }
}
