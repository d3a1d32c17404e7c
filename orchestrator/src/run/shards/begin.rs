//! Preparation by `submit`: begins the directory and lists the shards with missing chunks.

use super::super::prepare::Prepared;
use super::attempt::Attempt;
use super::error::ShardError;
use super::freeze::{freeze, refuse_refined};
use super::layout::Shard;
use super::measure::chunk_size;
use super::merge::each_missing;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use super::takeover::{refuse_no_old, take_over};
use bladeoff_study::Samples;
use std::collections::BTreeSet;
use std::path::Path;

/// Begins a directory of shards, or compares an existing one. `chunk`: chunk size of the command line; without it, workers per
/// shard and number of shards determine the size. `old`: directory whose samples are reused.
///
/// # Errors
/// The directory is another study's, or cannot be used.
pub fn begin(
    path: &Path,
    trusts: bool,
    samples: &Samples,
    (chunk, workers, shards): (Option<u64>, usize, u64),
    old: Option<&Path>,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    refuse_refined(samples)?;
    refuse_no_old(old)?;
    let shared = Shared::claim(path, trusts, note)?;
    let size = |prepared: &Prepared<'_>| chunk_size(prepared, workers, shards);
    let (shards_file, prepared) = freeze(&shared, samples, (chunk, old), size, note)?;
    if let Some(old) = old {
        let attempt = Attempt::begin(Shard { number: 0, of: 1 }, 0)?;
        take_over(old, &shared, (&shards_file, &prepared), &attempt, note)?;
    }
    Ok(())
}

/// Lists the shards with missing chunks. `last`: largest number of samples that the study needs, by its `[stop]`.
///
/// # Errors
/// The directory cannot be read.
pub fn shards_to_do(path: &Path, shards: u64, last: Option<u64>) -> Result<Vec<u64>, ShardError> {
    let none = || ShardError::None { path: path.to_path_buf() };
    let shared = Shared::open(path)?.ok_or_else(none)?;
    let shards_file = ShardsFile::read(&shared)?.ok_or_else(none)?;
    let mut found = BTreeSet::new();
    each_missing(&shared, &shards_file.needed(last), |chunk| {
        found.insert(chunk % shards.max(1));
    })?;
    Ok(found.into_iter().collect())
}
