//! Which chunk a shard takes next: a state machine that neither reads nor waits.
//!
//! ```text
//! 1  its own, in their order; what is there is passed over, what others are at is put off
//! 2  its own that were put off, until they are there or nobody is at them any more
//! 3  those of others that are missing, from the far end; those with a hint are passed over, whoever has put it
//! 4  some of these: whether who has put the hint lives
//! ```
//! Of ten thousand who help none may look closely at all that others are at: by two lists a folder they see who has put hints, and each looks
//! at [`MOST_LOOKED`] of these, others than his neighbours.
//! It waits for its own alone: whoever else's is being computed has somebody who waits for it. So no chunk is left out as long as one
//! attempt at its shard lives, and no node waits for others at the end.

use super::layout::Shard;
use std::collections::VecDeque;

/// Chunks with a hint of somebody else that one attempt looks at closely.
const MOST_LOOKED: u64 = 64;

/// How a chunk is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// Whether it is there, and whether who has put a hint lives.
    Closely,
    /// With its whole folder: taken if it has a hint, of whomever. What seems to be missing is looked at closely.
    Listed,
}

/// What is known of a chunk at this moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Published.
    There,
    /// Somebody else is at it.
    Taken,
    /// Neither.
    Missing,
}

/// What to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// Compute this one.
    Take(u64),
    /// Others are at what is left of the own: look again.
    Wait,
    /// Nothing is left to do here.
    Nothing,
}

/// Chooses for one attempt.
#[derive(Debug, Clone)]
pub(super) struct Chooser {
    shard: Shard,
    chunks: u64,
    /// The next of its own.
    next: u64,
    /// Its own that others are at.
    put_off: VecDeque<u64>,
    /// The next from the far end, plus one.
    far: u64,
    /// Those with a hint, from the far end.
    hinted: Vec<u64>,
    /// How many of these were looked at.
    looked: u64,
}

impl Chooser {
    /// `chunks`: how many there are.
    pub fn new(shard: Shard, chunks: u64) -> Self {
        Self { shard, chunks, next: shard.number, put_off: VecDeque::new(), far: chunks, hinted: Vec::new(), looked: 0 }
    }

    /// The next one. `state`: looks at a chunk; asked of few of them.
    pub fn choose<E>(&mut self, mut state: impl FnMut(u64, Look) -> Result<State, E>) -> Result<Choice, E> {
        while self.next < self.chunks {
            let chunk = self.next;
            let found = state(chunk, Look::Closely)?;
            self.next += self.shard.of;
            match found {
                State::There => {}
                State::Taken => self.put_off.push_back(chunk),
                State::Missing => return Ok(Choice::Take(chunk)),
            }
        }
        for _ in 0..self.put_off.len() {
            let Some(&chunk) = self.put_off.front() else { break };
            let found = state(chunk, Look::Closely)?;
            self.put_off.pop_front();
            match found {
                State::There => {}
                State::Taken => self.put_off.push_back(chunk),
                State::Missing => return Ok(Choice::Take(chunk)),
            }
        }
        while self.far > 0 {
            let chunk = self.far - 1;
            let found = if self.shard.owns(chunk) { State::There } else { state(chunk, Look::Listed)? };
            self.far = chunk;
            match found {
                State::There => {}
                State::Taken => self.hinted.push(chunk),
                State::Missing => return Ok(Choice::Take(chunk)),
            }
        }
        let all = self.hinted.len() as u64;
        while self.looked < all.min(MOST_LOOKED) {
            let place = (self.shard.number.wrapping_mul(MOST_LOOKED) + self.looked) % all;
            let chunk = self.hinted[usize::try_from(place).expect("a place in memory")];
            let found = state(chunk, Look::Closely)?;
            self.looked += 1;
            if found == State::Missing {
                return Ok(Choice::Take(chunk));
            }
        }
        Ok(if self.put_off.is_empty() { Choice::Nothing } else { Choice::Wait })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use State::{Missing, Taken, There};
    use std::convert::Infallible;

    fn chosen(chooser: &mut Chooser, states: &[State]) -> Choice {
        chooser.choose(|chunk, _| Ok::<_, Infallible>(states[chunk as usize])).expect("no error")
    }

    #[test]
    fn own_chunks_come_first_then_those_of_others_from_the_far_end() {
        let mut chooser = Chooser::new(Shard { number: 1, of: 3 }, 8);
        let mut states = [Missing; 8];
        states[4] = There;
        let mut taken = Vec::new();
        while let Choice::Take(chunk) = chosen(&mut chooser, &states) {
            states[chunk as usize] = There;
            taken.push(chunk);
        }
        assert_eq!(taken, [1, 7, 6, 5, 3, 2, 0]);
        assert_eq!(chosen(&mut chooser, &states), Choice::Nothing);
    }

    #[test]
    fn own_chunks_that_others_are_at_are_waited_for_and_those_of_others_are_not() {
        let mut chooser = Chooser::new(Shard { number: 0, of: 2 }, 4);
        let mut states = [Taken, Taken, Missing, Taken];
        assert_eq!(chosen(&mut chooser, &states), Choice::Take(2));
        assert_eq!(chosen(&mut chooser, &states), Choice::Wait);
        states[0] = Missing;
        assert_eq!(chosen(&mut chooser, &states), Choice::Take(0), "whoever was at it is gone");
        assert_eq!(chosen(&mut chooser, &states), Choice::Nothing, "1 and 3 have their own shard");
    }

    #[test]
    fn of_many_with_a_hint_some_are_looked_at_and_by_all_who_help_all() {
        let chunks = 1000;
        let mut found: Vec<u64> = Vec::new();
        for number in 0..20 {
            // All have a hint; who has put it is dead.
            let (mut chooser, mut looks) = (Chooser::new(Shard { number, of: 1_000_000 }, chunks), 0);
            let mut next = || {
                chooser.choose(|_, look| {
                    looks += u64::from(look == Look::Closely);
                    Ok::<_, Infallible>(if look == Look::Listed { Taken } else { Missing })
                })
            };
            // Its own one comes first, without a hint.
            while let Ok(Choice::Take(chunk)) = next() {
                found.push(chunk);
            }
            assert!(looks <= MOST_LOOKED + 1, "{looks}");
        }
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len() as u64, chunks);
    }

    #[test]
    fn a_look_that_fails_loses_nothing() {
        let mut chooser = Chooser::new(Shard { number: 0, of: 1 }, 1);
        assert_eq!(chooser.choose(|_, _| Err::<State, _>("away")), Err("away"));
        assert_eq!(chosen(&mut chooser, &[Missing]), Choice::Take(0));
    }
}
