//! Shared files of a directory, compared with the hashes in `shards.json`; restoration of damaged and missing ones.
//!
//! A file is restored only from bytes that have its recorded hash: the study and its inputs from the files that they were read
//! from, the plan from the study, and the basis by computing it again. So any process may restore it, and several at once.

use super::super::prepare::{Prepared, basis_of_others, new_basis};
use super::super::provenance::empirical_key;
use super::chunk::head;
use super::error::ShardError;
use super::layout::SHARDS;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use bladeoff_study::sampling::layout::MOST_PARAMETERS;
use bladeoff_study::{MACHINE, POINTS, STUDY, Samples, empirical};
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::shown;
use bladeoff_worker::job_spec::{BASIS_FILE, MOST_BASIS, PLAN_FILE};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::Path;

/// Largest study, machine, points file or plan that is compared \[bytes\].
const MOST_INPUT: u64 = 1 << 30;
/// Number of chunks whose heads are compared with `shards.json`.
const LOOKED_AT: usize = 100;
/// Files of the study and the keys of their hashes.
const OF_STUDY: [(&str, &str); 3] = [(STUDY, "study_blake3"), (MACHINE, "machine_blake3"), (POINTS, "points_blake3")];
/// Files computed from those, and the keys of their hashes.
const COMPUTED: [(&str, &str); 2] = [(BASIS_FILE, "basis_blake3"), (PLAN_FILE, "plan_blake3")];

/// Damaged or missing shared file.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Damaged {
    name: String,
    /// Recorded BLAKE3.
    wanted: String,
    is_missing: bool,
}

/// Names and hashes of the files of the study.
fn of_study(shards_file: &ShardsFile) -> Vec<(String, String)> {
    let own = OF_STUDY.map(|(name, key)| (name.to_owned(), key.to_owned())).into_iter();
    let of_laws = (0..MOST_PARAMETERS).map(|file| (empirical(file), empirical_key(file)));
    own.chain(of_laws).filter_map(|(name, key)| Some((name, shards_file.hash_of(&key)?))).collect()
}

/// Names and hashes of the computed files.
fn computed(shards_file: &ShardsFile) -> Vec<(String, String)> {
    COMPUTED.iter().filter_map(|(name, key)| Some(((*name).to_owned(), shards_file.hash_of(key)?))).collect()
}

/// Compares a file with its recorded hash; `None`: it is unchanged.
///
/// # Errors
/// The file cannot be read now.
fn damage(shared: &Shared, (name, wanted): (String, String)) -> Result<Option<Damaged>, FileError> {
    let most = if name == BASIS_FILE { MOST_BASIS } else { MOST_INPUT };
    let is_missing = match shared.folder().place(&name).read(most) {
        Ok(bytes) if has_hash(&bytes, &wanted) => return Ok(None),
        Ok(_) => false,
        Err(error) if error.source.kind() == ErrorKind::NotFound => true,
        // Too long, or not a regular file.
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
    /// Error that rejects the directory.
    fn refused(&self, shared: &Shared, shards_file: &ShardsFile) -> ShardError {
        let what = if self.is_missing { "missing" } else { "damaged: its bytes have changed since it was written" };
        let from = match self.name.as_str() {
            BASIS_FILE | PLAN_FILE => format!(
                "`run --shard` and `merge` of the program that began the directory ({}) restore it",
                shards_file.program().unwrap_or_default()
            ),
            _ => format!(
                "`run --shard` with the study as it was, {}, restores it",
                shown(Path::new(&shards_file.study_file()))
            ),
        };
        let why = format!(
            "it is {what} (BLAKE3 in {SHARDS}: {}); no finished sample is lost; {from}, or copy the file from another copy of this directory",
            self.wanted
        );
        ShardError::Damaged { path: shared.path().join(&self.name), why }
    }
}

/// Rejects a directory with a damaged study or input.
///
/// # Errors
/// [`ShardError::Damaged`] names the file.
pub(super) fn refuse_damaged_study(shared: &Shared, shards_file: &ShardsFile) -> Result<(), ShardError> {
    refuse(shared, shards_file, of_study(shards_file))
}

/// Rejects a directory with a damaged plan or basis.
///
/// # Errors
/// [`ShardError::Damaged`] names the file.
pub(super) fn refuse_damaged_basis(shared: &Shared, shards_file: &ShardsFile) -> Result<(), ShardError> {
    refuse(shared, shards_file, computed(shards_file))
}

/// Rejects a directory whose `shards.json` has changed: no chunk was made with it, but one was made with another of the same
/// study, plan and basis.
///
/// # Errors
/// [`ShardError::Damaged`].
pub(super) fn refuse_other_list(shared: &Shared, shards_file: &ShardsFile) -> Result<(), ShardError> {
    let identity = shards_file.identity();
    let agrees = |of: &Value, keys: &[&str]| keys.iter().all(|key| of[*key] == identity[*key]);
    let mut other = None;
    let mut left = LOOKED_AT;
    for number in shards_file.chunks.folders() {
        // Unreadable chunks are retried by the attempts to read or publish them.
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
        "it has changed since the chunks were made: chunk {chunk} is of the same study and basis, and of another \
         {SHARDS}. No finished sample is lost. Copy the file from another copy of this directory, or compute the \
         study in a new directory (--out NEW)"
    );
    Err(ShardError::Damaged { path: shared.path().join(SHARDS), why })
}

fn refuse(shared: &Shared, shards_file: &ShardsFile, files: Vec<(String, String)>) -> Result<(), ShardError> {
    match all_damaged(shared, files)?.first() {
        Some(damaged) => Err(damaged.refused(shared, shards_file)),
        None => Ok(()),
    }
}

/// Restores damaged files of the study, if the given study has the recorded hashes.
///
/// # Errors
/// The directory cannot be written.
pub(super) fn restore_study(
    shared: &Shared,
    shards_file: &ShardsFile,
    study: &Samples,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    let damaged = all_damaged(shared, of_study(shards_file))?;
    let inputs = if damaged.is_empty() { Vec::new() } else { study.study().inputs() };
    for one in &damaged {
        let text = inputs.iter().find_map(|(name, text)| text.filter(|_| *name == one.name));
        put_back(shared, one, text.map(str::as_bytes), "from the study", note)?;
    }
    Ok(())
}

/// Restores a damaged plan and basis. `samples`: of the published study.
///
/// # Errors
/// The basis cannot be computed; the directory cannot be written.
pub(super) fn restore_computed(
    shared: &Shared,
    shards_file: &ShardsFile,
    samples: &Samples,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    for one in all_damaged(shared, computed(shards_file))? {
        let bytes = if one.name == BASIS_FILE {
            new_basis(samples)?
        } else {
            let basis = match shared.folder().place(BASIS_FILE).read(MOST_BASIS) {
                Ok(bytes) if samples.study().function().is_none() => basis_of_others(samples, bytes)?,
                _ => None,
            };
            let job = Prepared::with_digest(samples, basis, shards_file.digest())?.job;
            Some(job.text().as_bytes().to_vec())
        };
        put_back(shared, &one, bytes.as_deref(), "computed again", note)?;
    }
    Ok(())
}

/// Replaces a damaged file by bytes with the recorded hash.
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

/// Whether the files of the study are unchanged, and whether plan and basis are.
///
/// # Errors
/// A file cannot be read now.
pub(super) fn are_whole(shared: &Shared, shards_file: &ShardsFile) -> Result<(bool, bool), FileError> {
    Ok((all_damaged(shared, of_study(shards_file))?.is_empty(), all_damaged(shared, computed(shards_file))?.is_empty()))
}
