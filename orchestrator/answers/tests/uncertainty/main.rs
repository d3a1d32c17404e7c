//! Questions, intervals and gates: figures that can be worked out by hand, published probabilities, and how often intervals hold.
//!
//! The coverage table of so many studies of each kind (1000: about five minutes):
//! `COVERAGE_STUDIES=1000 cargo test --release --workspace --test uncertainty coverage -- --nocapture`.

mod bad_runs;
mod coverage;
mod curves;
mod differences;
mod figures;
mod gates;
mod limits;
mod published;
mod questions;
mod spans;
mod support;
