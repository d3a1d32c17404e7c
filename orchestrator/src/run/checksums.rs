//! Whether the files of a result directory are as they were written.
//!
//! A changed bit in a page of numbers is read as another number: Parquet has checksums of pages, but our table library writes
//! none (nor would they cover headers and footer). So `manifest.json` has the BLAKE3 of each table, computed from the bytes on
//! their way to the disk, and of the inputs; the record of finished samples has its own, of every page and every entry.
//! Whoever reads rows compares before: a table that is not as it was written is not read.

use super::answer_sums::sums;
use super::directory::{
    ANSWER_SUMS, ANSWERS, CURVES, LEDGER, MACHINE, MANIFEST, PARTS, POINTS, RESULTS, STUDY, TIMINGS, row_files,
    timing_files,
};
use super::manifest::{Checksums, provenance as told_inputs};
use super::provenance::empirical_key;
use super::resume::of_record;
use super::status::{RunState, see};
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{Checksum, TableError, count_sound_rows};
use bladeoff_record::{Reader, RecordError};
use bladeoff_study::empirical;
use bladeoff_study::sampling::layout::MOST_PARAMETERS;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use bladeoff_worker::job_spec::{BASIS_FILE, PLAN_FILE};
use blake3::{Hash, Hasher};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Longer than any study, machine, points file or basis.
const LONGEST_INPUT: u64 = 1 << 30;

/// What comparing a file with its checksum gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compared {
    /// As it was written.
    Whole,
    /// Not as it was written.
    Changed,
    /// There is no checksum of it: an earlier build wrote it, or the manifest is gone.
    Unknown,
    /// There is no such file.
    Missing,
}

/// Compares a file with what it should be.
///
/// # Errors
/// It cannot be read.
pub(super) fn compare(path: &Place, wanted: Option<Checksum>) -> Result<Compared, FileError> {
    compare_hash(path, wanted.map(|wanted| wanted.hash), wanted.map(|wanted| wanted.bytes))
}

/// The same by hash alone, of a file of an input's size, if `bytes` are not known.
fn compare_hash(path: &Place, wanted: Option<Hash>, bytes: Option<u64>) -> Result<Compared, FileError> {
    let failed = |source| FileError::at("read", path)(source);
    let file = match path.open() {
        Ok(file) => file,
        Err(error) if error.source.kind() == io::ErrorKind::NotFound => return Ok(Compared::Missing),
        Err(error) => return Err(error),
    };
    let Some(wanted) = wanted else { return Ok(Compared::Unknown) };
    let length = file.metadata().map_err(failed)?.len();
    // Nobody waits for a file that has become a thousand times as long.
    if bytes.map_or(length > LONGEST_INPUT, |bytes| bytes != length) {
        return Ok(Compared::Changed);
    }
    let mut hasher = Hasher::new();
    hasher.update_reader(file.take(length + 1)).map_err(failed)?;
    Ok(if hasher.finalize() == wanted { Compared::Whole } else { Compared::Changed })
}

/// Refuses a directory whose finished table is not as it was written; says whether that is known at all.
///
/// # Errors
/// [`TableError::Changed`]; not readable.
pub fn refuse_changed(directory: &Path) -> Result<bool, TableError> {
    let folder = open(directory)?;
    let path = folder.place(RESULTS);
    match compare(&path, Checksums::told(&folder.place(MANIFEST)).results)? {
        Compared::Changed => Err(TableError::Changed { path: path.to_path_buf() }),
        compared => Ok(compared == Compared::Whole),
    }
}

/// The same of the timings.
///
/// # Errors
/// As [`refuse_changed`].
pub fn refuse_changed_timings(directory: &Path) -> Result<bool, TableError> {
    let folder = open(directory)?;
    let path = folder.place(TIMINGS);
    match compare(&path, Checksums::told(&folder.place(MANIFEST)).timings)? {
        Compared::Changed => Err(TableError::Changed { path: path.to_path_buf() }),
        compared => Ok(compared == Compared::Whole),
    }
}

fn open(directory: &Path) -> Result<Folder, FileError> {
    Folder::open(directory).map_err(FileError::at("open", directory))
}

/// What was found out of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verified {
    /// Name in the directory.
    pub name: String,
    /// Whether it may be believed; `None` where that cannot be found out.
    pub is_whole: Option<bool>,
    /// The same in words.
    pub words: String,
}

/// Looks at every file of a directory that results are read or made from. Nothing is written.
///
/// # Errors
/// The directory cannot be looked at.
pub fn verify(directory: &Path) -> Result<Vec<Verified>, FileError> {
    let state = see(directory)?.map(|seen| seen.state);
    let folder = open(directory)?;
    let manifest = folder.place(MANIFEST);
    let told = Checksums::told(&manifest);
    let inputs = told_inputs(&manifest);
    let mut all = Vec::new();
    if inputs.is_none() && manifest.exists() {
        let words = "damaged: it is no JSON object".to_owned();
        all.push(Verified { name: MANIFEST.to_owned(), is_whole: Some(false), words });
    }
    for (name, wanted) in [(RESULTS, told.results), (TIMINGS, told.timings)] {
        match compare(&folder.place(name), wanted) {
            Ok(Compared::Missing) if wanted.is_none() => {}
            compared => all.push(in_words(name, compared)),
        }
    }
    let own = [
        (STUDY, "study_blake3"),
        (MACHINE, "machine_blake3"),
        (POINTS, "points_blake3"),
        (BASIS_FILE, "basis_blake3"),
        (PLAN_FILE, "plan_blake3"),
    ];
    let own = own.map(|(name, key)| (name.to_owned(), key.to_owned())).into_iter();
    let of_laws = (0..MOST_PARAMETERS).map(|file| (empirical(file), empirical_key(file)));
    for (name, key) in own.chain(of_laws) {
        let told = inputs.as_ref().and_then(|told| told.get(&key)).and_then(|told| told.as_str());
        let wanted = told.and_then(|told| Hash::from_hex(told).ok());
        if told.is_some() && wanted.is_none() {
            let words = format!("damaged: its {key} is no hash");
            all.push(Verified { name: MANIFEST.to_owned(), is_whole: Some(false), words });
        }
        match compare_hash(&folder.place(&name), wanted, None) {
            Ok(Compared::Missing) if wanted.is_none() => {}
            compared => all.push(in_words(&name, compared)),
        }
    }
    all.extend(answers(&folder));
    if folder.place(LEDGER).exists() {
        all.push(record(&folder.place(LEDGER), state.as_ref()));
    }
    if !folder.place(RESULTS).exists() {
        all.extend(parts(&row_files(directory), &timing_files(directory)));
    }
    Ok(all)
}

