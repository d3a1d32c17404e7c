//! The durable record: studies that are killed, continued, extended, changed; one orchestrator per directory; damaged and full disks. In every case
//! the table is equal to that of an undisturbed run.

use crate::running::{PAUSE, handed_out};
use crate::support::read_only::ReadOnly;
use crate::support::shared_studies::{LARGE_RECORD, MANY};
use crate::support::{Folder, RUNTIME_VARIABLE, Said, alone, bladeoff, runtime, said, say, table};
use bladeoff::run::directory::row_files;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// 3 gaps x 8 masses; a sample takes some milliseconds.
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

/// Runs with a fault of the orchestrator; asserts that the fault occurred and ended the process by this signal.
fn run_killed(folder: &Folder, study: &str, out: &str, fault: &str) {
    let fired = tempfile::tempdir_in(folder.path("")).expect("a folder");
    let mut command = bladeoff(&["run", study, "--out", out, "--workers", "2"]);
    // pauses: no run ends before it is killed
    command.env("BLADEOFF_FAULT", format!("{PAUSE};{fault},dir={}", fired.path().display()));
    let output = command.output().expect("it starts");
    assert_eq!(output.status.signal(), Some(9), "{fault}: {}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_dir(fired.path()).expect("readable").count(), 1, "{fault} happened");
    assert!(!Path::new(out).join("results.parquet").exists(), "no table that looks complete");
}

#[test]
fn a_study_killed_five_times_equals_the_undisturbed_one() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (calm, killed) = (folder.name("calm"), folder.name("killed"));
    run_well(&study, &calm, &[]);
    let early = format!("who=orchestrator,at=claimed,sample={},do=kill", handed_out(24, 2));
    for fault in [
        early.as_str(),
        "who=orchestrator,at=recorded,sample=any,do=kill",
        "who=orchestrator,at=running,sample=any,do=kill",
        "who=orchestrator,at=sent,sample=any,do=kill",
        "who=orchestrator,at=recorded,sample=any,do=kill",
    ] {
        run_killed(&folder, &study, &killed, fault);
    }
    let last = run_well(&study, &killed, &[]);
    assert!(last.err.contains("did not end in order"), "{}", last.err);
    assert!(last.err.contains("of 24 samples are already finished"), "some of it was kept: {}", last.err);
    assert!(bytes(&killed) == bytes(&calm), "the table differs");
    assert!(!Path::new(&killed).join("parts").exists());
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
    assert!(second.err.contains("nothing to compute"), "{}", second.err);
    assert!(files() == before);
    // A deleted table is written again from the record.
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
    // More samples, a finer axis, an axis that was fixed before, other limits, a comment in the machine file: results are reused each time.
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
            assert!(ran.err.contains(&format!("{there} of {count} samples are already finished")), "{}", ran.err);
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
    assert!(ran.err.contains("150 of 150 samples are already finished, 0 are computed"), "{}", ran.err);
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
    // The state after a kill before the new record is renamed: new inputs, a partial record in a separate file, unfinished files.
    fs::write(format!("{out}/study.toml"), STUDY.replace("0.9 mm", "0.8 mm")).expect("written");
    fs::write(format!("{out}/ledger.redb.new"), "half a record").expect("written");
    fs::write(format!("{out}/manifest.json.tmp"), "{").expect("written");
    let ran = run_well(&study, &out, &[]);
    assert!(ran.err.contains("5 of 24 samples are already finished"), "{}", ran.err);
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
    let fault = format!("who=worker,at=running,sample=5,do=abort,times=99,dir={}", fired.display());
    let ran = said(command.env("BLADEOFF_FAULT", fault).output().expect("it starts"));
    assert_eq!(ran.code, 4, "{}", ran.err);
    assert!(fs::read_dir(&fired).expect("readable").count() >= 2, "the crashes happened");
    let (header, rows) = table(&out);
    let cause = header.iter().position(|name| name == "cause").expect("cause");
    assert_eq!(rows[5][cause], "worker_crashed");
    // Continued without --rerun, the sample remains failed; --rerun with another cause does not affect it.
    assert_eq!(run(&study, &out, &[]).code, 4);
    assert_eq!(run(&study, &out, &["--rerun", "cause=time_limit,diverged"]).code, 4);
    let again = run_well(&study, &out, &["--rerun", "cause=worker_crashed"]);
    assert!(again.err.contains("23 of 24 samples are already finished, 1 is computed"), "{}", again.err);
    assert!(bytes(&out) == bytes(&calm));
    assert_eq!(run(&study, &out, &["--rerun", "cause=nonsense"]).code, 2);
}

