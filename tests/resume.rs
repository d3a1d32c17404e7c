//! The durable record: studies that are killed, continued, grown, changed; one orchestrator per directory; damaged and
//! full disks. Whatever happens, the table is the one of an undisturbed run.

mod support;

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use support::{Folder, Said, bladeoff, said, say, table};

/// One study at a time: workers of several would only wait for each other's cores.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// 3 gaps x 8 masses; a sample takes some ten milliseconds.
const STUDY: &str = r#"schema = 1
name = "resume"
machine = "machines/rig.toml"

[set]
"run.end_time" = "0.03 s"

[[vary]]
path = "contact.gap"
values = ["0.5 mm", "0.7 mm", "0.9 mm"]

[[vary]]
path = "blade_off.mass"
from = "3 g"
to = "10 g"
count = 8
"#;

fn run(study: &str, out: &str, more: &[&str]) -> Said {
    let mut args = vec!["run", study, "--out", out, "--workers", "2"];
    args.extend(more);
    say(&args)
}

fn run_well(study: &str, out: &str, more: &[&str]) -> Said {
    let said = run(study, out, more);
    assert_eq!(said.code, 0, "{}", said.err);
    said
}

fn bytes(directory: &str) -> Vec<u8> {
    fs::read(format!("{directory}/results.parquet")).expect("the table")
}

/// Runs with a fault of the orchestrator; asserts that it happened and ended the process by this signal.
fn run_killed(folder: &Folder, study: &str, out: &str, fault: &str) {
    let fired = tempfile::tempdir_in(folder.path("")).expect("a folder");
    let mut command = bladeoff(&["run", study, "--out", out, "--workers", "2"]);
    command.env("BLADEOFF_FAULT", format!("{fault},dir={}", fired.path().display()));
    let output = command.output().expect("it starts");
    assert_eq!(output.status.signal(), Some(9), "{fault}: {}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_dir(fired.path()).expect("readable").count(), 1, "{fault} happened");
    assert!(!Path::new(out).join("results.parquet").exists(), "no table that looks complete");
}

#[test]
fn a_study_killed_five_times_equals_the_undisturbed_one() {
    let _alone = alone();
    let folder = Folder::new();
    // Long enough that no run gets through before its kill.
    let study = folder.write("s.toml", &STUDY.replace("0.03 s", "0.12 s"));
    let (calm, killed) = (folder.name("calm"), folder.name("killed"));
    run_well(&study, &calm, &[]);
    for fault in [
        "who=orchestrator,at=claimed,sample=2,do=kill",
        "who=orchestrator,at=recorded,sample=any,do=kill",
        "who=orchestrator,at=running,sample=any,do=kill",
        "who=orchestrator,at=sent,sample=any,do=kill",
        "who=orchestrator,at=recorded,sample=any,do=kill",
    ] {
        run_killed(&folder, &study, &killed, fault);
    }
    let last = run_well(&study, &killed, &[]);
    assert!(last.err.contains("did not end in order"), "{}", last.err);
    assert!(last.err.contains("of 24 samples are there already"), "some of it was kept: {}", last.err);
    assert!(bytes(&killed) == bytes(&calm), "the table differs");
    assert!(!Path::new(&killed).join("results-incomplete.parquet").exists());
}

#[test]
fn a_complete_study_is_not_computed_again() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let out = folder.name("out");
    let first = run_well(&study, &out, &[]);
    let files = || {
        ["results.parquet", "manifest.json", "workers.log", "plan.json"].map(|name| {
            let path = Path::new(&out).join(name);
            (fs::metadata(&path).expect("there").modified().expect("a time"), fs::read(&path).expect("readable"))
        })
    };
    let before = files();
    let second = run_well(&study, &out, &[]);
    assert_eq!(first.out, second.out, "the summary again");
    assert!(second.err.contains("nothing is computed"), "{}", second.err);
    assert!(files() == before);
    // A lost table comes from the record.
    fs::remove_file(format!("{out}/results.parquet")).expect("removed");
    run_well(&study, &out, &[]);
    assert!(bytes(&out) == before[0].1);
}

#[test]
fn a_grown_study_equals_a_fresh_run_of_it() {
    let _alone = alone();
    let folder = Folder::new();
    let out = folder.name("grown");
    let small = folder.write("s.toml", STUDY);
    run_well(&small, &out, &["--limit", "7"]);
    // More of the same, a finer axis, an axis that was fixed before, other limits, a remark in the machine: reused each time.
    let finer = STUDY.replace("count = 8", "count = 15").replace("\"0.9 mm\"]", "\"0.9 mm\", \"1.1 mm\", \"0.4 mm\"]");
    let friction = format!("{finer}\n[[vary]]\npath = \"contact.friction\"\nvalues = [0.1, 0.15]\n");
    let mut there = 7;
    for (text, count) in [
        (STUDY.to_owned(), 24),
        (format!("{STUDY}# only a remark\n[limits]\nmax_failed = 3\n"), 24),
        (finer, 75),
        (friction, 150),
    ] {
        let study = folder.write("s.toml", &text);
        let ran = run_well(&study, &out, &[]);
        if count > there {
            assert!(ran.err.contains(&format!("{there} of {count} samples are there already")), "{}", ran.err);
        }
        let fresh = folder.name(&format!("fresh-{count}-{}", text.len()));
        run_well(&study, &fresh, &[]);
        assert!(bytes(&out) == bytes(&fresh), "{count} samples");
        assert_eq!(fs::read_to_string(format!("{out}/study.toml")).expect("frozen"), text);
        there = count;
    }
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    folder.write("machines/rig.toml", &format!("# a remark\n{rig}"));
    let ran = run_well(&folder.name("s.toml"), &out, &[]);
    assert!(ran.err.contains("150 of 150 samples are there already, 0 are computed"), "{}", ran.err);
}

