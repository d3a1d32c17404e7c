//! Tables to compare: a result directory with its study, or a table alone.

use super::error::CliError;
use super::refusals::NotCompared;
use super::why::frozen;
use crate::questions::drawn;
use crate::run::directory::{MANIFEST, RESULTS};
use crate::run::shards::directory_status;
use crate::run::shards::row_files;
use crate::run::{end_of_table, refuse_changed};
use bladeoff_answers::compare::Draw;
use bladeoff_answers::tables::{Table, TableError, column_heads};
use bladeoff_study::Samples;
use bladeoff_system::place::Place;
use bladeoff_system::shown;
use serde_json::Value;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Largest manifest that is read \[bytes\].
const MOST_MANIFEST: u64 = 16 << 20;

/// Identity and time of a file: device, inode, size, modification time.
type Mark = Option<(u64, u64, u64, i64, i64)>;

/// A table to compare.
pub(super) struct Opened {
    /// Name shown to the reader.
    pub name: String,
    /// Files of the table, at least one.
    pub files: Vec<PathBuf>,
    /// Sampling of its rows.
    pub draw: Draw,
    /// Study of the table, if known.
    pub samples: Option<Samples>,
    /// Commit of the program that wrote the table.
    pub commit: Option<String>,
    /// Remarks for the reader.
    pub remarks: Vec<String>,
    marks: Vec<Mark>,
}

impl Opened {
    fn new(path: &Path, files: Vec<PathBuf>) -> Self {
        Self {
            name: shown(path),
            marks: files.iter().map(|file| mark(file)).collect(),
            files,
            draw: Draw::without(
                "no interval: a table alone does not say how its samples were drawn; its directory does",
            ),
            samples: None,
            commit: None,
            remarks: Vec::new(),
        }
    }

    /// Whether the files are still those that were opened.
    pub fn is_as_opened(&self) -> bool {
        self.files.iter().map(|file| mark(file)).eq(self.marks.iter().copied())
    }
}

fn mark(file: &Path) -> Mark {
    let found = fs::symlink_metadata(file).ok()?;
    Some((found.dev(), found.ino(), found.len(), found.mtime(), found.mtime_nsec()))
}

/// Opens a result directory, a table in one, or a table alone.
pub(super) fn open(path: &Path) -> Result<Opened, CliError> {
    if fs::metadata(path).is_ok_and(|found| found.is_dir()) {
        return of_directory(path, path);
    }
    if path.symlink_metadata().is_err_and(|error| error.kind() == std::io::ErrorKind::NotFound) {
        return Err(NotCompared::Missing { path: path.to_path_buf() }.into());
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.file_name().is_some_and(|name| name == RESULTS) && directory_status(parent)?.is_some() {
        return of_directory(parent, path);
    }
    // a link named by the user is followed
    let file = if path.is_symlink() { fs::canonicalize(path).unwrap_or_else(|_| path.into()) } else { path.into() };
    let opened = Opened::new(path, vec![file]);
    match column_heads(&opened.files[0]) {
        Err(TableError::File(error)) => Err(error.into()),
        Err(source) => Err(NotCompared::NoTable { path: path.to_path_buf(), source }.into()),
        Ok(_) => Ok(opened),
    }
}

/// Opens a result directory; `path`: the name given by the user.
fn of_directory(directory: &Path, path: &Path) -> Result<Opened, CliError> {
    directory_status(directory)?.ok_or_else(|| CliError::NotARun { path: directory.to_path_buf() })?;
    let files = row_files(directory);
    let Some(first) = files.first() else { return Err(CliError::no_results(directory)) };
    let is_whole = first.ends_with(RESULTS);
    let is_known = refuse_changed(directory)?;
    let mut opened = Opened::new(path, files);
    if is_whole && !is_known {
        let table = shown(directory.join(RESULTS));
        opened.remarks.push(format!("{table} cannot be verified: {MANIFEST} has no checksum of it"));
    }
    if !is_whole {
        opened.remarks.push("the study is incomplete; the rows finished so far are compared".to_owned());
    }
    let manifest = Place::from(&directory.join(MANIFEST)).read(MOST_MANIFEST).ok();
    let manifest: Option<Value> = manifest.and_then(|text| serde_json::from_slice(&text).ok());
    opened.commit = manifest.and_then(|told| Some(told["program"]["commit"].as_str()?.to_owned()));
    match frozen(directory) {
        Ok(samples) => {
            let end = opened.files.first().filter(|_| is_whole).map(|table| end_of_table(table)).transpose()?.flatten();
            let (points, rows) = end.map_or((samples.points(), samples.count()), |end| (end.points, end.samples));
            opened.draw = if !is_whole || Table::count_rows(&opened.files)? as u64 != rows {
                Draw::without(
                    "no interval: the study is not complete, and the samples that finish first are not random",
                )
            } else if end.is_some_and(|end| end.is_chosen()) {
                Draw::without("no interval: the combinations were chosen by their results ([refine])")
            } else if end.is_some_and(|end| end.share < 1.0) {
                Draw::without(
                    "no interval: the study ended at one of several interim analyses, because its answers were precise enough there ([stop])",
                )
            } else {
                drawn(&samples, points)
            };
            opened.samples = Some(samples);
        }
        Err(error) => {
            opened.draw = Draw::without("no interval: the design of the samples can no longer be read");
            opened.remarks.push(error.to_string());
        }
    }
    Ok(opened)
}