/// The file that a fault writes, once the process has reached the state of the fault.
fn wait_for_fault(folder: &Path) {
    wait_until("the fault", || fs::read_dir(folder).expect("readable").count() > 0);
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(120), "{what}: not within two minutes");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
}

fn status(out: &str) -> serde_json::Value {
    let said = say(&["status", out, "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    serde_json::from_str(&said.out).expect("JSON")
}

#[test]
fn a_stopped_run_keeps_its_directory_and_a_killed_one_leaves_it_to_the_next() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (calm, out, fired) = (folder.name("calm"), folder.name("out"), folder.path("fired"));
    run_well(&study, &calm, &[]);
    fs::create_dir(&fired).expect("created");
    assert_eq!(say(&["status", &folder.name("nowhere")]).code, 3);
    let fault = format!("{PAUSE};who=orchestrator,at=recorded,sample=any,do=stop,dir={}", fired.display());
    let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "2"]);
    let mut holder =
        command.env("BLADEOFF_FAULT", fault).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    wait_for_fault(&fired);
    // A stopped process is alive: another run may not use its directory and changes nothing in it.
    let second = run(&study, &out, &[]);
    assert_eq!(second.code, 3, "{}", second.err);
    assert!(second.err.contains(&format!("process {}", holder.id())), "{}", second.err);
    wait_until("the process is stopped", || status(&out)["state"] == "stopped");
    let shown = say(&["status", &out]).out;
    assert!(shown.contains("SIGCONT") && shown.contains("worker"), "{shown}");
    signal(&holder, "KILL");
    assert_eq!(holder.wait().expect("it ends").signal(), Some(9));
    let seen = status(&out);
    assert_eq!((seen["state"].as_str(), seen["total"].as_u64()), (Some("killed"), Some(24)));
    let shown = say(&["status", &out]).out;
    assert!(shown.contains(&format!("resume     {} run {study} --out {out}", crate::support::BINARY)), "{shown}");
    // A lock file of a process that does not exist is stale and ignored.
    let third = run_well(&study, &out, &[]);
    assert!(third.err.contains(&format!("process {}", holder.id())), "{}", third.err);
    // Singular or plural, depending on how many samples were recorded together.
    assert!(third.err.contains(" already finished, "), "{}", third.err);
    assert!(bytes(&out) == bytes(&calm));
    let seen = status(&out);
    assert_eq!((seen["state"].as_str(), seen["done"].as_u64()), (Some("complete"), Some(24)));
    assert!(!say(&["status", &out]).out.contains("resume "));
}

