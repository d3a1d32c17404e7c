//! Study of a directory of shards: published by the first process, compared by all others.
//!
//! Each file is published by `link(2)` and read back. If the process is killed between two files, the next process continues.
//! Damaged files are restored before the comparison (`published`).

use super::super::columns::own_columns;
use super::super::error::Change;
use super::super::prepare::{BasisBytes, Prepared, basis_of_others, new_basis};
use super::error::ShardError;
use super::layout::{MOST_CHUNKS, MOST_OF_CHUNK, SHARDS};
use super::publish::put_once;
use super::published::{
    are_whole, refuse_damaged_basis, refuse_damaged_study, refuse_other_list, restore_computed, restore_study,
};
use super::shards_file::{ShardsFile, VERSIONS, expected_fields, new_fields, text_of};
use super::shared::Shared;
use crate::engine_choice::as_planned;
use crate::version::VERSION;
use bladeoff_study::{FrozenFiles, Samples, load, load_frozen};
use bladeoff_system::files::FileError;
use bladeoff_system::place::Place;
use bladeoff_worker::job_spec::{BASIS_FILE, MOST_BASIS, PLAN_FILE};
use serde_json::json;
use std::io;
use std::path::Path;

/// Reads the samples of the study that is frozen in the directory.
///
/// # Errors
/// The study can no longer be read.
pub(super) fn samples(shared: &Shared, shards_file: &ShardsFile) -> Result<Samples, ShardError> {
    refuse_damaged_study(shared, shards_file)?;
    let damaged =
        |error: bladeoff_study::StudyError| ShardError::Damaged { path: shared.path().into(), why: error.to_string() };
    let mut study = load_frozen(FrozenFiles::of(shared.path()), own_columns).map_err(damaged)?;
    // A study without a name is named after its file.
    as_planned(&mut study, shared.path());
    (study.name, study.file) = (shards_file.study(), shards_file.study_file());
    let (scale, limit) = shards_file.selection();
    Samples::new(study, scale, limit).map_err(damaged)
}

/// Prepares the samples for tables, with the published basis. A later program with the same numerics may read a directory that
/// another program began.
///
/// # Errors
/// A file there is not the one that was published.
pub(super) fn prepared<'a>(
    shared: &Shared,
    shards_file: &ShardsFile,
    samples: &'a Samples,
) -> Result<Prepared<'a>, ShardError> {
    refuse_damaged_basis(shared, shards_file)?;
    refuse_other_list(shared, shards_file)?;
    let prepared = Prepared::with_digest(samples, read_basis(shared, samples)?, shards_file.digest())?;
    let mut wanted = expected_fields(&prepared, shards_file);
    wanted.insert("program".to_owned(), json!(shards_file.program()));
    match shards_file.check(shared, &wanted) {
        Err(ShardError::Changed { changes, .. }) if !changes.iter().any(|change| VERSIONS.contains(&&*change.key)) => {
            Err(shards_file.contradicts(shared, &changes))
        }
        checked => checked.map(|()| prepared),
    }
}

/// Restores damaged files of a directory from the files from which its study was read, if these are unchanged.
///
/// # Errors
/// The directory cannot be read or written; `trusts`: also accept a directory to which other users may write.
pub fn restore(directory: &Path, trusts: bool, note: &dyn Fn(&str)) -> Result<(), ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(()) };
    let Some(shards_file) = ShardsFile::read(&shared)? else { return Ok(()) };
    let (is_study_whole, is_rest_whole) = are_whole(&shared, &shards_file)?;
    if is_study_whole && is_rest_whole {
        return Ok(());
    }
    shared.trusted(trusts, note)?;
    if !is_study_whole {
        // Another study has other hashes and restores nothing.
        let study = load(Path::new(&shards_file.study_file()), own_columns).ok();
        if let Some(samples) = study.and_then(|study| Samples::new(study, None, None).ok()) {
            restore_study(&shared, &shards_file, &samples, note)?;
        }
    }
    if !is_rest_whole {
        restore_computed(&shared, &shards_file, &samples(&shared, &shards_file)?, note)?;
    }
    Ok(())
}

