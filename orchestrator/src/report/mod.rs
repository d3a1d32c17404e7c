//! What a person reads while a study runs: progress, time left; and one run in words.

mod bar;
mod bearings;
mod causes;
mod eta;
mod forecast;
mod limits;
mod outcome;
mod patience;
mod progress;
mod stability;
mod tally;
mod watch;

pub use bearings::{BearingNote, Beyond, bearings_beyond};
pub use causes::{advice, broken_by, cause_in_words, diverged_at, exceeded_by};
pub use eta::{Costs, Eta, Underway};
pub use forecast::{CAVEAT, Forecasts, forecast_lines, in_words, is_expected};
pub use limits::{BEYOND_SMALL, beyond_the_model, pushed_share, pushed_too_far};
pub use outcome::{OutcomeView, describe_outcome, describe_values, end_cause_in_words, mentions};
pub use patience::{matrices_of, with_word};
pub use progress::Progress;
pub use stability::{range_in_words, unstable};
pub use tally::Tally;
pub use watch::RunWatch;
