//! Indices against closed forms and other programs, what bad runs do to them, and how often their intervals hold.
//!
//! The coverage table of so many studies of each kind:
//! `COVERAGE_STUDIES=1000 cargo test --release -p bladeoff -p bladeoff-answers --test answers sensitivity::coverage -- --nocapture`.

mod bad_runs;
mod coverage;
mod designs;
mod given;
mod regimes;
mod support;
