//! Status of a directory of shards: chunks on disk, and attempts by their reports. The chunks decide where both disagree.

use super::super::directory::RESULTS;
use super::super::status::{DirectoryStatus, RunState, directory_status as status_of_run};
use super::attempt::{AttemptStatus, all_attempts};
use super::chunk::read;
use super::chunk_problems::in_words;
use super::error::ShardError;
use super::freeze::{prepared, samples};
use super::layout::{chunk_name, folder_of};
use super::merge::each_missing;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use bladeoff_study::Samples;
use bladeoff_system::call;
use bladeoff_system::files::FileError;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::Path;

/// Largest number of missing chunks that are listed.
const MAX_LISTED: usize = 10_000;

/// Status of a directory of shards.
#[derive(Debug, Clone)]
pub struct ShardsStatus {
    /// Name of the study.
    pub study: String,
    /// Study file as named on the command line.
    pub study_file: String,
    /// Samples of the study.
    pub samples: u64,
    /// Samples of a chunk.
    pub chunk: u64,
    /// Chunks of the study.
    pub chunks: u64,
    /// Published chunks.
    pub there: u64,
    /// Samples of the published chunks.
    pub done: u64,
    /// First missing chunk.
    pub first_missing: Option<u64>,
    /// Ranges of the missing chunks.
    pub missing: String,
    /// Whether the merged table exists.
    pub is_merged: bool,
    /// Program that began the directory.
    pub program: String,
    /// Values of `--scale` and `--limit`.
    pub part: (Option<f64>, Option<u64>),
    /// Attempts, live ones first.
    pub attempts: Vec<AttemptStatus>,
}

impl ShardsStatus {
    /// Command that continues the study: the merge, or the computation of the missing chunks.
    #[must_use]
    pub fn resume_command(&self, directory: &Path) -> String {
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

/// Reads the status of a directory of shards; `None`: it contains none. `last`: largest number of samples that the study needs,
/// by its `[stop]`.
///
/// # Errors
/// The directory cannot be read.
pub fn shards_status(directory: &Path, last: Option<u64>) -> Result<Option<ShardsStatus>, ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(None) };
    let Some(shards_file) = ShardsFile::read(&shared)? else { return Ok(None) };
    let mut missing = Vec::new();
    let mut lacking = 0;
    let needed = shards_file.needed(last);
    let there = each_missing(&shared, &needed, |chunk| {
        let range = shards_file.chunks.range(chunk);
        lacking += range.end - range.start;
        if missing.len() < MAX_LISTED {
            missing.push(chunk);
        }
    })?;
    let mut attempts = all_attempts(&shared);
    let order = |seen: &AttemptStatus| {
        (!seen.lives, seen.report.get("started").map(Value::to_string), seen.report["attempt"].to_string())
    };
    attempts.sort_by_key(order);
    Ok(Some(ShardsStatus {
        study: shards_file.study(),
        study_file: shards_file.study_file(),
        samples: needed.samples(),
        chunk: needed.size(),
        chunks: needed.count(),
        there,
        done: needed.samples() - lacking,
        first_missing: missing.first().copied(),
        missing: in_words(&missing),
        is_merged: shared.folder().place(RESULTS).is_file(),
        program: shards_file.program().unwrap_or_default(),
        part: shards_file.selection(),
        attempts,
    }))
}

/// Reads the status of any result directory. For shards: whether an attempt is alive, and the command that continues.
///
/// # Errors
/// The directory cannot be read.
pub fn directory_status(directory: &Path) -> Result<Option<DirectoryStatus>, FileError> {
    let seen = match shards_status(directory, None) {
        Ok(Some(seen)) => seen,
        // The commands that read the shards report their errors.
        Ok(None) | Err(_) => return status_of_run(directory),
    };
    let state = match (seen.is_merged, seen.attempts.iter().any(|attempt| attempt.lives)) {
        (true, _) => RunState::Complete,
        (false, true) => RunState::Running { holder: None, stopped: false },
        (false, false) => RunState::Ended,
    };
    let report = json!({ "study": seen.study, "total": seen.samples, "done": seen.done, "resume": seen.resume_command(directory) });
    Ok(Some(DirectoryStatus { state, last_report: report.as_object().cloned(), is_counted: true }))
}

/// Reads the samples of a directory of shards; `None`: it contains none.
///
/// # Errors
/// The study cannot be read.
pub fn samples_of(directory: &Path) -> Result<Option<Samples>, ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(None) };
    let Some(shards_file) = ShardsFile::read(&shared)? else { return Ok(None) };
    samples(&shared, &shards_file).map(Some)
}

/// Checks every published chunk completely; returns the number of valid ones and the errors of the others. Writes nothing.
///
/// # Errors
/// The directory or a shared file cannot be read.
pub fn verify_chunks(directory: &Path) -> Result<Option<(u64, Vec<String>)>, ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(None) };
    let Some(shards_file) = ShardsFile::read(&shared)? else { return Ok(None) };
    let samples = samples(&shared, &shards_file)?;
    let prepared = prepared(&shared, &shards_file, &samples)?;
    let (mut whole, mut damaged) = (0, Vec::new());
    for number in shards_file.chunks.folders() {
        let names = shared.names_in(number)?;
        let Ok(Some(folder)) = shared.chunks_in(number) else { continue };
        for chunk in names {
            if chunk >= shards_file.chunks.count() || folder_of(chunk) != number {
                damaged.push(format!("{}: no chunk of this study", chunk_name(chunk)));
                continue;
            }
            match read(&folder, &shards_file, &prepared, chunk) {
                Ok(_) => whole += 1,
                Err(error) => damaged.push(format!("{}: {error}", chunk_name(chunk))),
            }
        }
    }
    Ok(Some((whole, damaged)))
}
