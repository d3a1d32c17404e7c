//! Copies of a study's inputs in its result directory, byte for byte, and their names.

use std::path::{Path, PathBuf};

/// Name of the study file.
pub const STUDY: &str = "study.toml";
/// Name of the machine file.
pub const MACHINE: &str = "machine.toml";
/// Name of the points file.
pub const POINTS: &str = "points.csv";

/// Name of the file of an empirical distribution, counted from 0.
#[must_use]
pub fn empirical(number: usize) -> String {
    format!("empirical-{}.csv", number + 1)
}

/// Whether a name is that of an empirical distribution's file.
#[must_use]
pub fn is_empirical(name: &str) -> bool {
    let number = name.strip_prefix("empirical-").and_then(|rest| rest.strip_suffix(".csv"));
    number
        .and_then(|number| number.parse::<usize>().ok())
        .is_some_and(|number| number > 0 && empirical(number - 1) == name)
}

/// Paths of the copied inputs of a study.
#[derive(Debug, Clone)]
pub struct FrozenFiles {
    folder: PathBuf,
}

impl FrozenFiles {
    /// The inputs in a result directory.
    #[must_use]
    pub fn of(directory: &Path) -> Self {
        Self { folder: directory.to_path_buf() }
    }

    /// Path of the study file.
    #[must_use]
    pub fn study(&self) -> PathBuf {
        self.folder.join(STUDY)
    }

    pub(super) fn machine(&self) -> PathBuf {
        self.folder.join(MACHINE)
    }

    pub(super) fn points(&self) -> PathBuf {
        self.folder.join(POINTS)
    }

    pub(super) fn empirical(&self, number: usize) -> PathBuf {
        self.folder.join(empirical(number))
    }
}
