//! A table in words: what became of the samples, and the main quantities.

mod counts;
mod figures;
mod functions;
mod reached;
mod summary;
mod text;

pub use functions::FunctionSummary;
pub use summary::{Summary, percent, worst_least};
pub use text::{Align, TextTable, are, counted, duration, fitted, wrapped};
