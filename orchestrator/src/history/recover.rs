//! Recovery of an MCAP file whose writer was killed, or of the part before a damage.

use super::HistoryError;
use super::mcap_file::options;
use super::read::MOST_HISTORY;
use super::records::Records;
use bladeoff_system::files::{FileError, Pending};
use bladeoff_system::place::Place;
use mcap::McapError;
use mcap::records::{Record, op};
use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Reason for the end of a recovered history.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveredEnd {
    /// The file ended between two records.
    Whole,
    /// The file ended within a record or chunk.
    Cut,
    /// The next record or chunk is damaged; nothing after it is read.
    Damaged,
}

/// Summary of a recovered history.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovered {
    /// Number of messages.
    pub messages: u64,
    /// Time of the last message \[s\].
    pub last: f64,
    /// Reason for the end.
    pub end: RecoveredEnd,
}

/// Iterator over the complete records of a damaged or cut file.
struct Salvage<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    records: Records<'a>,
    /// Number of records returned.
    count: usize,
    /// Whether the incomplete last chunk is being read, which has no checksum.
    in_last_chunk: bool,
    end: RecoveredEnd,
}

impl<'a> Salvage<'a> {
    fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let records = Records::checked(path, bytes);
        Self { path, bytes, records, count: 0, in_last_chunk: false, end: RecoveredEnd::Whole }
    }
}

impl Iterator for Salvage<'_> {
    type Item = Record<'static>;

    fn next(&mut self) -> Option<Record<'static>> {
        loop {
            match self.records.next()? {
                Ok(record) => {
                    self.count += 1;
                    return Some(record);
                }
                Err(error) if !self.in_last_chunk && is_cut(&error, self.bytes) => {
                    self.in_last_chunk = true;
                    self.end = RecoveredEnd::Cut;
                    self.records = Records::unchecked(self.path, self.bytes);
                    // skip records that were already returned
                    self.records.by_ref().take(self.count).for_each(drop);
                }
                Err(_) => {
                    if !self.in_last_chunk {
                        self.end = RecoveredEnd::Damaged;
                    }
                    return None;
                }
            }
        }
    }
}

/// Opcode and length of a chunk that its writer has begun; the length is replaced when the chunk is complete.
const BEGUN_CHUNK: [u8; 9] = [op::CHUNK, 255, 255, 255, 255, 255, 255, 255, 255];

/// Whether the file ends within a record, or within a chunk that its writer did not complete.
fn is_cut(error: &HistoryError, bytes: &[u8]) -> bool {
    match error {
        HistoryError::Mcap { source: McapError::UnexpectedEof, .. } => true,
        HistoryError::Mcap { source: McapError::UnexpectedEoc, .. } => {
            bytes.windows(BEGUN_CHUNK.len()).rev().any(|found| found == BEGUN_CHUNK)
        }
        _ => false,
    }
}

/// Copies every complete record of `from`, up to its end or a damage, into a complete new file `to`.
///
/// # Errors
/// `from` is not readable or contains no complete message; `to` exists or cannot be written.
pub fn recover(from: &Path, to: &Path) -> Result<Recovered, HistoryError> {
    let read = Place::named(from).read(MOST_HISTORY).map_err(HistoryError::from);
    let bytes = read.map_err(HistoryError::named(from))?;
    let mut records = Salvage::new(from, &bytes);
    let mut pending = Pending::create(to)?;
    let failed = || HistoryError::mcap("write", to);
    let mut writer = options().create(BufWriter::new(pending.file())).map_err(failed())?;
    let mut saved = Recovered { messages: 0, last: 0.0, end: RecoveredEnd::Whole };
    // ids in the new file by ids in the old one
    let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
    for record in &mut records {
        match record {
            Record::Schema { header, data } if !schemas.contains_key(&header.id) => {
                let id = writer.add_schema(&header.name, &header.encoding, &data).map_err(failed())?;
                schemas.insert(header.id, id);
            }
            Record::Channel(channel) if !channels.contains_key(&channel.id) => {
                let schema = schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let id = writer
                    .add_channel(schema, &channel.topic, &channel.message_encoding, &channel.metadata)
                    .map_err(failed())?;
                channels.insert(channel.id, id);
            }
            Record::Message { mut header, data } => {
                let Some(&id) = channels.get(&header.channel_id) else { continue };
                header.channel_id = id;
                writer.write_to_known_channel(&header, &data).map_err(failed())?;
                saved.messages += 1;
                saved.last = saved.last.max(header.log_time as f64 * 1e-9);
            }
            Record::Metadata(metadata) => writer.write_metadata(&metadata).map_err(failed())?,
            _ => {}
        }
    }
    saved.end = records.end;
    if saved.messages == 0 {
        return Err(HistoryError::NothingToRecover { path: from.to_path_buf() });
    }
    writer.finish().map_err(failed())?;
    writer.into_inner().flush().map_err(FileError::at("write", to))?;
    pending.finish_new()?;
    Ok(saved)
}
