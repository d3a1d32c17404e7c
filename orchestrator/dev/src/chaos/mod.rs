//! A seeded storm over a small study: orchestrator and workers are killed and stopped at random states and random moments,
//! continued and started again until the study is complete; then its table must be the undisturbed one, byte for byte, and
//! nothing may be left in shared memory. `bladeoff-dev chaos`, and the tests of faults.

mod disturbed;
mod error;
mod storm;
mod subject;

pub use disturbed::{Running, WATCHDOG, left_behind, lives, state};
pub use error::ChaosError;
pub use storm::{Figures, Storm};
pub use subject::{LAB_RIG, SAMPLES, STUDY};