#[test]
fn a_changed_study_or_machine_is_refused_with_the_difference_and_nothing_is_touched() {
    let _alone = alone();
    let folder = Folder::new();
    let out = folder.name("out");
    let study = folder.write("s.toml", STUDY);
    run_well(&study, &out, &[]);
    let before = bytes(&out);
    let refused = |parts: &[&str], more: &[&str]| {
        let said = run(&study, &out, more);
        assert_eq!(said.code, 3, "{}", said.err);
        parts.iter().for_each(|part| assert!(said.err.contains(part), "{part}: {}", said.err));
        assert!(bytes(&out) == before);
        assert_eq!(fs::read_to_string(format!("{out}/study.toml")).expect("frozen"), STUDY);
    };
    refused(&["--limit: none -> 5"], &["--limit", "5"]);
    folder.write("s.toml", &STUDY.replace("0.03 s", "0.04 s"));
    refused(&["24 of its 24 finished samples", "run.end_time: 30 ms -> 40 ms"], &[]);
    folder.write("s.toml", &STUDY.replace("0.7 mm", "0.6 mm"));
    refused(&["8 of its 24", "contact.gap: 0.5 mm, 0.7 mm, 0.9 mm -> 0.5 mm, 0.6 mm, 0.9 mm"], &[]);
    folder.write("s.toml", STUDY);
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    folder.write("machines/rig.toml", &rig.replace("friction = 0.15", "friction = 0.25"));
    refused(&["contact.friction: 0.15 -> 0.25"], &[]);
    folder.write("machines/rig.toml", &rig);
    run_well(&study, &out, &[]);
}

#[test]
fn a_growth_that_is_killed_half_way_is_done_again() {
    let _alone = alone();
    let folder = Folder::new();
    let out = folder.name("out");
    let study = folder.write("s.toml", STUDY);
    run_well(&study, &out, &["--limit", "5"]);
    // As a kill before the new record has its name leaves it: new inputs, half a record aside, unfinished files.
    fs::write(format!("{out}/study.toml"), STUDY.replace("0.9 mm", "0.8 mm")).expect("written");
    fs::write(format!("{out}/ledger.redb.new"), "half a record").expect("written");
    fs::write(format!("{out}/manifest.json.tmp"), "{").expect("written");
    let ran = run_well(&study, &out, &[]);
    assert!(ran.err.contains("5 of 24 samples are there already"), "{}", ran.err);
    run_well(&study, &folder.name("fresh"), &[]);
    assert!(bytes(&out) == bytes(&folder.name("fresh")));
}

#[test]
fn samples_that_failed_or_killed_their_worker_are_computed_again_when_asked() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (calm, out) = (folder.name("calm"), folder.name("out"));
    run_well(&study, &calm, &[]);
    assert_eq!(run(&study, &folder.name("nowhere"), &["--rerun", "failed"]).code, 3, "nothing to compute again");
    let fired = folder.path("fired");
    fs::create_dir(&fired).expect("created");
    let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "2"]);
    let fault = format!("who=worker,at=running,sample=5,do=kill,times=99,dir={}", fired.display());
    let ran = said(command.env("BLADEOFF_FAULT", fault).output().expect("it starts"));
    assert_eq!(ran.code, 4, "{}", ran.err);
    assert!(fs::read_dir(&fired).expect("readable").count() >= 2, "the kills happened");
    let (header, rows) = table(&out);
    let cause = header.iter().position(|name| name == "cause").expect("cause");
    assert_eq!(rows[5][cause], "worker_killed");
    // Continued without --rerun it stays; another cause is not touched.
    assert_eq!(run(&study, &out, &[]).code, 4);
    assert_eq!(run(&study, &out, &["--rerun", "cause=time_limit,diverged"]).code, 4);
    let again = run_well(&study, &out, &["--rerun", "cause=worker_killed"]);
    assert!(again.err.contains("23 of 24 samples are there already, 1 are computed"), "{}", again.err);
    assert!(bytes(&out) == bytes(&calm));
    assert_eq!(run(&study, &out, &["--rerun", "cause=nonsense"]).code, 2);
}
