//! The result directory of a study: which file is what.

use super::RunError;
use super::lock::{Holder, Lock};
use super::status::STATUS;
use crate::files::{FileError, sync_directory, write_whole};
use crate::results::TableError;
use crate::study::Study;
use bladeoff_core::document::visible;
use bladeoff_worker::plan::{BASIS_FILE, PLAN_FILE};
use rustix::fs::{CWD, RenameFlags, renameat_with};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// The product: one row per sample.
pub const RESULTS: &str = "results.parquet";
/// Folder of the rows finished so far while there is no [`RESULTS`]: Parquet files, every row in one of them.
pub const PARTS: &str = "parts";
/// CPU time, worker and attempt of each sample.
pub const TIMINGS: &str = "timings.parquet";
/// The same for the rows in [`PARTS`], in files of the same names.
pub const TIMING_PARTS: &str = "timings-parts";
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
        Ok(Self { path: path.to_path_buf(), lock })
    }

    /// Removes what a killed run was writing; nobody else writes here now.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn tidy(&self) -> Result<(), FileError> {
        for name in
            [RESULTS, TIMINGS, MANIFEST, STUDY, MACHINE, POINTS, PLAN_FILE, BASIS_FILE, STATUS, PARTS, TIMING_PARTS]
        {
            self.remove(&format!("{name}.tmp"))?;
        }
        for folder in [PARTS, TIMING_PARTS] {
            self.empty_aside(folder)?;
        }
        self.remove(&format!("{LEDGER}.new"))
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

    /// An empty folder beside the one of this name, which it can take the place of.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn new_folder(&self, name: &str) -> Result<PathBuf, FileError> {
        self.empty_aside(name)?;
        let path = self.file(&aside(name));
        fs::create_dir(&path).map_err(FileError::at("create", &path))?;
        Ok(path)
    }

    /// Puts what [`RunDirectory::new_folder`] made in the place of the folder of this name: at every moment one of the two
    /// is there, where the file system can exchange names.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn put_new_folder(&self, name: &str) -> Result<(), FileError> {
        let (new, path) = (self.file(&aside(name)), self.file(name));
        let renamed = || {
            if path.exists() {
                if renameat_with(CWD, &new, CWD, &path, RenameFlags::EXCHANGE).is_ok() {
                    return Ok(());
                }
                // A file system that cannot exchange names: parts are replaced one by one.
                remove_parts_in(&path)?;
                for entry in fs::read_dir(&new)? {
                    let entry = entry?;
                    fs::rename(entry.path(), path.join(entry.file_name()))?;
                }
                return Ok(());
            }
            fs::rename(&new, &path)
        };
        renamed().map_err(FileError::at("rename to", &path))?;
        sync_directory(&self.path)?;
        self.empty_aside(name)
    }

    /// Removes the folders of finished rows, each at once with all parts in it. What somebody else has put there stays.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn remove_parts(&self) -> Result<(), FileError> {
        for name in [PARTS, TIMING_PARTS] {
            self.empty_aside(name)?;
            let (path, away) = (self.file(name), self.file(&aside(name)));
            match fs::rename(&path, &away) {
                Ok(()) => sync_directory(&self.path)?,
                Err(source) if source.kind() == std::io::ErrorKind::NotFound => continue,
                Err(source) => return Err(FileError::at("remove", &path)(source)),
            }
            self.empty_aside(name)?;
        }
        Ok(())
    }

    /// Removes the folder of parts on its way in or out. Files in it that are no parts are somebody's own: they go back to
    /// where they were put.
    fn empty_aside(&self, name: &str) -> Result<(), FileError> {
        let (path, home) = (self.file(&aside(name)), self.file(name));
        let emptied = || {
            remove_parts_in(&path)?;
            for entry in fs::read_dir(&path)? {
                let entry = entry?;
                fs::create_dir_all(&home)?;
                fs::rename(entry.path(), free_name(&home, &entry.file_name()))?;
            }
            fs::remove_dir(&path)
        };
        match emptied() {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(FileError::at("remove", &path)(source)),
            _ => Ok(()),
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

/// Name of a folder on its way in or out.
fn aside(folder: &str) -> String {
    format!("{folder}.aside")
}

/// Removes the parts in a folder.
fn remove_parts_in(folder: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if is_part(&entry.file_name()) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// A path of this name in a folder, or one like it that nothing has yet.
fn free_name(folder: &Path, name: &OsStr) -> PathBuf {
    let mut path = folder.join(name);
    let mut n = 1;
    while fs::symlink_metadata(&path).is_ok() {
        let mut other = name.to_owned();
        other.push(format!(".kept-{n}"));
        path = folder.join(other);
        n += 1;
    }
    path
}

/// Whether a file has the name of a part.
fn is_part(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let number = name.strip_prefix("part-").and_then(|rest| rest.strip_suffix(".parquet"));
    number.is_some_and(|number| number.len() >= 6 && number.bytes().all(|digit| digit.is_ascii_digit()))
}

/// Name of a part, from 1.
#[must_use]
pub fn part_name(number: u32) -> String {
    format!("part-{number:06}.parquet")
}

/// The files that hold the rows finished so far: the table, or the parts in their order; none before there are any.
#[must_use]
pub fn row_files(directory: &Path) -> Vec<PathBuf> {
    table_or_parts(directory, RESULTS, PARTS)
}

/// The files that hold the timings of those rows.
#[must_use]
pub fn timing_files(directory: &Path) -> Vec<PathBuf> {
    table_or_parts(directory, TIMINGS, TIMING_PARTS)
}

fn table_or_parts(directory: &Path, table: &str, parts: &str) -> Vec<PathBuf> {
    let table = directory.join(table);
    if table.is_file() {
        return vec![table];
    }
    let entries = fs::read_dir(directory.join(parts)).into_iter().flatten().flatten();
    let parts = entries.filter(|entry| is_part(&entry.file_name()));
    let mut parts: Vec<PathBuf> = parts.map(|entry| entry.path()).collect();
    parts.sort_unstable();
    parts
}

/// Reads the files that `list` finds in a directory, again if a run has replaced them meanwhile by others.
///
/// # Errors
/// What `read` returns.
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
        let unfinished = begun.iter().any(|begun| name.strip_suffix(".tmp").is_some_and(|stem| stem == *begun));
        if !(unfinished || begun.contains(&&*name) || *name == *format!("{LEDGER}.new")) {
            return Err(RunError::Foreign { path: path.to_path_buf(), file: visible(&name).into_owned() });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_somebody_puts_between_the_parts_stays() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let directory = RunDirectory::claim(folder.path()).expect("empty");
        let put = |path: &Path, name: &str, text: &str| fs::write(path.join(name), text).expect("written");
        let parts = directory.file(PARTS);
        let names = || {
            let entries = fs::read_dir(&parts).into_iter().flatten().flatten();
            let mut names: Vec<_> = entries.map(|entry| entry.file_name().into_string().expect("UTF-8")).collect();
            names.sort();
            names
        };
        fs::create_dir(&parts).expect("created");
        for name in [&part_name(1), &part_name(1_000_000), "part-mine.parquet", "notes.txt"] {
            put(&parts, name, name);
        }
        assert_eq!(row_files(folder.path()).len(), 2);
        // Fresh parts take the place of the old ones.
        let fresh = directory.new_folder(PARTS).expect("made");
        put(&fresh, &part_name(1), "fresh");
        directory.put_new_folder(PARTS).expect("exchanged");
        assert_eq!(names(), ["notes.txt", "part-000001.parquet", "part-mine.parquet"]);
        assert_eq!(fs::read_to_string(parts.join(part_name(1))).expect("there"), "fresh");
        // A kill half way, and a name that was used again meanwhile.
        fs::rename(&parts, directory.file(&aside(PARTS))).expect("renamed");
        fs::create_dir(&parts).expect("created");
        put(&parts, "notes.txt", "newer");
        directory.remove_parts().expect("removed");
        assert_eq!(names(), ["notes.txt", "notes.txt.kept-1", "part-mine.parquet"]);
        assert_eq!(fs::read_to_string(parts.join("notes.txt.kept-1")).expect("there"), "notes.txt");
        assert!(!directory.file(&aside(PARTS)).exists());
        // Without anything of somebody else nothing is left.
        fs::remove_dir_all(&parts).expect("removed");
        fs::create_dir(&parts).expect("created");
        put(&parts, &part_name(1), "");
        directory.remove_parts().expect("removed");
        assert!(!parts.exists());
    }
}
