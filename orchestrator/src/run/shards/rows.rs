//! The rows of any result directory, as files of tables: of one machine its table or parts, of shards that are not merged yet what their
//! chunks hold, converted into a folder of this process.

use super::super::directory::{self, RESULTS, part_name};
use super::super::error::RunError;
use super::super::partial_tables::PART_ROWS;
use super::super::tables::RowsWriter;
use super::chunk::read;
use super::error::ShardError;
use super::freeze::{prepared, samples};
use super::frozen::Frozen;
use super::layout::SHARDS;
use super::shared::Shared;
use bladeoff_answers::tables::start_threads;
use bladeoff_system::files::{FileError, Pending, unguessable};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Rows of the directories that were looked at, by their path; [`forget`] removes them.
static LOOKED: Mutex<BTreeMap<PathBuf, Looked>> = Mutex::new(BTreeMap::new());

#[derive(Clone, Default)]
struct Looked {
    rows: Vec<PathBuf>,
    timings: Vec<PathBuf>,
    /// Chunks that are not as they were written.
    damaged: Vec<String>,
    /// Where they are.
    folder: Option<Arc<OwnFolder>>,
}

/// Whether a directory holds shards that are not merged.
#[must_use]
pub fn is_unmerged(directory: &Path) -> bool {
    directory.join(SHARDS).is_file() && !directory.join(RESULTS).exists()
}

/// The files that hold the rows finished so far: as [`directory::row_files`], and of shards those of their chunks.
#[must_use]
pub fn row_files(directory: &Path) -> Vec<PathBuf> {
    if is_unmerged(directory) { looked(directory).rows } else { directory::row_files(directory) }
}

/// The files that hold the timings of those rows.
#[must_use]
pub fn timing_files(directory: &Path) -> Vec<PathBuf> {
    if is_unmerged(directory) { looked(directory).timings } else { directory::timing_files(directory) }
}

/// What cannot be read of shards that are not merged, in words.
#[must_use]
pub fn unread(directory: &Path) -> Vec<String> {
    if is_unmerged(directory) { looked(directory).damaged } else { Vec::new() }
}

/// Removes what was converted: before the program ends.
pub fn forget() {
    LOOKED.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

/// A folder that nobody else may look into, removed with it.
pub(super) struct OwnFolder(PathBuf);

impl OwnFolder {
    pub fn new() -> Result<Self, FileError> {
        let own = std::env::temp_dir().join(format!("bladeoff-look-{}-{}", std::process::id(), unguessable()));
        make(&own)?;
        Ok(Self(own))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for OwnFolder {
    fn drop(&mut self) {
        // A leftover is in nobody's way.
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn make(folder: &Path) -> Result<(), FileError> {
    fs::DirBuilder::new().mode(0o700).create(folder).map_err(FileError::at("create", folder))
}

fn looked(directory: &Path) -> Looked {
    let mut all = LOOKED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(looked) = all.get(directory) {
        return looked.clone();
    }
    let looked = convert(directory)
        .unwrap_or_else(|error| Looked { damaged: vec![bladeoff_system::with_causes(&error)], ..Looked::default() });
    all.insert(directory.to_path_buf(), looked.clone());
    looked
}

/// Writes the rows of all chunks as parts, in the order of the samples.
fn convert(path: &Path) -> Result<Looked, ShardError> {
    start_threads().map_err(RunError::from)?;
    let Some(shared) = Shared::open(path)? else { return Ok(Looked::default()) };
    let Some(frozen) = Frozen::read(&shared)? else { return Ok(Looked::default()) };
    let samples = samples(&shared, &frozen)?;
    let prepared = prepared(&shared, &frozen, &samples)?;
    let own = OwnFolder::new()?;
    let (rows, timings) = (own.path().join("parts"), own.path().join("timings-parts"));
    make(&rows)?;
    make(&timings)?;
    let mut looked = Looked::default();
    let mut open: Option<RowsWriter<'_>> = None;
    let mut count = 0;
    for folder in frozen.chunks.folders() {
        let names = shared.names_in(folder)?;
        let Ok(Some(chunks)) = shared.chunks_in(folder) else { continue };
        for chunk in names.into_iter().filter(|chunk| *chunk < frozen.chunks.count()) {
            let found = match read(&chunks, &frozen, &prepared, chunk) {
                Ok(found) => found,
                Err(error) => {
                    looked.damaged.push(format!("chunk {chunk}: {error}"));
                    continue;
                }
            };
            for (sample, entry) in frozen.chunks.range(chunk).zip(found.entries) {
                let mut part = match open.take() {
                    Some(part) => part,
                    None => {
                        let number = u32::try_from(looked.rows.len() + 1).unwrap_or(u32::MAX);
                        let name = part_name(number);
                        looked.rows.push(rows.join(&name));
                        looked.timings.push(timings.join(&name));
                        let more =
                            [("incomplete".to_owned(), "true".to_owned()), ("part".to_owned(), number.to_string())];
                        let pending = |folder: &Path| Pending::create(folder.join(&name));
                        RowsWriter::create(&prepared, pending(&rows)?, pending(&timings)?, &more)?
                    }
                };
                part.push(sample, entry)?;
                count += 1;
                if count % PART_ROWS == 0 {
                    part.finish()?;
                } else {
                    open = Some(part);
                }
            }
        }
    }
    if let Some(part) = open {
        part.finish()?;
    }
    looked.folder = Some(Arc::new(own));
    Ok(looked)
}
