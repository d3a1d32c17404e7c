//! Whole runs: engines side by side, columns, guards, limits, stresses, steps, twins, extreme machines.

mod columns;
#[path = "../common/mod.rs"]
mod common;
mod engines;
mod extremes;
mod guarded;
mod limits;
mod monitors;
mod releases;
mod ring_stresses;
mod stepping;
mod stresses;
mod torques;
mod twin;
mod verification;
mod yield_times;
