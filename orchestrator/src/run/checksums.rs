//! Verification of the files of a result directory.
//!
//! A changed bit in a page of numbers gives another number: Parquet has page checksums, but Polars writes none, and they would
//! not cover headers and footer. So `manifest.json` contains the BLAKE3 of each table, computed while it was written, and of the
//! inputs. The record has checksums of its own, of every page and entry. Every reader of rows compares first and rejects a
//! changed table.

use super::answer_sums::sums;
use super::directory::{
    ANSWER_SUMS, ANSWERS, CURVES, LEDGER, MACHINE, MANIFEST, PARTS, POINTS, RESULTS, STUDY, TIMINGS, row_files,
    timing_files,
};
use super::manifest::{Checksums, provenance as told_inputs, values};
use super::provenance::empirical_key;
use super::resume::of_record;
use super::status::{RunState, directory_status};
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{Checksum, TableError, count_sound_rows, read_metadata};
use bladeoff_record::{Reader, RecordError};
use bladeoff_study::empirical;
use bladeoff_study::sampling::layout::MOST_PARAMETERS;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use bladeoff_worker::job_spec::{BASIS_FILE, PLAN_FILE};
use blake3::{Hash, Hasher};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Upper bound of the size of a study, machine, points file or basis \[bytes\].
const LONGEST_INPUT: u64 = 1 << 30;

/// Keys of the hashes of the inputs in manifest, table and record.
const STUDY_HASH: &str = "study_blake3";
const MACHINE_HASH: &str = "machine_blake3";
const POINTS_HASH: &str = "points_blake3";

/// Result of comparing a file with its checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compared {
    /// The file is unchanged.
    Whole,
    /// The file has changed.
    Changed,
    /// No checksum exists: the manifest is missing or damaged.
    Unknown,
    /// The file does not exist.
    Missing,
}

/// Compares a file with its checksum.
///
/// # Errors
/// The file cannot be read.
pub(super) fn compare(path: &Place, wanted: Option<Checksum>) -> Result<Compared, FileError> {
    compare_hash(path, wanted.map(|wanted| wanted.hash), wanted.map(|wanted| wanted.bytes))
}

/// Compares a file of an input's size with a hash, if the number of `bytes` is unknown.
fn compare_hash(path: &Place, wanted: Option<Hash>, bytes: Option<u64>) -> Result<Compared, FileError> {
    let failed = |source| FileError::at("read", path)(source);
    let file = match path.open() {
        Ok(file) => file,
        Err(error) if error.source.kind() == io::ErrorKind::NotFound => return Ok(Compared::Missing),
        Err(error) => return Err(error),
    };
    let Some(wanted) = wanted else { return Ok(Compared::Unknown) };
    let length = file.metadata().map_err(failed)?.len();
    // A file that is a thousand times longer is rejected at once.
    if bytes.map_or(length > LONGEST_INPUT, |bytes| bytes != length) {
        return Ok(Compared::Changed);
    }
    let mut hasher = Hasher::new();
    hasher.update_reader(file.take(length + 1)).map_err(failed)?;
    Ok(if hasher.finalize() == wanted { Compared::Whole } else { Compared::Changed })
}

/// Rejects a directory whose finished table has changed, or whose copy of the study or the machine has: a reader would evaluate questions or use a
/// machine that do not belong to the table. Returns whether the table has a checksum.
///
/// # Errors
/// [`TableError::Changed`], or a file error.
pub fn refuse_changed(directory: &Path) -> Result<bool, TableError> {
    let folder = open(directory)?;
    let inputs = recorded_inputs(&folder);
    for (name, key) in [(STUDY, STUDY_HASH), (MACHINE, MACHINE_HASH)] {
        let path = folder.place(name);
        if compare_hash(&path, hash_of(&inputs, key), None)? == Compared::Changed {
            return Err(TableError::Changed { path: path.to_path_buf() });
        }
    }
    let path = folder.place(RESULTS);
    match compare(&path, Checksums::recorded(&folder.place(MANIFEST)).results)? {
        Compared::Changed => Err(TableError::Changed { path: path.to_path_buf() }),
        compared => Ok(compared == Compared::Whole),
    }
}

/// Hashes of the inputs by their keys: those of the manifest; without a manifest those of the table's metadata, and without a table those of
/// the record.
fn recorded_inputs(folder: &Folder) -> BTreeMap<String, String> {
    let text = |(key, value): (&String, &Value)| Some((key.clone(), value.as_str()?.to_owned()));
    let of_manifest = told_inputs(&folder.place(MANIFEST));
    if let Some(pairs) = of_manifest.as_ref().and_then(Value::as_object).filter(|pairs| !pairs.is_empty()) {
        return pairs.iter().filter_map(text).collect();
    }
    if folder.place(RESULTS).exists() {
        let pairs = read_metadata(&folder.place(RESULTS)).unwrap_or_default().into_iter();
        return pairs.filter_map(|(key, value)| Some((key.strip_prefix("bladeoff.")?.to_owned(), value))).collect();
    }
    Reader::peek(folder.place(LEDGER)).and_then(|record| record.header()).unwrap_or_default()
}

fn hash_of(inputs: &BTreeMap<String, String>, key: &str) -> Option<Hash> {
    Hash::from_hex(inputs.get(key)?).ok()
}

/// Names of the copies of study, machine and points in a directory that have changed since they were written.
pub(super) fn changed_inputs(folder: &Folder) -> Vec<&'static str> {
    let inputs = recorded_inputs(folder);
    let is_changed = |(name, key): &(&str, &str)| {
        compare_hash(&folder.place(name), hash_of(&inputs, key), None).is_ok_and(|found| found == Compared::Changed)
    };
    let copies = [(STUDY, STUDY_HASH), (MACHINE, MACHINE_HASH), (POINTS, POINTS_HASH)];
    copies.into_iter().filter(is_changed).map(|(name, _)| name).collect()
}

