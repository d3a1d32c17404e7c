//! A finished chunk as a file: the entries of the record, in the order of their samples, with what they come from, and a checksum.
//!
//! ```text
//! b"bOfC" | u8 version | u32 length of the head | head: JSON | entries, one behind the other | 32 bytes of BLAKE3 of all before
//! ```
//! Little endian. The head says which chunk of which study, program and numerics this is, and who computed it. Each entry has its own
//! length, key and checksum (`orchestrator/record/src/entry.rs`). It is read with a limit and whole, or it is none.

use super::super::prepare::Prepared;
use super::frozen::Frozen;
use super::layout::chunk_name;
use bladeoff_record::{Entry, EntryError};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Unfit;
use serde_json::{Value, json};
use std::io::{self, Read};

const MAGIC: [u8; 4] = *b"bOfC";
const VERSION: u8 = 1;
const CHECKSUM: usize = 32;
const BEFORE_HEAD: usize = 4 + 1 + 4;
/// Bytes of the longest head.
const MOST_HEAD: u64 = 64 << 10;
/// Bytes of the longest entry that a message can bring.
const MOST_ENTRY: u64 = 4096;

/// A chunk that was read.
#[derive(Debug)]
pub(super) struct Chunk {
    /// Who computed it: as its head says.
    pub by: Value,
    /// An entry for each sample.
    pub entries: Vec<Entry>,
}

/// Why a file is not the chunk that is wanted.
#[derive(Debug, thiserror::Error)]
pub(super) enum ChunkError {
    /// There is no such file.
    #[error("missing")]
    Missing,
    /// The bytes have changed since they were written, or are none of a chunk.
    #[error("damaged: {0}")]
    Damaged(&'static str),
    /// Of another version.
    #[error("version {0} of the format, this program knows {VERSION}")]
    Version(u8),
    /// It comes from something else.
    #[error("of another study, program or chunk: {key} is {found}, not {wanted}")]
    Other {
        /// What differs.
        key: String,
        /// In the file.
        found: String,
        /// Here.
        wanted: String,
    },
    /// One of its entries.
    #[error("sample {sample}: {source}")]
    Record {
        /// Which.
        sample: u64,
        /// What is wrong with it.
        source: EntryError,
    },
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(io::Error),
}

/// A chunk as bytes. `entries`: of its samples, in their order; `by`: who computed it.
pub(super) fn encode(frozen: &Frozen, chunk: u64, by: &Value, entries: &[Vec<u8>]) -> Vec<u8> {
    let range = frozen.chunks.range(chunk);
    let head = json!({
        "chunk": chunk,
        "first": range.start,
        "samples": entries.len(),
        "of": frozen.identity(),
        "by": by,
    });
    let head = head.to_string();
    let length = u32::try_from(head.len()).expect("names of hosts and jobs are short");
    let mut bytes =
        Vec::with_capacity(BEFORE_HEAD + head.len() + entries.iter().map(Vec::len).sum::<usize>() + CHECKSUM);
    bytes.extend(MAGIC);
    bytes.push(VERSION);
    bytes.extend(length.to_le_bytes());
    bytes.extend(head.as_bytes());
    entries.iter().for_each(|entry| bytes.extend(entry));
    let sum = blake3::hash(&bytes);
    bytes.extend(sum.as_bytes());
    bytes
}

/// Reads a chunk and checks everything in it: checksum, origin, number, the key of every entry.
///
/// # Errors
/// See [`ChunkError`].
pub(super) fn read(folder: &Folder, frozen: &Frozen, prepared: &Prepared<'_>, chunk: u64) -> Result<Chunk, ChunkError> {
    let range = frozen.chunks.range(chunk);
    let most = MOST_HEAD + (range.end - range.start) * MOST_ENTRY;
    let bytes = match folder.place(chunk_name(chunk)).read_checked(most) {
        Ok(bytes) => bytes,
        Err(Unfit::TooLarge { .. }) => {
            return Err(ChunkError::Damaged("it is longer than any chunk of so many samples"));
        }
        Err(Unfit::Io(error)) if error.kind() == io::ErrorKind::NotFound => return Err(ChunkError::Missing),
        Err(error) => return Err(ChunkError::Io(error.into())),
    };
    decode(&bytes, frozen, prepared, chunk)
}

fn decode(bytes: &[u8], frozen: &Frozen, prepared: &Prepared<'_>, chunk: u64) -> Result<Chunk, ChunkError> {
    let (head, mut rest) = opened(bytes)?;
    let range = frozen.chunks.range(chunk);
    let wanted =
        json!({ "chunk": chunk, "first": range.start, "samples": range.end - range.start, "of": frozen.identity() });
    for key in ["chunk", "first", "samples"] {
        same(key, &head[key], &wanted[key])?;
    }
    let identity = wanted["of"].as_object().expect("written as an object");
    for (key, wanted) in identity {
        same(key, &head["of"][key], wanted)?;
    }
    let mut entries = Vec::with_capacity(usize::try_from(range.end - range.start).unwrap_or_default());
    for sample in range {
        let record = |source| ChunkError::Record { sample, source };
        let (key, entry, behind) = Entry::first_of(rest).map_err(record)?;
        if key != prepared.keys.key(sample) {
            return Err(record(EntryError::Key));
        }
        entries.push(entry);
        rest = behind;
    }
    if !rest.is_empty() {
        return Err(ChunkError::Damaged("more behind its last entry"));
    }
    Ok(Chunk { by: head["by"].clone(), entries })
}

/// The head of a chunk, of whose file no more is read and nothing is checked; `None` if it has none.
pub(super) fn head(folder: &Folder, chunk: u64) -> Option<Value> {
    let mut file = folder.place(chunk_name(chunk)).open().ok()?;
    let mut before = [0; BEFORE_HEAD];
    file.read_exact(&mut before).ok()?;
    let length = u64::from(u32::from_le_bytes(*before.last_chunk()?));
    let mut head = Vec::new();
    file.take(length.min(MOST_HEAD)).read_to_end(&mut head).ok()?;
    serde_json::from_slice(&head).ok().filter(|_| before.starts_with(&MAGIC))
}

/// Head and entries of bytes that are as they were written.
///
/// # Errors
/// They are not, or of another version.
pub(super) fn opened(bytes: &[u8]) -> Result<(Value, &[u8]), ChunkError> {
    let Some(rest) = bytes.strip_prefix(&MAGIC) else {
        return Err(ChunkError::Damaged("it does not begin as a chunk"));
    };
    match rest.first() {
        Some(&VERSION) => {}
        Some(&found) => return Err(ChunkError::Version(found)),
        None => return Err(ChunkError::Damaged("it is cut off")),
    }
    let cut = ChunkError::Damaged("it is cut off");
    let Some((content, sum)) = bytes.split_last_chunk::<CHECKSUM>() else { return Err(cut) };
    if blake3::hash(content) != *sum {
        return Err(ChunkError::Damaged("its bytes have changed since they were written"));
    }
    let Some(length) = content.get(5..).and_then(|rest| rest.first_chunk().copied()).map(u32::from_le_bytes) else {
        return Err(cut);
    };
    let Some((head, entries)) = content[BEFORE_HEAD..].split_at_checked(length as usize) else { return Err(cut) };
    let head = serde_json::from_slice(head).map_err(|_| ChunkError::Damaged("its head is no JSON"))?;
    Ok((head, entries))
}

fn same(key: &str, found: &Value, wanted: &Value) -> Result<(), ChunkError> {
    if found == wanted {
        return Ok(());
    }
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    Err(ChunkError::Other { key: key.to_owned(), found: text(found), wanted: text(wanted) })
}
