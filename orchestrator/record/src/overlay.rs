//! A file that is read and never written: changes by the store stay in memory.
//!
//! Opening a store writes to its file, and after a crash the store is repaired first. Commands that only read use this overlay, so that the
//! file keeps its bytes and need not be writable.

use redb::StorageBackend;
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::sync::{PoisonError, RwLock};

/// Size of a block \[bytes\].
const BLOCK: usize = 4096;

/// The file, and the blocks written over it.
#[derive(Debug)]
pub(super) struct Overlay {
    file: File,
    written: RwLock<Written>,
}

#[derive(Debug)]
struct Written {
    length: u64,
    /// Position from which on the file's content is not visible: its length, or less after the store truncated it.
    file_end: u64,
    blocks: BTreeMap<u64, Box<[u8; BLOCK]>>,
}

impl Overlay {
    /// An overlay of the present file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn over(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        Ok(Self { file, written: RwLock::new(Written { length, file_end: length, blocks: BTreeMap::new() }) })
    }

    /// A block of the file; zeros after its end.
    fn original(&self, block: u64, file_end: u64) -> io::Result<Box<[u8; BLOCK]>> {
        let mut bytes = Box::new([0; BLOCK]);
        let start = block * BLOCK as u64;
        let there = usize::try_from(file_end.saturating_sub(start)).unwrap_or(BLOCK).min(BLOCK);
        self.file.read_exact_at(&mut bytes[..there], start)?;
        Ok(bytes)
    }
}

/// The blocks that overlap `length` bytes from `offset` on: block number, first byte in the block, position and number of these bytes.
fn blocks(offset: u64, length: usize) -> impl Iterator<Item = (u64, usize, usize, usize)> {
    let mut done = 0;
    std::iter::from_fn(move || {
        let at = offset + done as u64;
        let (block, inside) = (at / BLOCK as u64, (at % BLOCK as u64) as usize);
        let count = (BLOCK - inside).min(length - done);
        let place = done;
        done += count;
        (count > 0).then_some((block, inside, place, count))
    })
}

impl StorageBackend for Overlay {
    fn len(&self) -> io::Result<u64> {
        Ok(self.written.read().unwrap_or_else(PoisonError::into_inner).length)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let written = self.written.read().unwrap_or_else(PoisonError::into_inner);
        if offset.checked_add(out.len() as u64).is_none_or(|end| end > written.length) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        if written.blocks.is_empty() && written.file_end == written.length {
            return self.file.read_exact_at(out, offset);
        }
        for (block, inside, place, count) in blocks(offset, out.len()) {
            let bytes = match written.blocks.get(&block) {
                Some(bytes) => bytes,
                None => &self.original(block, written.file_end)?,
            };
            out[place..place + count].copy_from_slice(&bytes[inside..inside + count]);
        }
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        let mut written = self.written.write().unwrap_or_else(PoisonError::into_inner);
        if length < written.length {
            written.blocks.split_off(&length.div_ceil(BLOCK as u64));
            let inside = (length % BLOCK as u64) as usize;
            if let Some(last) = written.blocks.get_mut(&(length / BLOCK as u64)) {
                last[inside..].fill(0);
            }
            written.file_end = written.file_end.min(length);
        }
        written.length = length;
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        let mut written = self.written.write().unwrap_or_else(PoisonError::into_inner);
        for (block, inside, place, count) in blocks(offset, data.len()) {
            if !written.blocks.contains_key(&block) {
                let original = self.original(block, written.file_end)?;
                written.blocks.insert(block, original);
            }
            let bytes = written.blocks.get_mut(&block).expect("inserted above");
            bytes[inside..inside + count].copy_from_slice(&data[place..place + count]);
        }
        written.length = written.length.max(offset + data.len() as u64);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, Clone)]
    enum Act {
        Write(usize, Vec<u8>),
        SetLen(usize),
    }

    proptest! {
        #[test]
        fn it_is_read_like_a_file_that_was_written(
            first in prop::collection::vec(any::<u8>(), 0..3 * BLOCK),
            acts in prop::collection::vec(
                prop_oneof![
                    (0..4 * BLOCK, prop::collection::vec(any::<u8>(), 0..2 * BLOCK)).prop_map(|(at, bytes)| Act::Write(at, bytes)),
                    (0..5 * BLOCK).prop_map(Act::SetLen),
                ],
                0..8,
            ),
            from in 0..5 * BLOCK, count in 0..3 * BLOCK,
        ) {
            let file = tempfile::NamedTempFile::new().expect("a file");
            std::fs::write(file.path(), &first).expect("written");
            let overlay = Overlay::over(File::open(file.path()).expect("readable")).expect("readable");
            let mut model = first.clone();
            for act in acts {
                match act {
                    Act::Write(at, bytes) => {
                        overlay.write(at as u64, &bytes).expect("in memory");
                        model.resize(model.len().max(at + bytes.len()), 0);
                        model[at..at + bytes.len()].copy_from_slice(&bytes);
                    }
                    Act::SetLen(length) => {
                        overlay.set_len(length as u64).expect("in memory");
                        model.resize(length, 0);
                    }
                }
                prop_assert_eq!(overlay.len().expect("known"), model.len() as u64);
                let mut all = vec![1; model.len()];
                overlay.read(0, &mut all).expect("readable");
                prop_assert!(all == model);
            }
            let mut some = vec![1; count];
            let read = overlay.read(from as u64, &mut some);
            prop_assert_eq!(read.is_ok(), from + count <= model.len());
            prop_assert!(read.is_err() || some == model[from..from + count]);
            prop_assert!(std::fs::read(file.path()).expect("readable") == first);
        }
    }
}
