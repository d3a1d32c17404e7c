//! The record `shards.json` that all shards of a directory share: hashes of the published files, program, chunk size.
//!
//! ```text
//! basis.bin                    the one thing that another version may compute otherwise: the first one counts for all
//! study.toml, machine.toml ... the same bytes of everybody, or this is another study
//! plan.json                    follows from both
//! shards.json                  with it the directory is begun
//! ```

use super::super::error::Change;
use super::super::prepare::Prepared;
use super::super::provenance::EXPONENTIAL;
use super::error::ShardError;
use super::layout::{Chunks, MOST_CHUNKS, MOST_OF_CHUNK, SHARDS};
use super::shared::Shared;
use crate::version::VERSION;
use bladeoff_system::files::FileError;
use serde_json::{Map, Value, json};
use std::io;

/// What the file says it is.
const FORMAT: &str = "bladeoff shards";
/// Version of its layout.
const VERSION_OF_LAYOUT: u64 = 1;
/// Largest that is read.
const MOST: u64 = 1 << 20;

/// Keys of the versions of a program, which may differ without damage.
pub(super) const VERSIONS: [&str; 5] = ["program", "numerics_version", "table_schema", "ledger_version", EXPONENTIAL];

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

    /// A hash of a published file, by its key.
    pub fn hash_of(&self, key: &str) -> Option<String> {
        self.said.get("provenance")?.get(key)?.as_str().map(str::to_owned)
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

    /// As an error of its own file: the files beside it are as they were published, and it does not say what follows from them.
    pub fn contradicts(&self, shared: &Shared, changes: &[Change]) -> ShardError {
        let changes: Vec<String> = changes.iter().map(Change::to_string).collect();
        let why = format!(
            "it is damaged: it does not agree with the study and the basis beside it ({}); no finished sample is lost; copy it from \
             another copy of this directory",
            changes.join("; ")
        );
        ShardError::Damaged { path: shared.path().join(SHARDS), why }
    }

    /// Refuses what does not say the same.
    pub fn check(&self, shared: &Shared, wanted: &Map<String, Value>) -> Result<(), ShardError> {
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
pub(super) fn said(prepared: &Prepared<'_>, of: &Frozen) -> Map<String, Value> {
    saying(prepared, of.chunks.size())
}

pub(super) fn saying(prepared: &Prepared<'_>, chunk: u64) -> Map<String, Value> {
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
