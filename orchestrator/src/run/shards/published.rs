//! The files that shards share, compared with the hashes in `shards.json`: which is damaged or missing, and from where it is restored.
//!
//! A file is restored only from bytes that have its recorded hash: the study and its inputs from the files they were read from, the plan
//! from the study, the basis computed again. So it does not matter who restores it, or how many at once.

use super::super::prepare::{Prepared, basis_of_others, new_basis};
use super::super::provenance::empirical_key;
use super::chunk::head;
use super::error::ShardError;
use super::frozen::Frozen;
use super::layout::SHARDS;
use super::shared::Shared;
use bladeoff_study::sampling::layout::MOST_PARAMETERS;
use bladeoff_study::{MACHINE, POINTS, STUDY, Samples, empirical};
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::shown;
use bladeoff_worker::job_spec::{BASIS_FILE, MOST_BASIS, PLAN_FILE};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::Path;

/// Largest study, machine, points file or plan that is compared.
const MOST_INPUT: u64 = 1 << 30;
/// Chunks whose heads are compared with `shards.json`.
const LOOKED_AT: usize = 100;
/// Files of the study, with the keys of their hashes.
const OF_STUDY: [(&str, &str); 3] = [(STUDY, "study_blake3"), (MACHINE, "machine_blake3"), (POINTS, "points_blake3")];
/// Files that are computed from those.
const COMPUTED: [(&str, &str); 2] = [(BASIS_FILE, "basis_blake3"), (PLAN_FILE, "plan_blake3")];

/// A published file that is not as it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Damaged {
    name: String,
    /// BLAKE3 that it had.
    wanted: String,
    is_missing: bool,
}

/// Names and hashes of the files of the study.
fn of_study(frozen: &Frozen) -> Vec<(String, String)> {
    let own = OF_STUDY.map(|(name, key)| (name.to_owned(), key.to_owned())).into_iter();
    let of_laws = (0..MOST_PARAMETERS).map(|file| (empirical(file), empirical_key(file)));
    own.chain(of_laws).filter_map(|(name, key)| Some((name, frozen.hash_of(&key)?))).collect()
}

/// Names and hashes of what is computed from them.
fn computed(frozen: &Frozen) -> Vec<(String, String)> {
    COMPUTED.iter().filter_map(|(name, key)| Some(((*name).to_owned(), frozen.hash_of(key)?))).collect()
}

/// The file of this name that is not as it was written, if it is not.
///
/// # Errors
/// The file cannot be read now.
fn damage(shared: &Shared, (name, wanted): (String, String)) -> Result<Option<Damaged>, FileError> {
    let most = if name == BASIS_FILE { MOST_BASIS } else { MOST_INPUT };
    let is_missing = match shared.folder().place(&name).read(most) {
        Ok(bytes) if has_hash(&bytes, &wanted) => return Ok(None),
        Ok(_) => false,
        Err(error) if error.source.kind() == ErrorKind::NotFound => true,
        // too long, or no regular file
        Err(error) if error.source.kind() == ErrorKind::InvalidInput => false,
        Err(error) => return Err(error),
    };
    Ok(Some(Damaged { name, wanted, is_missing }))
}

fn all_damaged(shared: &Shared, files: Vec<(String, String)>) -> Result<Vec<Damaged>, FileError> {
    files.into_iter().filter_map(|file| damage(shared, file).transpose()).collect()
}

fn has_hash(bytes: &[u8], wanted: &str) -> bool {
    blake3::hash(bytes).to_hex().as_str() == wanted
}

impl Damaged {
    /// As why nothing is done with the directory.
    fn refused(&self, shared: &Shared, frozen: &Frozen) -> ShardError {
        let what = if self.is_missing { "missing" } else { "damaged: its bytes have changed since it was written" };
        let from = match self.name.as_str() {
            BASIS_FILE | PLAN_FILE => format!(
                "`run --shard` and `merge` of the program that began the directory ({}) restore it",
                frozen.program().unwrap_or_default()
            ),
            _ => format!(
                "`run --shard` with the study as it was, {}, restores it",
                shown(Path::new(&frozen.study_file()))
            ),
        };
        let why = format!(
            "it is {what} (BLAKE3 in {SHARDS}: {}); no finished sample is lost; {from}, or copy the file from another copy of this directory",
            self.wanted
        );
        ShardError::Damaged { path: shared.path().join(&self.name), why }
    }
}

/// Refuses a directory whose study, or an input of it, is not as it was published.
///
/// # Errors
/// [`ShardError::Damaged`] names the file.
pub(super) fn refuse_damaged_study(shared: &Shared, frozen: &Frozen) -> Result<(), ShardError> {
    refuse(shared, frozen, of_study(frozen))
}

