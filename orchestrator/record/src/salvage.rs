//! Search of a damaged store: entries are recognised anywhere in the file.
//!
//! The file is read in pieces and holes are skipped, so that a huge sparse file takes neither memory nor time.

use super::RecordError;
use super::entry::{Head, LEAST, MAGIC, length_at};
use bladeoff_system::files::FileError;
use bladeoff_system::place::Place;
use rustix::fs::SeekFrom;
use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Most bytes that are searched.
const MOST_BYTES: u64 = 8 << 30;
/// Number of bytes searched at once.
const PIECE: usize = 4 << 20;
/// Longest possible entry \[bytes\].
const LONGEST: usize = LEAST + 8 * u16::MAX as usize;

/// A damaged store and the positions of its entries.
#[derive(Debug)]
pub struct Remains {
    file: File,
    path: Place,
    entries: Vec<(Head, u64)>,
}

impl Remains {
    /// Searches a damaged store. Every returned entry has a valid checksum; of several entries with equal heads, the last is returned.
    /// `column`: as in [`Head::decode`].
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(path: impl Into<Place>, column: Option<usize>) -> Result<Self, RecordError> {
        let path = path.into();
        let file = path.open()?;
        let entries = find(&file, column, PIECE).map_err(FileError::at("read", &path))?;
        Ok(Self { file, path, entries })
    }

    /// The entries and their positions in the file.
    #[must_use]
    pub fn entries(&self) -> &[(Head, u64)] {
        &self.entries
    }

    /// The bytes of the entry at a position.
    ///
    /// # Errors
    /// The file cannot be read, or was changed meanwhile.
    pub fn bytes_at(&self, place: u64) -> Result<Vec<u8>, RecordError> {
        let read = || {
            let mut head = [0; MAGIC.len() + 4];
            self.file.read_exact_at(&mut head, place)?;
            let mut bytes = vec![0; length_at(&head).ok_or(io::ErrorKind::InvalidData)?];
            self.file.read_exact_at(&mut bytes, place)?;
            Ok::<_, io::Error>(bytes)
        };
        Ok(read().map_err(FileError::at("read", &self.path))?)
    }
}

fn find(file: &File, column: Option<usize>, piece: usize) -> io::Result<Vec<(Head, u64)>> {
    let mut found = HashMap::new();
    let mut bytes = vec![0; piece + LONGEST];
    let (mut start, mut read) = (0u64, 0u64);
    while read < MOST_BYTES {
        start = match rustix::fs::seek(file, SeekFrom::Data(start)) {
            Ok(data) => data,
            Err(rustix::io::Errno::NXIO) => break,
            // The file system does not support holes.
            Err(_) => start,
        };
        let filled = fill(file, &mut bytes, start)?;
        // Entries that begin behind the piece belong to the next one.
        let ends = if filled < bytes.len() { filled } else { piece };
        let mut at = 0;
        while let Some(step) =
            bytes[at..filled].windows(MAGIC.len()).position(|window| window == MAGIC).filter(|step| at + step < ends)
        {
            at += step;
            let entry = length_at(&bytes[at..filled]).and_then(|length| bytes[..filled].get(at..at + length));
            match entry.map(|entry| Head::decode(entry, column)) {
                Some(Ok(head)) => {
                    found.insert(head, start + at as u64);
                    at += entry.map_or(1, <[u8]>::len);
                }
                Some(Err(_)) | None => at += 1,
            }
        }
        if filled < bytes.len() {
            break;
        }
        let next = at.max(ends) as u64;
        (start, read) = (start + next, read + next);
    }
    let mut entries: Vec<(Head, u64)> = found.into_iter().collect();
    entries.sort_unstable_by_key(|(_, place)| *place);
    Ok(entries)
}

/// Reads from a position up to the end of the buffer or the file.
fn fill(file: &File, bytes: &mut [u8], start: u64) -> io::Result<usize> {
    let mut filled = 0;
    while filled < bytes.len() {
        match file.read_at(&mut bytes[filled..], start + filled as u64) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

#[cfg(test)]
mod tests {
    use super::super::entry::Entry;
    use super::*;
    use bladeoff_model::outcome::{CauseSet, EndCause, Outcome, Status};
    use bladeoff_study::SampleKey;
    use std::io::{Seek, Write};

    #[test]
    fn entries_are_found_across_pieces_and_behind_holes() {
        let mut file = tempfile::tempfile().expect("a file");
        let outcome = |count: usize| Outcome {
            status: Status::Ok,
            cause: None,
            causes: CauseSet::default(),
            notes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: vec![Some(1.5); count],
        };
        let mut places = Vec::new();
        for number in 0..200u64 {
            if number % 50 == 49 {
                file.seek(io::SeekFrom::Current(1 << 36)).expect("a hole");
            }
            file.write_all(&vec![b'b'; number as usize % 7]).expect("written");
            places.push(file.stream_position().expect("known"));
            let entry = Entry { outcome: outcome(number as usize % 60), cpu_s: 0.0, worker: 1, attempt: 1 };
            file.write_all(&entry.encode(SampleKey(number.into()))).expect("written");
        }
        let whole = find(&file, None, PIECE).expect("readable");
        assert_eq!(whole.iter().map(|(_, place)| *place).collect::<Vec<_>>(), places);
        for piece in [1, 100, 777, 4096] {
            assert!(find(&file, None, piece).expect("readable") == whole, "pieces of {piece} bytes");
        }
    }
}
