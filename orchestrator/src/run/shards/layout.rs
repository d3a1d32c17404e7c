//! Chunks of samples, shards of chunks, and file names: pure functions.

use std::ffi::OsStr;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// File that begins and identifies a directory of shards.
pub const SHARDS: &str = "shards.json";
/// Folder of published chunks.
pub const CHUNKS: &str = "chunks";
/// Folder of hints, which name the attempt that computes a chunk.
pub const HINTS: &str = "hints";
/// Folder of the heartbeat files of attempts.
pub const ATTEMPTS: &str = "attempts";
/// Folder of reused entries of incomplete chunks.
pub const REUSED: &str = "reused";
/// Folder of the scripts that `submit` writes.
pub const SCHEDULER: &str = "scheduler";

/// Number of chunks per folder.
pub const PER_FOLDER: u64 = 1000;
/// Largest number of samples of a chunk, which is held in memory as a whole.
pub const MOST_OF_CHUNK: u64 = 65_536;
/// Largest number of chunks of a study: a thousand folders of a thousand.
pub const MOST_CHUNKS: u64 = 1_000_000;
/// Largest number of shards.
pub const MOST_SHARDS: u64 = 100_000;

/// Chunks of equal length; the last one may be shorter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chunks {
    samples: u64,
    size: u64,
}

impl Chunks {
    /// Creates the chunks of a study; `size`: samples of a chunk, at least 1.
    #[must_use]
    pub fn new(samples: u64, size: u64) -> Self {
        Self { samples, size: size.max(1) }
    }

    /// Samples of a chunk.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Samples of the study.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Number of chunks.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.samples.div_ceil(self.size)
    }

    /// Range of the samples of a chunk.
    #[must_use]
    pub fn range(&self, chunk: u64) -> Range<u64> {
        let first = chunk * self.size;
        first..(first + self.size).min(self.samples)
    }

    /// Chunk that contains a sample.
    #[must_use]
    pub fn of(&self, sample: u64) -> u64 {
        sample / self.size
    }

    /// Chunks of the first `last` samples, the latest end by `[stop]`.
    #[must_use]
    pub fn up_to(&self, last: u64) -> Self {
        Self {
            samples: last.clamp(1, self.samples).div_ceil(self.size).saturating_mul(self.size).min(self.samples),
            ..*self
        }
    }

    /// Numbers of the folders with chunks.
    #[must_use]
    pub fn folders(&self) -> Range<u64> {
        0..self.count().div_ceil(PER_FOLDER)
    }
}

/// Number of the folder of a chunk.
#[must_use]
pub fn folder_of(chunk: u64) -> u64 {
    chunk / PER_FOLDER
}

/// Name of a folder of chunks.
#[must_use]
pub fn folder_name(folder: u64) -> String {
    format!("{folder:03}")
}

/// Name of a chunk's file.
#[must_use]
pub fn chunk_name(chunk: u64) -> String {
    format!("chunk-{chunk:06}.bin")
}

/// Name of a chunk's hint.
#[must_use]
pub fn hint_name(chunk: u64) -> String {
    format!("chunk-{chunk:06}")
}

/// Chunk whose file has this name.
#[must_use]
pub fn chunk_of(name: &OsStr) -> Option<u64> {
    let number = name.to_str()?.strip_prefix("chunk-")?.strip_suffix(".bin")?.parse().ok()?;
    (*chunk_name(number) == *name).then_some(number)
}

/// Chunk whose hint has this name.
#[must_use]
pub fn hinted(name: &OsStr) -> Option<u64> {
    let number = name.to_str()?.strip_prefix("chunk-")?.parse().ok()?;
    (*hint_name(number) == *name).then_some(number)
}

/// Shard `number` of `of`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number, from 0.
    pub number: u64,
    /// Number of shards.
    pub of: u64,
}

impl Shard {
    /// Whether a chunk belongs to this shard.
    #[must_use]
    pub fn owns(&self, chunk: u64) -> bool {
        chunk % self.of == self.number
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || format!("must be I/N, such as 0/16: 0 <= I < N, N at most {MOST_SHARDS}");
        let (number, of) = text.split_once('/').ok_or_else(wanted)?;
        let shard = Self { number: number.parse().map_err(|_| wanted())?, of: of.parse().map_err(|_| wanted())? };
        if shard.number < shard.of && shard.of <= MOST_SHARDS { Ok(shard) } else { Err(wanted()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_sample_is_in_one_chunk_and_every_chunk_of_one_shard(samples in 1u64..5000, size in 1u64..700, of in 1u64..40, last in 1u64..6000) {
            let chunks = Chunks::new(samples, size);
            let all: Vec<u64> = (0..chunks.count()).flat_map(|chunk| chunks.range(chunk)).collect();
            prop_assert!(all.iter().copied().eq(0..samples));
            prop_assert!(all.iter().all(|sample| chunks.range(chunks.of(*sample)).contains(sample)));
            let part = chunks.up_to(last);
            prop_assert!((last.min(samples)..=samples).contains(&part.samples()));
            prop_assert_eq!(part.count(), chunks.of(last.min(samples) - 1) + 1);
            prop_assert_eq!(part.range(part.count() - 1), chunks.range(part.count() - 1));
            for chunk in 0..chunks.count() {
                prop_assert_eq!((0..of).filter(|number| Shard { number: *number, of }.owns(chunk)).count(), 1);
                prop_assert!(chunks.folders().contains(&folder_of(chunk)));
            }
        }
    }

    #[test]
    fn names_and_words_are_read_back_and_others_are_none() {
        for chunk in [0, 999, 1_000_000, 12_345_678] {
            assert_eq!(chunk_of(OsStr::new(&chunk_name(chunk))), Some(chunk));
            assert_eq!(hinted(OsStr::new(&hint_name(chunk))), Some(chunk));
        }
        for name in ["chunk-1.bin", "chunk-000001.bin.0123abcd.tmp", "chunk-000001", "chunk-+00001.bin", "x"] {
            assert_eq!(chunk_of(OsStr::new(name)), None, "{name}");
        }
        assert_eq!("3/16".parse(), Ok(Shard { number: 3, of: 16 }));
        for text in ["16/16", "3", "-1/4", "a/b", "1/0", "0/100001", "1/2/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
