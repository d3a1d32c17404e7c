//! Parquet: collected in memory, written at the end.

use super::channels::Channel;
use super::csv::TIME;
use super::{HistoryError, Sink};
use bladeoff_answers::history::About;
use bladeoff_answers::tables::{NumberColumn, write_numbers};
use std::path::{Path, PathBuf};

/// Key in the file's metadata before the keys of the run, and before those of its outcome.
pub(super) const ABOUT_PREFIX: &str = "bladeoff.history.";
pub(super) const OUTCOME_PREFIX: &str = "bladeoff.outcome.";

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
        Ok(write_numbers(&self.path, &self.columns, &metadata)?)
    }

    fn temporary(&self) -> Option<&Path> {
        None
    }
}
