//! Random disturbances of a small study, reproducible by a seed: orchestrator and workers are killed and stopped at random states and times, and the
//! study is continued until it is complete. Then its table must be byte for byte equal to that of an undisturbed run, and nothing may be left in shared
//! memory. Used by `bladeoff-dev chaos` and the tests of faults.

mod disturbed;
mod error;
mod storm;
mod subject;

pub use disturbed::{PAUSE, Running, WATCHDOG, left_behind, lives, state};
pub use error::ChaosError;
pub use storm::{Figures, Storm};
pub use subject::{LAB_RIG, SAMPLES, STUDY};
