//! Rows of any result directory as table files. Of one machine: the table or its parts. Of unmerged shards: the rows of the
//! chunks, converted into a private folder of this process.

use super::super::directory::{self, RESULTS, part_name};
use super::super::error::RunError;
use super::super::partial_tables::PART_ROWS;
use super::super::tables::RowsWriter;
use super::chunk::read;
use super::error::ShardError;
use super::freeze::{prepared, samples};
use super::layout::SHARDS;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use bladeoff_answers::tables::start_threads;
use bladeoff_system::files::{FileError, Pending, unguessable};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Converted rows by directory; [`forget`] removes them.
static CONVERTED: Mutex<BTreeMap<PathBuf, ConvertedRows>> = Mutex::new(BTreeMap::new());

#[derive(Clone, Default)]
struct ConvertedRows {
    rows: Vec<PathBuf>,
    timings: Vec<PathBuf>,
    /// Damaged chunks, with their errors.
    damaged: Vec<String>,
    /// Folder of the converted files.
    folder: Option<Arc<OwnFolder>>,
}

/// Whether a directory contains unmerged shards.
#[must_use]
pub fn is_unmerged(directory: &Path) -> bool {
    directory.join(SHARDS).is_file() && !directory.join(RESULTS).exists()
}

/// Lists the files with the finished rows: as [`directory::row_files`], of unmerged shards the converted chunks.
#[must_use]
pub fn row_files(directory: &Path) -> Vec<PathBuf> {
    if is_unmerged(directory) { converted(directory).rows } else { directory::row_files(directory) }
}

/// Lists the files with the timings of those rows.
#[must_use]
pub fn timing_files(directory: &Path) -> Vec<PathBuf> {
    if is_unmerged(directory) { converted(directory).timings } else { directory::timing_files(directory) }
}

/// Reports the damaged chunks of unmerged shards.
#[must_use]
pub fn unread(directory: &Path) -> Vec<String> {
    if is_unmerged(directory) { converted(directory).damaged } else { Vec::new() }
}

/// Removes the converted files before the program ends.
pub fn forget() {
    CONVERTED.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

/// Private folder, removed when dropped.
pub(super) struct OwnFolder(PathBuf);

impl OwnFolder {
    pub fn new() -> Result<Self, FileError> {
        let own = std::env::temp_dir().join(format!("bladeoff-look-{}-{}", std::process::id(), unguessable()));
        create_private(&own)?;
        Ok(Self(own))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for OwnFolder {
    fn drop(&mut self) {
        // A leftover folder has no effect.
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn create_private(folder: &Path) -> Result<(), FileError> {
    fs::DirBuilder::new().mode(0o700).create(folder).map_err(FileError::at("create", folder))
}

fn converted(directory: &Path) -> ConvertedRows {
    let mut all = CONVERTED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(converted) = all.get(directory) {
        return converted.clone();
    }
    let converted = convert(directory).unwrap_or_else(|error| ConvertedRows {
        damaged: vec![bladeoff_system::with_causes(&error)],
        ..ConvertedRows::default()
    });
    all.insert(directory.to_path_buf(), converted.clone());
    converted
}

/// Writes the rows of all chunks as parts, in sample order.
fn convert(path: &Path) -> Result<ConvertedRows, ShardError> {
    start_threads().map_err(RunError::from)?;
    let Some(shared) = Shared::open(path)? else { return Ok(ConvertedRows::default()) };
    let Some(shards_file) = ShardsFile::read(&shared)? else { return Ok(ConvertedRows::default()) };
    let samples = samples(&shared, &shards_file)?;
    let prepared = prepared(&shared, &shards_file, &samples)?;
    let own = OwnFolder::new()?;
    let (rows, timings) = (own.path().join("parts"), own.path().join("timings-parts"));
    create_private(&rows)?;
    create_private(&timings)?;
    let mut converted = ConvertedRows::default();
    let mut open: Option<RowsWriter<'_>> = None;
    let mut count = 0;
    for folder in shards_file.chunks.folders() {
        let names = shared.names_in(folder)?;
        let Ok(Some(chunks)) = shared.chunks_in(folder) else { continue };
        for chunk in names.into_iter().filter(|chunk| *chunk < shards_file.chunks.count()) {
            let found = match read(&chunks, &shards_file, &prepared, chunk) {
                Ok(found) => found,
                Err(error) => {
                    converted.damaged.push(format!("chunk {chunk}: {error}"));
                    continue;
                }
            };
            for (sample, entry) in shards_file.chunks.range(chunk).zip(found.entries) {
                let mut part = match open.take() {
                    Some(part) => part,
                    None => {
                        let number = u32::try_from(converted.rows.len() + 1).unwrap_or(u32::MAX);
                        let name = part_name(number);
                        converted.rows.push(rows.join(&name));
                        converted.timings.push(timings.join(&name));
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
    converted.folder = Some(Arc::new(own));
    Ok(converted)
}
