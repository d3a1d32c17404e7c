//! `results.parquet`: rows in, bytes out, the same rows always giving the same bytes.

use super::schema::{Field, FieldKind, SCHEMA_VERSION, TableSchema};
use super::{ROW_GROUP, TableError};
use crate::files::{FileError, Pending};
use bladeoff_core::outcome::Outcome;
use polars::io::parquet::write::BatchedWriter;
use polars::prelude::{
    ArrowField, ArrowSchema, Column, CompatLevel, DataFrame, DataType, IntoColumn, KeyValueMetadata, NamedFrom,
    ParquetCompression, ParquetWriter, PlSmallStr, PolarsError, Schema, Series, StatisticsOptions,
};
use std::fs::File;
use std::path::{Path, PathBuf};

/// One value of a varied parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// SI number; whole where the column holds integers.
    Number(f64),
    /// Word of a choice.
    Word(String),
}

/// One row: a sample, what was varied and what came out.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Row number in the study.
    pub sample: u64,
    /// One value per parameter field of the schema.
    pub parameters: Vec<Value>,
    /// Contact detection; `None` without a diaphragm.
    pub detection: Option<String>,
    /// What came out; one value per outcome field of the schema.
    pub outcome: Outcome,
}

/// File-level key-value metadata: where the table comes from. Nothing that differs between equal runs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance(pub Vec<(String, String)>);

/// A table under construction, written in row groups of a fixed number of rows as they come.
pub struct ResultsWriter {
    schema: TableSchema,
    path: PathBuf,
    pending: Pending,
    writer: BatchedWriter<File>,
    group: Vec<Row>,
}

impl ResultsWriter {
    /// Starts a table that will be `path`.
    ///
    /// # Errors
    /// The disk is full or not writable, or the table library refused.
    pub fn create(path: &Path, schema: &TableSchema, provenance: &Provenance) -> Result<Self, TableError> {
        let mut pending = Pending::create(path)?;
        let polars_schema: Schema =
            schema.fields().iter().map(|f| (PlSmallStr::from(f.name.as_str()), data_type(f.kind))).collect();
        let mut metadata = vec![("bladeoff.schema_version".to_owned(), SCHEMA_VERSION.to_string())];
        metadata.extend(provenance.0.iter().map(|(key, value)| (format!("bladeoff.{key}"), value.clone())));
        metadata.insert(0, arrow_schema(schema));
        let file = pending.file().try_clone().map_err(FileError::at("write", path))?;
        let writer = ParquetWriter::new(file)
            .with_compression(ParquetCompression::Zstd(None))
            .with_statistics(StatisticsOptions::full())
            .with_key_value_metadata(Some(KeyValueMetadata::from_static(metadata)))
            .batched(&polars_schema)
            .map_err(failed(path))?;
        Ok(Self { schema: schema.clone(), path: path.to_path_buf(), pending, writer, group: Vec::new() })
    }

