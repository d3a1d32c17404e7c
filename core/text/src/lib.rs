//! The language of the input files: TOML in which every value has its place, quantities with units, formulas.
//!
//! Machine and study files are read by [`document`]; a text such as `"max_bearing_load_N > 1.2 MN"` becomes a program by [`formula`]. Problems carry file, line, key, value, what is
//! allowed and the nearest valid name.

pub mod document;
pub mod formula;
