//! A result directory that is removed, emptied or moved under its run: noticed within seconds, not at the end of the night.
//!
//! Every two seconds the run looks whether the directory that it holds open is the one at its path, and whether the record is
//! still under its name; two looks have to agree. Then it stops. What was only moved is whole: nothing else is done. Of what
//! was removed the record is still open, so its samples go, with inputs, plan and basis, to a new directory beside the old one
//! (`DIR.kept`), from which a run goes on as from any other. One that was closed to its user (`chmod 0 DIR`) is opened again or not
//! before the end: the record goes on in the open file; where tables cannot be written then, that is said.

use super::RunError;
use super::directory::{LEDGER, MANIFEST, RunDirectory};
use super::prepare::Prepared;
use super::status::StatusWriter;
use crate::ledger::Ledger;
use crate::report::Tally;
use bladeoff_answers::report::{are, counted};
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::folder::Standing;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_secs(2);
/// Directories of kept samples beside one another.
const MOST_KEPT: u32 = 1000;

/// What has become of the directory of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Loss {
    /// It was removed, or the record in it was.
    Removed(&'static str),
    /// It is elsewhere, with its record.
    Moved(Option<PathBuf>),
}

/// How a run ended whose directory was taken from it.
#[derive(Debug, thiserror::Error)]
pub enum Lost {
    /// It is elsewhere.
    #[error(
        "{} was moved during the run, {}: the run has stopped; {} {} in it",
        path.display(),
        to.as_ref().map_or("nobody knows where to".to_owned(), |to| format!("to {}", to.display())),
        counted(*done, "finished sample"),
        are(*done)
    )]
    Moved {
        /// Where it was.
        path: PathBuf,
        /// Where it is.
        to: Option<PathBuf>,
        /// Samples recorded in it.
        done: u64,
    },
    /// It is where it was, and cannot be entered.
    #[error(
        "{} was closed to this user during the run; {} {} kept in it: open it (`chmod u+rwx`), and the same command goes on",
        path.display(),
        counted(*done, "finished sample"),
        are(*done)
    )]
    Closed {
        /// The directory.
        path: PathBuf,
        /// Samples recorded in it.
        done: u64,
        /// What could not be done.
        #[source]
        source: Box<RunError>,
    },
    /// It is gone, what was finished is not.
    #[error("{what} {} was removed during the run: the run has stopped; {} {} kept in {}", path.display(), counted(*done, "finished sample"), are(*done), kept.display())]
    Kept {
        /// "the result directory" or the record in it.
        what: &'static str,
        /// Where it was.
        path: PathBuf,
        /// Samples kept.
        done: u64,
        /// Where they are.
        kept: PathBuf,
    },
    /// It is gone with what was finished.
    #[error("{what} {} was removed during the run: the run has stopped; {} could not be kept", path.display(), counted(*done, "finished sample"))]
    Gone {
        /// "the result directory" or the record in it.
        what: &'static str,
        /// Where it was.
        path: PathBuf,
        /// Samples that were finished.
        done: u64,
        /// Why they are lost.
        #[source]
        source: Box<RunError>,
    },
}

impl Lost {
    /// Where the study can go on.
    #[must_use]
    pub fn goes_on_in(&self) -> Option<&Path> {
        match self {
            Self::Moved { to, .. } => to.as_deref(),
            Self::Kept { kept, .. } => Some(kept),
            Self::Closed { path, .. } => Some(path),
            Self::Gone { .. } => None,
        }
    }
}

/// Looks from time to time.
#[derive(Debug)]
pub(super) struct Guard<'a> {
    directory: &'a RunDirectory,
    next: Instant,
    suspected: bool,
}

impl<'a> Guard<'a> {
    pub fn new(directory: &'a RunDirectory) -> Self {
        Self { directory, next: Instant::now() + LOOK_EVERY, suspected: false }
    }

    /// Whether the directory is lost, by two looks, if it is time for one.
    pub fn finds_loss(&mut self, ledger: &Ledger) -> bool {
        let now = Instant::now();
        if now < self.next {
            return false;
        }
        self.next = now + LOOK_EVERY;
        let is_lost = loss(self.directory, ledger).is_some();
        is_lost && std::mem::replace(&mut self.suspected, is_lost)
    }
}

/// What has become of the directory; `None`: it is where it was.
pub(super) fn loss(directory: &RunDirectory, ledger: &Ledger) -> Option<Loss> {
    let standing = directory.open().standing();
    match (standing, ledger.is_in_place()) {
        (Standing::Removed, _) => Some(Loss::Removed("the result directory")),
        (_, false) => Some(Loss::Removed("the record of finished samples in")),
        (Standing::Moved(to), true) => Some(Loss::Moved(to)),
        (Standing::Here, true) => None,
    }
}

/// Whether the directory cannot be entered any more.
pub(super) fn is_closed(directory: &RunDirectory) -> bool {
    let record = directory.file(LEDGER).identity();
    record.is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied)
}

/// Keeps what can be kept, and says how it stands. `manifest`: of the run so far.
pub(super) fn keep(
    loss: Loss,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    ledger: &Ledger,
    tally: &Tally,
    manifest: &str,
) -> Lost {
    let (path, done) = (directory.path().to_path_buf(), tally.done());
    match loss {
        Loss::Moved(to) => Lost::Moved { path, to, done },
        Loss::Removed(what) => {
            let kept = |kept: PathBuf| Lost::Kept { what, path: path.clone(), done, kept };
            match write_kept(directory, prepared, ledger, manifest) {
                Ok(directory) => {
                    let lost = kept(directory.path().to_path_buf());
                    StatusWriter::new(directory.open(), prepared.samples, done).finish("failed", Some(&lost), tally);
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
    ledger: &Ledger,
    manifest: &str,
) -> Result<RunDirectory, RunError> {
    let directory = RunDirectory::claim(&new_directory(lost.absolute())?, false)?;
    prepared.write(&directory)?;
    write_whole(directory.file(MANIFEST), manifest.as_bytes())?;
    let mut copy = Ledger::create(directory.file(LEDGER), &prepared.header())?;
    ledger.reader().for_each_bytes(|sample, bytes| copy.put_bytes(sample, bytes.to_vec()))?;
    copy.publish()?;
    Ok(directory)
}

/// Makes a directory beside one that was removed; for temporary files, where nothing can be made there.
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