    /// Takes a row; rows come in ascending order of their sample number.
    ///
    /// # Errors
    /// As [`ResultsWriter::create`].
    pub fn push(&mut self, row: Row) -> Result<(), TableError> {
        // Cut by sample number where a table is complete, by row number where it is not.
        self.group.push(row);
        if self.group.len() == ROW_GROUP { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> Result<(), TableError> {
        let written = frame(&self.schema, &self.group).and_then(|frame| self.writer.write_batch(&frame));
        self.group.clear();
        written.map_err(failed(&self.path))
    }

    /// Writes the rest and makes the table durable under its name.
    ///
    /// # Errors
    /// As [`ResultsWriter::create`].
    pub fn finish(mut self) -> Result<(), TableError> {
        if !self.group.is_empty() {
            self.write_group()?;
        }
        self.writer.finish().map_err(failed(&self.path))?;
        Ok(self.pending.finish()?)
    }
}

fn failed(path: &Path) -> impl FnOnce(PolarsError) -> TableError {
    let path = path.to_path_buf();
    move |source| TableError::Table { action: "write", path, source }
}

fn frame(schema: &TableSchema, rows: &[Row]) -> Result<DataFrame, PolarsError> {
    let mut columns = Vec::with_capacity(schema.fields().len());
    columns.push(counts("sample", rows.iter().map(|row| Some(row.sample))));
    for (position, field) in schema.parameters().iter().enumerate() {
        columns.push(parameter(field, rows.iter().map(|row| &row.parameters[position])));
    }
    columns.push(words("detection", rows.iter().map(|row| row.detection.clone())));
    columns.push(words("status", rows.iter().map(|row| Some(row.outcome.status.word().to_owned()))));
    columns.push(words("cause", rows.iter().map(|row| row.outcome.cause.map(|cause| cause.word().to_owned()))));
    columns.push(words("causes", rows.iter().map(|row| row.outcome.causes.words())));
    columns.push(words("end_cause", rows.iter().map(|row| Some(row.outcome.end_cause.word().to_owned()))));
    for (position, field) in schema.outcome().iter().enumerate() {
        // A quarantined sample has no values at all.
        let value = |row: &Row| row.outcome.values.get(position).copied().flatten().filter(|value| value.is_finite());
        let values = rows.iter().map(value);
        columns.push(match field.kind {
            FieldKind::Count => counts(&field.name, values.map(|value| value.map(|value| value as u64))),
            FieldKind::Choice(_) => words(
                &field.name,
                values.map(|value| value.and_then(|value| field.kind.word(value)).map(str::to_owned)),
            ),
            _ => reals(&field.name, values),
        });
    }
    DataFrame::new(rows.len(), columns)
}

fn parameter<'a>(field: &Field, values: impl Iterator<Item = &'a Value>) -> Column {
    let number = |value: &Value| match value {
        Value::Number(number) => Some(*number),
        Value::Word(_) => None,
    };
    match field.kind {
        FieldKind::Word | FieldKind::Choice(_) => words(
            &field.name,
            values.map(|value| match value {
                Value::Word(word) => Some(word.clone()),
                Value::Number(_) => None,
            }),
        ),
        FieldKind::Integer | FieldKind::Count => {
            let whole: Vec<Option<i64>> = values.map(|value| number(value).map(|number| number as i64)).collect();
            Series::new(field.name.as_str().into(), whole).into_column()
        }
        FieldKind::Real => reals(&field.name, values.map(number)),
    }
}

fn reals(name: &str, values: impl Iterator<Item = Option<f64>>) -> Column {
    Series::new(name.into(), values.collect::<Vec<_>>()).into_column()
}

fn counts(name: &str, values: impl Iterator<Item = Option<u64>>) -> Column {
    Series::new(name.into(), values.collect::<Vec<_>>()).into_column()
}

fn words(name: &str, values: impl Iterator<Item = Option<String>>) -> Column {
    Series::new(name.into(), values.collect::<Vec<_>>()).into_column()
}

fn data_type(kind: FieldKind) -> DataType {
    match kind {
        FieldKind::Real => DataType::Float64,
        FieldKind::Count => DataType::UInt64,
        FieldKind::Integer => DataType::Int64,
        FieldKind::Word | FieldKind::Choice(_) => DataType::String,
    }
}

/// The Arrow schema that readers find in the file, with unit and meaning in each field's metadata. Given as a key of
/// our own because a data frame's schema carries no field metadata; the writer keeps a key that is already there.
fn arrow_schema(schema: &TableSchema) -> (String, String) {
    let fields: ArrowSchema = schema
        .fields()
        .iter()
        .map(|field| {
            let name = PlSmallStr::from(field.name.as_str());
            // The plain string type: older Arrow readers do not know string views.
            let arrow: ArrowField = data_type(field.kind).to_arrow_field(name.clone(), CompatLevel::oldest());
            let metadata = [("unit", &field.unit), ("description", &field.meaning)];
            let metadata = metadata.into_iter().map(|(key, value)| (key.into(), value.as_str().into())).collect();
            (name, arrow.with_metadata(metadata))
        })
        .collect();
    let entry = polars_parquet::write::schema_to_metadata_key(&fields);
    (entry.key, entry.value.unwrap_or_default())
}
