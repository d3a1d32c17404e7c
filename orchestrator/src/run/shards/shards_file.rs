//! The record `shards.json` that all shards of a directory share: hashes of the published files, program, chunk size.
//!
//! ```text
//! basis.bin                    other versions may compute other last digits: the first published basis counts
//! study.toml, machine.toml ... must have the same bytes in every process, otherwise the study is another one
//! plan.json                    follows from both
//! shards.json                  begins the directory
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

/// Value of the key `format`.
const FORMAT: &str = "bladeoff shards";
/// Version of the layout.
const VERSION_OF_LAYOUT: u64 = 1;
/// Largest file that is read \[bytes\].
const MOST: u64 = 1 << 20;

/// Keys that name versions of a program. A difference in them is no damage.
pub(super) const VERSIONS: [&str; 5] = ["program", "numerics_version", "table_schema", "ledger_version", EXPONENTIAL];

/// Contents of `shards.json`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ShardsFile {
    fields: Map<String, Value>,
    /// BLAKE3 of the file, which identifies the directory.
    pub hash: String,
    /// Chunks of the study.
    pub chunks: Chunks,
}

impl ShardsFile {
    /// Reads `shards.json`; `None`: it does not exist.
    ///
    /// # Errors
    /// An unreadable file or an unknown version.
    pub fn read(shared: &Shared) -> Result<Option<Self>, ShardError> {
        let place = shared.folder().place(SHARDS);
        let bytes = match place.read(MOST) {
            Ok(bytes) => bytes,
            Err(error) if error.source.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let damaged = |why: &str| ShardError::Damaged { path: place.to_path_buf(), why: why.to_owned() };
        let fields = match serde_json::from_slice(&bytes) {
            Ok(Value::Object(fields)) if fields.get("format") == Some(&json!(FORMAT)) => fields,
            _ => return Err(damaged("it is none that a shard has written")),
        };
        if fields.get("version") != Some(&json!(VERSION_OF_LAYOUT)) {
            return Err(damaged("it is of another version of bladeoff"));
        }
        let number = |key: &str| fields.get(key).and_then(Value::as_u64).filter(|number| *number > 0);
        let (Some(samples), Some(size)) = (number("samples"), number("chunk")) else {
            return Err(damaged("it does not say how many samples there are, and in which chunks"));
        };
        let chunks = Chunks::new(samples, size);
        if size > MOST_OF_CHUNK || chunks.count() > MOST_CHUNKS {
            return Err(damaged("its chunks are too large or too many"));
        }
        Ok(Some(Self { hash: blake3::hash(&bytes).to_hex().to_string(), fields, chunks }))
    }

    /// Chunks that the study needs at most; `last`: largest number of samples, by `[stop]`.
    pub fn needed(&self, last: Option<u64>) -> Chunks {
        last.map_or(self.chunks, |last| self.chunks.up_to(last))
    }

    /// Whether the directory still has this `shards.json`.
    ///
    /// # Errors
    /// A file error.
    pub fn is_current(&self, shared: &Shared) -> Result<bool, FileError> {
        match shared.folder().place(SHARDS).read(MOST) {
            Ok(bytes) => Ok(blake3::hash(&bytes).to_hex().as_str() == self.hash),
            Err(error) if error.source.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Hash of all sample keys.
    pub fn digest(&self) -> Option<String> {
        self.text("samples_blake3")
    }

    /// Program that began the directory.
    pub fn program(&self) -> Option<String> {
        self.text("program")
    }

    /// Name of the study.
    pub fn study(&self) -> String {
        self.text("study").unwrap_or_default()
    }

    /// Hash of a published file, by its key.
    pub fn hash_of(&self, key: &str) -> Option<String> {
        self.fields.get("provenance")?.get(key)?.as_str().map(str::to_owned)
    }

    fn text(&self, key: &str) -> Option<String> {
        self.fields.get(key).and_then(Value::as_str).map(str::to_owned)
    }

    /// Values of `--scale` and `--limit`.
    pub fn selection(&self) -> (Option<f64>, Option<u64>) {
        (self.fields.get("scale").and_then(Value::as_f64), self.fields.get("limit").and_then(Value::as_u64))
    }

    /// Study file as named on the command line.
    pub fn study_file(&self) -> String {
        self.text("study_file").unwrap_or_default()
    }

    /// Origin of a chunk for its head: the hash of this file, and the values that explain it to a reader.
    pub fn identity(&self) -> Value {
        let part =
            |key: &str| self.fields.get("provenance").and_then(|all| all.get(key)).cloned().unwrap_or(Value::Null);
        json!({
            "shards_blake3": self.hash,
            "program": self.fields.get("program"),
            "numerics_version": part("numerics_version"),
            "exponential_revision": part(EXPONENTIAL),
            "study_blake3": part("study_blake3"),
            "plan_blake3": part("plan_blake3"),
            "basis_blake3": part("basis_blake3"),
            "samples_blake3": self.fields.get("samples_blake3"),
        })
    }

    /// Error for a damaged `shards.json` beside undamaged files, whose hashes contradict it.
    pub fn contradicts(&self, shared: &Shared, changes: &[Change]) -> ShardError {
        let changes: Vec<String> = changes.iter().map(Change::to_string).collect();
        let why = format!(
            "it is damaged: it does not agree with the study and the basis beside it ({}); no finished sample is lost; copy it from \
             another copy of this directory",
            changes.join("; ")
        );
        ShardError::Damaged { path: shared.path().join(SHARDS), why }
    }

    /// Rejects expected contents that differ.
    pub fn check(&self, shared: &Shared, wanted: &Map<String, Value>) -> Result<(), ShardError> {
        let changes = differences("", &Value::Object(self.fields.clone()), &Value::Object(wanted.clone()));
        if changes.is_empty() {
            Ok(())
        } else {
            Err(ShardError::Changed { path: shared.path().to_path_buf(), changes })
        }
    }
}

/// Lists differences by key.
fn differences(before: &str, from: &Value, to: &Value) -> Vec<Change> {
    let (Value::Object(old), Value::Object(new)) = (from, to) else {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let change = || Change { key: before.to_owned(), from: text(from), to: text(to) };
        return if from == to { Vec::new() } else { vec![change()] };
    };
    // Name and folder of the study file do not count. An earlier build does not name the revision of the exponential engine,
    // which is part of its sample keys.
    let is_unnamed = |key: &str| key == EXPONENTIAL && !old.contains_key(key);
    let keys: std::collections::BTreeSet<&String> =
        old.keys().chain(new.keys()).filter(|key| *key != "study_file" && !is_unnamed(key)).collect();
    let null = Value::Null;
    let of = |key: &String| differences(key, old.get(key).unwrap_or(&null), new.get(key).unwrap_or(&null));
    keys.into_iter().flat_map(of).collect()
}

/// Contents of `shards.json` for a study, with the chunk size of an existing file.
pub(super) fn expected_fields(prepared: &Prepared<'_>, of: &ShardsFile) -> Map<String, Value> {
    new_fields(prepared, of.chunks.size())
}

pub(super) fn new_fields(prepared: &Prepared<'_>, chunk: u64) -> Map<String, Value> {
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
    let Value::Object(fields) = value else { unreachable!("written as an object") };
    fields
}