#[test]
fn a_running_study_is_seen_with_its_workers_and_its_rows_are_read() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", &STUDY.replace("count = 8", "count = 400"));
    let out = folder.name("out");
    let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "2", "--refresh", "1"]);
    command.env("BLADEOFF_FAULT", PAUSE);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    wait_until("samples are shown as done", || {
        Path::new(&out).join("status.json").exists() && status(&out)["done"].as_u64().is_some_and(|done| done > 4)
    });
    let seen = status(&out);
    assert_eq!((seen["state"].as_str(), seen["pid"].as_u64()), (Some("running"), Some(child.id().into())));
    assert_eq!(seen["workers"].as_array().map(Vec::len), Some(2));
    let left = |key: &str| seen[key].as_f64().unwrap_or_else(|| panic!("{key}: {seen}"));
    assert!(left("left_to_s") > 1.0 && left("left_from_s") <= left("left_to_s"), "{seen}");
    let shown = say(&["status", &out]).out;
    assert!(shown.contains("running: process") && shown.contains("worker 1 (process"), "{shown}");
    let pace = shown.lines().find(|line| line.starts_with("pace")).expect("a pace");
    assert!(pace.contains("/s, ") || pace.contains("/min, "), "{pace}");
    assert!(pace.ends_with(" left"), "{pace}");
    wait_until("a part of what is finished", || !row_files(Path::new(&out)).is_empty());
    let (_, rows) = table(&out);
    assert!(!rows.is_empty() && rows.len() < 1200);
    let why = say(&["why", &out, &rows[0][0]]);
    assert!(why.code == 0 && why.out.contains("computed by"), "{}{}", why.out, why.err);
    let why = say(&["why", "1199", "--dir", &out]);
    assert!(why.code == 0 && why.out.contains("not finished"), "{}{}", why.out, why.err);
    signal(&child, "TERM");
    assert_eq!(child.wait().expect("it ends").code(), Some(143));
    let seen = status(&out);
    assert_eq!((seen["state"].as_str(), seen["ended"].as_str()), (Some("ended"), Some("terminated")));
}

#[test]
fn why_tells_all_of_a_sample() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (out, fired) = (folder.name("out"), folder.path("fired"));
    fs::create_dir(&fired).expect("created");
    let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "2"]);
    let fault = format!("who=worker,at=running,sample=5,do=kill,times=99,dir={}", fired.display());
    assert_eq!(said(command.env("BLADEOFF_FAULT", fault).output().expect("it starts")).code, 4);
    let why = say(&["why", "5", "--dir", &out]);
    assert_eq!(why.code, 0, "{}", why.err);
    for part in [
        "5 of 24",
        "contact.gap      0.5 mm",
        "rotor.unbalances.blade_off.mass  8 g",
        "quarantined",
        "worker_killed",
        "what to do",
        "--rerun cause=worker_killed",
        "in attempt ",
        "log                              w",
        "sample 5",
        "SIGKILL",
        &format!("{} replay {out} --sample 5", crate::support::BINARY),
    ] {
        assert!(why.out.contains(part), "{part}: {}", why.out);
    }
    assert_eq!(say(&["why", &out, "5"]).out, why.out);
    let replay = say(&["replay", &out, "--sample", "5"]);
    assert_eq!(replay.code, 0, "{}", replay.err);
    let wrong = [(3, &["why", &*out, "24"][..]), (2, &["why", &out, "x"]), (2, &["why", &out, "5", "--dir", &out])];
    for (code, words) in wrong {
        assert_eq!(say(words).code, code, "{words:?}");
    }
    let mut here = bladeoff(&["why", "5"]);
    let here = said(here.current_dir(&out).output().expect("it starts"));
    assert!(here.code == 0 && here.out.contains("5 of 24 in ."), "{}{}", here.out, here.err);
}

