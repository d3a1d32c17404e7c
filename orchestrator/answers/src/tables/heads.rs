//! Columns of a result table, read without its rows.

use super::TableError;
use super::read::{checked_reader, failed};
use super::threads::guarded;
use polars::prelude::{ArrowDataType, ArrowField};
use std::path::Path;

/// Kind of the cells of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeadKind {
    /// Numbers, including counts and integers.
    Numbers,
    /// Text.
    Words,
    /// Something that no study writes.
    Other,
}

/// Name, unit and kind of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnHead {
    /// Name of the column.
    pub name: String,
    /// SI unit from the field's metadata; "" for a pure number, or without metadata.
    pub unit: String,
    /// Kind of the cells.
    pub kind: HeadKind,
}

/// The columns of a result table, in order.
///
/// # Errors
/// The file cannot be read, is not Parquet, or has another schema version.
pub fn column_heads(path: &Path) -> Result<Vec<ColumnHead>, TableError> {
    let schema = guarded(path, || checked_reader(path)?.schema().map_err(failed(path)))?;
    Ok(schema.iter_values().map(head).collect())
}

fn head(field: &ArrowField) -> ColumnHead {
    let told = field.metadata.as_ref();
    let unit = told.and_then(|told| told.iter().find(|(key, _)| key.as_str() == "unit"));
    let kind = match field.dtype() {
        ArrowDataType::Utf8 | ArrowDataType::LargeUtf8 | ArrowDataType::Utf8View => HeadKind::Words,
        kind if kind.is_numeric() => HeadKind::Numbers,
        _ => HeadKind::Other,
    };
    ColumnHead { name: field.name.to_string(), unit: unit.map(|(_, unit)| unit.to_string()).unwrap_or_default(), kind }
}
