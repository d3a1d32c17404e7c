//! Histories of one run: what is recorded, how often, into which file; and reading them back. The only place that names mcap.
//!
//! ```text
//! simulate -> Recorder (decimates, evaluates channels) -> McapSink | CsvSink | ParquetSink -> FILE.tmp (Aside) -> FILE
//! FILE -> read -> History (one time axis, named channels with units) -> figures
//! FILE.mcap.tmp -> recover -> FILE.mcap       after a writer died
//! ```
//! A history never fails a run: the recorder keeps its first error, stops writing, and says so at the end.
//! Format of the files: `docs/histories.md`.

mod channels;
mod csv;
mod error;
mod mcap_file;
mod proto;
mod read;
mod recorder;
mod records;
mod recover;
mod staging;
mod table;
mod version;

pub use channels::{Channel, catalogue, select, unknown_in};
pub use error::HistoryError;
pub use read::read;
pub use recorder::{Decimation, Recorder, Settings, Written};
pub use recover::{Recovered, RecoveredEnd, recover};
pub use version::HISTORY_VERSION;

use bladeoff_answers::history::About;
use std::path::Path;

/// File formats, by extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `.mcap`: protobuf messages with their schema, chunks compressed with zstd.
    Mcap,
    /// `.csv`: one line per instant.
    Csv,
    /// `.parquet`: one row per instant.
    Parquet,
}

impl Format {
    /// The format that a file name asks for.
    ///
    /// # Errors
    /// [`HistoryError::Extension`].
    pub fn of(path: &Path) -> Result<Self, HistoryError> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("mcap") => Ok(Format::Mcap),
            Some("csv") => Ok(Format::Csv),
            Some("parquet") => Ok(Format::Parquet),
            _ => Err(HistoryError::Extension { path: path.to_path_buf() }),
        }
    }
}

/// Where a recorder's instants go.
trait Sink {
    /// One instant; one value per channel.
    fn record(&mut self, time: f64, values: &[f64]) -> Result<(), HistoryError>;
    /// Ends the file; `outcome` is the outcome of the run.
    fn finish(self: Box<Self>, outcome: &About) -> Result<(), HistoryError>;
    /// Where it lies until then, if it does.
    fn temporary(&self) -> Option<&Path>;
}
