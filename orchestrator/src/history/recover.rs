//! A whole MCAP from what a writer that died left behind.

use super::HistoryError;
use super::mcap_file::options;
use super::read::MOST_HISTORY;
use bladeoff_system::files::{FileError, Pending};
use bladeoff_system::place::Place;
use mcap::read::{ChunkFlattener, Options};
use mcap::records::Record;
use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::Path;

/// What was saved.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovered {
    /// Messages.
    pub messages: u64,
    /// Time of the last one \[s\].
    pub last: f64,
    /// Whether the file ended in the middle of a record (otherwise it was whole, or cut between two).
    pub cut: bool,
}

/// Copies every complete record of `from`, up to where it breaks off, into a whole new file `to`.
///
/// # Errors
/// `from` is not readable or has nothing in it; `to` is there or cannot be written.
pub fn recover(from: &Path, to: &Path) -> Result<Recovered, HistoryError> {
    let read = Place::named(from).read(MOST_HISTORY).map_err(HistoryError::from);
    let bytes = read.map_err(HistoryError::named(from))?;
    let records = ChunkFlattener::new_with_options(&bytes, Options::IgnoreEndMagic.into())
        .map_err(HistoryError::mcap("read", from))?;
    let mut pending = Pending::create(to)?;
    let failed = || HistoryError::mcap("write", to);
    let mut writer = options().create(BufWriter::new(pending.file())).map_err(failed())?;
    let mut saved = Recovered { messages: 0, last: 0.0, cut: false };
    // ids of the new file by those of the old
    let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
    for record in records {
        let Ok(record) = record else {
            saved.cut = true;
            break;
        };
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
    if saved.messages == 0 {
        return Err(HistoryError::NothingToRecover { path: from.to_path_buf() });
    }
    writer.finish().map_err(failed())?;
    writer.into_inner().flush().map_err(FileError::at("write", to))?;
    pending.finish_new()?;
    Ok(saved)
}
