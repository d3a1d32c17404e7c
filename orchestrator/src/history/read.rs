//! Reader of histories in any format.

use super::csv::TIME;
use super::mcap_file::{ABOUT, GROUP, OUTCOME, UNITS};
use super::records::Records;
use super::table::{ABOUT_PREFIX, CHECKSUM, OUTCOME_PREFIX, checksum, is_ours};
use super::{Format, HISTORY_VERSION, HistoryError, proto};
use bladeoff_answers::history::{About, History, Series};
use bladeoff_answers::tables::{CsvStyle, TableError, read_numbers};
use bladeoff_system::place::Place;
use mcap::records::Record;
use std::collections::BTreeMap;
use std::path::Path;

/// Largest history that is read: the whole file is held in memory \[bytes\].
pub(super) const MOST_HISTORY: u64 = 4 << 30;

/// Reads a history.
///
/// # Errors
/// The file cannot be read, has an unknown format or version, is damaged, or is cut off (then `bladeoff recover` helps).
pub fn read(path: &Path) -> Result<History, HistoryError> {
    let format = Format::of(path)?;
    let read = match format {
        Format::Mcap => read_mcap(path),
        Format::Csv => read_csv(path),
        Format::Parquet => read_parquet(path),
    };
    let history = read.map_err(HistoryError::named(path))?;
    if format == Format::Csv {
        return Ok(history);
    }
    let known = history.about.get("history_version").is_some_and(|found| *found == HISTORY_VERSION.to_string());
    if known { Ok(history) } else { Err(HistoryError::not_ours(path, "it does not say so")) }
}

/// A topic that is being read.
struct Topic {
    names: Vec<String>,
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
}

fn read_mcap(path: &Path) -> Result<History, HistoryError> {
    let bytes = Place::named(path).read(MOST_HISTORY)?;
    let mut history = History::default();
    let mut units = About::new();
    let mut schemas: BTreeMap<u16, Vec<String>> = BTreeMap::new();
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    for record in Records::checked(path, &bytes) {
        match record? {
            Record::Metadata(metadata) => match metadata.name.as_str() {
                ABOUT => history.about = metadata.metadata,
                UNITS => units = metadata.metadata,
                OUTCOME => history.outcome = metadata.metadata,
                _ => {}
            },
            Record::Schema { header, data } => {
                let names = proto::field_names(&data)
                    .ok_or_else(|| HistoryError::not_ours(path, "a schema is not one of ours"))?;
                schemas.insert(header.id, names);
            }
            Record::Channel(channel) => {
                let group = channel
                    .metadata
                    .get(GROUP)
                    .ok_or_else(|| HistoryError::not_ours(path, "a topic is not one of ours"))?;
                let fields = schemas
                    .get(&channel.schema_id)
                    .ok_or_else(|| HistoryError::not_ours(path, "a topic has no schema"))?;
                let names: Vec<String> = fields.iter().map(|field| format!("{group}.{field}")).collect();
                let values = vec![Vec::new(); names.len()];
                topics.entry(channel.id).or_insert(Topic { names, times: Vec::new(), values });
            }
            Record::Message { header, data } => {
                let topic = topics
                    .get_mut(&header.channel_id)
                    .ok_or_else(|| HistoryError::not_ours(path, "a message has no topic"))?;
                let values = proto::values(&data, topic.names.len())
                    .ok_or_else(|| HistoryError::not_ours(path, "a message does not fit its schema"))?;
                topic.times.push(header.log_time as f64 * 1e-9);
                for (series, value) in topic.values.iter_mut().zip(values) {
                    series.push(value);
                }
            }
            _ => {}
        }
    }
    // a recovered file may end between the topics of one instant
    let instants = topics.values().map(|topic| topic.times.len()).min().unwrap_or(0);
    for topic in topics.into_values() {
        if history.time.is_empty() {
            history.time = topic.times[..instants].to_vec();
        }
        for (name, mut values) in topic.names.into_iter().zip(topic.values) {
            values.truncate(instants);
            let unit = units.get(&name).cloned().unwrap_or_default();
            history.channels.push(Series { name, unit, values });
        }
    }
    Ok(history)
}

fn read_csv(path: &Path) -> Result<History, HistoryError> {
    let bytes = Place::named(path).read(MOST_HISTORY)?;
    let text = String::from_utf8(bytes).map_err(|_| HistoryError::not_ours(path, "it is not text in UTF-8"))?;
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    let style = if header.contains(';') { CsvStyle::Comma } else { CsvStyle::Point };
    let mut names = header.split(style.separator());
    if names.next() != Some(TIME) {
        return Err(HistoryError::not_ours(path, "its first column is not time_s"));
    }
    let series = |name: &str| Series { name: name.to_owned(), unit: unit_of(name).to_owned(), values: Vec::new() };
    let mut history = History { channels: names.map(series).collect(), ..History::default() };
    for (at, line) in lines.enumerate() {
        let number = |text: &str| {
            let wrong = || HistoryError::Number { path: path.to_path_buf(), line: at + 2, text: text.to_owned() };
            let parsed = match style {
                CsvStyle::Point => text.parse(),
                CsvStyle::Comma => text.replace(',', ".").parse(),
            };
            parsed.map_err(|_| wrong())
        };
        let mut cells = line.split(style.separator());
        history.time.push(number(cells.next().unwrap_or_default())?);
        for channel in &mut history.channels {
            channel.values.push(number(cells.next().unwrap_or_default())?);
        }
    }
    Ok(history)
}

/// Unit at the end of a channel name of this program, for a format that does not store units.
fn unit_of(name: &str) -> &'static str {
    for (suffix, unit) in
        [("_rad_s", "rad/s"), ("_m_s", "m/s"), ("_Nm", "N m"), ("_rad", "rad"), ("_m", "m"), ("_N", "N"), ("_J", "J")]
    {
        if name.ends_with(suffix) {
            return unit;
        }
    }
    ""
}

fn read_parquet(path: &Path) -> Result<History, HistoryError> {
    let (columns, metadata) = read_numbers(path)?;
    // damage to the metadata may affect the key: a file of this program without it is damaged, too
    let written = metadata.iter().find(|(key, _)| key == CHECKSUM).map(|(_, value)| value.as_str());
    let is_ours = metadata.iter().any(|(key, _)| is_ours(key));
    if written.map_or(is_ours, |written| written != checksum(&columns, &metadata)) {
        return Err(TableError::Damaged { path: path.to_path_buf() }.into());
    }
    let mut history = History::default();
    for (key, value) in metadata {
        if let Some(key) = key.strip_prefix(ABOUT_PREFIX) {
            history.about.insert(key.to_owned(), value);
        } else if let Some(key) = key.strip_prefix(OUTCOME_PREFIX) {
            history.outcome.insert(key.to_owned(), value);
        }
    }
    for column in columns {
        if column.name == TIME {
            history.time = column.values;
        } else {
            let unit = if column.unit.is_empty() { unit_of(&column.name).to_owned() } else { column.unit };
            history.channels.push(Series { name: column.name, unit, values: column.values });
        }
    }
    Ok(history)
}
