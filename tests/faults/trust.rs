//! No name in a result directory is trusted: links, pipes, directories and huge files in place of any of its files, folders that no run began,
//! directories of other users, and directories that are removed during a run. Every command has a time limit.

use crate::running::{Running, STUDY, WATCHDOG, handed_out, signal, wait_until};
use crate::support::shared_studies::two_samples;
use crate::support::{Folder, Said, alone, bladeoff, say};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Address space of a command \[kB\]; a huge file that is read completely does not fit.
const MEMORY_KB: u64 = 8 << 20;
const HUGE: u64 = 1 << 40;

/// Runs a command with limits of time and memory.
fn tried(args: &[&str]) -> Said {
    let direct = bladeoff(args);
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {MEMORY_KB} && exec \"$@\""), "sh"]).arg(direct.get_program());
    command.args(direct.get_args()).env_remove("BLADEOFF_FAULT").current_dir(crate::support::root());
    let spawned = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = spawned.expect("started");
    let pid = child.id();
    let (ended, watch) = std::sync::mpsc::channel::<()>();
    let watchdog = std::thread::spawn(move || {
        let hangs = watch.recv_timeout(WATCHDOG) == Err(std::sync::mpsc::RecvTimeoutError::Timeout);
        hangs && signal(pid, "KILL")
    });
    let output = child.wait_with_output().expect("waited for");
    drop(ended);
    assert!(!watchdog.join().expect("no panic"), "{args:?} hangs");
    assert!(output.status.code().is_some(), "{args:?}: {}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    crate::support::said(output)
}

/// Every file below a directory: its content, or its type.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("readable").flatten() {
        let path = entry.path();
        let kind = entry.file_type().expect("known");
        if kind.is_dir() {
            all.insert(path.clone(), b"a folder".to_vec());
            all.append(&mut files(&path));
        } else {
            all.insert(path.clone(), if kind.is_file() { fs::read(path).expect("readable") } else { Vec::new() });
        }
    }
    all
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).expect("created");
    for entry in fs::read_dir(from).expect("readable").flatten() {
        fs::copy(entry.path(), to.join(entry.file_name())).expect("a file");
    }
}

/// Object that occupies the name of a file of the run.
#[derive(Debug, Clone, Copy)]
enum Trap {
    Link,
    FolderLink,
    HardLink,
    Pipe,
    Huge,
    Folder,
}

impl Trap {
    const ALL: [Trap; 6] = [Trap::Link, Trap::FolderLink, Trap::HardLink, Trap::Pipe, Trap::Huge, Trap::Folder];

    /// Creates the trap; `mine`: a file and a folder of the user that must stay unchanged.
    fn set(self, path: &Path, mine: &Path) {
        let _ = fs::remove_file(path);
        match self {
            Trap::Link => symlink(mine.join("letter.txt"), path).expect("linked"),
            Trap::FolderLink => symlink(mine.join("folder"), path).expect("linked"),
            Trap::HardLink => fs::hard_link(mine.join("letter.txt"), path).expect("linked"),
            Trap::Pipe => assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo runs").success()),
            Trap::Huge => File::create(path).and_then(|file| file.set_len(HUGE)).expect("a hole"),
            Trap::Folder => {
                fs::create_dir(path).expect("created");
                fs::write(path.join("notes.txt"), "of the user").expect("written");
            }
        }
    }
}

/// A complete study of two samples, and files of the user.
struct Case {
    folder: Folder,
    study: String,
    mine: PathBuf,
}

impl Case {
    fn new() -> Self {
        let folder = Folder::new();
        let study = two_samples(&folder, "whole");
        folder.write("mine/letter.txt", "dear all\n");
        folder.write("mine/folder/part-000001.parquet", "of the user");
        folder.write("mine/folder/notes.txt", "of the user, too");
        let mine = folder.path("mine");
        Self { folder, study, mine }
    }

