//! What all shards of a directory have in common, published once: inputs, basis, plan and, last, `shards.json`, which says the rest.
//!
//! ```text
//! basis.bin                    the one thing that another version may compute otherwise: whoever is first, all others take his
//! study.toml, machine.toml ... the same bytes of everybody, or this is another study
//! plan.json                    follows from both
//! shards.json                  the hashes of all that, the program, the chunk: with it the directory is begun
//! ```
//! Each by `link(2)` and read back. Who is killed between two of them leaves a beginning that the next one goes on from.

use super::super::columns::own_columns;
use super::super::error::Change;
use super::super::prepare::{Frozen as Bytes, Prepared, basis_of_others, new_basis};
use super::super::provenance::EXPONENTIAL;
use super::error::ShardError;
use super::layout::{Chunks, MOST_CHUNKS, MOST_OF_CHUNK, SHARDS};
use super::publish::put_once;
use super::shared::Shared;
use crate::settled::as_planned;
use crate::version::VERSION;
use bladeoff_study::{FrozenFiles, Samples, load_frozen};
use bladeoff_system::files::FileError;
use bladeoff_system::place::Place;
use bladeoff_worker::plan::{BASIS_FILE, MOST_BASIS, PLAN_FILE};
use serde_json::{Map, Value, json};
use std::io;
use std::path::Path;

/// What the file says it is.
const FORMAT: &str = "bladeoff shards";
/// Version of its layout.
const VERSION_OF_LAYOUT: u64 = 1;
/// Largest that is read.
const MOST: u64 = 1 << 20;

/// What `shards.json` says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frozen {
    said: Map<String, Value>,
    /// BLAKE3 of its bytes: which directory of shards this is.
    pub hash: String,
    /// How samples are chunked.
    pub chunks: Chunks,
}

