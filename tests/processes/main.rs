//! Worker processes whose orchestrator is this test program. A program of its own: each run removes what killed runs of its user have
//! left in shared memory, and these tests look at what is left.

mod deaths;
mod names_taken;
mod shared_memory;
#[path = "../support/mod.rs"]
mod support;
mod workers;
