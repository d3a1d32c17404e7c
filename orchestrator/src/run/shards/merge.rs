//! From the chunks of all shards to the tables, byte for byte those that one machine would have written with the same basis.
//!
//! One chunk at a time is in memory, and a row group. Every entry is checked: its checksum, its key, and that its chunk comes from this
//! directory's program, numerics, basis and study. What is damaged is put aside, so that it is missing and computed again.

use super::super::checksums::refuse_changed;
use super::super::curves::forget_answers;
use super::super::directory::{MANIFEST, RESULTS, TIMINGS};
use super::super::error::RunError;
use super::super::manifest::{Checksums, Course, manifest, tells_complete};
use super::super::prepare::Prepared;
use super::super::request::Request;
use super::super::status::StatusWriter;
use super::super::tables::{RowsWriter, is_current, tally};
use super::chunk::{Chunk, ChunkError, read};
use super::error::ShardError;
use super::frozen::Frozen;
use super::layout::{CHUNKS, PER_FOLDER, chunk_name, folder_name, folder_of};
use super::shared::Shared;
use crate::dispatch::Ended;
use crate::report::Tally;
use crate::schedule::RunLimits;
use bladeoff_answers::tables::start_threads;
use bladeoff_study::Samples;
use bladeoff_system::files::{FileError, Pending, unguessable, write_whole};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Ranges of missing chunks that are listed.
const SHOWN: usize = 20;

/// What came of a merge.
#[derive(Debug)]
pub struct Merged {
    /// The study, as it is frozen in the directory.
    pub samples: Samples,
    /// What became of its samples.
    pub tally: Tally,
    /// The table.
    pub table: PathBuf,
    /// Its chunks.
    pub chunks: u64,
    /// Attempts that have published some of them.
    pub attempts: u64,
    /// Nodes that they were on.
    pub nodes: u64,
}

/// Merges a directory of shards; `trusts`: also one that others could write in.
///
/// # Errors
/// [`ShardError::Missing`] where chunks are missing or damaged; files.
pub fn merge(path: &Path, trusts: bool, note: &dyn Fn(&str)) -> Result<Merged, ShardError> {
    start_threads().map_err(RunError::from)?;
    let shared = Shared::open(path)?.ok_or_else(|| ShardError::None { path: path.to_path_buf() })?;
    shared.trusted(trusts, note)?;
    let frozen = Frozen::read(&shared)?.ok_or_else(|| ShardError::None { path: path.to_path_buf() })?;
    refuse_missing(&shared, &frozen)?;
    let samples = frozen.samples(&shared)?;
    let prepared = frozen.prepared(&shared, &samples)?;
    let mut merging = Merging {
        shared: &shared,
        frozen: &frozen,
        prepared: &prepared,
        made: BTreeMap::new(),
        tally: Tally::default(),
    };
    let manifest_place = shared.folder().place(MANIFEST);
    let is_there = is_current(path, RESULTS, &prepared.provenance)
        && refuse_changed(path).is_ok_and(|is_known| is_known)
        && tells_complete(&manifest_place);
    if is_there {
        note("merged already: the table is as it was written");
        let tally = tally(path)?;
        let (attempts, nodes) = (0, 0);
        drop(prepared);
        return Ok(Merged {
            tally,
            table: path.join(RESULTS),
            chunks: frozen.chunks.count(),
            attempts,
            nodes,
            samples,
        });
    }
    let begun = Course { started: SystemTime::now(), ..Course::begun(0) };
    let tables = merging.write(note)?;
    let course = Course {
        state: Ended::Complete.word(),
        finished: Some(SystemTime::now()),
        done: samples.count(),
        tables,
        ..begun
    };
    let text = merging.manifest(path, &course);
    write_whole(&manifest_place, text.as_bytes())?;
    StatusWriter::new(shared.folder(), &samples, 0).trusting(trusts).finish("complete", None, &merging.tally);
    let Merging { made, tally, .. } = merging;
    let nodes =
        made.values().map(|made| made.by["host"].to_string()).collect::<std::collections::BTreeSet<_>>().len() as u64;
    let attempts = made.len() as u64;
    drop(prepared);
    Ok(Merged { tally, table: path.join(RESULTS), chunks: frozen.chunks.count(), attempts, nodes, samples })
}

/// What one attempt has published.
struct Made {
    by: Value,
    chunks: u64,
    samples: u64,
}

struct Merging<'a> {
    shared: &'a Shared,
    frozen: &'a Frozen,
    prepared: &'a Prepared<'a>,
    made: BTreeMap<String, Made>,
    tally: Tally,
}