#[test]
fn a_record_cut_or_changed_anywhere_gives_the_same_table() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (calm, out) = (folder.name("calm"), folder.name("out"));
    run_well(&study, &calm, &[]);
    run_well(&study, &out, &[]);
    let whole = fs::read(format!("{out}/ledger.redb")).expect("the record");
    let (mut kept, mut aside) = (0, 0);
    let parts = [0, 1, 100, 1000, 4096, whole.len() / 3, whole.len() / 2, whole.len() - 5000, whole.len() - 1];
    let cuts = parts.iter().map(|&length| whole[..length].to_vec());
    let changes = (1..8).map(|eighth| {
        let mut bytes = whole.clone();
        bytes[eighth * whole.len() / 8] ^= 0xff;
        bytes
    });
    for damaged in cuts.chain(changes) {
        fs::write(format!("{out}/ledger.redb"), &damaged).expect("written");
        fs::remove_file(format!("{out}/results.parquet")).expect("there");
        let ran = run_well(&study, &out, &[]);
        assert!(bytes(&out) == bytes(&calm), "{}", ran.err);
        assert!(!ran.err.contains("internal error"), "{}", ran.err);
        aside += u32::from(ran.err.contains("the damaged record is kept as"));
        kept += u32::from(ran.err.contains("of 24 samples are already finished"));
    }
    let names = fs::read_dir(&out).expect("readable").flatten().map(|entry| entry.file_name());
    let named = names.filter(|name| name.to_string_lossy().starts_with("ledger.damaged-")).count();
    assert_eq!(u32::try_from(named).expect("few"), aside, "each damaged record is kept");
    assert!(aside >= 9 && kept >= 5, "{aside} kept aside, {kept} with entries that were used");
    // A damaged basis is computed again.
    fs::write(format!("{out}/basis.bin"), "damaged").expect("written");
    run_well(&study, &out, &[]);
    assert!(bytes(&out) == bytes(&calm));
}

#[test]
fn a_full_disk_is_exit_6_and_the_next_run_goes_on() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", LARGE_RECORD);
    let (calm, out) = (folder.name("calm"), folder.name("out"));
    run_well(&study, &calm, &[]);
    let size = fs::metadata(format!("{calm}/ledger.redb")).expect("the record").len();
    assert!(size > 12_288 << 10, "{size} bytes of record are enough for this test");
    // In blocks of 1024 bytes: 1 is too little for shared memory; 12288 is enough for it, but too little for the record.
    const FULL: &str = "File too large";
    let bounded = |blocks: &str| {
        let script = format!("ulimit -f {blocks}; exec \"$0\" run \"$1\" --out \"$2\" --workers 2");
        let mut command = Command::new("bash");
        command.args(["-c", &script, crate::support::BINARY, &study, &out]).env(RUNTIME_VARIABLE, runtime());
        said(command.output().expect("bash"))
    };
    for (blocks, why) in [("1", "files may have 1024 bytes (ulimit -f)"), ("12288", FULL), ("12288", FULL)] {
        let full = bounded(blocks);
        assert_eq!(full.code, 6, "{}", full.err);
        assert!(full.err.contains(why), "{}", full.err);
        assert!(!full.err.contains("internal error"), "{}", full.err);
        assert!(!Path::new(&out).join("results.parquet").exists());
    }
    let seen = status(&out);
    assert_eq!((seen["state"].as_str(), seen["ended"].as_str()), (Some("ended"), Some("failed")));
    // The count contains only recorded samples, and none of them is lost.
    let done = seen["done"].as_u64().expect("a count");
    assert!(done > 0 && done < MANY, "{done}");
    let ran = run_well(&study, &out, &[]);
    assert!(ran.err.contains("samples are already finished"), "what was recorded counts: {}", ran.err);
    assert!(ran.err.contains(&format!("{done} ")), "{done}: {}", ran.err);
    assert!(bytes(&out) == bytes(&calm));
}

#[test]
fn a_directory_that_cannot_be_written_is_exit_6() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let out = folder.name("out");
    run_well(&study, &out, &["--limit", "3"]);
    let nowhere = run(&study, "/proc/nowhere", &[]);
    assert_eq!(nowhere.code, 6, "{}", nowhere.err);
    let read_only = ReadOnly::new(&folder, &out);
    let ran = read_only.run(&study);
    drop(read_only);
    assert_eq!(ran.code, 6, "{}", ran.err);
    assert!(ran.err.contains("Permission denied") && ran.err.contains(&out), "{}", ran.err);
    assert_eq!(table(&out).1.len(), 3, "nothing was touched");
}
