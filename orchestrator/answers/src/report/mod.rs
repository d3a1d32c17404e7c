//! A table in words: what became of the samples, and the main quantities.

mod summary;
mod text;

pub use summary::{SUMMARY_COLUMNS, Summary, percent};
pub use text::{Align, TextTable, are, counted, duration, fitted, wrapped};
