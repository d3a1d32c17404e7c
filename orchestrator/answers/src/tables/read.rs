//! Reads a result table into plain columns.

use super::pages;
use super::schema::SCHEMA_VERSION;
use super::threads::guarded;
use super::{ROW_GROUP, TableError};
use bladeoff_system::place::Place;
use polars::prelude::{Column, DataFrame, DataType, ParallelStrategy, ParquetReader, PolarsError, SerReader};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Rows per piece if a table is read in pieces.
const PIECE_ROWS: usize = 4 * ROW_GROUP;

/// The cells of one column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers, including counts and integers.
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
    /// The file cannot be read, is not Parquet, or has another schema version.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        pages::check(path, Place::from(path).open()?)?;
        guarded(path, || Self::of(checked_reader(path)?.finish().map_err(failed(path))?, path))
    }

    /// Reads those of the given columns that exist in the files, and calls `visit` for pieces of some row groups in order. The memory needed does
    /// not depend on the length of the table.
    ///
    /// # Errors
    /// As [`Table::read`]; errors of `visit`.
    pub fn for_each_piece(
        files: &[PathBuf],
        columns: &[&str],
        mut visit: impl FnMut(&Self) -> Result<(), TableError>,
    ) -> Result<(), TableError> {
        for path in files {
            let schema = guarded(path, || checked_reader(path)?.schema().map_err(failed(path)))?;
            let there = columns.iter().filter(|name| schema.contains(name)).map(|name| (*name).to_owned());
            let there: Vec<String> = there.collect();
            for_each_frame(path, Some(&there), |frame| visit(&Self::of(frame, path)?))?;
        }
        Ok(())
    }

    /// Names of the columns of a result table, in order.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn names_in(path: &Path) -> Result<Vec<String>, TableError> {
        let schema = guarded(path, || checked_reader(path)?.schema().map_err(failed(path)))?;
        Ok(schema.iter_names().map(ToString::to_string).collect())
    }

    /// Names of the numeric columns of a result table, in order.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn number_names_in(path: &Path) -> Result<Vec<String>, TableError> {
        let names = Self::names_in(path)?;
        // the type of a column needs no rows
        let frame = guarded(path, || checked_reader(path)?.with_slice(Some((0, 0))).finish().map_err(failed(path)))?;
        let table = Self::of(frame, path)?;
        Ok(names.into_iter().filter(|name| table.numbers(name).is_some()).collect())
    }

    /// Number of rows of all files.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn count_rows(files: &[PathBuf]) -> Result<usize, TableError> {
        let rows = |path: &PathBuf| guarded(path, || checked_reader(path)?.num_rows().map_err(failed(path)));
        files.iter().map(rows).sum()
    }

    /// The row of a sample as a table of one row, and its file; `None` if no file contains the sample. If row numbers are sample numbers,
    /// only one row group is read; otherwise the column `sample` is read first.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn row(files: &[PathBuf], sample: u64) -> Result<Option<(Self, PathBuf)>, TableError> {
        for path in files {
            if let Some(frame) = guarded(path, || row_of(|| checked_reader(path), path, sample))? {
                return Ok(Some((Self::of(frame, path)?, path.clone())));
            }
        }
        Ok(None)
    }

    fn of(frame: DataFrame, path: &Path) -> Result<Self, TableError> {
        let rows = frame.height();
        let columns = frame
            .columns()
            .iter()
            .map(|column| Ok((column.name().to_string(), cells(column)?)))
            .collect::<Result<_, PolarsError>>()
            .map_err(failed(path))?;
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

/// Number of rows of a Parquet file, after reading all of it: damage to the format is found, a changed number is not.
///
/// # Errors
/// The file cannot be read, or is damaged.
pub fn count_sound_rows(path: &Path) -> Result<usize, TableError> {
    let reader = || -> Result<_, TableError> {
        let file = Place::from(path).open()?;
        Ok(ParquetReader::new(file).read_parallel(ParallelStrategy::None))
    };
    pages::check(path, Place::from(path).open()?)?;
    guarded(path, || {
        let rows = reader()?.num_rows().map_err(failed(path))?;
        let mut read = 0;
        for from in (0..rows).step_by(PIECE_ROWS) {
            let piece = reader()?.with_slice(Some((from, PIECE_ROWS.min(rows - from)))).finish();
            read += piece.map_err(failed(path))?.height();
        }
        if read == rows { Ok(rows) } else { Err(TableError::Damaged { path: path.to_path_buf() }) }
    })
}

/// Calls `visit` for pieces of a table, with these columns or all. The schema version is checked.
pub(super) fn for_each_frame(
    path: &Path,
    columns: Option<&[String]>,
    mut visit: impl FnMut(DataFrame) -> Result<(), TableError>,
) -> Result<(), TableError> {
    let rows = guarded(path, || checked_reader(path)?.num_rows().map_err(failed(path)))?;
    pages::check(path, Place::from(path).open()?)?;
    for from in (0..rows).step_by(PIECE_ROWS) {
        let read = || {
            let reader = checked_reader(path)?.with_columns(columns.map(<[String]>::to_vec));
            reader.with_slice(Some((from, PIECE_ROWS.min(rows - from)))).finish().map_err(failed(path))
        };
        visit(guarded(path, read)?)?;
    }
    Ok(())
}

/// The row of a sample in one file, with all columns.
pub(super) fn row_of(
    reader: impl Fn() -> Result<ParquetReader<File>, TableError>,
    path: &Path,
    sample: u64,
) -> Result<Option<DataFrame>, TableError> {
    let read = |columns: Option<&str>, from: usize, count: usize| {
        let columns = columns.map(|column| vec![column.to_owned()]);
        let reader = reader()?.with_columns(columns);
        reader.with_slice(Some((from, count))).finish().map_err(failed(path))
    };
    let samples =
        |frame: &DataFrame| frame.column("sample").and_then(|column| column.u64().cloned()).map_err(failed(path));
    let row_at = |row: usize| {
        let frame = read(None, row, 1)?;
        let is_row = frame.columns().iter().all(|column| column.len() == 1);
        if is_row { Ok(frame) } else { Err(TableError::Damaged { path: path.to_path_buf() }) }
    };
    let rows = reader()?.num_rows().map_err(failed(path))?;
    pages::check(path, Place::from(path).open()?)?;
    if let Some(row) = usize::try_from(sample).ok().filter(|&row| row < rows)
        && samples(&read(Some("sample"), row, 1)?)?.iter().next().flatten() == Some(sample)
    {
        return row_at(row).map(Some);
    }
    for from in (0..rows).step_by(PIECE_ROWS) {
        let samples = samples(&read(Some("sample"), from, PIECE_ROWS.min(rows - from))?)?;
        if let Some(row) = samples.iter().position(|found| found == Some(sample)) {
            return row_at(from + row).map(Some);
        }
    }
    Ok(None)
}

pub(super) fn failed(path: &Path) -> impl Fn(PolarsError) -> TableError {
    let path = path.to_path_buf();
    move |source| TableError::Table { action: "read", path: path.clone(), source }
}

/// A reader of a table, after a check of the schema version.
pub(super) fn checked_reader(path: &Path) -> Result<ParquetReader<File>, TableError> {
    let file = Place::from(path).open()?;
    // One thread: less memory, and a panic on a damaged file occurs in the reading thread.
    let mut reader = ParquetReader::new(file).read_parallel(ParallelStrategy::None);
    let metadata = reader.get_metadata().map_err(failed(path))?;
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
