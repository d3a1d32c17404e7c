//! Parquet: collected in memory, written at the end.

use super::channels::Channel;
use super::csv::TIME;
use super::{HistoryError, Sink};
use bladeoff_answers::history::About;
use bladeoff_answers::tables::{NumberColumn, write_numbers};
use std::path::{Path, PathBuf};

/// Prefixes of the keys of the run and of the keys of its outcome in the file's metadata.
pub(super) const ABOUT_PREFIX: &str = "bladeoff.history.";
pub(super) const OUTCOME_PREFIX: &str = "bladeoff.outcome.";
/// Key of the checksum, which is needed because the pages of a Parquet file have none.
pub(super) const CHECKSUM: &str = "bladeoff.blake3";

/// BLAKE3 of the names and values of all columns in their order, and of the keys of the run and its outcome.
pub(super) fn checksum(columns: &[NumberColumn], metadata: &[(String, String)]) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    };
    for column in columns {
        add(column.name.as_bytes());
        add(&column.values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
    }
    let mut ours: Vec<_> = metadata.iter().filter(|(key, _)| is_ours(key)).collect();
    ours.sort();
    for (key, value) in ours {
        add(key.as_bytes());
        add(value.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// Whether a key of the metadata is one of the run or its outcome.
pub(super) fn is_ours(key: &str) -> bool {
    key.starts_with(ABOUT_PREFIX) || key.starts_with(OUTCOME_PREFIX)
}

/// Collects the instants.
pub(super) struct ParquetSink {
    path: PathBuf,
    columns: Vec<NumberColumn>,
    about: About,
}

impl ParquetSink {
    pub fn new(path: &Path, channels: &[Channel], about: About) -> Self {
        let column = |name: String, unit: &str, meaning: &str| NumberColumn {
            name,
            unit: unit.to_owned(),
            meaning: meaning.to_owned(),
            values: Vec::new(),
        };
        let mut columns = vec![column(TIME.to_owned(), "s", "simulated time")];
        columns.extend(channels.iter().map(|channel| column(channel.name(), channel.unit, &channel.meaning)));
        Self { path: path.to_path_buf(), columns, about }
    }
}

impl Sink for ParquetSink {
    fn record(&mut self, time: f64, values: &[f64]) -> Result<(), HistoryError> {
        for (column, value) in self.columns.iter_mut().zip(std::iter::once(&time).chain(values)) {
            column.values.push(*value);
        }
        Ok(())
    }

    fn finish(self: Box<Self>, outcome: &About) -> Result<(), HistoryError> {
        let prefixed = |prefix: &str, about: &About| -> Vec<(String, String)> {
            about.iter().map(|(key, value)| (format!("{prefix}{key}"), value.clone())).collect()
        };
        let mut metadata = prefixed(ABOUT_PREFIX, &self.about);
        metadata.extend(prefixed(OUTCOME_PREFIX, outcome));
        metadata.push((CHECKSUM.to_owned(), checksum(&self.columns, &metadata)));
        Ok(write_numbers(&self.path, &self.columns, &metadata)?)
    }

    fn temporary(&self) -> Option<&Path> {
        None
    }
}
