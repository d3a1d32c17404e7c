//! What is left in a damaged store: entries are recognised by themselves, wherever in the file they stand.

use super::LedgerError;
use super::record::{Head, MAGIC, length_at};
use crate::files::FileError;
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest store that is read whole to be salvaged.
const MOST_BYTES: u64 = 8 << 30;

/// The bytes of a damaged store and the entries in them.
#[derive(Debug)]
pub struct Remains {
    bytes: Vec<u8>,
    entries: Vec<(Head, usize)>,
}

impl Remains {
    /// Reads a damaged store. Every entry returned has its checksum; the last of several with equal heads is taken.
    /// `column`: as of [`Head::decode`].
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(path: &Path, column: Option<usize>) -> Result<Self, LedgerError> {
        let failed = |source| LedgerError::File(FileError::at("read", path)(source));
        let mut bytes = Vec::new();
        File::open(path).and_then(|file| file.take(MOST_BYTES).read_to_end(&mut bytes)).map_err(failed)?;
        let entries = find(&bytes, column);
        Ok(Self { bytes, entries })
    }

    /// The entries and their places.
    #[must_use]
    pub fn entries(&self) -> &[(Head, usize)] {
        &self.entries
    }

    /// The bytes of the entry at a place.
    #[must_use]
    pub fn bytes_at(&self, place: usize) -> &[u8] {
        let length = length_at(&self.bytes[place..]).expect("an entry was found there");
        &self.bytes[place..place + length]
    }
}

fn find(bytes: &[u8], column: Option<usize>) -> Vec<(Head, usize)> {
    let mut found = HashMap::new();
    let mut at = 0;
    while let Some(step) = bytes[at..].windows(MAGIC.len()).position(|window| window == MAGIC) {
        at += step;
        let entry = length_at(&bytes[at..]).and_then(|length| bytes.get(at..at + length));
        match entry.map(|entry| Head::decode(entry, column)) {
            Some(Ok(head)) => {
                found.insert(head, at);
                at += entry.map_or(1, <[u8]>::len);
            }
            Some(Err(_)) | None => at += 1,
        }
    }
    let mut entries: Vec<(Head, usize)> = found.into_iter().collect();
    entries.sort_unstable_by_key(|(_, place)| *place);
    entries
}
