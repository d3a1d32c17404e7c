//! Missing and rejected chunks of a merge, reported together: counts, and the first chunk of each kind.

use super::chunk::ChunkError;
use super::error::ShardError;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use std::fmt;

/// Largest number of listed ranges.
pub(super) const SHOWN: usize = 20;
/// Keys of a chunk's head that name its samples.
const PLACE: [&str; 3] = ["chunk", "first", "samples"];

/// Reason why a chunk file was set aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Damaged,
    Foreign,
    Duplicate,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Damaged, Self::Foreign, Self::Duplicate];

    fn of(error: &ChunkError) -> Self {
        match error {
            ChunkError::Other { key, .. } if PLACE.contains(&key.as_str()) => Self::Duplicate,
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
            Self::Duplicate => "with samples of another chunk, which would then exist twice",
        }
    }
}

/// Missing and rejected chunks.
#[derive(Debug, Default)]
pub(super) struct ChunkProblems {
    /// Chunks without a file.
    missing: Vec<u64>,
    /// Chunks whose file was set aside, with the reason.
    set_aside: Vec<(u64, Kind, String)>,
}

impl ChunkProblems {
    /// Missing chunks alone.
    pub fn missing(missing: Vec<u64>) -> Self {
        Self { missing, set_aside: Vec::new() }
    }

    /// Adds a chunk that could not be read.
    pub fn add(&mut self, chunk: u64, error: &ChunkError) {
        match error {
            ChunkError::Missing => self.missing.push(chunk),
            error => self.set_aside.push((chunk, Kind::of(error), error.to_string())),
        }
    }

    /// Whether all chunks were valid.
    pub fn is_empty(&self) -> bool {
        self.missing.is_empty() && self.set_aside.is_empty()
    }

    /// Number of chunks set aside.
    pub fn set_aside(&self) -> usize {
        self.set_aside.len()
    }

    /// Converts the problems to the error of the merge.
    pub fn into_error(self, shared: &Shared, shards_file: &ShardsFile) -> ShardError {
        let mut missing: Vec<u64> =
            self.missing.iter().copied().chain(self.set_aside.iter().map(|(chunk, ..)| *chunk)).collect();
        missing.sort_unstable();
        ShardError::Missing {
            path: shared.path().to_path_buf(),
            missing: missing.len() as u64,
            total: shards_file.chunks.count(),
            list: in_words(&missing),
            aside: self.to_string(),
        }
    }
}

/// Prints one line per kind of rejected chunk.
impl fmt::Display for ChunkProblems {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for kind in Kind::ALL {
            let mut chunks: Vec<u64> = Vec::new();
            let mut first = None;
            for (chunk, _, why) in self.set_aside.iter().filter(|(_, found, _)| *found == kind) {
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

/// Formats ascending numbers as ranges: "0-3, 7, 9-10"; long lists are cut.
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
        let mut problems = ChunkProblems::default();
        assert!(problems.is_empty() && problems.to_string().is_empty());
        problems.add(1, &ChunkError::Missing);
        for chunk in 40..90 {
            problems.add(chunk, &other("numerics"));
        }
        problems.add(7, &other("chunk"));
        problems.add(9, &ChunkError::Damaged("it is cut off"));
        assert_eq!(
            problems.to_string(),
            "\n  1 put aside, damaged: 9 (chunk 9: damaged: it is cut off)\n  50 put aside, of another study, program or basis: 40-89 \
             (chunk 40: of another study, program or chunk: numerics is 3, not 7)\n  1 put aside, with samples of \
             another chunk, which would then exist twice: 7 (chunk 7: of another study, program or chunk: chunk is 3, \
             not 7)"
        );
        assert_eq!((problems.set_aside(), problems.is_empty()), (52, false));
    }

    #[test]
    fn missing_chunks_are_told_as_ranges() {
        assert_eq!(in_words(&[0, 1, 2, 3, 7, 9, 10]), "0-3, 7, 9-10");
        let every_second: Vec<u64> = (0..30).map(|number| 2 * number).collect();
        assert!(in_words(&every_second).ends_with("36, 38 and 10 more"), "{}", in_words(&every_second));
    }
}