/// Reads the published basis; `None`: the study needs no basis.
fn read_basis(shared: &Shared, samples: &Samples) -> Result<BasisBytes, ShardError> {
    if samples.study().function().is_some() {
        return Ok(None);
    }
    let place = shared.folder().place(BASIS_FILE);
    let bytes = place.read(MOST_BASIS)?;
    let taken = basis_of_others(samples, bytes.clone())?;
    // A basis that does not fit would be computed again, by each process for itself.
    if taken.as_ref() != Some(&bytes) {
        let why = "it is not a basis of this study's machine: remove the directory, or choose another --out".to_owned();
        return Err(ShardError::Damaged { path: place.to_path_buf(), why });
    }
    Ok(taken)
}

/// Reads the basis of an old directory; `None`: it has no basis.
fn basis_of(old: &Path) -> Result<Option<Vec<u8>>, FileError> {
    let place = Place::from(&old.join(BASIS_FILE));
    match place.read(MOST_BASIS) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.source.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Basis of a new directory: that of the old directory whose samples are reused if it fits this study, otherwise a new one.
fn first_basis(samples: &Samples, old: Option<&Path>) -> Result<BasisBytes, ShardError> {
    match old.map(basis_of).transpose()?.flatten() {
        Some(bytes) if samples.study().function().is_none() => Ok(basis_of_others(samples, bytes)?),
        _ => Ok(new_basis(samples)?),
    }
}

/// Rejects a study with `[refine]`: all samples must be known in advance.
///
/// # Errors
/// [`ShardError::Refined`].
pub(super) fn refuse_refined(samples: &Samples) -> Result<(), ShardError> {
    let study = samples.study();
    if study.refine.is_some() { Err(ShardError::Refined { study: (&study.file).into() }) } else { Ok(()) }
}

/// Reads the published study, or publishes it. `asked`: chunk size of the command line; `old`: directory whose samples will be
/// reused; `chunk`: computes the chunk size of a new directory.
///
/// # Errors
/// The directory was begun with another study, program or chunk; files.
pub(super) fn freeze<'a>(
    shared: &Shared,
    samples: &'a Samples,
    (asked, old): (Option<u64>, Option<&Path>),
    chunk: impl FnOnce(&Prepared<'_>) -> u64,
    note: &dyn Fn(&str),
) -> Result<(ShardsFile, Prepared<'a>), ShardError> {
    if let Some(shards_file) = ShardsFile::read(shared)? {
        restore_study(shared, &shards_file, samples, note)?;
        refuse_damaged_study(shared, &shards_file)?;
        // Another study has another plan and basis.
        if is_same_study(shared, samples) {
            restore_computed(shared, &shards_file, samples, note)?;
        }
        refuse_damaged_basis(shared, &shards_file)?;
        refuse_other_list(shared, &shards_file)?;
        let prepared = known(shared, samples, &shards_file)?;
        refuse_other_chunk(shared, &shards_file, asked)?;
        return Ok((shards_file, prepared));
    }
    let folder = shared.folder();
    // Chunks are published after it. A second check: another process may have begun the directory meanwhile.
    if !shared.names_in(0)?.is_empty() && !folder.place(SHARDS).exists() {
        let why = "it is missing although its chunks exist: restore it, or choose another --out".to_owned();
        return Err(ShardError::Damaged { path: shared.path().join(SHARDS), why });
    }
    if !folder.place(BASIS_FILE).exists()
        && let Some(basis) = first_basis(samples, old)?
    {
        put_once(folder, BASIS_FILE, &basis)?;
    }
    let prepared = Prepared::new(samples, read_basis(shared, samples)?)?;
    for (name, text) in samples.study().inputs() {
        match text {
            Some(text) => publish(shared, &name, text.as_bytes())?,
            None if folder.place(&name).exists() => return Err(other_input(shared, &name)),
            None => {}
        }
    }
    publish(shared, PLAN_FILE, prepared.job.text().as_bytes())?;
    let size = asked.unwrap_or_else(|| chunk(&prepared));
    check_chunk(size, samples.count())?;
    put_once(folder, SHARDS, text_of(new_fields(&prepared, size)).as_bytes())?;
    let shards_file =
        ShardsFile::read(shared)?.ok_or_else(|| ShardError::Replaced { path: shared.path().to_path_buf() })?;
    let prepared = known(shared, samples, &shards_file)?;
    refuse_other_chunk(shared, &shards_file, asked)?;
    Ok((shards_file, prepared))
}

/// Compares a study with the published one. Inputs are compared first, because the basis of another machine would give a
/// misleading message.
fn known<'a>(shared: &Shared, samples: &'a Samples, shards_file: &ShardsFile) -> Result<Prepared<'a>, ShardError> {
    let (scale, limit) = shards_file.selection();
    let is_same = is_same_study(shared, samples)
        && (scale, limit) == (samples.scale(), samples.limit())
        && shards_file.program().as_deref() == Some(VERSION.as_str());
    // The same inputs and program have the same keys, so up to 1e8 keys need not be computed again.
    let digest = if is_same { shards_file.digest() } else { None };
    let basis = match read_basis(shared, samples) {
        // The basis of another machine: the differences are reported below.
        Err(_) if !is_same => new_basis(samples)?,
        found => found?,
    };
    let prepared = Prepared::with_digest(samples, basis, digest)?;
    match shards_file.check(shared, &expected_fields(&prepared, shards_file)) {
        Err(ShardError::Changed { changes, .. }) if is_same => Err(shards_file.contradicts(shared, &changes)),
        checked => checked.map(|()| prepared),
    }
}