impl Frozen {
    /// Reads it; `None` if it is not there.
    ///
    /// # Errors
    /// It cannot be read, or is of another version.
    pub fn read(shared: &Shared) -> Result<Option<Self>, ShardError> {
        let place = shared.folder().place(SHARDS);
        let bytes = match place.read(MOST) {
            Ok(bytes) => bytes,
            Err(error) if error.source.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let damaged = |why: &str| ShardError::Damaged { path: place.to_path_buf(), why: why.to_owned() };
        let said = match serde_json::from_slice(&bytes) {
            Ok(Value::Object(said)) if said.get("format") == Some(&json!(FORMAT)) => said,
            _ => return Err(damaged("it is none that a shard has written")),
        };
        if said.get("version") != Some(&json!(VERSION_OF_LAYOUT)) {
            return Err(damaged("it is of another version of bladeoff"));
        }
        let number = |key: &str| said.get(key).and_then(Value::as_u64).filter(|number| *number > 0);
        let (Some(samples), Some(size)) = (number("samples"), number("chunk")) else {
            return Err(damaged("it does not say how many samples there are, and in which chunks"));
        };
        let chunks = Chunks::new(samples, size);
        if size > MOST_OF_CHUNK || chunks.count() > MOST_CHUNKS {
            return Err(damaged("its chunks are too large or too many"));
        }
        Ok(Some(Self { hash: blake3::hash(&bytes).to_hex().to_string(), said, chunks }))
    }

    /// Those of which samples are needed at most; `last`: by `[stop]`.
    pub fn needed(&self, last: Option<u64>) -> Chunks {
        last.map_or(self.chunks, |last| self.chunks.up_to(last))
    }

    /// Whether the directory is still the one that was begun so.
    ///
    /// # Errors
    /// It cannot be looked at.
    pub fn is_it(&self, shared: &Shared) -> Result<bool, FileError> {
        match shared.folder().place(SHARDS).read(MOST) {
            Ok(bytes) => Ok(blake3::hash(&bytes).to_hex().as_str() == self.hash),
            Err(error) if error.source.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Hash of all keys.
    pub fn digest(&self) -> Option<String> {
        self.text("samples_blake3")
    }

    /// The program that began the directory.
    pub fn program(&self) -> Option<String> {
        self.text("program")
    }

    /// Name of the study.
    pub fn study(&self) -> String {
        self.text("study").unwrap_or_default()
    }

    fn text(&self, key: &str) -> Option<String> {
        self.said.get(key).and_then(Value::as_str).map(str::to_owned)
    }

    /// `--scale` and `--limit` of it.
    pub fn part(&self) -> (Option<f64>, Option<u64>) {
        (self.said.get("scale").and_then(Value::as_f64), self.said.get("limit").and_then(Value::as_u64))
    }

    /// The study's file as it was named.
    pub fn study_file(&self) -> String {
        self.text("study_file").unwrap_or_default()
    }

    /// What a chunk says of where it comes from: the hash of all this, and its most telling parts for people.
    pub fn identity(&self) -> Value {
        let part = |key: &str| self.said.get("provenance").and_then(|all| all.get(key)).cloned().unwrap_or(Value::Null);
        json!({
            "shards_blake3": self.hash,
            "program": self.said.get("program"),
            "numerics_version": part("numerics_version"),
            "exponential_revision": part(EXPONENTIAL),
            "study_blake3": part("study_blake3"),
            "plan_blake3": part("plan_blake3"),
            "basis_blake3": part("basis_blake3"),
            "samples_blake3": self.said.get("samples_blake3"),
        })
    }

    /// The samples of the study that is frozen beside it.
    ///
    /// # Errors
    /// It cannot be read any more.
    pub fn samples(&self, shared: &Shared) -> Result<Samples, ShardError> {
        let damaged = |error: bladeoff_study::StudyError| ShardError::Damaged {
            path: shared.path().into(),
            why: error.to_string(),
        };
        let mut study = load_frozen(FrozenFiles::of(shared.path()), own_columns).map_err(damaged)?;
        // Without a name of its own it is called as its file was.
        as_planned(&mut study, shared.path());
        (study.name, study.file) = (self.study(), self.study_file());
        let (scale, limit) = self.part();
        Samples::new(study, scale, limit).map_err(damaged)
    }

    /// The same ready to be written as tables, with the basis that is frozen there. A later program with the same numerics may read what it
    /// does not go on with.
    ///
    /// # Errors
    /// A file there is not the one that was published.
    pub fn prepared<'a>(&self, shared: &Shared, samples: &'a Samples) -> Result<Prepared<'a>, ShardError> {
        let prepared = Prepared::with_digest(samples, read_basis(shared, samples)?, self.digest())?;
        let mut wanted = said(&prepared, self);
        wanted.insert("program".to_owned(), json!(self.program()));
        self.check(shared, &wanted)?;
        Ok(prepared)
    }

    /// Refuses what does not say the same.
    fn check(&self, shared: &Shared, wanted: &Map<String, Value>) -> Result<(), ShardError> {
        let changes = differences("", &Value::Object(self.said.clone()), &Value::Object(wanted.clone()));
        if changes.is_empty() {
            Ok(())
        } else {
            Err(ShardError::Changed { path: shared.path().to_path_buf(), changes })
        }
    }
}

/// What differs, key by key.
fn differences(before: &str, from: &Value, to: &Value) -> Vec<Change> {
    let (Value::Object(old), Value::Object(new)) = (from, to) else {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let change = || Change { key: before.to_owned(), from: text(from), to: text(to) };
        return if from == to { Vec::new() } else { vec![change()] };
    };
    // The name and the folder of the study's file do not count. An earlier build does not name the revision of the exponential engine, which its keys
    // count all the same.
    let is_unnamed = |key: &str| key == EXPONENTIAL && !old.contains_key(key);
    let keys: std::collections::BTreeSet<&String> =
        old.keys().chain(new.keys()).filter(|key| *key != "study_file" && !is_unnamed(key)).collect();
    let null = Value::Null;
    let of = |key: &String| differences(key, old.get(key).unwrap_or(&null), new.get(key).unwrap_or(&null));
    keys.into_iter().flat_map(of).collect()
}

/// What the file of a study says; its chunk from a file that is there.
fn said(prepared: &Prepared<'_>, of: &Frozen) -> Map<String, Value> {
    saying(prepared, of.chunks.size())
}

fn saying(prepared: &Prepared<'_>, chunk: u64) -> Map<String, Value> {
    let samples = prepared.samples;
    let provenance: Map<String, Value> =
        prepared.provenance.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
    let value = json!({
        "format": FORMAT,
        "version": VERSION_OF_LAYOUT,
        "program": *VERSION,
        "study": samples.study().name,
        "study_file": samples.study().file,
        "samples": samples.count(),
        "chunk": chunk,
        "scale": samples.scale(),
        "limit": samples.limit(),
        "samples_blake3": prepared.digest,
        "provenance": provenance,
    });
    let Value::Object(said) = value else { unreachable!("written as an object") };
    said
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

/// Takes what is published, or publishes it. `chunk`: how many samples a chunk is to have, by whoever is first; `asked`: by the user; `old`: a
/// directory whose samples will be taken over.
///
/// # Errors
/// The directory was begun with another study, program or chunk; files.
pub(super) fn freeze<'a>(
    shared: &Shared,
    samples: &'a Samples,
    (asked, old): (Option<u64>, Option<&Path>),
    chunk: impl FnOnce(&Prepared<'_>) -> u64,
) -> Result<(Frozen, Prepared<'a>), ShardError> {
    if let Some(frozen) = Frozen::read(shared)? {
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
    let is_same_input = |(name, text): (String, Option<&str>)| match text {
        Some(text) => shared.folder().place(&name).read(text.len() as u64).is_ok_and(|found| found == text.as_bytes()),
        None => !shared.folder().place(&name).exists(),
    };
    let (scale, limit) = frozen.part();
    let is_same = samples.study().inputs().into_iter().all(is_same_input)
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
    frozen.check(shared, &said(&prepared, frozen))?;
    Ok(prepared)
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

/// Publishes a file that everybody's is equal to.
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
