//! What can be seen of shards from outside: chunks on disk, attempts by what they say of themselves. What is on disk is believed.

use super::super::directory::RESULTS;
use super::super::status::{RunState, Seen, see as see_run};
use super::attempt::{AttemptSeen, all};
use super::chunk::read;
use super::error::ShardError;
use super::freeze::{prepared, samples};
use super::frozen::Frozen;
use super::layout::{chunk_name, folder_of};
use super::merge::each_missing;
use super::shared::Shared;
use super::wrong::in_words;
use bladeoff_study::Samples;
use bladeoff_system::call;
use bladeoff_system::files::FileError;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::Path;

/// Missing chunks that are kept to be listed.
const KEPT: usize = 10_000;

/// A directory of shards.
#[derive(Debug, Clone)]
pub struct ShardsSeen {
    /// Name of the study.
    pub study: String,
    /// The study's file as it was named.
    pub study_file: String,
    /// Samples of it.
    pub samples: u64,
    /// Samples of a chunk.
    pub chunk: u64,
    /// Chunks of the study.
    pub chunks: u64,
    /// Chunks that are there.
    pub there: u64,
    /// Samples in them.
    pub done: u64,
    /// The first that is not.
    pub first_missing: Option<u64>,
    /// Which are not, in words.
    pub missing: String,
    /// Whether its table is there.
    pub is_merged: bool,
    /// The program that began it.
    pub program: String,
    /// By which parts of the study.
    pub part: (Option<f64>, Option<u64>),
    /// Who has computed and who does, the living first.
    pub attempts: Vec<AttemptSeen>,
}

impl ShardsSeen {
    /// The command that goes on with it: merge, or compute what is missing.
    #[must_use]
    pub fn go_on(&self, directory: &Path) -> String {
        let directory = call::path_word(directory);
        if self.there == self.chunks {
            return call::command([OsStr::new("merge"), directory.as_os_str()]);
        }
        let study = call::path_word(Path::new(&self.study_file));
        let words: [&OsStr; 6] = [
            "run".as_ref(),
            study.as_os_str(),
            "--out".as_ref(),
            directory.as_os_str(),
            "--shard".as_ref(),
            "0/1".as_ref(),
        ];
        let mut command = call::command(words);
        let (scale, limit) = self.part;
        scale.iter().for_each(|scale| command.push_str(&format!(" --scale {scale}")));
        limit.iter().for_each(|limit| command.push_str(&format!(" --limit {limit}")));
        format!("{command} (or with other shards, or `submit` again)")
    }
}

/// Looks at a directory of shards; `None`: it is none. `last`: samples that it needs at most, by its `[stop]`.
///
/// # Errors
/// It cannot be read.
pub fn see_shards(directory: &Path, last: Option<u64>) -> Result<Option<ShardsSeen>, ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(None) };
    let Some(frozen) = Frozen::read(&shared)? else { return Ok(None) };
    let mut missing = Vec::new();
    let mut lacking = 0;
    let needed = frozen.needed(last);
    let there = each_missing(&shared, &needed, |chunk| {
        let range = frozen.chunks.range(chunk);
        lacking += range.end - range.start;
        if missing.len() < KEPT {
            missing.push(chunk);
        }
    })?;
    let mut attempts = all(&shared);
    let order = |seen: &AttemptSeen| {
        (!seen.lives, seen.said.get("started").map(Value::to_string), seen.said["attempt"].to_string())
    };
    attempts.sort_by_key(order);
    Ok(Some(ShardsSeen {
        study: frozen.study(),
        study_file: frozen.study_file(),
        samples: needed.samples(),
        chunk: needed.size(),
        chunks: needed.count(),
        there,
        done: needed.samples() - lacking,
        first_missing: missing.first().copied(),
        missing: in_words(&missing),
        is_merged: shared.folder().place(RESULTS).is_file(),
        program: frozen.program().unwrap_or_default(),
        part: frozen.part(),
        attempts,
    }))
}

/// What is known of any result directory, as of one machine: of shards whether somebody computes and how to go on.
///
/// # Errors
/// It cannot be read.
pub fn see(directory: &Path) -> Result<Option<Seen>, FileError> {
    let seen = match see_shards(directory, None) {
        Ok(Some(seen)) => seen,
        // What is wrong with it is said by who reads it.
        Ok(None) | Err(_) => return see_run(directory),
    };
    let state = match (seen.is_merged, seen.attempts.iter().any(|attempt| attempt.lives)) {
        (true, _) => RunState::Complete,
        (false, true) => RunState::Running { holder: None, stopped: false },
        (false, false) => RunState::Ended,
    };
    let told = json!({ "study": seen.study, "total": seen.samples, "done": seen.done, "go_on": seen.go_on(directory) });
    Ok(Some(Seen { state, told: told.as_object().cloned(), is_counted: true }))
}

/// The samples of a directory of shards; `None`: it is none.
///
/// # Errors
/// Its study cannot be read any more.
pub fn samples_of(directory: &Path) -> Result<Option<Samples>, ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(None) };
    let Some(frozen) = Frozen::read(&shared)? else { return Ok(None) };
    samples(&shared, &frozen).map(Some)
}

/// Reads every chunk that is there and checks all of it: how many are whole, and what is wrong with the others. Nothing is written.
///
/// # Errors
/// The directory, or what is published in it, cannot be read.
pub fn verify_chunks(directory: &Path) -> Result<Option<(u64, Vec<String>)>, ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(None) };
    let Some(frozen) = Frozen::read(&shared)? else { return Ok(None) };
    let samples = samples(&shared, &frozen)?;
    let prepared = prepared(&shared, &frozen, &samples)?;
    let (mut whole, mut damaged) = (0, Vec::new());
    for number in frozen.chunks.folders() {
        let names = shared.names_in(number)?;
        let Ok(Some(folder)) = shared.chunks_in(number) else { continue };
        for chunk in names {
            if chunk >= frozen.chunks.count() || folder_of(chunk) != number {
                damaged.push(format!("{}: no chunk of this study", chunk_name(chunk)));
                continue;
            }
            match read(&folder, &frozen, &prepared, chunk) {
                Ok(_) => whole += 1,
                Err(error) => damaged.push(format!("{}: {error}", chunk_name(chunk))),
            }
        }
    }
    Ok(Some((whole, damaged)))
}
