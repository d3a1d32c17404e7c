//! The result directory of a study: which file is what.

use super::RunError;
use crate::files::{FileError, sync_directory, write_whole};
use crate::study::Study;
use std::fs;
use std::path::{Path, PathBuf};

/// The product: one row per sample.
pub const RESULTS: &str = "results.parquet";
/// Rows finished so far of a study that was ended early; there is no [`RESULTS`] then.
pub const INCOMPLETE_RESULTS: &str = "results-incomplete.parquet";
/// CPU time, worker and attempt of each sample.
pub const TIMINGS: &str = "timings.parquet";
/// Versions, build, host, dates, command.
pub const MANIFEST: &str = "manifest.json";
/// The study as it was, byte for byte.
pub const STUDY: &str = "study.toml";
/// The machine as it was, byte for byte.
pub const MACHINE: &str = "machine.toml";
/// The points file as it was, byte for byte.
pub const POINTS: &str = "points.csv";
/// Record of finished samples.
pub const LEDGER: &str = "ledger.redb";

/// A result directory.
#[derive(Debug, Clone)]
pub struct RunDirectory {
    path: PathBuf,
}

impl RunDirectory {
    /// Makes the directory and puts the study's inputs into it.
    ///
    /// # Errors
    /// It is already there, or cannot be written.
    pub fn create(path: &Path, study: &Study) -> Result<Self, RunError> {
        if path.symlink_metadata().is_ok() {
            return Err(RunError::Exists { path: path.to_path_buf() });
        }
        if let Some(parent) = path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(FileError::at("create", parent))?;
        }
        // `create_dir` decides between two runs that start at the same moment.
        fs::create_dir(path).map_err(|source| match source.kind() {
            std::io::ErrorKind::AlreadyExists => RunError::Exists { path: path.to_path_buf() },
            _ => FileError::at("create", path)(source).into(),
        })?;
        sync_directory(path.parent().unwrap_or(Path::new(".")))?;
        let directory = Self { path: path.to_path_buf() };
        write_whole(&directory.file(STUDY), study.text.as_bytes())?;
        write_whole(&directory.file(MACHINE), study.machine_text.as_bytes())?;
        if let Some(points) = &study.points_text {
            write_whole(&directory.file(POINTS), points.as_bytes())?;
        }
        Ok(directory)
    }

    /// The directory.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// One of its files.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}
