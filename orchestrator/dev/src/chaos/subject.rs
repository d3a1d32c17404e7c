//! The study that is disturbed.

/// The lab rig of `studies/machines`: a machine that is simulated in a fraction of a second.
pub const LAB_RIG: &str = include_str!("../../../../studies/machines/lab_rig.toml");

/// 4 gaps x 5 masses of `machines/rig.toml`; a sample takes some milliseconds.
pub const STUDY: &str = include_str!("study.toml");

/// Number of samples of the study.
pub const SAMPLES: u64 = 20;
