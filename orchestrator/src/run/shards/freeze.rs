//! A study put into a directory of shards by the first process, or compared with what is published there.
//!
//! Each file is published by `link(2)` and read back. A process that is killed between two of them leaves a beginning that the next one
//! continues. Damaged files are restored before anything is compared (`published`).

use super::super::columns::own_columns;
use super::super::error::Change;
use super::super::prepare::{Frozen as Bytes, Prepared, basis_of_others, new_basis};
use super::error::ShardError;
use super::frozen::{Frozen, VERSIONS, said, saying};
use super::layout::{MOST_CHUNKS, MOST_OF_CHUNK, SHARDS};
use super::publish::put_once;
use super::published::{
    are_whole, refuse_damaged_basis, refuse_damaged_study, refuse_other_list, restore_computed, restore_study,
};
use super::shared::Shared;
use crate::engine_choice::as_planned;
use crate::version::VERSION;
use bladeoff_study::{FrozenFiles, Samples, load, load_frozen};
use bladeoff_system::files::FileError;
use bladeoff_system::place::Place;
use bladeoff_worker::job_spec::{BASIS_FILE, MOST_BASIS, PLAN_FILE};
use serde_json::{Value, json};
use std::io;
use std::path::Path;

/// The samples of the study that is frozen beside it.
///
/// # Errors
/// The study cannot be read any more.
pub(super) fn samples(shared: &Shared, frozen: &Frozen) -> Result<Samples, ShardError> {
    refuse_damaged_study(shared, frozen)?;
    let damaged =
        |error: bladeoff_study::StudyError| ShardError::Damaged { path: shared.path().into(), why: error.to_string() };
    let mut study = load_frozen(FrozenFiles::of(shared.path()), own_columns).map_err(damaged)?;
    // Without a name of its own it is called as its file was.
    as_planned(&mut study, shared.path());
    (study.name, study.file) = (frozen.study(), frozen.study_file());
    let (scale, limit) = frozen.part();
    Samples::new(study, scale, limit).map_err(damaged)
}

/// The samples ready to be written as tables, with the published basis. A later program with the same numerics may read a directory that
/// another program has begun.
///
/// # Errors
/// A file there is not the one that was published.
pub(super) fn prepared<'a>(shared: &Shared, frozen: &Frozen, samples: &'a Samples) -> Result<Prepared<'a>, ShardError> {
    refuse_damaged_basis(shared, frozen)?;
    refuse_other_list(shared, frozen)?;
    let prepared = Prepared::with_digest(samples, read_basis(shared, samples)?, frozen.digest())?;
    let mut wanted = said(&prepared, frozen);
    wanted.insert("program".to_owned(), json!(frozen.program()));
    match frozen.check(shared, &wanted) {
        Err(ShardError::Changed { changes, .. }) if !changes.iter().any(|change| VERSIONS.contains(&&*change.key)) => {
            Err(frozen.contradicts(shared, &changes))
        }
        checked => checked.map(|()| prepared),
    }
}

/// Restores damaged files of a directory whose study is not at hand: from the files that its study was read from, if these are as they were.
///
/// # Errors
/// The directory cannot be read, or not be written; `trusts`: also one that others could write in.
pub fn restore(directory: &Path, trusts: bool, note: &dyn Fn(&str)) -> Result<(), ShardError> {
    let Some(shared) = Shared::open(directory)? else { return Ok(()) };
    let Some(frozen) = Frozen::read(&shared)? else { return Ok(()) };
    let (is_study_whole, is_rest_whole) = are_whole(&shared, &frozen)?;
    if is_study_whole && is_rest_whole {
        return Ok(());
    }
    shared.trusted(trusts, note)?;
    if !is_study_whole {
        // another study has other hashes, and restores nothing
        let study = load(Path::new(&frozen.study_file()), own_columns).ok();
        if let Some(samples) = study.and_then(|study| Samples::new(study, None, None).ok()) {
            restore_study(&shared, &frozen, &samples, note)?;
        }
    }
    if !is_rest_whole {
        restore_computed(&shared, &frozen, &samples(&shared, &frozen)?, note)?;
    }
    Ok(())
}

/// The basis that is published, if the study needs one.
fn read_basis(shared: &Shared, samples: &Samples) -> Result<Bytes, ShardError> {
    if samples.study().function().is_some() {
        return Ok(None);
    }
    let place = shared.folder().place(BASIS_FILE);
    let bytes = place.read(MOST_BASIS)?;
    let taken = basis_of_others(samples, bytes.clone())?;
    // One that does not serve would be computed anew, by everybody his own.
    if taken.as_ref() != Some(&bytes) {
        let why = "it is no basis of this study's machine: remove the directory, or choose another --out".to_owned();
        return Err(ShardError::Damaged { path: place.to_path_buf(), why });
    }
    Ok(taken)
}

