//! Questions, intervals and gates: figures that can be worked out by hand. How often intervals hold is counted in the package that knows
//! designs as well (`tests/program/coverage.rs`).

mod bad_runs;
mod beyond;
mod curves;
mod differences;
mod figures;
mod gates;
mod limits;
mod map_pictures;
mod maps;
mod paired;
mod passing;
mod questions;
mod smoothed;
mod spans;
mod support;
mod trusted;
