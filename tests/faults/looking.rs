//! Status of result directories: states and counts of runs that could not report their end, rejected commands that change nothing, directories
//! that cannot be written, files lost besides the record.

use crate::running::{Running, STUDY, signal, wait_until};
use crate::support::read_only::ReadOnly;
use crate::support::{Folder, Said, alone, say};
use bladeoff_record::Reader;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;

fn run(study: &str, out: &str, more: &[&str]) -> Said {
    say(&[&["run", study, "--out", out, "--workers", "2"], more].concat())
}

fn status(out: &str) -> serde_json::Value {
    let said = say(&["status", out, "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    serde_json::from_str(&said.out).expect("JSON")
}

fn status_text(out: &str) -> String {
    say(&["status", out]).out
}

/// Number of samples in the record, independent of `status`.
fn recorded(out: &str) -> u64 {
    Reader::open(Path::new(out).join("ledger.redb")).and_then(|record| record.len()).expect("a whole record")
}

/// Every file below a directory with its bytes.
fn files(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(out).expect("readable").flatten() {
        if entry.path().is_dir() {
            all.extend(files(&entry.path()));
        } else {
            all.insert(entry.path().display().to_string(), fs::read(entry.path()).expect("readable"));
        }
    }
    all
}

#[test]
fn a_killed_run_is_counted_by_its_record_also_without_its_lock_file() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let out = folder.name("out");
    let mut killed = Running::start_slow(&folder, &study, &out, "who=orchestrator,at=recorded,sample=12,do=kill");
    assert_eq!((killed.end().signal(), killed.fired()), (Some(9), 1), "{}", killed.said());
    let done = recorded(&out);
    assert!((1..20).contains(&done), "{done}");
    let is_right = |text: &str, words: &str| {
        assert!(text.contains(words) && text.contains("; last report at 20"), "{text}");
        assert!(text.contains(&format!("done       {done} of 20 samples")), "{done}: {text}");
        assert!(text.contains(&format!("outcome    ok {done}")), "{text}");
    };
    is_right(&status_text(&out), "state      killed: process ");
    // a run that empties the lock file, even a rejected one, removes only the name of the holder
    folder.write("other.toml", &STUDY.replace("0.9 mm", "0.8 mm"));
    assert_eq!(run(&folder.name("other.toml"), &out, &[]).code, 3);
    assert!(!fs::read_to_string(folder.path("out/run.lock")).expect("there").contains("pid"));
    is_right(&status_text(&out), "state      killed or failed: it could not record its end");
    let seen = status(&out);
    assert_eq!((&seen["state"], &seen["done"], &seen["left"]), (&"killed".into(), &done.into(), &(20 - done).into()));
    // without status.json, the record is counted
    fs::remove_file(folder.path("out/status.json")).expect("there");
    let text = status_text(&out);
    assert!(text.contains(&format!("done       {done} of 20 samples")), "{text}");
    let again = run(&study, &out, &[]);
    assert!(again.err.contains(&format!("{done} of 20 samples are already finished")), "{}", again.err);
    assert_eq!(status(&out)["state"], "complete");
}

#[test]
fn a_directory_that_was_moved_under_its_run_tells_the_truth() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (out, moved) = (folder.name("out"), folder.name("moved"));
    let mut run_there = Running::start_slow(&folder, &study, &out, "who=orchestrator,at=recorded,sample=9,do=stop");
    wait_until("the fault", || run_there.fired() == 1);
    fs::rename(&out, &moved).expect("renamed");
    wait_until("the run is stopped", || status(&moved)["state"] == "stopped");
    // counts of a live run are those of its last report, and all counted samples are durable
    let told = status(&moved)["done"].as_u64().expect("a count");
    fs::copy(folder.path("moved/ledger.redb"), folder.path("copy.redb")).expect("copied");
    let durable = Reader::peek(folder.path("copy.redb")).and_then(|record| record.len()).expect("readable");
    assert!(told <= durable && durable > 0, "{told} {durable}");
    assert!(signal(run_there.child.id(), "CONT"));
    assert_eq!(run_there.end().code(), Some(6), "{}", run_there.said());
    let done = recorded(&moved);
    let text = status_text(&moved);
    assert!(text.contains("state      ended: failed") && text.contains("was moved during the run, to "), "{text}");
    assert!(text.contains(&format!("done       {done} of 20 samples")), "{done}: {text}");
    let go_on = format!("resume     {} run {study} --out {moved}\n", crate::support::BINARY);
    assert!(text.contains(&go_on), "{text}");
    let again = run(&study, &moved, &[]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert!(again.err.contains(&format!("{done} of 20 samples are already finished")), "{}", again.err);
}

#[test]
fn the_budget_that_ended_a_run_is_named_and_parts_only_where_they_are() {
    let _alone = alone();
    let folder = Folder::new();
    // samples that take much longer than the run
    let endless = STUDY.replace("exponential", "reduced").replace("[set]", "[set]\n\"run.step\" = \"1e-9 s\"");
    assert_ne!(endless, STUDY);
    let study = folder.write("s.toml", &endless);
    let out = folder.name("out");
    let ran = run(&study, &out, &["--wall", "0.1 s", "--json-events"]);
    assert_eq!(ran.code, 5, "{}", ran.err);
    assert!(!ran.err.contains("parts") && !Path::new(&out).join("parts").exists(), "{}", ran.err);
    let last: serde_json::Value = serde_json::from_str(ran.out.lines().last().expect("events")).expect("JSON");
    assert_eq!((&last["event"], &last["table"], &last["done"]), (&"finished".into(), &"".into(), &0.into()));
    assert_eq!((&status(&out)["state"], &status(&out)["ended"]), (&"ended".into(), &"wall".into()));
    assert!(status_text(&out).contains("state      ended: by --wall\n"), "{}", status_text(&out));
    let failing = STUDY.replace("[set]", "[set]\n\"run.step_limit\" = 1");
    let (study, out) = (folder.write("f.toml", &failing), folder.name("failing"));
    assert_eq!(run(&study, &out, &["--max-failures", "1"]).code, 5);
    assert_eq!(status(&out)["ended"], "max_failures");
    let manifest = fs::read_to_string(folder.path("failing/manifest.json")).expect("there");
    assert!(manifest.contains("\"state\": \"max_failures\""), "{manifest}");
}

#[test]
fn a_refused_run_changes_no_byte() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let (whole, killed) = (folder.name("whole"), folder.name("killed"));
    assert_eq!(run(&study, &whole, &[]).code, 0);
    let mut child = Running::start_slow(&folder, &study, &killed, "who=orchestrator,at=recorded,sample=9,do=kill");
    assert_eq!((child.end().signal(), child.fired()), (Some(9), 1), "{}", child.said());
    let other = folder.write("other.toml", &STUDY.replace("0.5 mm", "0.6 mm"));
    folder.write("killed/manifest.json.tmp", "as a kill leaves it");
    for out in [&whole, &killed] {
        let mut before = files(Path::new(out));
        for more in [&[][..], &["--rerun", "failed"]] {
            assert_eq!(run(&other, out, more).code, 3);
        }
        let mut after = files(Path::new(out));
        // every run writes to the lock file
        let lock = format!("{out}/run.lock");
        assert!(before.remove(&lock).is_some() && after.remove(&lock).is_some());
        assert!(before == after, "{:?} {:?}", before.keys(), after.keys());
    }
    assert_eq!(run(&study, &killed, &[]).code, 0);
    assert!(!folder.path("killed/manifest.json.tmp").exists());
    // a run with nothing to compute does not change the record
    let record = || fs::read(folder.path("whole/ledger.redb")).expect("the record");
    let before = record();
    assert_eq!(run(&study, &whole, &[]).code, 0);
    assert!(record() == before);
}