/// Whether the published inputs equal those of this study.
fn is_same_study(shared: &Shared, samples: &Samples) -> bool {
    let is_same_input = |(name, text): (String, Option<&str>)| match text {
        Some(text) => shared.folder().place(&name).read(text.len() as u64).is_ok_and(|found| found == text.as_bytes()),
        None => !shared.folder().place(&name).exists(),
    };
    samples.study().inputs().into_iter().all(is_same_input)
}

fn refuse_other_chunk(shared: &Shared, shards_file: &ShardsFile, asked: Option<u64>) -> Result<(), ShardError> {
    let size = shards_file.chunks.size();
    match asked.filter(|asked| *asked != size) {
        None => Ok(()),
        Some(asked) => {
            let change = Change { key: "--chunk".to_owned(), from: size.to_string(), to: asked.to_string() };
            Err(ShardError::Changed { path: shared.path().to_path_buf(), changes: vec![change] })
        }
    }
}

fn check_chunk(size: u64, samples: u64) -> Result<(), ShardError> {
    let refused = |why: String| Err(ShardError::Chunk { size, why });
    if size > MOST_OF_CHUNK {
        return refused(format!("a chunk is kept in memory as a whole; at most {MOST_OF_CHUNK} samples"));
    }
    if samples.div_ceil(size) > MOST_CHUNKS {
        let least = samples.div_ceil(MOST_CHUNKS);
        return refused(format!("the study would have more than {MOST_CHUNKS} chunks; at least {least} samples"));
    }
    Ok(())
}

/// Publishes a file whose bytes are the same in every process.
fn publish(shared: &Shared, name: &str, bytes: &[u8]) -> Result<(), ShardError> {
    let place = shared.folder().place(name);
    if !place.exists() {
        put_once(shared.folder(), name, bytes)?;
    }
    let is_ours = place.read(bytes.len() as u64).is_ok_and(|found| found == bytes);
    if is_ours { Ok(()) } else { Err(other_input(shared, name)) }
}

fn other_input(shared: &Shared, name: &str) -> ShardError {
    let change = Change { key: name.to_owned(), from: "of another study".to_owned(), to: "of this one".to_owned() };
    ShardError::Changed { path: shared.path().to_path_buf(), changes: vec![change] }
}
