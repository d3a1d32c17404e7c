//! File of a finished chunk: its origin, the record entries of its samples in ascending order, and a checksum.
//!
//! ```text
//! b"bOfC" | u8 version | u32 length of the head | head: JSON | entries, one behind the other | 32 bytes of BLAKE3 of all before
//! ```
//! Little endian. The head names chunk, study, program, numerics and attempt. Each entry has its own length, key and checksum
//! (`orchestrator/record/src/entry.rs`). The reader limits the length and rejects the file unless every part is valid.

use super::super::prepare::Prepared;
use super::layout::chunk_name;
use super::shards_file::ShardsFile;
use bladeoff_record::{Entry, EntryError};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Unfit;
use serde_json::{Value, json};
use std::io::{self, Read};

const MAGIC: [u8; 4] = *b"bOfC";
const VERSION: u8 = 1;
const CHECKSUM: usize = 32;
const BEFORE_HEAD: usize = 4 + 1 + 4;
/// Largest head \[bytes\].
const MOST_HEAD: u64 = 64 << 10;
/// Largest entry that a worker message can contain \[bytes\].
const MOST_ENTRY: u64 = 4096;

/// Contents of a chunk.
#[derive(Debug)]
pub(super) struct Chunk {
    /// Attempt that computed the chunk, from the head.
    pub by: Value,
    /// Entries, one per sample.
    pub entries: Vec<Entry>,
}

/// Reason why a file is not the requested chunk.
#[derive(Debug, thiserror::Error)]
pub(super) enum ChunkError {
    /// The file does not exist.
    #[error("missing")]
    Missing,
    /// The bytes changed after the file was written, or are no chunk.
    #[error("damaged: {0}")]
    Damaged(&'static str),
    /// Unknown version of the format.
    #[error("version {0} of the format; this program reads {VERSION}")]
    Version(u8),
    /// The chunk belongs to another study, program or place.
    #[error("of another study, program or chunk: {key} is {found}, not {wanted}")]
    Other {
        /// Key that differs.
        key: String,
        /// Value in the file.
        found: String,
        /// Expected value.
        wanted: String,
    },
    /// An entry is invalid.
    #[error("sample {sample}: {source}")]
    Record {
        /// Sample of the entry.
        sample: u64,
        /// Defect of the entry.
        source: EntryError,
    },
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(io::Error),
}

/// Encodes a chunk. `entries`: entries of its samples in ascending order; `by`: metadata of the attempt.
pub(super) fn encode(shards_file: &ShardsFile, chunk: u64, by: &Value, entries: &[Vec<u8>]) -> Vec<u8> {
    let range = shards_file.chunks.range(chunk);
    let head = json!({
        "chunk": chunk,
        "first": range.start,
        "samples": entries.len(),
        "of": shards_file.identity(),
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

/// Reads a chunk and checks its checksum, origin and number, and the key of every entry.
///
/// # Errors
/// See [`ChunkError`].
pub(super) fn read(
    folder: &Folder,
    shards_file: &ShardsFile,
    prepared: &Prepared<'_>,
    chunk: u64,
) -> Result<Chunk, ChunkError> {
    let range = shards_file.chunks.range(chunk);
    let most = MOST_HEAD + (range.end - range.start) * MOST_ENTRY;
    let bytes = match folder.place(chunk_name(chunk)).read_checked(most) {
        Ok(bytes) => bytes,
        Err(Unfit::TooLarge { .. }) => {
            return Err(ChunkError::Damaged("it is longer than any chunk of so many samples"));
        }
        Err(Unfit::Io(error)) if error.kind() == io::ErrorKind::NotFound => return Err(ChunkError::Missing),
        Err(error) => return Err(ChunkError::Io(error.into())),
    };
    decode(&bytes, shards_file, prepared, chunk)
}

fn decode(bytes: &[u8], shards_file: &ShardsFile, prepared: &Prepared<'_>, chunk: u64) -> Result<Chunk, ChunkError> {
    let (head, mut rest) = opened(bytes)?;
    let range = shards_file.chunks.range(chunk);
    let wanted = json!({ "chunk": chunk, "first": range.start, "samples": range.end - range.start, "of": shards_file.identity() });
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

/// Reads the head of a chunk without any check of the file; `None` if it has no head.
pub(super) fn head(folder: &Folder, chunk: u64) -> Option<Value> {
    let mut file = folder.place(chunk_name(chunk)).open().ok()?;
    let mut before = [0; BEFORE_HEAD];
    file.read_exact(&mut before).ok()?;
    let length = u64::from(u32::from_le_bytes(*before.last_chunk()?));
    let mut head = Vec::new();
    file.take(length.min(MOST_HEAD)).read_to_end(&mut head).ok()?;
    serde_json::from_slice(&head).ok().filter(|_| before.starts_with(&MAGIC))
}

/// Splits a chunk into head and entries after checking its checksum.
///
/// # Errors
/// Changed bytes or an unknown version.
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
