//! Request of a comparison: tables, columns, tolerances.

use super::draw::Draw;
use std::path::PathBuf;

/// A table.
#[derive(Debug, Clone)]
pub struct Source<'a> {
    /// What it is called.
    pub name: String,
    /// Its files, at least one.
    pub files: &'a [PathBuf],
    /// How its rows were drawn.
    pub draw: &'a Draw,
}

/// What is asked.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// `COLUMN VALUE`, each.
    pub tolerances: &'a [String],
    /// Inputs that rows do not match by.
    pub ignore: &'a [String],
}
