//! Answers from tables: intervals, questions, gates, maps, sensitivities and ends. Modules of the library's test program, because each program of tests links the table
//! library.

mod refining;
mod sensitivity;
mod stopping;
mod uncertainty;
