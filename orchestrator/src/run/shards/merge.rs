//! Merge of all chunks into tables, byte for byte those of one machine with the same basis.
//!
//! One chunk and one row group are in memory at a time. Checksum, key and origin of every entry are checked. Damaged chunks are
//! set aside, so that they are missing and computed again.

use super::super::checksums::refuse_changed;
use super::super::curves::forget_answers;
use super::super::directory::{MANIFEST, RESULTS, TIMINGS};
use super::super::end::{PrecisionCheck, TableEnd, end_of_table};
use super::super::error::RunError;
use super::super::manifest::{Checksums, Course, manifest, tells_complete};
use super::super::prepare::Prepared;
use super::super::request::Request;
use super::super::so_far::Watched;
use super::super::status::StatusWriter;
use super::super::tables::{RowsWriter, end_metadata, is_current, tally};
use super::chunk::{Chunk, ChunkError, read};
use super::chunk_problems::{ChunkProblems, SHOWN};
use super::error::ShardError;
use super::freeze::prepared;
use super::layout::{CHUNKS, Chunks, PER_FOLDER, chunk_name, folder_name, folder_of};
use super::leftovers::{self, MergeNote};
use super::shards_file::ShardsFile;
use super::shared::Shared;
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

/// Largest number of attempts listed in a manifest.
const LISTED: usize = 20_000;

/// Result of a merge.
#[derive(Debug)]
pub struct Merged {
    /// Counts of the table's samples by status.
    pub tally: Tally,
    /// End of the table, if it is not the end of the design or interim analyses were made.
    pub end: Option<TableEnd>,
    /// Path of the table.
    pub table: PathBuf,
    /// Number of merged chunks.
    pub chunks: u64,
    /// Number of attempts that published them; 0 for an existing table.
    pub attempts: u64,
    /// Number of their nodes.
    pub nodes: u64,
}

/// Merges a directory of shards. `samples`: samples of the frozen study; `looking`: interim analyses that may end the study
/// early; `trusts`: also accept a directory to which other users may write.
///
/// # Errors
/// [`ShardError::Missing`] where chunks are missing or damaged; files.
pub fn merge(
    path: &Path,
    trusts: bool,
    samples: &Samples,
    looking: Option<&dyn PrecisionCheck>,
    note: &dyn Fn(&str),
) -> Result<Merged, ShardError> {
    start_threads().map_err(RunError::from)?;
    let shared = Shared::open(path)?.ok_or_else(|| ShardError::None { path: path.to_path_buf() })?;
    shared.trusted(trusts, note)?;
    let shards_file = ShardsFile::read(&shared)?.ok_or_else(|| ShardError::None { path: path.to_path_buf() })?;
    leftovers::remove(&shared);
    let prepared = prepared(&shared, &shards_file, samples)?;
    let mut merging = Merging {
        shared: &shared,
        shards_file: &shards_file,
        prepared: &prepared,
        shares: BTreeMap::new(),
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
        note("already merged: the table has not changed since");
        let (tally, end) = (tally(path)?, end_of_table(&table)?);
        return Ok(Merged { tally, end, table, chunks: shards_file.chunks.count(), attempts: 0, nodes: 0 });
    }
    // An existing table is damaged or of a killed merge. It must not be taken for a whole one.
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
    let (attempts, nodes) = (merging.shares.len() as u64, merging.nodes().len() as u64);
    let chunks = shards_file.needed(end.map(|end| end.samples)).count();
    Ok(Merged { tally: merging.tally, end, table, chunks, attempts, nodes })
}

/// Chunks and samples of one attempt.
struct AttemptShare {
    by: Value,
    chunks: u64,
    samples: u64,
}

/// Merge in progress.
pub(super) struct Merging<'a> {
    pub(super) shared: &'a Shared,
    pub(super) shards_file: &'a ShardsFile,
    pub(super) prepared: &'a Prepared<'a>,
    shares: BTreeMap<String, AttemptShare>,
    tally: Tally,
}

