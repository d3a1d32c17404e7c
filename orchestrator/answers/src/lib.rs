//! Answers from the tables and histories of a study; nothing here depends on a run in progress.
//!
//! ```text
//! rows --tables--> results.parquet --tables--> columns --report--> summary as text
//! history of a run, machine, lines --figures--> SVG, PNG, by the elements and axes of drawing
//! columns of a random design --estimate--> figures with intervals --ask--> answers, --gate--> 0, 4 or 5
//! columns over two parameters --map--> cells, smoothed where samples are scattered --ask--> answers, --figures--> pictures
//! columns --sensitivity--> importance of parameters; figures at interim analyses --stop--> whether they are precise enough
//! text, tables, figures --page--> one HTML page
//! two tables --compare--> differences between them
//! ```
//! The table describes its study: nothing here depends on study files, workers or records.

pub mod ask;
pub mod compare;
mod drawing;
pub mod estimate;
pub mod figures;
pub mod gate;
pub mod history;
pub mod map;
pub mod page;
pub mod sensitivity;
mod share;
pub mod stop;
pub mod summary;
pub mod tables;

/// Tests of the public interface use the name of the library.
#[cfg(test)]
extern crate self as bladeoff_answers;
#[cfg(test)]
#[path = "../tests/answers.rs"]
mod tests;
