//! From the chunks of all shards to the tables, byte for byte those that one machine would have written with the same basis.
//!
//! One chunk at a time is in memory, and a row group. Every entry is checked: its checksum, its key, and that its chunk comes from this
//! directory's program, numerics, basis and study. What is damaged is put aside, so that it is missing and computed again.

use super::super::checksums::refuse_changed;
use super::super::curves::forget_answers;
use super::super::directory::{MANIFEST, RESULTS, TIMINGS};
use super::super::end::{Looking, TableEnd, end_of_table};
use super::super::error::RunError;
use super::super::manifest::{Checksums, Course, manifest, tells_complete};
use super::super::prepare::Prepared;
use super::super::request::Request;
use super::super::status::StatusWriter;
use super::super::tables::{RowsWriter, is_current, tally, told};
use super::chunk::{Chunk, ChunkError, read};
use super::error::ShardError;
use super::freeze::prepared;
use super::frozen::Frozen;
use super::layout::{CHUNKS, Chunks, PER_FOLDER, chunk_name, folder_name, folder_of};
use super::leftovers::{self, Writing};
use super::shared::Shared;
use super::wrong::{SHOWN, Wrong};
use crate::dispatch::Ended;
use crate::schedule::RunLimits;
use crate::terminal::Tally;
use bladeoff_answers::tables::start_threads;
use bladeoff_study::Samples;
use bladeoff_system::files::{FileError, Pending, unguessable, write_whole};
use bladeoff_worker::fault::NoFaults;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Attempts that are listed in a manifest, which is read whole.
const LISTED: usize = 20_000;

/// What came of a merge.
#[derive(Debug)]
pub struct Merged {
    /// What became of the samples in the table.
    pub tally: Tally,
    /// Where the table ends, if that is not where the design does, or was looked at before.
    pub end: Option<TableEnd>,
    /// The table.
    pub table: PathBuf,
    /// Chunks that it is made of.
    pub chunks: u64,
    /// Attempts that have published them; none of a table that was there.
    pub attempts: u64,
    /// Nodes that they were on.
    pub nodes: u64,
}

/// Merges a directory of shards. `samples`: of the study that is frozen there; `looking`: where it may end before its design does; `trusts`:
/// also one that others could write in.
///
/// # Errors
/// [`ShardError::Missing`] where chunks are missing or damaged; files.
pub fn merge(
    path: &Path,
    trusts: bool,
    samples: &Samples,
    looking: Option<&dyn Looking>,
    note: &dyn Fn(&str),
) -> Result<Merged, ShardError> {
    start_threads().map_err(RunError::from)?;
    let shared = Shared::open(path)?.ok_or_else(|| ShardError::None { path: path.to_path_buf() })?;
    shared.trusted(trusts, note)?;
    let frozen = Frozen::read(&shared)?.ok_or_else(|| ShardError::None { path: path.to_path_buf() })?;
    leftovers::remove(&shared);
    let prepared = prepared(&shared, &frozen, samples)?;
    let mut merging = Merging {
        shared: &shared,
        frozen: &frozen,
        prepared: &prepared,
        made: BTreeMap::new(),
        tally: Tally::default(),
    };
    if looking.is_none() {
        merging.refuse_missing(note)?;
    }
    let (folder, table) = (shared.folder(), path.join(RESULTS));
    let is_there = is_current(path, RESULTS, &prepared.provenance)
        && refuse_changed(path).is_ok_and(|is_known| is_known)
        && tells_complete(&folder.place(MANIFEST));
    if is_there {
        note("merged already: the table is as it was written");
        let (tally, end) = (tally(path)?, end_of_table(&table)?);
        return Ok(Merged { tally, end, table, chunks: frozen.chunks.count(), attempts: 0, nodes: 0 });
    }
    // One that is there is damaged, or of a merge that was killed: nobody may take it for the whole.
    for name in [RESULTS, TIMINGS] {
        folder.place(name).remove()?;
    }
    let begun = Course { started: SystemTime::now(), ..Course::begun(0) };
    let end = looking.map_or(Ok(None), |looking| merging.end(looking, note))?;
    let tables = merging.write(end.as_ref(), note)?;
    let ended = if end.is_some_and(|end| end.is_early()) { Ended::Stop } else { Ended::Complete };
    let course = Course {
        state: ended.state(),
        ended: Some(ended.word()),
        end,
        finished: Some(SystemTime::now()),
        done: merging.tally.done(),
        tables,
        ..begun
    };
    let text = merging.manifest(path, &course);
    write_whole(folder.place(MANIFEST), text.as_bytes())?;
    let mut status = StatusWriter::new(folder, samples, 0).trusting(trusts);
    status.tell_end(ended, end);
    status.finish(ended.state(), None, &merging.tally, 0);
    let (attempts, nodes) = (merging.made.len() as u64, merging.nodes().len() as u64);
    let chunks = frozen.needed(end.map(|end| end.samples)).count();
    Ok(Merged { tally: merging.tally, end, table, chunks, attempts, nodes })
}

/// What one attempt has published.
struct Made {
    by: Value,
    chunks: u64,
    samples: u64,
}

/// A directory that is merged.
pub(super) struct Merging<'a> {
    pub(super) shared: &'a Shared,
    pub(super) frozen: &'a Frozen,
    pub(super) prepared: &'a Prepared<'a>,
    made: BTreeMap<String, Made>,
    tally: Tally,
}

