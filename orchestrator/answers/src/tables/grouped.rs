//! Writer of a Parquet file with row groups of a fixed number of rows.

use super::stream::{self, Checksum, Out, Watch};
use super::{ROW_GROUP, TableError, start_threads};
use bladeoff_system::files::Pending;
use polars::io::parquet::write::BatchedWriter;
use polars::prelude::{DataFrame, ParquetCompression, ParquetWriter, PolarsError, Schema};

/// Collects rows to groups; `frame` converts a group to columns.
pub(super) struct GroupedWriter<T> {
    pending: Pending,
    writer: BatchedWriter<Out>,
    watch: Watch,
    group: Vec<T>,
    frame: Box<dyn Fn(&[T]) -> Result<DataFrame, PolarsError>>,
}

impl<T> GroupedWriter<T> {
    /// Starts a file with the columns of `schema`; `more`: further settings of the Parquet writer.
    ///
    /// # Errors
    /// The disk is full or not writable, or Polars reports an error.
    pub fn create(
        mut pending: Pending,
        schema: &Schema,
        more: impl FnOnce(ParquetWriter<Out>) -> ParquetWriter<Out>,
        frame: impl Fn(&[T]) -> Result<DataFrame, PolarsError> + 'static,
    ) -> Result<Self, TableError> {
        start_threads()?;
        let (out, watch) = stream::open(&mut pending)?;
        let writer = more(ParquetWriter::new(out).with_compression(ParquetCompression::Zstd(None)));
        let writer = writer.batched(schema).map_err(|error| watch.failed(error))?;
        Ok(Self { pending, writer, watch, group: Vec::new(), frame: Box::new(frame) })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// As [`GroupedWriter::create`].
    pub fn push(&mut self, row: T) -> Result<(), TableError> {
        // cut by sample number in a complete table, by row number otherwise
        self.group.push(row);
        if self.group.len() == ROW_GROUP { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> Result<(), TableError> {
        let written = (self.frame)(&self.group).and_then(|frame| self.writer.write_batch(&frame));
        self.group.clear();
        written.map_err(|error| self.watch.failed(error))
    }

    /// Writes the remaining rows, makes the file durable under its name, and returns its checksum.
    ///
    /// # Errors
    /// As [`GroupedWriter::create`].
    pub fn finish(mut self) -> Result<Checksum, TableError> {
        if !self.group.is_empty() {
            self.write_group()?;
        }
        self.writer.finish().map_err(|error| self.watch.failed(error))?;
        let checksum = self.watch.checksum();
        self.pending.finish()?;
        Ok(checksum)
    }
}