#[test]
fn a_directory_that_cannot_be_written_is_compared_all_the_same() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let grown = folder.write("grown.toml", &STUDY.replace("count = 5", "count = 9"));
    let other = folder.write("other.toml", &STUDY.replace("0.5 mm", "0.6 mm"));
    let out = folder.name("out");
    assert_eq!(run(&study, &out, &[]).code, 0);
    let read_only = ReadOnly::new(&folder, &out);
    let before = files(Path::new(&out));
    let [complete, refused, incomplete] = [&study, &other, &grown].map(|study| read_only.run(study));
    drop(read_only);
    assert_eq!((complete.code, refused.code, incomplete.code), (0, 3, 6), "{}", complete.err);
    assert!(
        complete.err.contains("nothing to compute") && complete.out.contains("20 of 20 samples"),
        "{}",
        complete.err
    );
    assert!(
        refused.err.contains("20 of its 20 finished samples") || refused.err.contains("contact.gap"),
        "{}",
        refused.err
    );
    assert!(incomplete.err.contains("20 of 36 samples are already finished"), "{}", incomplete.err);
    assert!(incomplete.err.contains("run.lock") && incomplete.err.contains("Permission denied"), "{}", incomplete.err);
    assert!(files(Path::new(&out)) == before);
}

#[test]
fn what_is_lost_beside_a_complete_record_is_made_again() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let out = folder.name("out");
    assert_eq!(run(&study, &out, &[]).code, 0);
    let read = |name: &str| fs::read(folder.path(&format!("out/{name}"))).expect(name);
    let (results, timings) = (read("results.parquet"), read("timings.parquet"));
    let names: Vec<String> = files(Path::new(&out)).into_keys().collect();
    let runs_again = |words: &str| {
        let again = run(&study, &out, &[]);
        assert!(
            again.code == 0 && again.err.contains("nothing to compute") && again.err.contains(words),
            "{}",
            again.err
        );
        assert!(read("results.parquet") == results && read("timings.parquet") == timings);
        assert_eq!(files(Path::new(&out)).into_keys().collect::<Vec<_>>(), names);
        let manifest: serde_json::Value = serde_json::from_slice(&read("manifest.json")).expect("JSON");
        assert_eq!((&manifest["state"], &manifest["done"]), (&"complete".into(), &20.into()));
        assert_eq!((&status(&out)["state"], &status(&out)["done"]), (&"complete".into(), &20.into()));
        assert!(say(&["why", &out, "3"]).out.contains("computed by                      worker "));
    };
    for name in ["timings.parquet", "manifest.json", "status.json", "study.toml", "machine.toml", "plan.json"] {
        fs::remove_file(folder.path(&format!("out/{name}"))).expect(name);
        runs_again(if name.starts_with(['t', 'm']) && !name.ends_with("toml") { name } else { "" });
    }
    // truncated timings are no error for `why`
    folder.write("out/manifest.json", "{");
    fs::write(folder.path("out/timings.parquet"), &timings[..timings.len() / 2]).expect("written");
    let why = say(&["why", &out, "3"]);
    assert!(why.code == 0 && why.out.contains("computed by                      unknown: "), "{}{}", why.out, why.err);
    runs_again("timings.parquet was missing or damaged");
}
