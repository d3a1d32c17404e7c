//! Writer of `results.parquet`; the same rows always give the same bytes.

use super::TableError;
use super::grouped::GroupedWriter;
use super::schema::{ENGINE, Field, FieldKind, NOTES, SCHEMA_VERSION, TableSchema};
use super::stream::{Checksum, Out};
use bladeoff_model::machine::ParamValue;
use bladeoff_model::outcome::Outcome;
use bladeoff_system::files::Pending;
use polars::prelude::{
    ArrowField, ArrowSchema, Column, CompatLevel, DataFrame, DataType, IntoColumn, KeyValueMetadata, NamedFrom,
    ParquetWriter, PlSmallStr, PolarsError, Schema, Series, StatisticsOptions,
};

/// One row: sample, varied values and outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Row number in the study.
    pub sample: u64,
    /// One value per parameter field of the schema: an SI number (an integer if the column contains integers), a word, or text; `None` is
    /// null.
    pub parameters: Vec<Option<ParamValue>>,
    /// Contact detection; `None` without a diaphragm.
    pub detection: Option<String>,
    /// Engine; `None` in a formula study.
    pub engine: Option<String>,
    /// Outcome; one value per outcome field of the schema.
    pub outcome: Outcome,
}

/// Key-value metadata of the file with the provenance of the table; nothing that differs between equal runs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance(pub Vec<(String, String)>);

/// Writer of the table.
pub struct ResultsWriter(GroupedWriter<Row>);

impl ResultsWriter {
    /// Starts a table in this file.
    ///
    /// # Errors
    /// The disk is full or not writable, or Polars reports an error.
    pub fn create(file: Pending, schema: &TableSchema, provenance: &Provenance) -> Result<Self, TableError> {
        let polars_schema: Schema =
            schema.fields().iter().map(|f| (PlSmallStr::from(f.name.as_str()), data_type(f.kind))).collect();
        let mut metadata = vec![("bladeoff.schema_version".to_owned(), SCHEMA_VERSION.to_string())];
        metadata.extend(provenance.0.iter().map(|(key, value)| (format!("bladeoff.{key}"), value.clone())));
        metadata.insert(0, arrow_schema(schema));
        let metadata = KeyValueMetadata::from_static(metadata);
        let settings = |writer: ParquetWriter<Out>| {
            writer.with_statistics(StatisticsOptions::full()).with_key_value_metadata(Some(metadata))
        };
        let schema = schema.clone();
        let frame = move |rows: &[Row]| frame(&schema, rows);
        Ok(Self(GroupedWriter::create(file, &polars_schema, settings, frame)?))
    }

    /// Adds a row; rows must be in ascending order of their sample number.
    ///
    /// # Errors
    /// As [`ResultsWriter::create`].
    pub fn push(&mut self, row: Row) -> Result<(), TableError> {
        self.0.push(row)
    }

    /// Writes the remaining rows, makes the table durable under its name, and returns its checksum.
    ///
    /// # Errors
    /// As [`ResultsWriter::create`].
    pub fn finish(self) -> Result<Checksum, TableError> {
        self.0.finish()
    }
}

fn frame(schema: &TableSchema, rows: &[Row]) -> Result<DataFrame, PolarsError> {
    let mut columns = Vec::with_capacity(schema.fields().len());
    columns.push(counts("sample", rows.iter().map(|row| Some(row.sample))));
    for (position, field) in schema.parameters().iter().enumerate() {
        columns.push(parameter(field, rows.iter().map(|row| &row.parameters[position])));
    }
    if schema.is_of_machine() {
        columns.push(words("detection", rows.iter().map(|row| row.detection.clone())));
    }
    columns.push(words("status", rows.iter().map(|row| Some(row.outcome.status.word().to_owned()))));
    columns.push(words("cause", rows.iter().map(|row| row.outcome.cause.map(|cause| cause.word().to_owned()))));
    columns.push(words("causes", rows.iter().map(|row| row.outcome.causes.words())));
    columns.push(words("end_cause", rows.iter().map(|row| Some(row.outcome.end_cause.word().to_owned()))));
    if schema.is_of_machine() {
        columns.push(words(NOTES, rows.iter().map(|row| row.outcome.notes.words())));
    }
    for (position, field) in schema.outcome().iter().enumerate() {
        // a quarantined sample has no values
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
    if schema.is_of_machine() {
        columns.push(words(ENGINE, rows.iter().map(|row| row.engine.clone())));
    }
    DataFrame::new(rows.len(), columns)
}

fn parameter<'a>(field: &Field, values: impl Iterator<Item = &'a Option<ParamValue>>) -> Column {
    let number = |value: &Option<ParamValue>| match value {
        Some(ParamValue::Number(number)) => Some(*number),
        Some(ParamValue::Choice(_)) | None => None,
    };
    match field.kind {
        FieldKind::Word | FieldKind::Choice(_) => words(
            &field.name,
            values.map(|value| match value {
                Some(ParamValue::Choice(word)) => Some(word.clone()),
                Some(ParamValue::Number(_)) | None => None,
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

/// Arrow schema with unit and meaning in each field's metadata. It is written as a key, because the schema of a data frame has no field
/// metadata; the writer keeps an existing key.
fn arrow_schema(schema: &TableSchema) -> (String, String) {
    let fields: ArrowSchema = schema
        .fields()
        .iter()
        .map(|field| {
            let name = PlSmallStr::from(field.name.as_str());
            // plain strings: older Arrow readers do not support string views
            let arrow: ArrowField = data_type(field.kind).to_arrow_field(name.clone(), CompatLevel::oldest());
            let metadata = [("unit", &field.unit), ("description", &field.meaning)];
            let metadata = metadata.into_iter().map(|(key, value)| (key.into(), value.as_str().into())).collect();
            (name, arrow.with_metadata(metadata))
        })
        .collect();
    let entry = polars_parquet::write::schema_to_metadata_key(&fields);
    (entry.key, entry.value.unwrap_or_default())
}
