//! Text summary of a table: statuses of the samples, and the main quantities.

mod counts;
mod figures;
mod functions;
mod reached;
mod runs;
mod text;

pub use functions::FunctionSummary;
pub use runs::{Summary, percent, worst_least};
pub use text::{Align, TextTable, are, counted, duration, fitted, wrapped};
