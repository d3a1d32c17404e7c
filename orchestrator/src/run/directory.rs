//! The result directory of a study: which file is what.

use super::RunError;
use super::lock::{Holder, Lock};
use super::status::STATUS;
use crate::files::{FileError, sync_directory, write_whole};
use crate::study::Study;
use bladeoff_worker::plan::{BASIS_FILE, PLAN_FILE};
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
/// Who works in the directory.
pub const LOCK: &str = "run.lock";
/// Messages of the workers.
pub const WORKER_LOG: &str = "workers.log";

/// A result directory that no other process works in.
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    lock: Lock,
}

impl RunDirectory {
    /// Makes the directory if it is not there and takes its lock.
    ///
    /// # Errors
    /// Another run works in it; it is not a directory of results; it cannot be written.
    pub fn claim(path: &Path) -> Result<Self, RunError> {
        if fs::metadata(path).is_ok_and(|found| !found.is_dir()) {
            return Err(RunError::NotADirectory { path: path.to_path_buf() });
        }
        refuse_foreign(path)?;
        if fs::symlink_metadata(path).is_err() {
            fs::create_dir_all(path).map_err(FileError::at("create", path))?;
            sync_directory(path.parent().unwrap_or(Path::new(".")))?;
        }
        let lock = Lock::take(path, LOCK)?;
        let directory = Self { path: path.to_path_buf(), lock };
        // What a killed run was writing; nobody else writes here now.
        for name in [RESULTS, INCOMPLETE_RESULTS, TIMINGS, MANIFEST, STUDY, MACHINE, POINTS, STATUS] {
            directory.remove(&format!("{name}.tmp"))?;
        }
        directory.remove(&format!("{LEDGER}.new"))?;
        Ok(directory)
    }

    /// The run before, if it did not end in order.
    #[must_use]
    pub fn left_by(&self) -> Option<&Holder> {
        self.lock.left_by()
    }

    /// Puts a study's inputs into it; those that are there already are not touched.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn write_inputs(&self, study: &Study) -> Result<(), FileError> {
        let texts =
            [(STUDY, Some(&study.text)), (MACHINE, Some(&study.machine_text)), (POINTS, study.points_text.as_ref())];
        for (name, text) in texts {
            let path = self.file(name);
            match text {
                Some(text) if fs::read(&path).is_ok_and(|found| found == text.as_bytes()) => {}
                Some(text) => write_whole(&path, text.as_bytes())?,
                None => self.remove(name)?,
            }
        }
        Ok(())
    }

    /// Removes one of its files, if it is there.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn remove(&self, name: &str) -> Result<(), FileError> {
        let path = self.file(name);
        match fs::remove_file(&path) {
            Ok(()) => sync_directory(&self.path),
            Err(source) if source.kind() == std::io::ErrorKind::NotFound => Ok(()),
            Err(source) => Err(FileError::at("remove", &path)(source)),
        }
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

/// Refuses a directory that holds anything but a run, or the beginning of one that was killed before it had a record.
fn refuse_foreign(path: &Path) -> Result<(), RunError> {
    if path.join(LEDGER).exists() {
        return Ok(());
    }
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(FileError::at("read", path)(source).into()),
    };
    for entry in entries {
        let name = entry.map_err(FileError::at("read", path))?.file_name();
        let name = name.to_string_lossy();
        let begun = [STUDY, MACHINE, POINTS, PLAN_FILE, BASIS_FILE, LOCK];
        let unfinished = begun.iter().any(|begun| {
            name.strip_suffix(".tmp").is_some_and(|stem| stem == *begun || begun.starts_with(&format!("{stem}.")))
        });
        if !(unfinished || begun.contains(&&*name) || *name == *format!("{LEDGER}.new")) {
            return Err(RunError::Foreign { path: path.to_path_buf(), file: name.into_owned() });
        }
    }
    Ok(())
}
