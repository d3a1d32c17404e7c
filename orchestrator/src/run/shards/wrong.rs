//! What is wrong with the chunks of a directory that is merged: all of it told at once, with counts and the first of each kind.

use super::chunk::ChunkError;
use super::error::ShardError;
use super::frozen::Frozen;
use super::shared::Shared;
use std::fmt;

/// Ranges of chunks that are listed.
pub(super) const SHOWN: usize = 20;
/// Keys of a chunk's head that say which samples are in it.
const PLACE: [&str; 3] = ["chunk", "first", "samples"];

/// Why a chunk that has a file was put aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Damaged,
    Foreign,
    Doubled,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Damaged, Self::Foreign, Self::Doubled];

    fn of(error: &ChunkError) -> Self {
        match error {
            ChunkError::Other { key, .. } if PLACE.contains(&key.as_str()) => Self::Doubled,
            ChunkError::Other { .. } => Self::Foreign,
            ChunkError::Missing
            | ChunkError::Damaged(_)
            | ChunkError::Version(_)
            | ChunkError::Record { .. }
            | ChunkError::Io(_) => Self::Damaged,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Damaged => "damaged",
            Self::Foreign => "of another study, program or basis",
            Self::Doubled => "with samples of another chunk, which would be there twice",
        }
    }
}

/// What is wrong, by chunk.
#[derive(Debug, Default)]
pub(super) struct Wrong {
    /// Chunks that have no file.
    absent: Vec<u64>,
    /// Those that had one, and what was wrong with it.
    aside: Vec<(u64, Kind, String)>,
}

impl Wrong {
    /// These chunks are not there, and nothing is known of others.
    pub fn absent(absent: Vec<u64>) -> Self {
        Self { absent, aside: Vec::new() }
    }

    /// A chunk was not what it should be.
    pub fn was(&mut self, chunk: u64, error: &ChunkError) {
        match error {
            ChunkError::Missing => self.absent.push(chunk),
            error => self.aside.push((chunk, Kind::of(error), error.to_string())),
        }
    }

    /// Whether every chunk was as it should be.
    pub fn is_nothing(&self) -> bool {
        self.absent.is_empty() && self.aside.is_empty()
    }

    /// Chunks that were put aside so far.
    pub fn aside(&self) -> usize {
        self.aside.len()
    }

    /// As why there is no table.
    pub fn told(&self, shared: &Shared, frozen: &Frozen) -> ShardError {
        let mut missing: Vec<u64> =
            self.absent.iter().copied().chain(self.aside.iter().map(|(chunk, ..)| *chunk)).collect();
        missing.sort_unstable();
        ShardError::Missing {
            path: shared.path().to_path_buf(),
            missing: missing.len() as u64,
            total: frozen.chunks.count(),
            list: in_words(&missing),
            aside: self.to_string(),
        }
    }
}

/// A line for each kind of what was put aside; nothing where nothing was.
impl fmt::Display for Wrong {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for kind in Kind::ALL {
            let mut chunks: Vec<u64> = Vec::new();
            let mut first = None;
            for (chunk, _, why) in self.aside.iter().filter(|(_, found, _)| *found == kind) {
                chunks.push(*chunk);
                first = first.or(Some((chunk, why)));
            }
            chunks.sort_unstable();
            if let Some((chunk, why)) = first {
                let (count, list) = (chunks.len(), in_words(&chunks));
                write!(out, "\n  {count} put aside, {}: {list} (chunk {chunk}: {why})", kind.words())?;
            }
        }
        Ok(())
    }
}

/// Ascending numbers as ranges: "0-3, 7, 9-10"; of many the first.
pub(super) fn in_words(chunks: &[u64]) -> String {
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    for &chunk in chunks {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == chunk => *last = chunk,
            _ => ranges.push((chunk, chunk)),
        }
    }
    let word = |(first, last): &(u64, u64)| if first == last { first.to_string() } else { format!("{first}-{last}") };
    let words: Vec<String> = ranges.iter().take(SHOWN).map(word).collect();
    if ranges.len() > SHOWN {
        let more: u64 = ranges[SHOWN..].iter().map(|(first, last)| last - first + 1).sum();
        return format!("{} and {more} more", words.join(", "));
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_aside_is_told_by_kind_with_counts_and_the_first_of_each() {
        let other =
            |key: &str| ChunkError::Other { key: key.to_owned(), found: "3".to_owned(), wanted: "7".to_owned() };
        let mut wrong = Wrong::default();
        assert!(wrong.is_nothing() && wrong.to_string().is_empty());
        wrong.was(1, &ChunkError::Missing);
        for chunk in 40..90 {
            wrong.was(chunk, &other("numerics"));
        }
        wrong.was(7, &other("chunk"));
        wrong.was(9, &ChunkError::Damaged("it is cut off"));
        assert_eq!(
            wrong.to_string(),
            "\n  1 put aside, damaged: 9 (chunk 9: damaged: it is cut off)\n  50 put aside, of another study, program or basis: 40-89 \
             (chunk 40: of another study, program or chunk: numerics is 3, not 7)\n  1 put aside, with samples of another chunk, which \
             would be there twice: 7 (chunk 7: of another study, program or chunk: chunk is 3, not 7)"
        );
        assert_eq!((wrong.aside(), wrong.is_nothing()), (52, false));
    }

    #[test]
    fn missing_chunks_are_told_as_ranges() {
        assert_eq!(in_words(&[0, 1, 2, 3, 7, 9, 10]), "0-3, 7, 9-10");
        let every_second: Vec<u64> = (0..30).map(|number| 2 * number).collect();
        assert!(in_words(&every_second).ends_with("36, 38 and 10 more"), "{}", in_words(&every_second));
    }
}
