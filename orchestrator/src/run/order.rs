//! The order in which samples are handed out: shuffled, so that what is finished at any moment is like the whole.
//!
//! In a grid the cost of a sample drifts along the slowest axis, from runs that rub all the time to runs that never do. In
//! the order of the numbers the first half would say nothing of the second: neither of its time nor of its results.
//! No result depends on the order.

use crate::schedule::Todo;
use bladeoff_study::Samples;
use bladeoff_study::sampling::Shuffle;

/// Blocks at most, each of successive missing samples. Up to so many samples are shuffled one by one; of more, neighbours stay
/// together, which saves pages of the record.
const MOST_BLOCKS: u64 = 1024;
/// One order for all studies: whatever happens once happens again.
const SEED: u64 = 0;

/// In which order the missing samples of a study are handed out: of a design as they are, so that half-way there is a beginning of its
/// points (which are random already: what finishes first is not), otherwise shuffled.
#[must_use]
pub fn ordered(todo: Todo, samples: &Samples) -> Todo {
    if samples.layout().is_some() { todo } else { shuffled(todo) }
}

/// The same samples in shuffled blocks of equal length; suspects stay at the end. The order depends on nothing but which samples they
/// are.
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
            // What is missing after a run that was interrupted anywhere.
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
        // Every second sample, as after a rerun of what failed here and there.
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
            // Four standard deviations of a mean of as many drawn numbers.
            let spread = count as f64 / 12f64.sqrt() / (part as f64).sqrt();
            assert!((mean - (count - 1) as f64 / 2.0).abs() < 4.0 * spread, "{part}: {mean}");
        }
    }
}