impl Merging<'_> {
    fn write(&mut self, note: &dyn Fn(&str)) -> Result<Checksums, ShardError> {
        let folder = self.shared.folder();
        let pending = |name: &str| Pending::create(folder.place(name));
        let mut rows = RowsWriter::create(self.prepared, pending(RESULTS)?, pending(TIMINGS)?, &[])?;
        let mut damaged = Vec::new();
        for chunk in 0..self.frozen.chunks.count() {
            match self.read(chunk) {
                Ok(found) if damaged.is_empty() => {
                    self.count(&found);
                    for (sample, entry) in self.frozen.chunks.range(chunk).zip(found.entries) {
                        rows.push(sample, entry)?;
                    }
                }
                Ok(_) => {}
                Err(error) => {
                    self.put_aside(chunk, error, note)?;
                    damaged.push(chunk);
                }
            }
        }
        if !damaged.is_empty() {
            return Err(missing(self.shared, self.frozen, &damaged));
        }
        forget_answers(folder)?;
        Ok(rows.finish()?)
    }

    fn read(&self, chunk: u64) -> Result<Chunk, ChunkError> {
        match self.shared.chunks_in(folder_of(chunk)) {
            Ok(Some(folder)) => read(&folder, self.frozen, self.prepared, chunk),
            Ok(None) => Err(ChunkError::Missing),
            Err(error) => Err(ChunkError::Io(error)),
        }
    }

    fn count(&mut self, chunk: &Chunk) {
        chunk.entries.iter().for_each(|entry| self.tally.add(&entry.outcome));
        let attempt = chunk.by["attempt"].as_str().unwrap_or_default().to_owned();
        let made = self.made.entry(attempt).or_insert_with(|| Made { by: chunk.by.clone(), chunks: 0, samples: 0 });
        made.chunks += 1;
        made.samples += chunk.entries.len() as u64;
    }

    /// Takes the name from a chunk that is not one, so that it is computed again.
    fn put_aside(&self, chunk: u64, error: ChunkError, note: &dyn Fn(&str)) -> Result<(), ShardError> {
        let place = || -> Result<_, FileError> {
            let number = folder_of(chunk);
            let folder = self.shared.numbered(CHUNKS, number)?;
            Ok(folder.place(chunk_name(chunk)))
        };
        match error {
            ChunkError::Missing => Ok(()),
            ChunkError::Io(source) => {
                let path = self.shared.path().join(CHUNKS).join(folder_name(folder_of(chunk)));
                Err(FileError::at("read", &path.join(chunk_name(chunk)))(source).into())
            }
            ChunkError::Version(_) => {
                let path = self.shared.path().join(CHUNKS).join(chunk_name(chunk));
                Err(ShardError::Damaged { path, why: error.to_string() })
            }
            error => {
                let place = place()?;
                let aside = place.with_suffix(&format!(".damaged-{}", unguessable()));
                place.rename_to_free(&aside).map_err(FileError::at("rename", &place))?;
                place.sync_parent()?;
                note(&format!("chunk {chunk} is put aside as {aside}: {error}"));
                Ok(())
            }
        }
    }

    /// The manifest of a run, with what the shards were instead of workers.
    fn manifest(&self, path: &Path, course: &Course) -> String {
        let study = self.prepared.samples.study();
        let request = Request {
            out: path.to_path_buf(),
            trusts: false,
            workers: 0,
            sample: study.limits.sample,
            limits: RunLimits::default(),
            json_events: false,
            rerun: None,
            refresh: Duration::ZERO,
        };
        let text = manifest(&request, self.prepared.samples, &self.prepared.provenance, course);
        let mut value: Map<String, Value> = serde_json::from_str(&text).expect("an object, written just now");
        value.remove("workers");
        let attempts = self.made.values().map(|made| {
            let mut one = made.by.as_object().cloned().unwrap_or_default();
            one.insert("chunks".to_owned(), json!(made.chunks));
            one.insert("samples".to_owned(), json!(made.samples));
            Value::Object(one)
        });
        let shards = json!({
            "shards_blake3": self.frozen.hash,
            "program": self.frozen.program(),
            "chunk": self.frozen.chunks.size(),
            "chunks": self.frozen.chunks.count(),
            "attempts": attempts.collect::<Vec<_>>(),
        });
        value.insert("shards".to_owned(), shards);
        let mut text = serde_json::to_string_pretty(&value).expect("strings and numbers always have a JSON form");
        text.push('\n');
        text
    }
}

/// Refuses a directory in which chunks have no file, by its folders alone.
fn refuse_missing(shared: &Shared, frozen: &Frozen) -> Result<(), ShardError> {
    let mut absent = Vec::new();
    each_missing(shared, frozen, |chunk| absent.push(chunk))?;
    if absent.is_empty() { Ok(()) } else { Err(missing(shared, frozen, &absent)) }
}

/// Every chunk that has no file, in ascending order; gives how many have one.
pub(super) fn each_missing(shared: &Shared, frozen: &Frozen, mut visit: impl FnMut(u64)) -> Result<u64, FileError> {
    let count = frozen.chunks.count();
    let mut there = 0;
    for folder in frozen.chunks.folders() {
        let names = shared.names_in(folder)?;
        let first = folder * PER_FOLDER;
        for chunk in first..(first + PER_FOLDER).min(count) {
            if names.contains(&chunk) {
                there += 1;
            } else {
                visit(chunk);
            }
        }
    }
    Ok(there)
}

fn missing(shared: &Shared, frozen: &Frozen, chunks: &[u64]) -> ShardError {
    ShardError::Missing {
        path: shared.path().to_path_buf(),
        missing: chunks.len() as u64,
        total: frozen.chunks.count(),
        list: in_words(chunks),
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
    fn missing_chunks_are_told_as_ranges() {
        assert_eq!(in_words(&[0, 1, 2, 3, 7, 9, 10]), "0-3, 7, 9-10");
        let every_second: Vec<u64> = (0..30).map(|number| 2 * number).collect();
        assert!(in_words(&every_second).ends_with("36, 38 and 10 more"), "{}", in_words(&every_second));
    }
}