    /// Runs every command on a directory with a trap in place of a file.
    fn try_all(&self, name: &str, trap: Trap, is_incomplete: bool) {
        let out = self.folder.path("out");
        let _ = fs::remove_dir_all(&out);
        copy(&self.folder.path("whole"), &out);
        if is_incomplete {
            fs::remove_file(out.join("results.parquet")).expect("there");
        }
        trap.set(&out.join(name), &self.mine);
        let before = files(&self.mine);
        let dir = out.to_str().expect("UTF-8");
        for words in [
            vec!["status", dir],
            vec!["status", dir, "--json"],
            vec!["why", dir, "0"],
            vec!["replay", dir, "--sample", "0"],
            vec!["export", dir, "--csv"],
            vec!["run", &self.study, "--out", dir, "--workers", "1"],
        ] {
            let said = tried(&words);
            let what = format!("{name} is {trap:?}: {words:?}: {}: {}", said.code, said.err);
            assert!([0, 3, 6].contains(&said.code), "{what}");
            assert!(said.code == 0 || said.err.starts_with("error: ") || said.err.contains("\nerror: "), "{what}");
            assert!(files(&self.mine) == before, "{what}: the user's files were touched");
        }
    }
}

const NAMES: [&str; 14] = [
    "run.lock",
    "ledger.redb",
    "status.json",
    "manifest.json",
    "plan.json",
    "basis.bin",
    "study.toml",
    "machine.toml",
    "points.csv",
    "results.parquet",
    "timings.parquet",
    "workers.log",
    "parts",
    "parts.aside",
];

#[test]
fn whatever_stands_in_the_place_of_a_file_no_command_hangs_or_follows_it() {
    let _alone = alone();
    let case = Case::new();
    for name in NAMES {
        Trap::ALL.iter().for_each(|trap| case.try_all(name, *trap, false));
    }
}

#[test]
fn whatever_stands_in_the_way_of_a_run_that_goes_on_is_not_followed() {
    let _alone = alone();
    let case = Case::new();
    for name in [
        "results.parquet.tmp",
        "status.json.tmp",
        "ledger.redb.new",
        "parts.tmp",
        "workers.log",
        "parts",
        "timings-parts.aside",
        "manifest.json",
    ] {
        Trap::ALL.iter().for_each(|trap| case.try_all(name, *trap, true));
    }
}

#[test]
fn what_is_refused_is_said_in_words() {
    let _alone = alone();
    let case = Case::new();
    let words = |name: &str, trap: Trap, command: &[&str]| {
        let out = case.folder.path("words");
        let _ = fs::remove_dir_all(&out);
        copy(&case.folder.path("whole"), &out);
        trap.set(&out.join(name), &case.mine);
        let said = tried(command);
        assert_ne!(said.code, 0, "{name} {trap:?}");
        said.err
    };
    let dir = case.folder.name("words");
    let run = ["run", &case.study, "--out", &dir];
    assert!(words("run.lock", Trap::Link, &run).contains("symbolic link, which is not followed"));
    assert!(words("run.lock", Trap::HardLink, &run).contains("has a second name"));
    assert!(words("ledger.redb", Trap::Pipe, &run).contains("a named pipe and not a regular file"));
    assert!(words("results.parquet", Trap::Folder, &["export", &dir, "--csv"]).contains("a directory and not"));
    assert!(
        words("plan.json", Trap::Huge, &["replay", &dir, "--sample", "0"]).contains("1099511627776 bytes; at most")
    );
    assert!(words("study.toml", Trap::Pipe, &["why", &dir, "0"]).contains("not a regular file"));
}

#[test]
fn what_stands_in_the_place_of_the_parts_of_a_complete_study_is_no_matter_and_stays() {
    let _alone = alone();
    let case = Case::new();
    let out = case.folder.path("out");
    let dir = case.folder.name("out");
    for (name, trap) in [("parts", Trap::FolderLink), ("timings-parts", Trap::Link), ("parts.aside", Trap::Pipe)] {
        let _ = fs::remove_dir_all(&out);
        copy(&case.folder.path("whole"), &out);
        trap.set(&out.join(name), &case.mine);
        let before = files(&case.mine);
        let run = || tried(&["run", &case.study, "--out", &dir, "--workers", "1"]);
        let said = run();
        assert_eq!(said.code, 0, "{name} {trap:?}: {}", said.err);
        assert!(said.err.contains("every sample is already finished"), "{}", said.err);
        let told = format!("{name} (");
        assert!(said.err.contains(&told) && said.err.contains("kept unchanged"), "{name}: {}", said.err);
        // needed if rows of the table are missing
        fs::remove_file(out.join("results.parquet")).expect("there");
        let said = run();
        assert!(said.code == 6 && said.err.contains(name), "{name} {trap:?}: {}: {}", said.code, said.err);
        assert!(fs::symlink_metadata(out.join(name)).is_ok() && files(&case.mine) == before, "{name}: touched");
    }
}

