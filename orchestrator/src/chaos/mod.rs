//! A seeded storm over a small study: orchestrator and workers are killed and stopped at random states and random moments,
//! continued and started again until the study is complete; then its table must be the undisturbed one, byte for byte, and
//! nothing may be left in shared memory. `bladeoff bench chaos`, and the tests of faults.

mod disturbed;
mod storm;

pub use disturbed::{Running, WATCHDOG, left_behind, lives, state};
pub use storm::{Figures, Storm};

use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::path::PathBuf;

/// The lab rig of `studies/machines`: a machine that is simulated in a fraction of a second.
pub const LAB_RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");

/// 4 gaps x 5 masses of `machines/rig.toml`; a sample takes a tenth of a second, so that there are results on disk before the
/// last begins.
pub const STUDY: &str = r#"schema = 1
name = "faults"
machine = "machines/rig.toml"

[set]
"run.end_time" = "0.1 s"

[[vary]]
path = "contact.gap"
from = "0.5 mm"
to = "0.9 mm"
count = 4

[[vary]]
path = "blade_off.mass"
from = "3 g"
to = "10 g"
count = 5
"#;

/// Samples of it.
pub const SAMPLES: u64 = 20;

/// What a storm found, or why it could not be raised.
#[derive(Debug, thiserror::Error)]
pub enum ChaosError {
    /// The table is not the undisturbed one.
    #[error(
        "study {study}: its table is not the undisturbed one; the result directory is kept as {}",
        shown(directory)
    )]
    Differs {
        /// Number of the study in the storm, from 1.
        study: u64,
        /// Where it is.
        directory: PathBuf,
    },
    /// Something is left in shared memory or in the temporary folder.
    #[error("study {study} has left {}", left.iter().map(|path| shown(path)).collect::<Vec<_>>().join(", "))]
    Left {
        /// Number of the study in the storm, from 1.
        study: u64,
        /// What.
        left: Vec<PathBuf>,
    },
    /// A process that should have ended.
    #[error("{what} does not end\n{said}")]
    Hangs {
        /// Which.
        what: &'static str,
        /// What it said.
        said: String,
    },
    /// A run that nobody killed failed.
    #[error("a run ended with {status}\n{said}")]
    Failed {
        /// How it ended.
        status: String,
        /// What it said.
        said: String,
    },
    /// A file, or a process that cannot be started.
    #[error(transparent)]
    File(#[from] FileError),
}
