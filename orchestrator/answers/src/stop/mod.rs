//! End of a study by precision, as a pure function of its rows: the end does not depend on when or how often it is analysed.
//!
//! ```text
//! [stop]   half_width, relative   largest half width of the interval of every question in every group
//!          samples                largest number of points
//! interim analysis k = 0, 1, ...  of the first 256 2^k points; the last one at the end of the design or at `samples`
//!   intervals  1 - alpha at every analysis, as in a study planned with this number of points
//!   gates      alpha/2^(k+1), the last with the rest of alpha: all levels together are alpha
//! ```
//! The study ends at the first interim analysis whose intervals are narrow enough, whatever was computed beyond. There is no decision
//! between two analyses, so the end does not depend on which run finished first.
//!
//! An interval that ends its study covers the true value about as often as it states, because the number of points depends on the width
//! alone: Y. S. Chow, H. Robbins, Ann. Math. Stat. 36 (1965). `tests/program/stop_coverage.rs` measures it. The result of a gate is a
//! decision about the estimate itself, so a gate spends its error over the analyses.

mod forecast;
mod look;
mod rule;

pub use forecast::{expected, half_width};
pub use look::{InterimAnalysis, interim_analyses};
pub use rule::{Hindrance, Precision, StopRule};
