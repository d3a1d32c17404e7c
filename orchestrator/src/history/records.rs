//! Reader of the records of an MCAP file whose bytes may be damaged.
//!
//! Every length in the file is compared with a limit before memory is allocated for it. The records of a chunk are used
//! only if its checksum agrees. Only the kinds of records that a history has are parsed.

use super::HistoryError;
use mcap::parse_record;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::path::Path;

/// Largest record or chunk of a file that is smaller than this: uncompressed, a chunk may be larger than its file \[bytes\].
const LARGEST_RECORD: usize = 16 << 20;

/// The records of a file in order, including those in chunks. Reading ends at the first error.
pub(super) struct Records<'a> {
    path: &'a Path,
    rest: &'a [u8],
    reader: LinearReader,
}

impl<'a> Records<'a> {
    /// Reads the records of complete chunks after checking their checksums.
    pub fn checked(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self::new(path, bytes, true)
    }

    /// Reads every complete record, also in a chunk that is cut off and therefore has no checksum.
    pub fn unchecked(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self::new(path, bytes, false)
    }

    fn new(path: &'a Path, bytes: &'a [u8], check: bool) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(check)
            .with_record_length_limit(bytes.len().max(LARGEST_RECORD));
        Self { path, rest: bytes, reader: LinearReader::new_with_options(options) }
    }
}

/// Whether a history contains records of this kind. Other records are skipped.
fn is_used(kind: u8) -> bool {
    matches!(kind, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA)
}

/// Whether the texts of a record end within it: the library allocates memory for a text according to the length in the file.
fn lengths_fit(kind: u8, data: &[u8]) -> bool {
    let mut rest = data;
    let fits = match kind {
        op::SCHEMA => skip(&mut rest, 2).and_then(|()| texts(&mut rest, 2)),
        op::CHANNEL => skip(&mut rest, 4).and_then(|()| texts(&mut rest, 2)).and_then(|()| table(&mut rest)),
        op::METADATA => texts(&mut rest, 1).and_then(|()| table(&mut rest)),
        _ => Some(()),
    };
    fits.is_some()
}

fn skip(rest: &mut &[u8], count: usize) -> Option<()> {
    *rest = rest.get(count..)?;
    Some(())
}

/// Reads a length of four bytes.
fn length(rest: &mut &[u8]) -> Option<usize> {
    let (length, behind) = rest.split_first_chunk()?;
    *rest = behind;
    usize::try_from(u32::from_le_bytes(*length)).ok()
}

/// Skips texts, each preceded by its length.
fn texts(rest: &mut &[u8], count: usize) -> Option<()> {
    (0..count).try_for_each(|_| length(rest).and_then(|length| skip(rest, length)))
}

/// Skips pairs of texts, preceded by their total length.
fn table(rest: &mut &[u8]) -> Option<()> {
    let bytes = length(rest)?;
    let end = rest.len().checked_sub(bytes)?;
    while rest.len() > end {
        texts(rest, 2)?;
    }
    Some(())
}

impl Iterator for Records<'_> {
    type Item = Result<Record<'static>, HistoryError>;

    fn next(&mut self) -> Option<Self::Item> {
        let failed = HistoryError::mcap("read", self.path);
        loop {
            match self.reader.next_event()? {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let (now, later) = self.rest.split_at(wanted.min(self.rest.len()));
                    self.reader.insert(now.len()).copy_from_slice(now);
                    self.reader.notify_read(now.len());
                    self.rest = later;
                }
                Ok(LinearReadEvent::Record { opcode, .. }) if !is_used(opcode) => {}
                Ok(LinearReadEvent::Record { data, opcode }) if !lengths_fit(opcode, data) => {
                    return Some(Err(HistoryError::not_ours(self.path, "a text in it is longer than its record")));
                }
                Ok(LinearReadEvent::Record { data, opcode }) => {
                    return Some(parse_record(opcode, data).map(Record::into_owned).map_err(failed));
                }
                Err(error) => return Some(Err(failed(error))),
            }
        }
    }
}
