//! Reuse of the samples of an old directory by their keys: of a study that has grown, or of a run of one machine.
//!
//! A chunk with all samples in the old directory is published at once. The samples of other chunks go to `reused/`, as a chunk
//! file with fewer entries, for the attempt that computes the chunk. A key contains all inputs of a sample, including numerics
//! and basis. So the new directory uses the old basis, otherwise no key would be equal.

use super::super::directory::LEDGER;
use super::super::error::RunError;
use super::super::prepare::Prepared;
use super::super::reuse::{Worth, worth};
use super::attempt::Attempt;
use super::chunk::{encode, opened};
use super::error::ShardError;
use super::layout::{CHUNKS, REUSED, SHARDS, chunk_name, folder_name, folder_of};
use super::merge::each_missing;
use super::publish::put_once;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use bladeoff_answers::summary::counted;
use bladeoff_model::outcome::Status;
use bladeoff_record::{Entry, Head, Reader};
use bladeoff_study::SampleKey;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::shown;
use std::collections::BTreeMap;
use std::path::Path;

/// Largest chunk of an old directory that is read \[bytes\].
const MOST: u64 = 512 << 20;

/// Index of an old directory: keys of its samples and places of their entries.
struct OldDirectory {
    source: Source,
    /// Key, chunk or sample, and place in the chunk, in key order.
    index: Vec<(SampleKey, u64, u32)>,
    /// Last chunk that was read.
    last: Option<(u64, Vec<Vec<u8>>)>,
}

enum Source {
    Record(Reader),
    Chunks(Folder),
}

impl OldDirectory {
    fn open(path: &Path) -> Result<Self, ShardError> {
        let folder = Folder::open(path).map_err(FileError::at("open", path))?;
        let mut index = Vec::new();
        let source = if folder.place(SHARDS).is_file() {
            let chunks = folder.folder(CHUNKS).map_err(FileError::at("open", &folder.place(CHUNKS)))?;
            for name in chunks.names().map_err(FileError::at("read", chunks.path()))? {
                let Some(name) = name.to_str() else { continue };
                let Ok(numbered) = chunks.folder(name) else { continue };
                for file in numbered.names().map_err(FileError::at("read", numbered.path()))? {
                    let Some(chunk) = super::layout::chunk_of(&file) else { continue };
                    // Damaged chunks are computed again.
                    let Some(entries) = entries_of(&chunks, chunk) else { continue };
                    for (place, bytes) in entries.iter().enumerate() {
                        if let Ok((key, _)) = Entry::decode(bytes) {
                            index.push((key, chunk, u32::try_from(place).unwrap_or(u32::MAX)));
                        }
                    }
                }
            }
            Source::Chunks(chunks)
        } else if folder.place(LEDGER).is_file() {
            let record = Reader::open(folder.place(LEDGER)).map_err(RunError::from)?;
            let gathered = record.for_each_head(None, |sample, head| {
                if let Ok(head) = head {
                    index.push((head.key, sample, 0));
                }
            });
            gathered.map_err(RunError::from)?;
            Source::Record(record)
        } else {
            return Err(ShardError::None { path: path.to_path_buf() });
        };
        index.sort_unstable();
        Ok(Self { source, index, last: None })
    }

    /// Finds the entry of a sample that a new computation would give; `None`: no entry fits.
    fn entry(&mut self, key: SampleKey, prepared: &Prepared<'_>, sample: u64) -> Result<Option<Vec<u8>>, ShardError> {
        let mut at = self.index.partition_point(|(known, ..)| *known < key);
        while let Some(&(_, place, entry)) = self.index.get(at).filter(|(known, ..)| *known == key) {
            at += 1;
            let Some(bytes) = self.bytes(place, entry)? else { continue };
            let Ok(head) = Head::decode(&bytes, prepared.steps) else { continue };
            let is_same = worth(&head, prepared.keys.step_limit(sample), false) == Worth::Same;
            if is_same && head.key == key && head.status != Status::Quarantined {
                return Ok(Some(bytes));
            }
        }
        Ok(None)
    }

