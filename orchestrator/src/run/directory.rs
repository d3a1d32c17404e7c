//! Result directory of a study, and the names of its files.

use super::error::RunError;
pub use super::lock::LOCK;
use super::lock::{Holder, Lock, Mark, foreign_lock, mark};
use super::trust::check;
use bladeoff_answers::tables::TableError;
use bladeoff_record::is_store;
use bladeoff_study::sampling::layout::MOST_PARAMETERS;
pub use bladeoff_study::{MACHINE, POINTS, STUDY};
use bladeoff_study::{Study, empirical, is_empirical};
use bladeoff_system::files::{FileError, is_temporary, sync_parent, write_whole};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::{Place, close_to_others};
use bladeoff_worker::job_spec::{BASIS_FILE, PLAN_FILE};
use rustix::process::geteuid;
use std::ffi::OsStr;
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

/// Final table: one row per sample.
pub const RESULTS: &str = "results.parquet";
/// Folder of the finished rows while there is no [`RESULTS`]: Parquet files that contain every finished row once.
pub const PARTS: &str = "parts";
/// CPU time, worker and attempt of each sample.
pub const TIMINGS: &str = "timings.parquet";
/// Folder of the timings of the rows in [`PARTS`], in files of the same names.
pub const TIMING_PARTS: &str = "timings-parts";
/// Rows of an interim analysis.
pub(super) const LOOK: &str = "look.parquet";
/// Versions, build, host, dates, command.
pub const MANIFEST: &str = "manifest.json";
/// Record of finished samples.
pub const LEDGER: &str = "ledger.redb";
/// Name of the record file.
pub const STATUS: &str = "status.json";
/// Answers to the questions of a complete study.
pub const ANSWERS: &str = "answers.json";
/// Folder of their curves: a Parquet file for each question with a curve.
pub const CURVES: &str = "answers";
/// Checksums of answers and curves, in the format of `b3sum`.
pub(super) const ANSWER_SUMS: &str = "answers.b3sum";
/// Messages of the workers.
pub const WORKER_LOG: &str = "workers.log";

/// Files that are written under a temporary name first.
const WHOLE: [&str; 15] = [
    RESULTS,
    LOOK,
    TIMINGS,
    MANIFEST,
    STUDY,
    MACHINE,
    POINTS,
    PLAN_FILE,
    BASIS_FILE,
    STATUS,
    PARTS,
    TIMING_PARTS,
    LEDGER,
    ANSWERS,
    ANSWER_SUMS,
];
/// Files that exist before the record.
const FIRST: [&str; 6] = [LOCK, STUDY, MACHINE, POINTS, BASIS_FILE, PLAN_FILE];

/// Result directory locked by this process. It is held open, so that the run keeps using the same directory if its path changes.
#[derive(Debug)]
pub struct RunDirectory {
    folder: Folder,
    /// Absolute path.
    absolute: PathBuf,
    lock: Lock,
}

impl RunDirectory {
    /// Creates the directory if necessary and locks it; `trusts`: also accept a directory to which other users may write.
    /// `study`: study whose inputs a run killed at its beginning may have left.
    ///
    /// # Errors
    /// Another run uses the directory, it is no result directory, other users may write to it, or it cannot be written.
    pub fn claim(path: &Path, trusts: bool, study: Option<&Study>) -> Result<Self, RunError> {
        if fs::metadata(path).is_ok_and(|found| !found.is_dir()) {
            return Err(RunError::NotADirectory { path: path.to_path_buf() });
        }
        let is_new = fs::symlink_metadata(path).is_err();
        if is_new {
            fs::DirBuilder::new().recursive(true).mode(0o755).create(path).map_err(FileError::at("create", path))?;
            sync_parent(path)?;
        }
        let folder = Folder::open(path).map_err(FileError::at("open", path))?;
        let trusted = || -> Result<(), RunError> { check(&folder, trusts)?.map_or(Ok(()), |doubt| Err(doubt.into())) };
        if let Err(refused) = trusted().and_then(|()| refuse_foreign(&folder, study)) {
            if is_new {
                // An empty directory that remains has no effect.
                let _ = fs::remove_dir(path);
            }
            return Err(refused);
        }
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let lock = Lock::take(&folder, LOCK)?;
        // A user who can open the record can lock it. An unreadable record is an error later.
        if let Ok(record) = folder.place(LEDGER).open_own() {
            close_to_others(&record);
        }
        Ok(Self { folder, absolute, lock })
    }

