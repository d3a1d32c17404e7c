//! Runs that are killed, stopped or disturbed by fault hooks at known states, the storm of kills, and Table 1 of the paper.

mod chaos;
mod deciding;
mod ending;
mod function_studies;
mod hooks;
mod kill_matrix;
mod looking;
mod night;
mod parts;
mod refine;
mod resume;
mod running;
mod shards;
mod slurm;
mod studies;
#[path = "../support/mod.rs"]
mod support;
mod table;
mod table1;
mod trust;
mod users;