/// The answers and their curves, as far as there are any.
fn answers(folder: &Folder) -> Vec<Verified> {
    let Some(sums) = sums(folder) else {
        let compared = compare(&folder.place(ANSWERS), None);
        return match compared {
            Ok(Compared::Missing) => Vec::new(),
            compared => vec![Verified {
                words: in_words(ANSWERS, compared).words.replace(MANIFEST, ANSWER_SUMS),
                name: ANSWERS.to_owned(),
                is_whole: None,
            }],
        };
    };
    let curves = folder.folder(CURVES).ok();
    let place = |name: &str| match name.strip_prefix(CURVES).and_then(|name| name.strip_prefix('/')) {
        Some(curve) => curves.as_ref().map(|curves| curves.place(curve)),
        None => Some(folder.place(name)),
    };
    let of = |(name, hash): (String, Option<Hash>)| match (hash, place(&name)) {
        (None, _) => Verified {
            name: ANSWER_SUMS.to_owned(),
            is_whole: Some(false),
            words: format!("damaged: {name:?} has no hash"),
        },
        (hash, Some(place)) => in_words(&name, compare_hash(&place, hash, None)),
        (_, None) => in_words(&name, Ok(Compared::Missing)),
    };
    sums.into_iter().map(of).collect()
}

fn in_words(name: &str, compared: Result<Compared, FileError>) -> Verified {
    let (is_whole, words) = match compared {
        Ok(Compared::Whole) => (Some(true), "as it was written".to_owned()),
        Ok(Compared::Changed) => (Some(false), "damaged: not as it was written".to_owned()),
        Ok(Compared::Missing) => (Some(false), "missing".to_owned()),
        Ok(Compared::Unknown) => (None, format!("unknown: {MANIFEST} has no checksum of it")),
        Err(error) if is_closed(&error) => (None, format!("unknown: {error}: {}", error.source)),
        Err(error) => (Some(false), format!("{error}: {}", error.source)),
    };
    Verified { name: name.to_owned(), is_whole, words }
}

/// Whether a file may not be read: then it is nobody's damage.
fn is_closed(error: &FileError) -> bool {
    error.source.kind() == io::ErrorKind::PermissionDenied
}

/// Every page and every entry of the record.
fn record(path: &Place, state: Option<&RunState>) -> Verified {
    let name = LEDGER.to_owned();
    let unknown = |words: &str| Verified { name: name.clone(), is_whole: None, words: format!("unknown: {words}") };
    match state {
        Some(RunState::Running { .. }) => return unknown("the run writes it"),
        Some(RunState::Unknown { .. }) => return unknown("whether a run writes it is not known"),
        _ => {}
    }
    let (mut whole, mut damaged) = (0u64, 0u64);
    let read = Reader::open(path).and_then(|record| {
        record.for_each_head(None, |_, head| *(if head.is_ok() { &mut whole } else { &mut damaged }) += 1)
    });
    let (is_whole, words) = match read {
        Ok(()) if damaged == 0 && whole == 1 => (true, "its only entry is whole".to_owned()),
        Ok(()) if damaged == 0 => (true, format!("all its {whole} entries are whole")),
        Ok(()) => (false, format!("damaged: {damaged} of its {}", of_record(whole + damaged))),
        Err(RecordError::File(error)) if is_closed(&error) => return unknown("its user alone may read it"),
        Err(error) => (false, error.to_string()),
    };
    Verified { name, is_whole: Some(is_whole), words }
}

/// Parts have no checksum: they are read whole, which finds what is no Parquet any more.
fn parts(rows: &[PathBuf], timings: &[PathBuf]) -> Option<Verified> {
    if rows.is_empty() {
        return None;
    }
    let count = |files: &[PathBuf]| files.iter().map(|path| count_sound_rows(path)).sum::<Result<usize, TableError>>();
    let (is_whole, words) = match (count(rows), count(timings)) {
        (Ok(rows), Ok(timings)) if rows == timings => (
            None,
            format!(
                "readable, {}; they have no checksum, and the next run makes them again",
                counted(rows as u64, "row")
            ),
        ),
        (Ok(rows), Ok(timings)) => {
            (Some(false), format!("damaged: {}, {}", counted(rows as u64, "row"), counted(timings as u64, "timing")))
        }
        (Err(error), _) | (_, Err(error)) => (Some(false), error.to_string()),
    };
    Some(Verified { name: PARTS.to_owned(), is_whole, words })
}
