//! What a person reads while a study runs and after it: progress, summary, one run in words.

mod eta;
mod outcome;
mod progress;
mod summary;
mod tally;
mod text;

pub use eta::{Costs, Eta, Underway};
pub use outcome::{
    OutcomeView, advice, beyond_small_displacements, cause_in_words, describe_outcome, end_cause_in_words, mentions,
};
pub use progress::Progress;
pub use summary::{SUMMARY_COLUMNS, Summary};
pub use tally::Tally;
pub use text::{Align, TextTable, duration};
