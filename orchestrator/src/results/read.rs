//! A result table read back into plain columns: what summaries work on.

use super::schema::SCHEMA_VERSION;
use super::{ROW_GROUP, TableError};
use crate::files::FileError;
use polars::prelude::{Column, DataFrame, DataType, ParquetReader, PolarsError, SerReader};
use std::fs::File;
use std::path::Path;

/// Rows that are read at once where a table is read in parts.
const PART_ROWS: usize = 8 * ROW_GROUP;

/// The cells of one column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers (counts and integers, too).
    Numbers(Vec<Option<f64>>),
    /// Words.
    Words(Vec<Option<String>>),
}

/// A table in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    columns: Vec<(String, Cells)>,
    rows: usize,
}

impl Table {
    /// Reads a result table.
    ///
    /// # Errors
    /// Not readable, not Parquet, or of another schema version.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        Self::of(read_frame(path)?, path)
    }

    /// Reads some columns of a result table, as far as it has them, and calls `visit` for its parts in order. A part is
    /// some row groups, so that a table of any length needs little memory.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn for_each_part(path: &Path, columns: &[&str], mut visit: impl FnMut(&Self)) -> Result<(), TableError> {
        let failed = |source| TableError::Table { action: "read", path: path.to_path_buf(), source };
        let mut reader = checked_reader(path)?;
        let rows = reader.num_rows().map_err(failed)?;
        let schema = reader.schema().map_err(failed)?;
        let there = columns.iter().filter(|name| schema.contains(name)).map(|name| (*name).to_owned());
        let there: Vec<String> = there.collect();
        for from in (0..rows).step_by(PART_ROWS) {
            let reader = checked_reader(path)?.with_columns(Some(there.clone()));
            let frame = reader.with_slice(Some((from, PART_ROWS.min(rows - from)))).finish().map_err(failed)?;
            visit(&Self::of(frame, path)?);
        }
        Ok(())
    }

    fn of(frame: DataFrame, path: &Path) -> Result<Self, TableError> {
        let failed = |source| TableError::Table { action: "read", path: path.to_path_buf(), source };
        let rows = frame.height();
        let columns = frame
            .columns()
            .iter()
            .map(|column| Ok((column.name().to_string(), cells(column)?)))
            .collect::<Result<_, PolarsError>>()
            .map_err(failed)?;
        Ok(Self { columns, rows })
    }

    /// A table from its columns, all of `rows` cells.
    #[must_use]
    pub fn from_columns(rows: usize, columns: Vec<(String, Cells)>) -> Self {
        Self { columns, rows }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Names of the columns in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
    }

    /// The numbers of a column; `None` if there is no such column of numbers.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<&[Option<f64>]> {
        self.columns.iter().find_map(|(column, cells)| match cells {
            Cells::Numbers(values) if column == name => Some(values.as_slice()),
            _ => None,
        })
    }

    /// The words of a column; `None` if there is no such column of words.
    #[must_use]
    pub fn words(&self, name: &str) -> Option<&[Option<String>]> {
        self.columns.iter().find_map(|(column, cells)| match cells {
            Cells::Words(values) if column == name => Some(values.as_slice()),
            _ => None,
        })
    }
}

/// Reads the frame after its schema version was checked.
pub(super) fn read_frame(path: &Path) -> Result<DataFrame, TableError> {
    let failed = |source| TableError::Table { action: "read", path: path.to_path_buf(), source };
    checked_reader(path)?.finish().map_err(failed)
}

/// A reader of a table whose schema version was checked.
fn checked_reader(path: &Path) -> Result<ParquetReader<File>, TableError> {
    let failed = |source| TableError::Table { action: "read", path: path.to_path_buf(), source };
    let file = File::open(path).map_err(FileError::at("open", path))?;
    let mut reader = ParquetReader::new(file);
    let metadata = reader.get_metadata().map_err(failed)?;
    let found = metadata
        .key_value_metadata()
        .iter()
        .flatten()
        .find(|entry| entry.key == "bladeoff.schema_version")
        .and_then(|entry| entry.value.clone());
    if found.as_deref() != Some(SCHEMA_VERSION.to_string().as_str()) {
        return Err(TableError::Version { path: path.to_path_buf(), found });
    }
    Ok(reader)
}

fn cells(column: &Column) -> Result<Cells, PolarsError> {
    if column.dtype() == &DataType::String {
        let words = column.str()?.iter().map(|word| word.map(str::to_owned)).collect();
        return Ok(Cells::Words(words));
    }
    let numbers = column.cast(&DataType::Float64)?;
    Ok(Cells::Numbers(numbers.f64()?.iter().collect()))
}
