//! Cleanup of unfinished tables that killed merges leave in the shared directory.
//!
//! Nothing on a shared disk says surely that a process of another node is dead. So a merge puts a note beside its tables that names it: a
//! process of the same system that is gone has left them. Tables whose writer is not known, or was on another node, are removed when they
//! have not been written to for an hour.

use super::super::directory::{RESULTS, TIMINGS};
use super::shared::Shared;
use bladeoff_system::files::{FileError, create_beside, is_temporary};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// Age of a table under construction whose writer has ended.
const LEFTOVER: Duration = Duration::from_secs(3600);
/// Name that a note has as a file under construction: `merge.0123abcd.tmp`.
const NOTE: &str = "merge";
/// Largest note that is read.
const MOST: u64 = 4096;

/// The note of a merge in progress; removed at its end.
#[derive(Debug)]
pub(super) struct Writing(Place);

impl Writing {
    /// Says that this process writes these tables.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn begin(folder: &Folder, tables: &[&Path]) -> Result<Self, FileError> {
        let (mut file, place) = create_beside(&folder.place(NOTE), Place::create_new)?;
        let note = Self(place);
        let names = tables.iter().filter_map(|table| table.file_name()?.to_str());
        let text = json!({ "system": system(), "pid": std::process::id(), "began": began("self"), "tables": names.collect::<Vec<_>>() });
        file.write_all(text.to_string().as_bytes()).map_err(FileError::at("write", &note.0))?;
        Ok(note)
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        // A leftover names a process that is gone.
        let _ = self.0.remove();
    }
}

/// The processes that this one can see: by the start of the system and the container.
fn system() -> Option<String> {
    let start = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let container = fs::read_link("/proc/self/ns/pid").ok()?;
    Some(format!("{} {}", start.trim(), container.to_string_lossy()))
}

/// When a process began, in ticks of its system: another one may have its number later.
fn began(pid: &str) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name in parentheses may hold anything; this is the 20th word behind it.
    stat.rsplit_once(") ")?.1.split(' ').nth(19)?.parse().ok()
}

/// Whether the process that wrote a note is surely gone.
fn is_gone(note: &Value) -> bool {
    let (Some(own), Some(pid), Some(start)) = (system(), note["pid"].as_u64(), note["began"].as_u64()) else {
        return false;
    };
    note["system"] == json!(own) && began(&pid.to_string()) != Some(start)
}

/// Removes the tables that killed merges have left.
pub(super) fn remove(shared: &Shared) {
    let folder = shared.folder();
    let names = folder.names().unwrap_or_default();
    let is_old = |place: &Place| {
        let age = || place.symlink_metadata().ok()?.modified().ok()?.elapsed().ok();
        age().is_some_and(|age| age > LEFTOVER)
    };
    let is_table = |name: &std::ffi::OsStr| [RESULTS, TIMINGS].iter().any(|table| is_temporary(name, table));
    // What cannot be removed is in nobody's way.
    for name in names.iter().filter(|name| is_temporary(name, NOTE)) {
        let place = folder.place(name);
        let note = place.read(MOST).ok().and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
        if let Some(note) = note.filter(is_gone) {
            let tables = note["tables"].as_array().into_iter().flatten().filter_map(Value::as_str);
            for table in tables.filter(|table| is_table(table.as_ref())) {
                let _ = folder.place(table).remove();
            }
            let _ = place.remove();
        } else if is_old(&place) {
            let _ = place.remove();
        }
    }
    for name in names.iter().filter(|name| is_table(name)) {
        let place = folder.place(name);
        if is_old(&place) {
            let _ = place.remove();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_of_a_living_process_or_another_system_is_not_of_a_dead_one() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let open = Folder::open(folder.path()).expect("opened");
        let note = Writing::begin(&open, &[Path::new("/a/results.parquet.0123abcd.tmp")]).expect("written");
        let text = note.0.read(MOST).expect("there");
        let mut said: Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(said["tables"], json!(["results.parquet.0123abcd.tmp"]));
        assert!(!is_gone(&said), "this process lives");
        said["began"] = json!(1);
        assert!(is_gone(&said), "its number is another process's");
        said["system"] = json!("another");
        assert!(!is_gone(&said) && !is_gone(&json!([])) && !is_gone(&json!({})));
        drop(note);
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 0);
    }
}