impl Merging<'_> {
    fn write(&mut self, end: Option<&TableEnd>, note: &dyn Fn(&str)) -> Result<Checksums, ShardError> {
        let folder = self.shared.folder();
        let pending = |name: &str| Pending::create(folder.place(name));
        let (results, timings) = (pending(RESULTS)?, pending(TIMINGS)?);
        let _writing = Writing::begin(folder, &[results.temporary(), timings.temporary()])?;
        let mut rows = RowsWriter::create(self.prepared, results, timings, &told(end))?;
        let mut wrong = Wrong::default();
        let last = end.map_or(self.frozen.chunks.samples(), |end| end.samples);
        for chunk in 0..self.frozen.chunks.up_to(last).count() {
            match self.read(chunk) {
                Ok(found) if wrong.is_nothing() => {
                    let range = self.frozen.chunks.range(chunk);
                    let range = range.start..range.end.min(last);
                    self.count(&found.by, range.end - range.start);
                    for (sample, entry) in range.zip(found.entries) {
                        self.tally.add(&entry.outcome);
                        rows.push(sample, entry)?;
                    }
                }
                Ok(_) => {}
                Err(error) => self.put_aside(chunk, error, &mut wrong, note)?,
            }
        }
        if !wrong.is_nothing() {
            return Err(wrong.told(self.shared, self.frozen));
        }
        forget_answers(folder)?;
        Ok(rows.finish()?)
    }

    pub(super) fn read(&self, chunk: u64) -> Result<Chunk, ChunkError> {
        match self.shared.chunks_in(folder_of(chunk)) {
            Ok(Some(folder)) => read(&folder, self.frozen, self.prepared, chunk),
            Ok(None) => Err(ChunkError::Missing),
            Err(error) => Err(ChunkError::Io(error)),
        }
    }

    fn count(&mut self, by: &Value, samples: u64) {
        let attempt = by["attempt"].as_str().unwrap_or_default().to_owned();
        let made = self.made.entry(attempt).or_insert_with(|| Made { by: by.clone(), chunks: 0, samples: 0 });
        made.chunks += 1;
        made.samples += samples;
    }

    /// Refuses a directory in which chunks have no file, by its folders alone; before that it looks at all others, so that everything that is
    /// wrong is told, and computed again, at once.
    fn refuse_missing(&self, note: &dyn Fn(&str)) -> Result<(), ShardError> {
        let mut absent = BTreeSet::new();
        each_missing(self.shared, &self.frozen.chunks, |chunk| {
            absent.insert(chunk);
        })?;
        if absent.is_empty() {
            return Ok(());
        }
        let mut wrong = Wrong::default();
        for chunk in 0..self.frozen.chunks.count() {
            if absent.contains(&chunk) {
                wrong.was(chunk, &ChunkError::Missing);
            } else if let Err(error) = self.read(chunk) {
                self.put_aside(chunk, error, &mut wrong, note)?;
            }
        }
        Err(wrong.told(self.shared, self.frozen))
    }

    /// Takes the name from a chunk that is not one, so that it is computed again.
    pub(super) fn put_aside(
        &self,
        chunk: u64,
        error: ChunkError,
        wrong: &mut Wrong,
        note: &dyn Fn(&str),
    ) -> Result<(), ShardError> {
        wrong.was(chunk, &error);
        let place = || -> Result<_, FileError> {
            let number = folder_of(chunk);
            let folder = self.shared.numbered(CHUNKS, number)?;
            Ok(folder.place(chunk_name(chunk)))
        };
        match error {
            ChunkError::Missing => Ok(()),
            // a folder, a link, a pipe has the name of a chunk
            ChunkError::Io(source) if !place()?.is_there_but_no_file() => {
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
                // of many the first: the end tells of all
                if wrong.aside() <= SHOWN {
                    note(&format!("chunk {chunk} is put aside as {aside}: {error}"));
                }
                Ok(())
            }
        }
    }

    fn nodes(&self) -> BTreeSet<&str> {
        self.made.values().filter_map(|made| made.by["host"].as_str()).collect()
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
            begun: Instant::now(),
            json_events: false,
            rerun: None,
            looking: None,
            refining: None,
            refresh: Duration::ZERO,
            faults: &NoFaults,
        };
        let text = manifest(&request, self.prepared.samples, &self.prepared.provenance, course);
        let mut value: Map<String, Value> = serde_json::from_str(&text).expect("an object, written just now");
        value.remove("workers");
        let attempts = self.made.values().take(LISTED).map(|made| {
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
            "nodes": self.nodes().len(),
            "attempts_count": self.made.len(),
            "attempts": attempts.collect::<Vec<_>>(),
        });
        value.insert("shards".to_owned(), shards);
        let mut text = serde_json::to_string_pretty(&value).expect("strings and numbers always have a JSON form");
        text.push('\n');
        text
    }
}

/// Every one of these chunks that has no file, in ascending order; gives how many have one.
pub(super) fn each_missing(shared: &Shared, chunks: &Chunks, mut visit: impl FnMut(u64)) -> Result<u64, FileError> {
    let count = chunks.count();
    let mut there = 0;
    for folder in chunks.folders() {
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