    /// Removes the temporary files of a killed run by their names, without reading the folders of parts.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn tidy_files(&self) -> Result<(), FileError> {
        let names = self.folder.names().map_err(FileError::at("read", self.path()))?;
        let is_begun = |name: &OsStr| {
            // Earlier builds used this temporary name for the record.
            is_whole_begun(name) || name.to_str() == Some(&format!("{LEDGER}.new"))
        };
        let mut is_changed = false;
        for name in names.iter().filter(|name| is_begun(name)) {
            let place = self.folder.place(name);
            // Another file of such a name has no effect.
            if place.is_file() && self.is_own(&place) {
                is_changed |= place.remove()?;
            }
        }
        if is_changed { self.folder.sync() } else { Ok(()) }
    }

    /// Whether a file belongs to this user or to the owner of the directory.
    fn is_own(&self, place: &Place) -> bool {
        let own = [Some(geteuid().as_raw()), self.folder.stat().ok().map(|found| found.st_uid)];
        place.owner().is_some_and(|owner| own.contains(&Some(owner)))
    }

    /// Previous run, if it was killed.
    #[must_use]
    pub fn left_by(&self) -> Option<&Holder> {
        self.lock.left_by()
    }

    /// Writes the inputs of a study; existing files are kept.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn write_inputs(&self, study: &Study) -> Result<(), FileError> {
        for (name, text) in study.inputs() {
            let path = self.file(&name);
            match text {
                Some(text) if path.read(text.len() as u64).is_ok_and(|found| found == text.as_bytes()) => {}
                Some(text) => write_whole(&path, text.as_bytes())?,
                None => self.remove(&name)?,
            }
        }
        Ok(())
    }

    /// Removes a file of the directory, if it exists.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn remove(&self, name: &str) -> Result<(), FileError> {
        if self.file(name).remove()? { self.folder.sync() } else { Ok(()) }
    }

    /// Path by which the directory was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Absolute path of the directory.
    #[must_use]
    pub fn absolute(&self) -> &Path {
        &self.absolute
    }

    /// Open folder.
    #[must_use]
    pub fn open(&self) -> &Folder {
        &self.folder
    }

    /// Place of a file in the directory.
    #[must_use]
    pub fn file(&self, name: &str) -> Place {
        self.folder.place(name)
    }
}

/// Whether this is the file name of a part.
pub(super) fn is_part(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let number = name.strip_prefix("part-").and_then(|rest| rest.strip_suffix(".parquet"));
    number.is_some_and(|number| number.len() >= 6 && number.bytes().all(|digit| digit.is_ascii_digit()))
}

/// File name of a part; numbers begin at 1.
#[must_use]
pub fn part_name(number: u32) -> String {
    format!("part-{number:06}.parquet")
}

/// Lists the files with the finished rows: the table, or the parts in order.
#[must_use]
pub fn row_files(directory: &Path) -> Vec<PathBuf> {
    table_or_parts(directory, RESULTS, PARTS)
}

/// Lists the files with the timings of those rows.
#[must_use]
pub fn timing_files(directory: &Path) -> Vec<PathBuf> {
    table_or_parts(directory, TIMINGS, TIMING_PARTS)
}

fn table_or_parts(directory: &Path, table: &str, parts: &str) -> Vec<PathBuf> {
    let Ok(folder) = Folder::open(directory) else { return Vec::new() };
    // Any file with the name of the table; its readers report an invalid one.
    if folder.place(table).exists() {
        return vec![directory.join(table)];
    }
    let names = folder.folder(parts).and_then(|parts| parts.names()).unwrap_or_default();
    let mut files: Vec<PathBuf> =
        names.into_iter().filter(|name| is_part(name)).map(|name| directory.join(parts).join(name)).collect();
    files.sort_unstable();
    files
}

