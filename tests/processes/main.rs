//! Tests of worker processes whose orchestrator is this test program. It is a separate program because each run removes what killed runs of the same
//! user have left in shared memory, and these tests check what is left.

mod deaths;
mod names_taken;
mod shared_memory;
#[path = "../support/mod.rs"]
mod support;
mod workers;
