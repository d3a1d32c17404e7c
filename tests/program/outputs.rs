//! Output files of commands: no file of the user is removed silently, no file of another user blocks them, and a replaced file is reported
//! when it is replaced.

use crate::support::processes::STUDY;
use crate::support::shared_studies::two_samples;
use crate::support::skipped::skipped;
use crate::support::{Folder, Said, bladeoff, said, say};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

/// A user id that is not in use.
const OTHER: u32 = 54_324;

/// A folder with a complete study of two samples, and a history.
struct Case(Folder);

impl Case {
    fn new() -> Self {
        let folder = Folder::new();
        two_samples(&folder, "runs");
        let case = Self(folder);
        assert!(case.record("h.mcap").err.contains(" instants, every "));
        case
    }

    fn record(&self, name: &str) -> Said {
        let (rig, history) = (self.0.name("machines/rig.toml"), self.0.name(name));
        let said = say(&["simulate", &rig, "--set", "run.end_time=0.002 s", "--history", &history]);
        assert_eq!(said.code, 0, "{}", said.err);
        said
    }

    fn names(&self, folder: &str) -> BTreeSet<String> {
        let names = fs::read_dir(self.0.path(folder)).expect("readable").flatten().map(|entry| entry.file_name());
        names.map(|name| name.to_string_lossy().into_owned()).collect()
    }
}

#[test]
fn a_file_with_the_name_of_a_temporary_one_stays() {
    let case = Case::new();
    let name = |name: &str| case.0.name(name);
    let (runs, history) = (name("runs"), name("h.mcap"));
    for (out, args) in [
        ("o/t.csv", vec!["export", &runs, "--csv", "--out"]),
        ("o/m.toml", vec!["new", "machine", "--out"]),
        ("o/f.svg", vec!["plot", &history, "--out"]),
        ("o/r.mcap", vec!["recover", &history, "--out"]),
    ] {
        let mine = case.0.write(&format!("{out}.tmp"), "mine");
        let before = case.names("o");
        let said = say(&[&args[..], &[&name(out)]].concat());
        assert_eq!(said.code, 0, "{out}: {}", said.err);
        assert_eq!(fs::read_to_string(&mine).expect("it stays"), "mine", "{out}");
        let made: Vec<String> = case.names("o").difference(&before).cloned().collect();
        assert_eq!(made, [out.trim_start_matches("o/")], "nothing else is left");
    }
}

/// The part of a history left by a killed run can be recovered: the next run with that name does not remove it.
#[test]
fn what_a_killed_run_has_left_of_its_history_stays_and_is_said() {
    let case = Case::new();
    for (file, recovers) in [("a.mcap", true), ("a.csv", false)] {
        let left = case.0.write(&format!("{file}.tmp"), "of a killed run");
        let said = case.record(file);
        assert_eq!(fs::read_to_string(&left).expect("it stays"), "of a killed run", "{file}");
        assert!(said.err.contains(&format!("{left} exists and is kept")), "{}", said.err);
        assert_eq!(said.err.contains(&format!(" recover {left})")), recovers, "{}", said.err);
        // the temporary name without .tmp is a valid name of a history
        let other =
            said.err.split("the history is written to ").nth(1).and_then(|rest| rest.lines().next()).expect("a name");
        let (stem, end) = file.split_once('.').expect("an extension");
        let begins = case.0.name(&format!("{stem}-"));
        assert!(other.starts_with(&begins) && other.ends_with(&format!(".{end}.tmp")), "{other}");
        assert!(!Path::new(other).exists() && case.0.path(file).is_file(), "{other}");
    }
}

