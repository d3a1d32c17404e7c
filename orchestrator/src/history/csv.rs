//! CSV: a header of channel names, one line per instant, numbers in their shortest form that is read back with the same bits; with `,` and decimal
//! points, or with `;` and decimal commas.

use super::channels::Channel;
use super::staging::StagedFile;
use super::{HistoryError, Sink};
use bladeoff_answers::history::About;
use bladeoff_answers::tables::CsvStyle;
use bladeoff_system::files::FileError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Name of the first column.
pub(super) const TIME: &str = "time_s";

/// Writes `FILE.csv.tmp`, which is renamed to `FILE.csv` when it is complete.
pub(super) struct CsvSink {
    path: PathBuf,
    file: BufWriter<File>,
    line: String,
    style: CsvStyle,
    /// Dropped after the file, because dropping the file writes.
    staged: StagedFile,
}

impl CsvSink {
    pub fn create(path: &Path, channels: &[Channel], style: CsvStyle) -> Result<Self, HistoryError> {
        let (file, staged) = StagedFile::create(path)?;
        let mut sink =
            Self { path: path.to_path_buf(), file: BufWriter::new(file), line: TIME.to_owned(), style, staged };
        for channel in channels {
            sink.line.push(style.separator());
            sink.line.push_str(&channel.name());
        }
        sink.write()?;
        Ok(sink)
    }

    fn write(&mut self) -> Result<(), HistoryError> {
        self.line.push('\n');
        Ok(self.file.write_all(self.line.as_bytes()).map_err(FileError::at("write", &self.path))?)
    }
}

impl Sink for CsvSink {
    fn record(&mut self, time: f64, values: &[f64]) -> Result<(), HistoryError> {
        self.line.clear();
        self.line.push_str(&self.style.number(time));
        for value in values {
            self.line.push(self.style.separator());
            self.line.push_str(&self.style.number(*value));
        }
        self.write()
    }

    fn finish(self: Box<Self>, _outcome: &About) -> Result<(), HistoryError> {
        let file = self.file.into_inner().map_err(|error| FileError::at("write", &self.path)(error.into_error()))?;
        Ok(self.staged.publish(file)?)
    }

    fn temporary(&self) -> Option<&Path> {
        Some(self.staged.temporary())
    }
}
