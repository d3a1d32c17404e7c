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
/// Key of the BLAKE3 of all other keys.
const CHECKSUM: &str = "checksum";
/// Advice for a damaged `shards.json`.
const WHAT_TO_DO: &str = "no finished sample is lost; copy shards.json from another copy of this directory, or compute the study in a new \
                          directory (--out NEW)";

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
        let damaged = |why: &str| {
            let why = format!("it is damaged: {why}; {WHAT_TO_DO}");
            ShardError::Damaged { path: place.to_path_buf(), why }
        };
        let Ok(Value::Object(mut fields)) = serde_json::from_slice(&bytes) else {
            return Err(damaged("it is not a JSON object"));
        };
        match fields.remove(CHECKSUM) {
            Some(found) if found == json!(checksum(&fields)) => {}
            Some(_) => return Err(damaged("its contents do not have the recorded checksum")),
            None => return Err(damaged("it has no checksum")),
        }
        if fields.get("format") != Some(&json!(FORMAT)) {
            return Err(damaged(&format!("its key format is not {FORMAT:?}")));
        }
        if fields.get("version") != Some(&json!(VERSION_OF_LAYOUT)) {
            let why = "another version of bladeoff wrote it; use that version, or another --out".to_owned();
            return Err(ShardError::Damaged { path: place.to_path_buf(), why });
        }
        let number = |key: &str| fields.get(key).and_then(Value::as_u64).filter(|number| *number > 0);
        let (Some(samples), Some(size)) = (number("samples"), number("chunk")) else {
            return Err(damaged("it lacks the number of samples or the chunk size"));
        };
        let chunks = Chunks::new(samples, size);
        if size > MOST_OF_CHUNK || chunks.count() > MOST_CHUNKS {
            return Err(damaged("its chunk size or its number of chunks is out of range"));
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
            "it is damaged: it does not agree with the study and the basis beside it ({}); {WHAT_TO_DO}",
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

/// BLAKE3 of the contents, as the key `checksum` has it.
fn checksum(fields: &Map<String, Value>) -> String {
    let text = Value::Object(fields.clone()).to_string();
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

/// Text of a new `shards.json`, with its checksum.
pub(super) fn text_of(mut fields: Map<String, Value>) -> String {
    fields.insert(CHECKSUM.to_owned(), json!(checksum(&fields)));
    format!("{:#}\n", Value::Object(fields))
}

/// Lists differences by key.
fn differences(before: &str, from: &Value, to: &Value) -> Vec<Change> {
    let (Value::Object(old), Value::Object(new)) = (from, to) else {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let change = || Change { key: before.to_owned(), from: text(from), to: text(to) };
        return if from == to { Vec::new() } else { vec![change()] };
    };
    // name and folder of the study file do not count
    let keys: std::collections::BTreeSet<&String> =
        old.keys().chain(new.keys()).filter(|key| *key != "study_file").collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::shards::shared::Shared;

    const FIELDS: &str = r#"{"chunk": 10, "format": "bladeoff shards", "limit": null, "program": "0.1.0", "provenance": {"seed": "3"},
        "samples": 120, "samples_blake3": "bba7", "scale": null, "study": "f", "study_file": "f.toml", "version": 1}"#;

    fn read(bytes: &[u8]) -> Result<Option<ShardsFile>, ShardError> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(SHARDS), bytes).expect("written");
        ShardsFile::read(&Shared::open(folder.path()).expect("readable").expect("there"))
    }

    /// Every single flipped bit is found, and the message names the file and a remedy.
    #[test]
    fn every_flipped_bit_of_shards_json_is_found() {
        let fields: Map<String, Value> = serde_json::from_str(FIELDS).expect("JSON");
        let whole = text_of(fields.clone()).into_bytes();
        let known = read(&whole).expect("whole").expect("there");
        assert_eq!(known.fields, fields);
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            match read(&bytes) {
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains(SHARDS) && text.contains("it is damaged") && text.contains("copy"), "{text}");
                }
                // white space between tokens, or the case of an escape
                Ok(found) => assert_eq!(found.expect("there").fields, fields, "bit {bit}"),
            }
        }
    }

    #[test]
    fn a_file_without_a_checksum_is_damaged() {
        let without = read(FIELDS.as_bytes()).expect_err("damaged").to_string();
        assert!(without.contains("it has no checksum"), "{without}");
    }
}