/// Rejects changed timings in the same way.
///
/// # Errors
/// As [`refuse_changed`].
pub fn refuse_changed_timings(directory: &Path) -> Result<bool, TableError> {
    let folder = open(directory)?;
    let path = folder.place(TIMINGS);
    match compare(&path, Checksums::recorded(&folder.place(MANIFEST)).timings)? {
        Compared::Changed => Err(TableError::Changed { path: path.to_path_buf() }),
        compared => Ok(compared == Compared::Whole),
    }
}

fn open(directory: &Path) -> Result<Folder, FileError> {
    Folder::open(directory).map_err(FileError::at("open", directory))
}

/// Result of the verification of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verified {
    /// File name in the directory.
    pub name: String,
    /// Whether the file is valid; `None`: unknown.
    pub is_whole: Option<bool>,
    /// Result in words.
    pub words: String,
}

/// Verifies every file that results are read or made from. Writes nothing.
///
/// # Errors
/// The directory cannot be read.
pub fn verify(directory: &Path) -> Result<Vec<Verified>, FileError> {
    let state = directory_status(directory)?.map(|seen| seen.state);
    let folder = open(directory)?;
    let manifest = folder.place(MANIFEST);
    let recorded = Checksums::recorded(&manifest);
    let inputs = recorded_inputs(&folder);
    let mut all = Vec::new();
    if told_inputs(&manifest).is_none() && manifest.exists() {
        let words = "damaged: it is no JSON object".to_owned();
        all.push(Verified { name: MANIFEST.to_owned(), is_whole: Some(false), words });
    }
    for (name, wanted) in [(RESULTS, recorded.results), (TIMINGS, recorded.timings)] {
        match compare(&folder.place(name), wanted) {
            Ok(Compared::Missing) if wanted.is_none() => {}
            compared => {
                if name == RESULTS && matches!(compared, Ok(Compared::Whole)) {
                    all.extend(contradictions(&folder));
                }
                all.push(in_words(name, compared));
            }
        }
    }
    let own = [
        (STUDY, STUDY_HASH),
        (MACHINE, MACHINE_HASH),
        (POINTS, POINTS_HASH),
        (BASIS_FILE, "basis_blake3"),
        (PLAN_FILE, "plan_blake3"),
    ];
    let own = own.map(|(name, key)| (name.to_owned(), key.to_owned())).into_iter();
    let of_laws = (0..MOST_PARAMETERS).map(|file| (empirical(file), empirical_key(file)));
    for (name, key) in own.chain(of_laws) {
        let wanted = hash_of(&inputs, &key);
        if inputs.contains_key(&key) && wanted.is_none() {
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

/// Compares the manifest with the metadata of an unchanged table; `None`: no value differs.
fn contradictions(folder: &Folder) -> Option<Verified> {
    let table = read_metadata(&folder.place(RESULTS)).ok()?;
    let of_table = |key: &str| table.iter().find(|(name, _)| name.strip_prefix("bladeoff.") == Some(key));
    let differs = |(key, told): (String, String)| {
        let (_, value) = of_table(&key).filter(|(_, value)| *value != told)?;
        Some(format!("its {key} is {told:?}, that of {RESULTS} is {value:?}"))
    };
    let found: Vec<String> = values(&folder.place(MANIFEST)).into_iter().filter_map(differs).collect();
    (!found.is_empty()).then(|| Verified {
        name: MANIFEST.to_owned(),
        is_whole: Some(false),
        words: format!("damaged: {}", found.join("; ")),
    })
}

/// Verifies the answers and their curves, if they exist.
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
    let unlisted = folder.place(ANSWERS).exists() && !sums.iter().any(|(name, _)| name == ANSWERS);
    let damaged = unlisted.then(|| Verified {
        name: ANSWER_SUMS.to_owned(),
        is_whole: Some(false),
        words: format!("damaged: it has no line of {ANSWERS}"),
    });
    sums.into_iter().map(of).chain(damaged).collect()
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

/// Whether reading failed for lack of permission, which is no damage.
fn is_closed(error: &FileError) -> bool {
    error.source.kind() == io::ErrorKind::PermissionDenied
}

/// Verifies every page and every entry of the record.
fn record(path: &Place, state: Option<&RunState>) -> Verified {
    let name = LEDGER.to_owned();
    let unknown = |words: &str| Verified { name: name.clone(), is_whole: None, words: format!("unknown: {words}") };
    match state {
        Some(RunState::Running { .. }) => return unknown("the run writes it"),
        Some(RunState::Unknown { .. }) => return unknown("unknown whether a run is writing it"),
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

/// Verifies the parts, which have no checksum: reading them completely finds invalid Parquet.
fn parts(rows: &[PathBuf], timings: &[PathBuf]) -> Option<Verified> {
    if rows.is_empty() {
        return None;
    }
    let count = |files: &[PathBuf]| files.iter().map(|path| count_sound_rows(path)).sum::<Result<usize, TableError>>();
    let (is_whole, words) = match (count(rows), count(timings)) {
        (Ok(rows), Ok(timings)) if rows == timings => (
            None,
            format!("readable, {}; they have no checksum, and the next run rewrites them", counted(rows as u64, "row")),
        ),
        (Ok(rows), Ok(timings)) => {
            (Some(false), format!("damaged: {}, {}", counted(rows as u64, "row"), counted(timings as u64, "timing")))
        }
        (Err(error), _) | (_, Err(error)) => (Some(false), error.to_string()),
    };
    Some(Verified { name: PARTS.to_owned(), is_whole, words })
}
