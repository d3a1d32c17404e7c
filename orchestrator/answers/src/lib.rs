//! What a study answers: from tables and histories alone, never from a run under way.
//!
//! ```text
//! rows --tables--> results.parquet --tables--> columns --report--> summary as text
//! history of a run, machine, lines --figures--> SVG, PNG
//! runs of the paper's comparison --table1--> the paper's table beside ours
//! ```
//! What a study is, its table says: nothing here knows study files, workers or records.

pub mod figures;
pub mod history;
pub mod report;
pub mod table1;
pub mod tables;