#[test]
fn a_link_in_the_way_of_a_history_is_not_followed() {
    let _alone = alone();
    let folder = Folder::new();
    folder.write("mine/letter.txt", "dear all\n");
    let (mine, rig) = (folder.path("mine"), folder.name("machines/rig.toml"));
    let before = files(&mine);
    let recorded = |name: &str| {
        let history = folder.name(name);
        let said = tried(&["simulate", &rig, "--set", "run.end_time=0.002 s", "--history", &history]);
        assert!(said.code == 0 && said.err.contains(" instants, every "), "{name}: {}", said.err);
        assert!(fs::symlink_metadata(&history).expect("there").is_file(), "{name} is a file of its own");
        fs::read(&history).expect("readable")
    };
    for end in ["mcap", "csv", "parquet"] {
        let alone = recorded(&format!("alone.{end}"));
        for in_the_way in [format!("a.{end}.tmp"), format!("a.{end}")] {
            symlink(mine.join("letter.txt"), folder.path(&in_the_way)).expect("linked");
            assert!(recorded(&format!("a.{end}")) == alone, "{in_the_way}");
            assert!(files(&mine) == before, "{in_the_way} was followed");
            // files that the user did not ask to replace stay
            let is_left = fs::symlink_metadata(folder.path(&in_the_way)).expect("there").is_symlink();
            assert_eq!(is_left, in_the_way.ends_with("tmp"), "{in_the_way}");
            fs::remove_file(folder.path(&format!("a.{end}"))).expect("there");
        }
    }
}

#[test]
fn a_folder_that_no_run_began_is_never_taken_over_for_its_names() {
    let _alone = alone();
    let case = Case::new();
    let out = case.folder.path("own");
    let run = || say(&["run", &case.study, "--out", out.to_str().expect("UTF-8"), "--workers", "1"]);
    for (names, first) in [
        (&["machine.toml"][..], "machine.toml"),
        (&["points.csv", "study.toml", "machine.toml"], "machine.toml"),
        (&["plan.json", "basis.bin"], "basis.bin"),
        (&["study.toml.tmp"], "study.toml.tmp"),
        (&["run.lock", "points.csv"], "points.csv"),
        (&["ledger.redb"], "ledger.redb"),
        (&["run.lock"], "run.lock"),
    ] {
        for text in ["of the user\n", ""] {
            if text.is_empty() && names == ["run.lock"] {
                continue;
            }
            fs::create_dir(&out).expect("created");
            names.iter().for_each(|name| fs::write(out.join(name), text).expect("written"));
            let before = files(&out);
            let said = run();
            assert_eq!(said.code, 3, "{names:?}: {}", said.err);
            assert!(
                said.err.contains(&format!("{out:?} is not a result directory: it contains {first:?}"))
                    && said.err.contains("--out"),
                "{names:?}: {}",
                said.err
            );
            assert!(files(&out) == before, "{names:?} were touched");
            fs::remove_dir_all(&out).expect("removed");
        }
    }
    // a directory that a run began belongs to it: killed before it wrote anything, or with everything but the record
    fs::create_dir(&out).expect("created");
    assert_eq!(run().code, 0, "an empty folder");
    let lock = fs::read_to_string(out.join("run.lock")).expect("there");
    assert!(lock.contains("bladeoff") && !lock.contains("pid"), "{lock}");
    for gone in ["ledger.redb", "results.parquet", "timings.parquet", "manifest.json", "status.json", "workers.log"] {
        fs::remove_file(out.join(gone)).expect("there");
    }
    let said = run();
    assert!(said.code == 0 && !said.err.contains("are already finished"), "{}", said.err);
    // a directory of an earlier build, whose lock file was empty after a normal end
    fs::write(out.join("run.lock"), "").expect("written");
    assert!(run().err.contains("every sample is already finished"));
    // lock file truncated by a power failure, or empty, before there was a record; with inputs and other initial files
    let empty = |others: &[&str]| {
        for entry in fs::read_dir(&out).expect("readable").flatten() {
            let is_input = ["study.toml", "machine.toml", "points.csv"].iter().any(|name| entry.file_name() == *name);
            if !is_input {
                fs::remove_file(entry.path()).expect("a file");
            }
        }
        others.iter().chain(&["run.lock"]).for_each(|name| fs::write(out.join(name), "").expect("written"));
    };
    empty(&["plan.json.0123abcd.tmp"]);
    let said = run();
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(out.join("results.parquet").exists() && !out.join("plan.json.0123abcd.tmp").exists());
    empty(&["notes.txt"]);
    let said = run();
    assert!(said.code == 3 && said.err.contains("it contains \"notes.txt\""), "{}", said.err);
    // inputs of another study, or other files with the same names
    fs::remove_file(out.join("notes.txt")).expect("there");
    fs::write(out.join("study.toml"), "my study").expect("written");
    let said = run();
    assert!(said.code == 3 && said.err.contains("is not a result directory"), "{}", said.err);
    assert_eq!(fs::read_to_string(out.join("study.toml")).expect("there"), "my study");
}

