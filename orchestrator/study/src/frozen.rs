//! Copies of a study's inputs beside its results, byte for byte, and their names.

use std::path::{Path, PathBuf};

/// The study.
pub const STUDY: &str = "study.toml";
/// Its machine.
pub const MACHINE: &str = "machine.toml";
/// Its points file.
pub const POINTS: &str = "points.csv";

/// The file of the n-th empirical law that there is, from 0.
#[must_use]
pub fn empirical(number: usize) -> String {
    format!("empirical-{}.csv", number + 1)
}

/// Whether a name is that of an empirical law's file.
#[must_use]
pub fn is_empirical(name: &str) -> bool {
    let number = name.strip_prefix("empirical-").and_then(|rest| rest.strip_suffix(".csv"));
    number
        .and_then(|number| number.parse::<usize>().ok())
        .is_some_and(|number| number > 0 && empirical(number - 1) == name)
}

/// Places of the files that a study froze.
#[derive(Debug, Clone)]
pub struct FrozenFiles {
    folder: PathBuf,
}

impl FrozenFiles {
    /// In a result directory.
    #[must_use]
    pub fn of(directory: &Path) -> Self {
        Self { folder: directory.to_path_buf() }
    }

    /// The study.
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