#[test]
fn what_is_replaced_is_said_when_it_is() {
    let case = Case::new();
    for file in ["b.mcap", "b.csv", "b.parquet"] {
        assert!(!case.record(file).err.contains("it replaced"), "{file}: there was none");
        let again = case.record(file).err;
        assert!(again.contains("; it replaced an existing file"), "{file}: {again}");
    }
    let (history, out) = (case.0.name("h.mcap"), case.0.name("figures"));
    let plot = || say(&["plot", &history, "--out", &out]);
    assert!(!plot().err.contains("is replaced"));
    assert_eq!(plot().err.matches("is replaced").count(), 2);
    // a failed output replaces nothing
    fs::remove_file(case.0.path("figures/h-time.svg")).expect("drawn");
    fs::create_dir(case.0.path("figures/h-time.svg")).expect("in the way");
    let failed = plot();
    assert!(failed.code == 6 && !failed.err.contains("is replaced"), "{}: {}", failed.code, failed.err);
    assert_eq!(case.names("figures"), ["h-time.png", "h-time.svg"].map(str::to_owned).into(), "nothing is left");
    // files that cannot easily be regenerated are not replaced
    let table = case.0.write("t.csv", "mine");
    for args in [vec!["export", &case.0.name("runs"), "--csv"], vec!["new", "study"], vec!["recover", &history]] {
        let refused = say(&[&args[..], &["--out", &table]].concat());
        assert!(refused.code == 3 && refused.err.contains("already exists"), "{args:?}: {}", refused.err);
    }
    assert_eq!(fs::read_to_string(&table).expect("there"), "mine");
}

/// In a folder for all users (/tmp) only the owner can remove a file.
#[test]
fn whatever_others_have_put_into_a_folder_for_everybody_stops_no_output() {
    if fs::metadata("/proc/self").expect("Linux").uid() != 0 {
        return skipped("files of others in a folder for everybody", "takes root, to be somebody else");
    }
    let case = Case::new();
    let set = |name: &str, mode| fs::set_permissions(case.0.path(name), Permissions::from_mode(mode)).expect("set");
    crate::support::copy_binary(&case.0.path("bladeoff"));
    fs::create_dir(case.0.path("all")).expect("created");
    for (name, mode) in [("", 0o755), ("bladeoff", 0o755), ("machines", 0o755), ("all", 0o1777)] {
        set(name, mode);
    }
    let (rig, runs, history) = (case.0.name("machines/rig.toml"), case.0.name("runs"), case.0.name("h.mcap"));
    for (file, args) in [
        ("t.csv", vec!["export", &runs, "--csv", "--out"]),
        ("f.svg", vec!["plot", &history, "--out"]),
        ("a.mcap", vec!["simulate", &rig, "--set", "run.end_time=0.002 s", "--history"]),
        ("a.parquet", vec!["simulate", &rig, "--set", "run.end_time=0.002 s", "--history"]),
    ] {
        case.0.write(&format!("all/{file}.tmp"), "of somebody else");
        let mut command = Command::new(case.0.path("bladeoff"));
        command.args(args).arg(case.0.path(&format!("all/{file}"))).current_dir("/").uid(OTHER).gid(OTHER);
        let said = said(command.output().expect("it starts"));
        assert_eq!(said.code, 0, "{file}: {}", said.err);
        let made = fs::metadata(case.0.path(&format!("all/{file}"))).expect("written");
        assert!(made.uid() == OTHER && made.len() > 0 && made.mode() & 0o777 == 0o644, "{file}: {}", said.err);
    }
    assert_eq!(case.names("all").len(), 8, "four outputs, four files of somebody else");
}

#[test]
fn rows_without_a_checksum_are_said_to_have_none() {
    let folder = Folder::new();
    let failing = STUDY.replace("[set]", "[set]\n\"run.step_limit\" = 1");
    let (study, out) = (folder.write("f.toml", &failing), folder.name("out"));
    let ran = say(&["run", &study, "--out", &out, "--workers", "2", "--max-failures", "1"]);
    assert!(ran.code == 5 && !folder.path("out/results.parquet").exists(), "{}", ran.err);
    let exported = say(&["export", &out, "--csv"]);
    assert!(exported.code == 0 && exported.out.lines().count() > 1, "{}", exported.err);
    assert!(exported.err.contains("Parts have no checksum"), "{}", exported.err);
}

/// The manifest contains the command; it panicked for a command that is not UTF-8.
#[test]
fn a_directory_whose_name_is_no_text_is_worked_in() {
    let case = Case::new();
    let (study, out) = (case.0.name("s.toml"), case.0.path("").join(OsStr::from_bytes(b"out\xff")));
    let run = || {
        let mut command = bladeoff(&["run", &study, "--workers", "1", "--out"]);
        let said = said(command.arg(&out).output().expect("it starts"));
        assert_eq!(said.code, 0, "{}", said.err);
        said
    };
    run();
    assert!(out.join("results.parquet").exists());
    assert!(run().err.contains("every sample is already finished"));
}
