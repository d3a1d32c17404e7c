//! A worker process: serves samples of a study with the core solver.
//!
//! It is started by the orchestrator as `bladeoff worker ...` (so their versions never differ), reads the frozen
//! [`job_spec`] of the result directory and checks its hash, connects, and then asks, computes, reports ([`serve()`])
//! until it is told to stop or its parent ends. A batch goes as a whole to a [`solver`], which gives a [`batch_recorder`] the outcome of
//! each sample. A [`heartbeat`] thread beats and sees the parent's end also while a sample is
//! computed. [`process`] holds what concerns the process as such, [`fault`] the hooks by which tests kill it at a known
//! state.

pub mod args;
pub mod batch_recorder;
pub mod core_solver;
mod entry;
pub mod fault;
pub mod function_solver;
pub mod heartbeat;
pub mod job_spec;
pub mod noop;
pub mod process;
pub mod serve;
pub mod solver;

pub use args::WorkerArgs;
pub use entry::worker_main;
pub use serve::serve;
pub use solver::Solver;