    fn bytes(&mut self, place: u64, entry: u32) -> Result<Option<Vec<u8>>, ShardError> {
        match &self.source {
            Source::Record(record) => Ok(record.bytes(place).map_err(RunError::from)?),
            Source::Chunks(chunks) => {
                if self.last.as_ref().is_none_or(|(chunk, _)| *chunk != place) {
                    self.last = entries_of(chunks, place).map(|entries| (place, entries));
                }
                Ok(self.last.as_ref().and_then(|(_, entries)| entries.get(entry as usize).cloned()))
            }
        }
    }
}

/// Reads the entries of an undamaged chunk; `None`: missing or damaged.
fn entries_of(chunks: &Folder, chunk: u64) -> Option<Vec<Vec<u8>>> {
    let folder = chunks.folder(&folder_name(folder_of(chunk))).ok()?;
    split(&folder.place(chunk_name(chunk)).read(MOST).ok()?)
}

fn split(bytes: &[u8]) -> Option<Vec<Vec<u8>>> {
    let (_, mut rest) = opened(bytes).ok()?;
    let mut entries = Vec::new();
    while !rest.is_empty() {
        let (_, _, behind) = Entry::first_of(rest).ok()?;
        entries.push(rest[..rest.len() - behind.len()].to_vec());
        rest = behind;
    }
    Some(entries)
}

/// Rejects an old directory without samples, before a new one is begun.
///
/// # Errors
/// [`ShardError::None`].
pub(super) fn refuse_no_old(old: Option<&Path>) -> Result<(), ShardError> {
    let is_one = |path: &&Path| path.join(SHARDS).is_file() || path.join(LEDGER).is_file();
    match old.filter(|path| !is_one(path)) {
        Some(path) => Err(ShardError::None { path: path.to_path_buf() }),
        None => Ok(()),
    }
}

/// Reuses the samples of an old directory for missing chunks.
///
/// # Errors
/// The old directory cannot be read, or the new one cannot be written.
pub(super) fn take_over(
    old: &Path,
    shared: &Shared,
    (shards_file, prepared): (&ShardsFile, &Prepared<'_>),
    attempt: &Attempt,
    note: &dyn Fn(&str),
) -> Result<(), ShardError> {
    let mut source = OldDirectory::open(old)?;
    let mut missing = Vec::new();
    each_missing(shared, &shards_file.chunks, |chunk| missing.push(chunk))?;
    let (mut samples, mut whole) = (0u64, 0u64);
    for chunk in missing {
        let range = shards_file.chunks.range(chunk);
        let mut entries = Vec::new();
        for sample in range.clone() {
            entries.extend(source.entry(prepared.keys.key(sample), prepared, sample)?);
        }
        if entries.is_empty() {
            continue;
        }
        samples += entries.len() as u64;
        let is_whole = entries.len() as u64 == range.end - range.start;
        whole += u64::from(is_whole);
        let folder = shared.numbered(if is_whole { CHUNKS } else { REUSED }, folder_of(chunk))?;
        put_once(&folder, &chunk_name(chunk), &encode(shards_file, chunk, &attempt.metadata(), &entries))?;
    }
    note(&format!(
        "{} of {} taken over from {} ({} whole)",
        samples,
        counted(shards_file.chunks.samples(), "sample"),
        shown(old),
        counted(whole, "chunk")
    ));
    Ok(())
}

/// Reads the reused entries of a missing chunk, by sample.
pub(super) fn taken_over(
    shared: &Shared,
    shards_file: &ShardsFile,
    prepared: &Prepared<'_>,
    chunk: u64,
) -> BTreeMap<u64, Vec<u8>> {
    let entries = || {
        let folder = shared.folder().folder(REUSED).ok()?;
        entries_of(&folder, chunk)
    };
    let mut found: BTreeMap<SampleKey, Vec<u8>> = BTreeMap::new();
    for bytes in entries().unwrap_or_default() {
        if let Ok((key, _)) = Entry::decode(&bytes) {
            found.insert(key, bytes);
        }
    }
    if found.is_empty() {
        return BTreeMap::new();
    }
    let of = |sample| Some((sample, found.get(&prepared.keys.key(sample))?.clone()));
    shards_file.chunks.range(chunk).filter_map(of).collect()
}