/// The basis of an old directory, if it has one.
fn basis_of(old: &Path) -> Result<Option<Vec<u8>>, FileError> {
    let place = Place::from(&old.join(BASIS_FILE));
    match place.read(MOST_BASIS) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.source.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// The basis of who is first: that of an old directory whose samples are taken over, if it serves this study, or a new one.
fn first_basis(samples: &Samples, old: Option<&Path>) -> Result<Bytes, ShardError> {
    match old.map(basis_of).transpose()?.flatten() {
        Some(bytes) if samples.study().function().is_none() => Ok(basis_of_others(samples, bytes)?),
        _ => Ok(new_basis(samples)?),
    }
}

/// Which samples a study has must be known before any is computed.
///
/// # Errors
/// `[refine]` chooses them by results.
pub(super) fn refuse_refined(samples: &Samples) -> Result<(), ShardError> {
    let study = samples.study();
    if study.refine.is_some() { Err(ShardError::Refined { study: (&study.file).into() }) } else { Ok(()) }
}

/// Takes what is published, or publishes it. `chunk`: how many samples a chunk gets in a new directory; `asked`: by the user; `old`: a
/// directory whose samples will be taken over.
///
/// # Errors
/// The directory was begun with another study, program or chunk; files.
pub(super) fn freeze<'a>(
    shared: &Shared,
    samples: &'a Samples,
    (asked, old): (Option<u64>, Option<&Path>),
    chunk: impl FnOnce(&Prepared<'_>) -> u64,
    note: &dyn Fn(&str),
) -> Result<(Frozen, Prepared<'a>), ShardError> {
    if let Some(frozen) = Frozen::read(shared)? {
        restore_study(shared, &frozen, samples, note)?;
        refuse_damaged_study(shared, &frozen)?;
        // of another study they would be others
        if is_same_study(shared, samples) {
            restore_computed(shared, &frozen, samples, note)?;
        }
        refuse_damaged_basis(shared, &frozen)?;
        refuse_other_list(shared, &frozen)?;
        let prepared = known(shared, samples, &frozen)?;
        refuse_other_chunk(shared, &frozen, asked)?;
        return Ok((frozen, prepared));
    }
    let folder = shared.folder();
    // chunks come after it: it is looked for once more, somebody may have begun meanwhile
    if !shared.names_in(0)?.is_empty() && !folder.place(SHARDS).exists() {
        let why = "it is missing beside chunks that it belongs to: bring it back, or choose another --out".to_owned();
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
    publish(shared, PLAN_FILE, prepared.plan.text().as_bytes())?;
    let size = asked.unwrap_or_else(|| chunk(&prepared));
    check_chunk(size, samples.count())?;
    let said = saying(&prepared, size);
    let mut text =
        serde_json::to_string_pretty(&Value::Object(said)).expect("strings and numbers always have a JSON form");
    text.push('\n');
    put_once(folder, SHARDS, text.as_bytes())?;
    let frozen = Frozen::read(shared)?.ok_or_else(|| ShardError::Replaced { path: shared.path().to_path_buf() })?;
    let prepared = known(shared, samples, &frozen)?;
    refuse_other_chunk(shared, &frozen, asked)?;
    Ok((frozen, prepared))
}

/// A study compared with what is published. The inputs are compared before anything is made of them: to read a basis of another machine
/// would say little.
fn known<'a>(shared: &Shared, samples: &'a Samples, frozen: &Frozen) -> Result<Prepared<'a>, ShardError> {
    let (scale, limit) = frozen.part();
    let is_same = is_same_study(shared, samples)
        && (scale, limit) == (samples.scale(), samples.limit())
        && frozen.program().as_deref() == Some(VERSION.as_str());
    // The keys of the same inputs under the same program are the same: they need not be computed again, a hundred million of them.
    let digest = if is_same { frozen.digest() } else { None };
    let basis = match read_basis(shared, samples) {
        // Of another machine: what differs is said below.
        Err(_) if !is_same => new_basis(samples)?,
        found => found?,
    };
    let prepared = Prepared::with_digest(samples, basis, digest)?;
    match frozen.check(shared, &said(&prepared, frozen)) {
        Err(ShardError::Changed { changes, .. }) if is_same => Err(frozen.contradicts(shared, &changes)),
        checked => checked.map(|()| prepared),
    }
}

/// Whether the published inputs are those of this study.
fn is_same_study(shared: &Shared, samples: &Samples) -> bool {
    let is_same_input = |(name, text): (String, Option<&str>)| match text {
        Some(text) => shared.folder().place(&name).read(text.len() as u64).is_ok_and(|found| found == text.as_bytes()),
        None => !shared.folder().place(&name).exists(),
    };
    samples.study().inputs().into_iter().all(is_same_input)
}

fn refuse_other_chunk(shared: &Shared, frozen: &Frozen, asked: Option<u64>) -> Result<(), ShardError> {
    let size = frozen.chunks.size();
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
        return refused(format!("a chunk is held in memory as a whole; at most {MOST_OF_CHUNK} samples"));
    }
    if samples.div_ceil(size) > MOST_CHUNKS {
        let least = samples.div_ceil(MOST_CHUNKS);
        return refused(format!("the study would have more than {MOST_CHUNKS} chunks; at least {least} samples"));
    }
    Ok(())
}

/// Publishes a file of which every process has the same bytes.
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
