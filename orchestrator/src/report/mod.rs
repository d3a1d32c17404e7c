//! What a person reads while a study runs: progress, time left; and one run in words.

mod bar;
mod eta;
mod limits;
mod outcome;
mod patience;
mod progress;
mod tally;
mod watch;

pub use eta::{Costs, Eta, Underway};
pub use limits::beyond_the_model;
pub use outcome::{
    OutcomeView, advice, cause_in_words, describe_outcome, describe_values, diverged_at, end_cause_in_words, mentions,
};
pub use patience::{matrices_of, with_word};
pub use progress::Progress;
pub use tally::Tally;
pub use watch::RunWatch;
