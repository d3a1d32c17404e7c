//! Indices against closed forms and other programs, effects of bad runs, and coverage of the intervals.
//!
//! The coverage table for this number of studies of each kind:
//! `COVERAGE_STUDIES=1000 cargo test --release -p bladeoff -p bladeoff-answers --test answers sensitivity::coverage -- --nocapture`.

mod bad_runs;
mod coverage;
mod designs;
mod given;
mod regimes;
mod support;
