//! What of a study's inputs lies beside its results, byte for byte, and by which names.

use super::definition::Study;
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

/// Where the files are that a study froze.
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

impl Study {
    /// Its inputs by the names that they have beside the results; `None`: this study has none of these.
    #[must_use]
    pub fn inputs(&self) -> Vec<(String, Option<&str>)> {
        let machine = self.machine().map(|machine| machine.text.as_str());
        let mut inputs = vec![
            (STUDY.to_owned(), Some(self.text.as_str())),
            (MACHINE.to_owned(), machine),
            (POINTS.to_owned(), self.points_text.as_deref()),
        ];
        let texts = self.empirical_texts.iter().enumerate();
        inputs.extend(texts.map(|(number, text)| (empirical(number), Some(text.as_str()))));
        inputs
    }
}
