//! Worker process: computes samples of a study with the core solver.
//!
//! The orchestrator starts it as `bladeoff worker ...`, so their versions never differ. It reads the frozen [`job_spec`] of the
//! result directory, checks its hash and connects. Then it asks, computes and reports ([`serve()`]) until it gets the order to
//! stop or its parent ends. A batch goes as a whole to a [`solver`], which passes the outcome of each sample to a
//! [`batch_recorder`]. A [`heartbeat`] thread reports progress and notices the end of the parent also while a sample is computed.
//! [`process`] has the functions of the process itself, [`fault`] the hooks by which tests kill it at a known state.

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
