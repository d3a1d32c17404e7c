//! Tables of numeric columns: histories as Parquet.

use super::threads::guarded;
use super::{TableError, pages, start_threads, stream};
use bladeoff_system::files::Pending;
use bladeoff_system::place::Place;
use polars::prelude::{
    ArrowSchema, Column, CompatLevel, DataFrame, DataType, IntoColumn, KeyValueMetadata, NamedFrom, ParallelStrategy,
    ParquetCompression, ParquetReader, ParquetWriter, PlSmallStr, PolarsError, SerReader, Series,
};
use std::fs::File;
use std::path::Path;

/// One column of numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NumberColumn {
    /// Name; ends in the SI unit if there is one.
    pub name: String,
    /// SI unit, "" for none.
    pub unit: String,
    /// Meaning, in one sentence.
    pub meaning: String,
    /// Values.
    pub values: Vec<f64>,
}

/// Writes columns of equal length to `path`, durably, with unit and meaning in each field's metadata.
///
/// # Errors
/// The disk is full or not writable, or Polars reports an error.
pub fn write_numbers(path: &Path, columns: &[NumberColumn], metadata: &[(String, String)]) -> Result<(), TableError> {
    let failed = |source| TableError::Table { action: "write", path: path.to_path_buf(), source };
    let height = columns.first().map_or(0, |column| column.values.len());
    let data: Vec<Column> =
        columns.iter().map(|column| Series::new(column.name.as_str().into(), &column.values).into_column()).collect();
    let mut frame = DataFrame::new(height, data).map_err(failed)?;
    let fields: ArrowSchema = columns
        .iter()
        .map(|column| {
            let name = PlSmallStr::from(column.name.as_str());
            let words = [("unit", &column.unit), ("description", &column.meaning)];
            let words = words.into_iter().map(|(key, value)| (key.into(), value.as_str().into())).collect();
            (name.clone(), DataType::Float64.to_arrow_field(name, CompatLevel::oldest()).with_metadata(words))
        })
        .collect();
    let schema = polars_parquet::write::schema_to_metadata_key(&fields);
    let mut pairs = vec![(schema.key, schema.value.unwrap_or_default())];
    pairs.extend(metadata.iter().cloned());
    start_threads()?;
    let mut pending = Pending::create(path)?;
    let (out, watch) = stream::open(&mut pending)?;
    ParquetWriter::new(out)
        .with_compression(ParquetCompression::Zstd(None))
        .with_key_value_metadata(Some(KeyValueMetadata::from_static(pairs)))
        .finish(&mut frame)
        .map_err(|error| watch.failed(error))?;
    Ok(pending.finish()?)
}

/// Key-value metadata of a Parquet file.
///
/// # Errors
/// The file cannot be read, or is not Parquet.
pub fn read_metadata(path: &Path) -> Result<Vec<(String, String)>, TableError> {
    metadata_in(path, Place::from(path).open()?)
}

fn metadata_in(path: &Path, file: File) -> Result<Vec<(String, String)>, TableError> {
    let failed = |source| TableError::Table { action: "read", path: path.to_path_buf(), source };
    let mut reader = ParquetReader::new(file);
    let metadata = guarded(path, || reader.get_metadata().map_err(failed))?;
    let entries = metadata.key_value_metadata().iter().flatten();
    Ok(entries.filter_map(|entry| Some((entry.key.clone(), entry.value.clone()?))).collect())
}

/// Reads the numeric columns and the metadata of a Parquet file. Units and meanings are left empty; names end in the unit.
///
/// # Errors
/// The file cannot be read, or is not Parquet.
#[expect(clippy::type_complexity, reason = "columns, and pairs of key and value")]
pub fn read_numbers(path: &Path) -> Result<(Vec<NumberColumn>, Vec<(String, String)>), TableError> {
    let failed = |source| TableError::Table { action: "read", path: path.to_path_buf(), source };
    let open = || Place::named(path).open();
    let pairs = metadata_in(path, open()?)?;
    pages::check(path, open()?)?;
    let file = open()?;
    // One thread: a panic on a damaged file occurs in the reading thread.
    let reader = ParquetReader::new(file).read_parallel(ParallelStrategy::None);
    let frame = guarded(path, || reader.finish().map_err(failed))?;
    let numbers = |column: &Column| -> Result<NumberColumn, PolarsError> {
        let values = column.cast(&DataType::Float64)?;
        let values = values.f64()?.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        Ok(NumberColumn { name: column.name().to_string(), values, ..NumberColumn::default() })
    };
    let columns = frame.columns().iter().filter(|column| column.dtype().is_primitive_numeric());
    Ok((columns.map(numbers).collect::<Result<_, _>>().map_err(failed)?, pairs))
}
