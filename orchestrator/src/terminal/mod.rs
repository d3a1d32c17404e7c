//! Output on the terminal: progress and time left of a study, summary of one run.

mod advice;
mod bar;
mod bearings;
mod causes;
mod eta;
mod forecast;
mod outcome;
mod patience;
mod progress;
mod stability;
mod tally;
mod watch;

pub use advice::{Advice, BACKWARD, Change, Ran, advice, step_key};
pub use bearings::{BearingNote, Beyond, bearing_remarks, bearings_beyond};
pub use causes::{broken_by, cause_in_words, diverged_at, exceeded_at, exceeded_by, just_above};
pub use eta::{Costs, Eta, Underway};
pub use forecast::{CAVEAT, Forecasts, forecast_lines, in_words, is_expected};
pub use outcome::{OutcomeView, describe_outcome, describe_values, end_cause_in_words, mentions, ok_in_words};
pub use patience::{matrices_of, with_word};
pub use progress::Progress;
pub use stability::{Stability, range_in_words, unstable};
pub use tally::Tally;
pub use watch::RunWatch;
