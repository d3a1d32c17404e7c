//! Answers from tables: intervals, questions, gates, maps, sensitivities and ends. One program, because each links the table library.

mod refining;
mod sensitivity;
mod stopping;
mod uncertainty;
