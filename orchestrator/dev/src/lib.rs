//! Tools of the developers, which are not released.
//!
//! `bladeoff-dev run ...` and `bladeoff-dev worker ...` are the code of `bladeoff` with [`faults`] from the environment. [`chaos`] kills and
//! stops runs at random and compares their tables. [`table1`] compares runs with the paper's Table 1. [`cli`] has the commands.

pub mod chaos;
pub mod cli;
pub mod faults;
pub mod table1;