/// Refuses a directory whose plan or basis is not as it was published.
///
/// # Errors
/// [`ShardError::Damaged`] names the file.
pub(super) fn refuse_damaged_basis(shared: &Shared, frozen: &Frozen) -> Result<(), ShardError> {
    refuse(shared, frozen, computed(frozen))
}

/// Refuses a directory in which no chunk was made with its `shards.json`, and one was with another of the same study, plan and basis: then
/// that file has changed, and not the chunks.
///
/// # Errors
/// [`ShardError::Damaged`].
pub(super) fn refuse_other_list(shared: &Shared, frozen: &Frozen) -> Result<(), ShardError> {
    let identity = frozen.identity();
    let agrees = |of: &Value, keys: &[&str]| keys.iter().all(|key| of[*key] == identity[*key]);
    let mut other = None;
    let mut left = LOOKED_AT;
    for number in frozen.chunks.folders() {
        // where chunks cannot be read now, the attempts to read or publish one wait for them
        let (Ok(names), Ok(Some(folder))) = (shared.names_in(number), shared.chunks_in(number)) else { continue };
        for chunk in names.into_iter().take(left) {
            left -= 1;
            let Some(head) = head(&folder, chunk) else { continue };
            if agrees(&head["of"], &["shards_blake3"]) {
                return Ok(());
            }
            if agrees(&head["of"], &["study_blake3", "plan_blake3", "basis_blake3"]) {
                other.get_or_insert(chunk);
            }
        }
        if left == 0 {
            break;
        }
    }
    let Some(chunk) = other else { return Ok(()) };
    let why = format!(
        "it has changed since the chunks were made: chunk {chunk} is of the same study and basis, and of another {SHARDS}; no finished \
         sample is lost; copy it from another copy of this directory"
    );
    Err(ShardError::Damaged { path: shared.path().join(SHARDS), why })
}

fn refuse(shared: &Shared, frozen: &Frozen, files: Vec<(String, String)>) -> Result<(), ShardError> {
    match all_damaged(shared, files)?.first() {
        Some(damaged) => Err(damaged.refused(shared, frozen)),
        None => Ok(()),
    }
}

/// Restores files of the study that are damaged from a study whose files have the recorded hashes. Others stay as they are.
///
/// # Errors
/// The directory cannot be written.
pub(super) fn restore_study(
    shared: &Shared,
    frozen: &Frozen,
    study: &Samples,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    let damaged = all_damaged(shared, of_study(frozen))?;
    let inputs = if damaged.is_empty() { Vec::new() } else { study.study().inputs() };
    for one in &damaged {
        let text = inputs.iter().find_map(|(name, text)| text.filter(|_| *name == one.name));
        put_back(shared, one, text.map(str::as_bytes), "from the study", note)?;
    }
    Ok(())
}

/// Restores plan and basis where they are damaged. `samples`: of the study that is published.
///
/// # Errors
/// The basis cannot be computed; the directory cannot be written.
pub(super) fn restore_computed(
    shared: &Shared,
    frozen: &Frozen,
    samples: &Samples,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    for one in all_damaged(shared, computed(frozen))? {
        let bytes = if one.name == BASIS_FILE {
            new_basis(samples)?
        } else {
            let basis = match shared.folder().place(BASIS_FILE).read(MOST_BASIS) {
                Ok(bytes) if samples.study().function().is_none() => basis_of_others(samples, bytes)?,
                _ => None,
            };
            let plan = Prepared::with_digest(samples, basis, frozen.digest())?.plan;
            Some(plan.text().as_bytes().to_vec())
        };
        put_back(shared, &one, bytes.as_deref(), "computed again", note)?;
    }
    Ok(())
}

/// Puts bytes in the place of a damaged file, if they have its hash.
fn put_back(
    shared: &Shared,
    damaged: &Damaged,
    bytes: Option<&[u8]>,
    how: &str,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    let Some(bytes) = bytes.filter(|bytes| has_hash(bytes, &damaged.wanted)) else { return Ok(()) };
    write_whole(shared.folder().place(&damaged.name), bytes)?;
    let what = if damaged.is_missing { "missing" } else { "damaged" };
    note(&format!(
        "{} was {what} and is restored ({how}): its BLAKE3 is the recorded one",
        shown(shared.path().join(&damaged.name))
    ));
    Ok(())
}

/// Whether the study's files are as they were published, and whether plan and basis are.
///
/// # Errors
/// A file cannot be read now.
pub(super) fn are_whole(shared: &Shared, frozen: &Frozen) -> Result<(bool, bool), FileError> {
    Ok((all_damaged(shared, of_study(frozen))?.is_empty(), all_damaged(shared, computed(frozen))?.is_empty()))
}
