//! Choice of the next chunk of a shard: a state machine without I/O and without waiting.
//!
//! ```text
//! 1  own chunks in ascending order; published ones are skipped, those in progress elsewhere are deferred
//! 2  deferred own chunks, until they are published or no live attempt computes them
//! 3  missing chunks of other shards, from the last one down; chunks with a hint are skipped
//! 4  a few of those: whether the attempt that wrote the hint is alive
//! ```
//! With ten thousand helpers, no helper can check all chunks in progress. Two directory listings per folder show the hints, and each
//! helper checks [`MAX_HINT_CHECKS`] of them, different ones from those of its neighbours. An attempt waits for its own chunks only:
//! each chunk in progress elsewhere has an owner that waits for it. So no chunk is lost while one attempt at its shard is alive, and no
//! node waits for others at the end.

use super::layout::Shard;
use std::collections::VecDeque;

/// Largest number of hints that one attempt checks.
const MAX_HINT_CHECKS: u64 = 64;

/// Way of looking up a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lookup {
    /// Look up the file of the chunk, and whether the attempt of its hint is alive.
    Single,
    /// Look up the listing of its folder: in progress if it has a hint. A chunk that seems to be missing is looked up singly.
    Folder,
}

/// State of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ChunkState {
    /// Published.
    Published,
    /// In progress in another live attempt.
    InProgress,
    /// Neither published nor in progress.
    Missing,
}

/// Next action of an attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// Compute this chunk.
    Compute(u64),
    /// Wait: the remaining own chunks are in progress elsewhere.
    Wait,
    /// No chunk is left for this attempt.
    Done,
}

/// Chooser of the chunks of one attempt.
#[derive(Debug, Clone)]
pub(super) struct ChunkChooser {
    shard: Shard,
    chunks: u64,
    /// Next own chunk.
    next: u64,
    /// Own chunks in progress elsewhere.
    put_off: VecDeque<u64>,
    /// Next chunk from the last one down, plus one.
    far: u64,
    /// Chunks of other shards with a hint, from the last one down.
    hinted: Vec<u64>,
    /// Number of hints checked.
    hints_checked: u64,
}

impl ChunkChooser {
    /// Creates the chooser of a shard; `chunks`: number of chunks.
    pub fn new(shard: Shard, chunks: u64) -> Self {
        Self {
            shard,
            chunks,
            next: shard.number,
            put_off: VecDeque::new(),
            far: chunks,
            hinted: Vec::new(),
            hints_checked: 0,
        }
    }

    /// Chooses the next chunk. `look_up`: reads the state of a chunk; called for few chunks.
    pub fn choose<E>(&mut self, mut look_up: impl FnMut(u64, Lookup) -> Result<ChunkState, E>) -> Result<Choice, E> {
        while self.next < self.chunks {
            let chunk = self.next;
            let found = look_up(chunk, Lookup::Single)?;
            self.next += self.shard.of;
            match found {
                ChunkState::Published => {}
                ChunkState::InProgress => self.put_off.push_back(chunk),
                ChunkState::Missing => return Ok(Choice::Compute(chunk)),
            }
        }
        for _ in 0..self.put_off.len() {
            let Some(&chunk) = self.put_off.front() else { break };
            let found = look_up(chunk, Lookup::Single)?;
            self.put_off.pop_front();
            match found {
                ChunkState::Published => {}
                ChunkState::InProgress => self.put_off.push_back(chunk),
                ChunkState::Missing => return Ok(Choice::Compute(chunk)),
            }
        }
        while self.far > 0 {
            let chunk = self.far - 1;
            let found = if self.shard.owns(chunk) { ChunkState::Published } else { look_up(chunk, Lookup::Folder)? };
            self.far = chunk;
            match found {
                ChunkState::Published => {}
                ChunkState::InProgress => self.hinted.push(chunk),
                ChunkState::Missing => return Ok(Choice::Compute(chunk)),
            }
        }
        let all = self.hinted.len() as u64;
        while self.hints_checked < all.min(MAX_HINT_CHECKS) {
            let place = (self.shard.number.wrapping_mul(MAX_HINT_CHECKS) + self.hints_checked) % all;
            let chunk = self.hinted[usize::try_from(place).expect("a place in memory")];
            let found = look_up(chunk, Lookup::Single)?;
            self.hints_checked += 1;
            if found == ChunkState::Missing {
                return Ok(Choice::Compute(chunk));
            }
        }
        Ok(if self.put_off.is_empty() { Choice::Done } else { Choice::Wait })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ChunkState::{InProgress, Missing, Published};
    use std::convert::Infallible;

    fn chosen(chooser: &mut ChunkChooser, states: &[ChunkState]) -> Choice {
        chooser.choose(|chunk, _| Ok::<_, Infallible>(states[chunk as usize])).expect("no error")
    }

    #[test]
    fn own_chunks_come_first_then_those_of_others_from_the_far_end() {
        let mut chooser = ChunkChooser::new(Shard { number: 1, of: 3 }, 8);
        let mut states = [Missing; 8];
        states[4] = Published;
        let mut taken = Vec::new();
        while let Choice::Compute(chunk) = chosen(&mut chooser, &states) {
            states[chunk as usize] = Published;
            taken.push(chunk);
        }
        assert_eq!(taken, [1, 7, 6, 5, 3, 2, 0]);
        assert_eq!(chosen(&mut chooser, &states), Choice::Done);
    }

    #[test]
    fn own_chunks_that_others_are_at_are_waited_for_and_those_of_others_are_not() {
        let mut chooser = ChunkChooser::new(Shard { number: 0, of: 2 }, 4);
        let mut states = [InProgress, InProgress, Missing, InProgress];
        assert_eq!(chosen(&mut chooser, &states), Choice::Compute(2));
        assert_eq!(chosen(&mut chooser, &states), Choice::Wait);
        states[0] = Missing;
        assert_eq!(chosen(&mut chooser, &states), Choice::Compute(0), "whoever was at it is gone");
        assert_eq!(chosen(&mut chooser, &states), Choice::Done, "1 and 3 have their own shard");
    }

    #[test]
    fn of_many_with_a_hint_some_are_looked_at_and_by_all_who_help_all() {
        let chunks = 1000;
        let mut found: Vec<u64> = Vec::new();
        for number in 0..20 {
            // All chunks have hints of dead attempts.
            let (mut chooser, mut looks) = (ChunkChooser::new(Shard { number, of: 1_000_000 }, chunks), 0);
            let mut next = || {
                chooser.choose(|_, lookup| {
                    looks += u64::from(lookup == Lookup::Single);
                    Ok::<_, Infallible>(if lookup == Lookup::Folder { InProgress } else { Missing })
                })
            };
            // The own chunk comes first, without a check of its hint.
            while let Ok(Choice::Compute(chunk)) = next() {
                found.push(chunk);
            }
            assert!(looks <= MAX_HINT_CHECKS + 1, "{looks}");
        }
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len() as u64, chunks);
    }

    #[test]
    fn a_look_that_fails_loses_nothing() {
        let mut chooser = ChunkChooser::new(Shard { number: 0, of: 1 }, 1);
        assert_eq!(chooser.choose(|_, _| Err::<ChunkState, _>("away")), Err("away"));
        assert_eq!(chosen(&mut chooser, &[Missing]), Choice::Compute(0));
    }
}