#[test]
fn a_directory_that_others_could_write_in_is_refused_unless_they_are_trusted() {
    let _alone = alone();
    let case = Case::new();
    let out = case.folder.name("shared");
    fs::create_dir(&out).expect("created");
    fs::set_permissions(&out, fs::Permissions::from_mode(0o777)).expect("own");
    let run = |more: &[&str]| say(&[&["run", &case.study, "--out", &out, "--workers", "1"], more].concat());
    let said = run(&[]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("mode 0777") && said.err.contains("--trust-dir"), "{}", said.err);
    assert_eq!(fs::read_dir(&out).expect("readable").count(), 0);
    assert_eq!(run(&["--trust-dir"]).code, 0);
    assert_eq!(run(&[]).code, 3, "each time");
    // the command to resume contains the option, too
    let (study, part) = (endless(&case.folder), case.folder.name("part"));
    fs::create_dir(&part).expect("created");
    fs::set_permissions(&part, fs::Permissions::from_mode(0o777)).expect("own");
    let said = say(&["run", &study, "--out", &part, "--workers", "1", "--trust-dir", "--wall", "0.1 s"]);
    let command = format!("bladeoff-dev run {study} --out {part} --trust-dir\n");
    assert!(said.code == 5 && said.err.contains(&command), "{}", said.err);
    assert!(say(&["status", &part]).out.contains(&command));
    assert_eq!(say(&["why", &out, "0"]).code, 0, "to be read it needs no trust");
    // only the user can write what a run creates, for any umask
    let made = case.folder.name("made/by/run");
    let direct = bladeoff(&["run", &case.study, "--out", &made, "--workers", "1"]);
    let mut open = Command::new("sh");
    open.args(["-c", "umask 0 && exec \"$@\"", "sh"]).arg(direct.get_program()).args(direct.get_args());
    assert!(open.current_dir(crate::support::root()).output().expect("started").status.success());
    for entry in fs::read_dir(&made).expect("readable").flatten().map(|entry| entry.path()).chain([made.clone().into()])
    {
        assert_eq!(fs::metadata(&entry).expect("there").mode() & 0o022, 0, "{}", entry.display());
    }
}

#[test]
fn a_directory_of_somebody_else_is_refused_unless_they_are_trusted() {
    let _alone = alone();
    if fs::metadata("/proc/self").expect("Linux").uid() != 0 {
        let _ = writeln!(std::io::stderr(), "SKIPPED, not tested: a directory of another user takes root");
        return;
    }
    let case = Case::new();
    let out = case.folder.name("theirs");
    fs::create_dir(&out).expect("created");
    chown(&out, Some(65_534), Some(65_534)).expect("root");
    let run = |more: &[&str]| say(&[&["run", &case.study, "--out", &out, "--workers", "1"], more].concat());
    let said = run(&[]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("another user (uid 65534)") && said.err.contains("--trust-dir"), "{}", said.err);
    assert_eq!(run(&["--trust-dir"]).code, 0);
}

/// 16 samples that take no time and 4 that take longer than a night.
fn endless(folder: &Folder) -> String {
    let text = STUDY.replace("exponential", "reduced").replace("0.1 s", "0.002 s");
    let text = text.replace("from = \"3 g\"\nto = \"10 g\"\ncount = 5\n", "values = [\"3 g\"]\n");
    let text = text
        + "[[vary]]\npath = \"run.step\"\nvalues = [\"5e-6 s\", \"5.5e-6 s\", \"4e-6 s\", \"4.5e-6 s\", \"1e-10 s\"]\n";
    folder.write("endless.toml", &text)
}

