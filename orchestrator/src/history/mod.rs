//! Recording and reading of the history of one run. The only module that uses the mcap crate.
//!
//! ```text
//! simulate -> Recorder (decimates, evaluates channels) -> McapSink | CsvSink | ParquetSink -> FILE.tmp (Aside) -> FILE
//! FILE -> read -> History (one time axis, named channels with units) -> figures
//! FILE.mcap.tmp -> recover -> FILE.mcap       after the writer was killed
//! ```
//! A failing history never fails a run: the recorder keeps its first error, stops writing, and reports the error at the end.
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

/// File format, by extension.
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
    /// Format for the extension of a file name.
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

/// Output of a recorder.
trait Sink {
    /// Writes one instant; one value per channel.
    fn record(&mut self, time: f64, values: &[f64]) -> Result<(), HistoryError>;
    /// Completes the file; `outcome`: outcome of the run.
    fn finish(self: Box<Self>, outcome: &About) -> Result<(), HistoryError>;
    /// Path of the incomplete file, if it is on disk.
    fn temporary(&self) -> Option<&Path>;
}
