//! Questions, intervals and gates: results that can be calculated manually. Coverage is measured in the package that also contains the
//! designs (`tests/program/coverage.rs`).

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