impl Merging<'_> {
    fn write(&mut self, end: Option<&TableEnd>, note: &dyn Fn(&str)) -> Result<Checksums, ShardError> {
        let folder = self.shared.folder();
        let pending = |name: &str| Pending::create(folder.place(name));
        let (results, timings) = (pending(RESULTS)?, pending(TIMINGS)?);
        let _note = MergeNote::begin(folder, &[results.temporary(), timings.temporary()])?;
        let mut rows = RowsWriter::create(self.prepared, results, timings, &end_metadata(end))?;
        let mut problems = ChunkProblems::default();
        let last = end.map_or(self.shards_file.chunks.samples(), |end| end.samples);
        for chunk in 0..self.shards_file.chunks.up_to(last).count() {
            match self.read(chunk) {
                Ok(found) if problems.is_empty() => {
                    let range = self.shards_file.chunks.range(chunk);
                    let range = range.start..range.end.min(last);
                    self.count(&found.by, range.end - range.start);
                    for (sample, entry) in range.zip(found.entries) {
                        self.tally.add(&entry.outcome);
                        rows.push(sample, entry)?;
                    }
                }
                Ok(_) => {}
                Err(error) => self.set_aside(chunk, error, &mut problems, note)?,
            }
        }
        if !problems.is_empty() {
            return Err(problems.into_error(self.shared, self.shards_file));
        }
        forget_answers(folder)?;
        Ok(rows.finish()?)
    }

    pub(super) fn read(&self, chunk: u64) -> Result<Chunk, ChunkError> {
        match self.shared.chunks_in(folder_of(chunk)) {
            Ok(Some(folder)) => read(&folder, self.shards_file, self.prepared, chunk),
            Ok(None) => Err(ChunkError::Missing),
            Err(error) => Err(ChunkError::Io(error)),
        }
    }

    fn count(&mut self, by: &Value, samples: u64) {
        let attempt = by["attempt"].as_str().unwrap_or_default().to_owned();
        let shares =
            self.shares.entry(attempt).or_insert_with(|| AttemptShare { by: by.clone(), chunks: 0, samples: 0 });
        shares.chunks += 1;
        shares.samples += samples;
    }

    /// Rejects a directory with missing chunk files, found by listing the folders. All other chunks are checked first, so that
    /// all problems are reported and computed again at once.
    fn refuse_missing(&self, note: &dyn Fn(&str)) -> Result<(), ShardError> {
        let mut absent = BTreeSet::new();
        each_missing(self.shared, &self.shards_file.chunks, |chunk| {
            absent.insert(chunk);
        })?;
        if absent.is_empty() {
            return Ok(());
        }
        let mut problems = ChunkProblems::default();
        for chunk in 0..self.shards_file.chunks.count() {
            if absent.contains(&chunk) {
                problems.add(chunk, &ChunkError::Missing);
            } else if let Err(error) = self.read(chunk) {
                self.set_aside(chunk, error, &mut problems, note)?;
            }
        }
        Err(problems.into_error(self.shared, self.shards_file))
    }

    /// Sets a rejected chunk aside, so that it is computed again.
    pub(super) fn set_aside(
        &self,
        chunk: u64,
        error: ChunkError,
        problems: &mut ChunkProblems,
        note: &dyn Fn(&str),
    ) -> Result<(), ShardError> {
        problems.add(chunk, &error);
        let place = || -> Result<_, FileError> {
            let number = folder_of(chunk);
            let folder = self.shared.numbered(CHUNKS, number)?;
            Ok(folder.place(chunk_name(chunk)))
        };
        match error {
            ChunkError::Missing => Ok(()),
            // A folder, a link or a pipe has the name of a chunk.
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
                // The first ones only: the final message counts all.
                if problems.set_aside() <= SHOWN {
                    note(&format!("chunk {chunk} is put aside as {aside}: {error}"));
                }
                Ok(())
            }
        }
    }

    fn nodes(&self) -> BTreeSet<&str> {
        self.shares.values().filter_map(|shares| shares.by["host"].as_str()).collect()
    }

    /// Manifest of the merged table, with shards in place of workers.
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
            watched: Watched::default(),
            refresh: Duration::ZERO,
            faults: &NoFaults,
        };
        let text = manifest(&request, self.prepared.samples, &self.prepared.provenance, course);
        let mut value: Map<String, Value> = serde_json::from_str(&text).expect("an object, written just now");
        value.remove("workers");
        let attempts = self.shares.values().take(LISTED).map(|shares| {
            let mut one = shares.by.as_object().cloned().unwrap_or_default();
            one.insert("chunks".to_owned(), json!(shares.chunks));
            one.insert("samples".to_owned(), json!(shares.samples));
            Value::Object(one)
        });
        let shards = json!({
            "shards_blake3": self.shards_file.hash,
            "program": self.shards_file.program(),
            "chunk": self.shards_file.chunks.size(),
            "chunks": self.shards_file.chunks.count(),
            "nodes": self.nodes().len(),
            "attempts_count": self.shares.len(),
            "attempts": attempts.collect::<Vec<_>>(),
        });
        value.insert("shards".to_owned(), shards);
        let mut text = serde_json::to_string_pretty(&value).expect("strings and numbers always have a JSON form");
        text.push('\n');
        text
    }
}

/// Visits every chunk without a file in ascending order; returns the number of chunks with one.
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
