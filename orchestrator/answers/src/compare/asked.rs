//! Request of a comparison: tables, columns, tolerances.

use super::draw::Draw;
use std::path::PathBuf;

/// A table to compare.
#[derive(Debug, Clone)]
pub struct Source<'a> {
    /// Name shown to the reader.
    pub name: String,
    /// Files of the table, at least one.
    pub files: &'a [PathBuf],
    /// Sampling of its rows.
    pub draw: &'a Draw,
}

/// Options of the comparison.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// Tolerances, each as `COLUMN VALUE`.
    pub tolerances: &'a [String],
    /// Inputs that are ignored when rows are matched.
    pub ignore: &'a [String],
}
