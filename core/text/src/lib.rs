//! The language of the input files: TOML with the position of every value, quantities with units, formulas.
//!
//! [`document`] reads machine and study files; [`formula`] compiles a text such as `"max_bearing_load_N > 1.2 MN"` to a program. Problems have
//! file, line, key, value, allowed values and the nearest valid name.

pub mod document;
pub mod formula;