/// A run in progress with recorded samples that will not end on its own: the four long samples wait instead of computing.
fn under_way(folder: &Folder, study: &str, out: &str) -> Running {
    let hangs = [4, 9, 14, 19].map(|sample| format!("who=worker,at=running,sample={sample},do=hang")).join(";");
    let run = Running::start(folder, study, out, &hangs);
    let done = || serde_json::from_str::<serde_json::Value>(&say(&["status", out, "--json"]).out).ok();
    wait_until("some samples are recorded", || done().is_some_and(|told| told["done"].as_u64() > Some(0)));
    run
}

fn assert_stops(run: &mut Running, words: &str) -> String {
    let begun = Instant::now();
    let status = run.end();
    assert!(begun.elapsed() < Duration::from_secs(60), "noticed within a minute: {:?}", begun.elapsed());
    let said = run.said();
    assert_eq!(status.code(), Some(6), "{said}");
    assert!(said.contains(words), "{said}");
    said
}

/// Asserts that the printed command resumes the study from the recorded samples.
fn assert_goes_on(study: &str, out: &Path, said: &str) {
    let out = out.to_str().expect("UTF-8");
    assert!(said.contains(&format!("bladeoff-dev run {study} --out {out}\n")), "{said}");
    let again = say(&["run", study, "--out", out, "--workers", "1", "--wall", "0.1 s"]);
    assert_eq!(again.code, 5, "{}", again.err);
    // the number of samples depends on the time available
    assert!(again.err.contains(" of 20 samples ") && again.err.contains(" already finished, "), "{}", again.err);
}

#[test]
fn a_directory_that_is_removed_under_its_run_is_noticed_and_what_was_finished_is_kept() {
    let _alone = alone();
    let folder = Folder::new();
    let study = endless(&folder);
    let out = folder.name("runs/out");
    let mut run = under_way(&folder, &study, &out);
    fs::remove_dir_all(folder.path("runs")).expect("removed");
    let said = assert_stops(&mut run, "was removed during the run");
    let kept = folder.path("runs/out.kept");
    let status = say(&["status", kept.to_str().expect("UTF-8")]);
    assert!(status.code == 0 && status.out.contains(" of 20 samples"), "{}{}", status.out, status.err);
    assert!(!Path::new(&out).exists(), "no half a directory is made again");
    assert_goes_on(&study, &kept, &said);
    // second time: the rescued record of the first one stays
    let mut run = under_way(&folder, &study, &out);
    for entry in fs::read_dir(&out).expect("readable").flatten().filter(|entry| entry.path().is_file()) {
        let _ = fs::remove_file(entry.path());
    }
    let said = assert_stops(&mut run, "the record of finished samples in");
    assert_goes_on(&study, &folder.path("runs/out.kept-2"), &said);
}

#[test]
fn a_directory_that_is_moved_under_its_run_stops_it_whole() {
    let _alone = alone();
    let folder = Folder::new();
    let study = endless(&folder);
    let (out, moved) = (folder.name("out"), folder.path("moved"));
    let mut run = under_way(&folder, &study, &out);
    fs::rename(&out, &moved).expect("renamed");
    // a new directory of the same name is not written to
    fs::create_dir(&out).expect("created");
    let said = assert_stops(&mut run, "was moved during the run, to ");
    assert_eq!(fs::read_dir(&out).expect("readable").count(), 0);
    let moved = fs::canonicalize(moved).expect("there");
    assert!(!folder.path("out.kept").exists() && !moved.with_extension("kept").exists());
    assert_goes_on(&study, &moved, &said);
}

#[test]
fn a_directory_that_is_removed_when_all_is_computed_is_kept_whole() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", &STUDY.replace("0.1 s", "0.002 s"));
    let out = folder.name("out");
    let fault = format!("who=orchestrator,at=recorded,sample={},do=stop", handed_out(20, 10));
    let mut run = Running::start(&folder, &study, &out, &fault);
    wait_until("the fault", || run.fired() == 1);
    fs::remove_dir_all(&out).expect("removed");
    assert!(signal(run.child.id(), "CONT"));
    assert_eq!(run.end().code(), Some(6), "{}", run.said());
    assert!(run.said().contains("20 finished samples are kept"), "{}", run.said());
    let again = say(&["run", &study, "--out", &folder.name("out.kept"), "--workers", "1"]);
    assert!(again.code == 0 && again.err.contains("20 of 20 samples are already finished"), "{}", again.err);
}
