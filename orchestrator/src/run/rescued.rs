//! Rescue of a result directory that was removed during its run. The record is still open, so its samples are written, with
//! inputs, plan and basis, to a new directory beside the old one (`DIR.kept`), which can be resumed.

use super::directory::{LEDGER, MANIFEST, RunDirectory};
use super::directory_lost::Loss;
use super::error::{Lost, RunError};
use super::prepare::Prepared;
use super::status::StatusWriter;
use crate::terminal::Tally;
use bladeoff_record::Record;
use bladeoff_system::files::{FileError, write_whole};
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

/// Largest number of directories of rescued samples beside each other.
const MOST_KEPT: u32 = 1000;

/// Rescues the samples and describes the loss. `manifest`: manifest of the run so far.
pub(super) fn keep(
    loss: Loss,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    record: &Record,
    tally: &Tally,
    manifest: &str,
) -> Lost {
    let (path, done) = (directory.path().to_path_buf(), tally.done());
    match loss {
        Loss::Moved(to) => Lost::Moved { path, to, done },
        Loss::Removed(what) => {
            let kept = |kept: PathBuf| Lost::Kept { what, path: path.clone(), done, kept };
            match write_kept(directory, prepared, record, manifest) {
                Ok(directory) => {
                    let lost = kept(directory.path().to_path_buf());
                    StatusWriter::new(directory.open(), prepared.samples, done).finish("failed", Some(&lost), tally, 0);
                    lost
                }
                Err(source) => Lost::Gone { what, path, done, source: Box::new(source) },
            }
        }
    }
}

fn write_kept(
    lost: &RunDirectory,
    prepared: &Prepared<'_>,
    record: &Record,
    manifest: &str,
) -> Result<RunDirectory, RunError> {
    let directory = RunDirectory::claim(&new_directory(lost.absolute())?, false, None)?;
    prepared.write(&directory)?;
    write_whole(directory.file(MANIFEST), manifest.as_bytes())?;
    let mut copy = Record::create(directory.file(LEDGER), &prepared.header())?;
    record.reader().for_each_bytes(|sample, bytes| copy.put_bytes(sample, bytes.to_vec()))?;
    copy.publish()?;
    Ok(directory)
}

/// Creates a directory beside a removed one, or in the folder for temporary files if that is impossible.
fn new_directory(path: &Path) -> Result<PathBuf, RunError> {
    let name = path.file_name().unwrap_or(OsStr::new("run"));
    let beside = path.parent().unwrap_or(Path::new("/"));
    let make = |folder: &Path| {
        fs::create_dir_all(folder)?;
        for n in 1..=MOST_KEPT {
            let mut kept = name.to_owned();
            kept.push(if n == 1 { ".kept".to_owned() } else { format!(".kept-{n}") });
            let kept = folder.join(kept);
            match fs::DirBuilder::new().mode(0o755).create(&kept) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                made => return made.map(|()| kept),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    };
    let made = make(beside).or_else(|_| make(&std::env::temp_dir()));
    Ok(made.map_err(FileError::at("create a directory like", path))?)
}