/// Reads the files that `list` returns, and again if a run replaces them meanwhile.
///
/// # Errors
/// The error of `read`.
pub fn read_current<T>(
    directory: &Path,
    list: fn(&Path) -> Vec<PathBuf>,
    mut read: impl FnMut(&[PathBuf]) -> Result<T, TableError>,
) -> Result<T, TableError> {
    loop {
        let files = list(directory);
        match read(&files) {
            Err(TableError::File(error))
                if error.source.kind() == std::io::ErrorKind::NotFound && list(directory) != files => {}
            read => return read,
        }
    }
}

/// Whether this is a temporary name of a run.
fn is_whole_begun(name: &OsStr) -> bool {
    let begins = |whole: &str| is_temporary(name, whole);
    WHOLE.into_iter().any(begins) || (0..MOST_PARAMETERS).any(|number| begins(&empirical(number)))
}

/// Rejects a directory with files that was not begun by a run. A run writes its lock before anything else.
fn refuse_foreign(folder: &Folder, study: Option<&Study>) -> Result<(), RunError> {
    let mark = mark(folder, LOCK);
    if mark == Mark::Closed {
        let lock = folder.place(LOCK);
        return Err(match foreign_lock(folder, &lock) {
            Some(theirs) => theirs.into(),
            None => FileError::at("open", &lock)(ErrorKind::PermissionDenied.into()).into(),
        });
    }
    if mark == Mark::Run || is_store(&folder.place(LEDGER)) {
        return Ok(());
    }
    let names = folder.names().map_err(FileError::at("read", folder.path()))?;
    // An empty lock: the run was killed before it wrote the holder, the power failed, or the file was emptied before there was a
    // record.
    let is_there = |(name, text): (String, Option<&str>)| match text {
        Some(text) => folder.place(&name).read(text.len() as u64).is_ok_and(|found| found == text.as_bytes()),
        None => !folder.place(&name).exists(),
    };
    let has_inputs = mark == Mark::Empty && study.is_some_and(|study| study.inputs().into_iter().all(is_there));
    let is_first = |name: &OsStr| {
        FIRST.iter().any(|first| name == *first) || name.to_str().is_some_and(is_empirical) || is_whole_begun(name)
    };
    let is_begun = |name: &OsStr| mark == Mark::Empty && name == LOCK || has_inputs && is_first(name);
    match names.into_iter().filter(|name| !is_begun(name)).min() {
        None => Ok(()),
        Some(name) => Err(RunError::Foreign { path: folder.path().to_path_buf(), file: name }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_run_was_writing_goes_and_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let directory = RunDirectory::claim(folder.path(), false, None).expect("empty");
        let path = |name: &str| folder.path().join(name);
        let begun = [
            "plan.json.0123abcd.tmp",
            "parts.0123abcd.tmp",
            "ledger.redb.0123abcd.tmp",
            "manifest.json.tmp",
            "ledger.redb.new",
        ];
        let others = ["plan.json.mine.tmp", "notes.txt.0123abcd.tmp", "plan.json"];
        begun.iter().chain(&others).for_each(|name| fs::write(path(name), b"x").expect("written"));
        fs::create_dir(path("study.toml.0123abcd.tmp")).expect("created");
        std::os::unix::fs::symlink("notes.txt.0123abcd.tmp", path("machine.toml.0123abcd.tmp")).expect("linked");
        directory.tidy().expect("writable");
        let is_there = |name: &&str| fs::symlink_metadata(path(name)).is_ok();
        assert!(!begun.iter().any(is_there) && others.iter().all(is_there));
        assert!(["study.toml.0123abcd.tmp", "machine.toml.0123abcd.tmp"].iter().all(is_there), "no regular files");
    }
}
