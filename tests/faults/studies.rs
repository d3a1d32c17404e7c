//! Studies from file to table with the real solver: columns, determinism, faults, signals.

use crate::running::PAUSE;
use crate::support::{Folder, SMALL_STUDY, alone, bladeoff, said, say, table};
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

fn run(study: &str, out: &str, more: &[&str]) -> crate::support::Said {
    let mut args = vec!["run", study, "--out", out];
    args.extend(more);
    say(&args)
}

fn bytes(directory: &str) -> Vec<u8> {
    fs::read(format!("{directory}/results.parquet")).expect("the table")
}

#[test]
fn a_study_gives_a_table_with_its_parameters_status_and_quantities() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.small_study();
    let out = folder.name("out");
    let ran = run(&study, &out, &[]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.contains("12 of 12 samples") && ran.out.contains("hyp2-frozen"), "{}", ran.out);
    let (header, rows) = table(&out);
    let start = [
        "sample",
        "diaphragms.seal.contact.gap_m",
        "diaphragms.seal.contact.friction",
        "detection",
        "status",
        "cause",
        "causes",
        "end_cause",
        "notes",
        "end_time_s",
    ];
    assert_eq!(header[..start.len()], start);
    assert_eq!(rows.len(), 12);
    let at = |name: &str| header.iter().position(|column| column == name).expect("the column");
    for (sample, row) in rows.iter().enumerate() {
        assert_eq!(row[0], sample.to_string());
        assert_eq!(row[at("status")], "ok");
        let rubs = row[1] == "0.0005";
        assert_eq!(row[at("first_contact_s")].is_empty(), !rubs, "null without contact");
        assert_eq!(row[at("detection")], ["hyp1", "hyp2", "hyp2-frozen"][sample % 3]);
    }
    assert!(rows.iter().any(|row| !row[at("first_contact_s")].is_empty()), "contact happened");
    assert_eq!(fs::read_to_string(format!("{out}/study.toml")).expect("frozen"), SMALL_STUDY);
    let machine = fs::read(folder.path("machines/rig.toml")).expect("the rig");
    assert_eq!(fs::read(format!("{out}/machine.toml")).expect("frozen"), machine);
    let manifest = fs::read(format!("{out}/manifest.json")).expect("the manifest");
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).expect("JSON");
    assert_eq!(manifest["state"], "complete");
    assert_eq!(manifest["done"], 12);
    for file in ["timings.parquet", "workers.log", "ledger.redb"] {
        assert!(fs::exists(format!("{out}/{file}")).expect("readable"), "{file}");
    }
    fs::write(folder.path("something"), "else").expect("written");
    let elsewhere = run(&study, &folder.name(""), &[]);
    assert_eq!(elsewhere.code, 3, "a folder of something else: {}", elsewhere.err);
}

#[test]
fn one_two_and_three_workers_give_the_same_bytes() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.small_study();
    let mut tables = Vec::new();
    for workers in ["1", "2", "3"] {
        let out = folder.name(workers);
        let ran = run(&study, &out, &["--workers", workers]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        tables.push(bytes(&out));
    }
    assert!(tables[0] == tables[1] && tables[1] == tables[2]);
}

#[test]
fn a_worker_killed_in_a_sample_changes_no_byte() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.small_study();
    assert_eq!(run(&study, &folder.name("calm"), &["--workers", "2"]).code, 0);
    let fired = folder.path("fired");
    fs::create_dir(&fired).expect("created");
    let fault = format!("who=worker,at=running,sample=4,do=kill,dir={}", fired.display());
    let out = folder.name("killed");
    let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "2"]);
    let ran = said(command.env("BLADEOFF_FAULT", fault).output().expect("it starts"));
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert_eq!(fs::read_dir(&fired).expect("readable").count(), 1, "the kill happened");
    let manifest = fs::read(format!("{out}/manifest.json")).expect("the manifest");
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).expect("JSON");
    assert_eq!(manifest["worker_deaths"], 1);
    assert!(bytes(&out) == bytes(&folder.name("calm")));
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.small_study();
    let start = |out: &str| {
        let mut command = bladeoff(&["run", &study, "--out", out, "--workers", "2"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
    };
    let (a, b) = (folder.name("a"), folder.name("b"));
    let (first, second) = (start(&a), start(&b));
    for child in [first, second] {
        let ran = said(child.wait_with_output().expect("it ends"));
        assert_eq!(ran.code, 0, "{}", ran.err);
    }
    assert!(bytes(&a) == bytes(&b));
}

#[test]
fn scale_thins_every_axis_and_limit_takes_a_prefix_of_one_shuffle() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.small_study();
    let list = |more: &[&str]| -> BTreeSet<String> {
        let mut args = vec!["check", &study, "--list"];
        args.extend(more);
        let said = say(&args);
        assert_eq!(said.code, 0, "{}", said.err);
        said.out.lines().skip(1).map(|line| line.split_once('\t').expect("a number first").1.to_owned()).collect()
    };
    let (all, scaled) = (list(&[]), list(&["--scale", "0.1"]));
    assert_eq!((all.len(), scaled.len()), (12, 8), "three detections become two, pairs stay");
    assert!(scaled.is_subset(&all) && !scaled.iter().any(|line| line.ends_with("hyp2")));
    let (three, five) = (list(&["--limit", "3"]), list(&["--limit", "5"]));
    assert_eq!((three.len(), five.len()), (3, 5));
    assert!(three.is_subset(&five) && five.is_subset(&all));
    let out = folder.name("out");
    assert_eq!(run(&study, &out, &["--limit", "3"]).code, 0);
    let (_, rows) = table(&out);
    assert_eq!(rows.iter().map(|row| row[0].as_str()).collect::<Vec<_>>(), ["0", "1", "2"]);
}

#[test]
fn failures_beyond_the_limits_of_the_study_are_exit_4() {
    let _alone = alone();
    let folder = Folder::new();
    let text = "schema = 1\nmachine = \"machines/rig.toml\"\n[[vary]]\npath = \"run.step_limit\"\nvalues = [100, 200, 1000000]\n";
    let strict = folder.write("strict.toml", text);
    let out = folder.name("strict");
    let ran = run(&strict, &out, &[]);
    assert_eq!(ran.code, 4, "{}", ran.err);
    assert!(ran.out.contains("2 (2 step_limit)"), "{}", ran.out);
    let (header, rows) = table(&out);
    let status = header.iter().position(|column| column == "status").expect("status");
    assert_eq!(rows.iter().map(|row| row[status].as_str()).collect::<Vec<_>>(), ["failed", "failed", "ok"]);
    let lax = folder.write("lax.toml", &format!("{text}[limits]\nmax_failed = 2\n"));
    assert_eq!(run(&lax, &folder.name("lax"), &[]).code, 0);
}

#[test]
fn zipped_axes_and_points_are_combined_as_written() {
    let folder = Folder::new();
    folder.write("points.csv", "# two points\ncontact.gap, contact.friction\n0.5 mm, 0.1\n0.0006, 0.2\n");
    let study = folder.write(
        "s.toml",
        r#"schema = 1
machine = "machines/rig.toml"
[points]
file = "points.csv"
[[vary]]
path = "blade_off.mass"
values = ["5 g", "10 g"]
zip = "blade"
[[vary]]
path = "blade_off.radius"
from = "40 mm"
to = "50 mm"
count = 2
zip = "blade"
"#,
    );
    let said = say(&["check", &study, "--list"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let lines: Vec<&str> = said.out.lines().skip(1).collect();
    assert_eq!(
        lines,
        [
            "0\t0.0005\t0.1\t0.005\t0.04",
            "1\t0.0005\t0.1\t0.01\t0.05",
            "2\t0.0006\t0.2\t0.005\t0.04",
            "3\t0.0006\t0.2\t0.01\t0.05"
        ]
    );
    folder.write("points.csv", "contact.gap, contact.gp\n0.5 mm\n-1 mm, 2\n");
    let said = say(&["check", &study]);
    assert_eq!(said.code, 3);
    for part in ["points.csv:1:14", "points.csv:2:1", "points.csv:3:1"] {
        assert!(said.err.contains(part), "{part}: {}", said.err);
    }
    let text = fs::read_to_string(&study).expect("the study").replace("\"10 g\"]", "\"10 g\", \"15 g\"]");
    folder.write("points.csv", "contact.gap\n0.5 mm\n");
    let said = say(&["check", &folder.write("s.toml", &text)]);
    assert_eq!(said.code, 3);
    assert!(
        said.err.contains("has 2 values, but rotor.unbalances.blade_off.mass of the same zip group has 3"),
        "{}",
        said.err
    );
}

#[test]
fn a_study_cannot_name_a_folder_or_file_elsewhere() {
    let folder = Folder::new();
    for name in ["../up", "a/b", "..", ".hidden", "/tmp/x", "", "a\\u0000b"] {
        let study = folder.write("s.toml", &SMALL_STUDY.replace("name = \"small\"", &format!("name = \"{name}\"")));
        let said = say(&["check", &study, "--list"]);
        assert_eq!(said.code, 3, "{name:?}");
        assert!(said.err.contains("name"), "{name:?}: {}", said.err);
    }
    for machine in ["/etc/passwd", "../../../rig.toml", "machines/../../rig.toml"] {
        let study = folder.write("s.toml", &SMALL_STUDY.replace("machines/rig.toml", machine));
        let said = say(&["check", &study, "--list"]);
        assert!(said.code == 3 && said.err.contains("is outside the folders"), "{machine}: {}", said.err);
    }
    let points = format!("{SMALL_STUDY}[points]\nfile = \"/etc/passwd\"\n");
    let said = say(&["check", &folder.write("s.toml", &points)]);
    assert!(said.code == 3 && said.err.contains("is outside the folders"), "{}", said.err);
}

/// Prefix of the names of this run's shared memory, from the command lines of its workers.
fn shared_memory_prefix(pid: u32) -> String {
    let children = crate::support::processes::children(pid);
    let child = children.first().expect("a worker runs");
    let command = fs::read(format!("/proc/{child}/cmdline")).expect("of a living process");
    let arguments: Vec<String> =
        command.split(|byte| *byte == 0).map(|part| String::from_utf8_lossy(part).into_owned()).collect();
    let at = arguments.iter().position(|argument| argument == "--prefix").expect("a worker's command line");
    arguments[at + 1].clone()
}

#[test]
fn ctrl_c_while_a_study_is_prepared_ends_it_with_a_word() {
    let folder = Folder::new();
    let text = "schema = 1\nmodel = \"function\"\n[function]\ng = \"x\"\n[design]\nkind = \"monte-carlo\"\nsamples = 9000000\n\
                [[uncertain]]\nname = \"x\"\ndistribution = \"normal\"\nmean = 0\nsd = 1\n";
    let (study, out) = (folder.write("many.toml", text), folder.name("out"));
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let mut command = bladeoff(&["run", &study, "--out", &out]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
        let mut err = BufReader::new(child.stderr.take().expect("piped")).lines().map(|line| line.expect("UTF-8"));
        // printed before the keys of all samples are computed
        err.find(|line| line.contains("9000000 samples")).expect("a first line");
        assert!(Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().expect("kill").success());
        let rest: Vec<String> = err.collect();
        assert_eq!(child.wait().expect("it ends").code(), Some(code), "{rest:?}");
        assert!(rest.iter().any(|line| line.contains("ended before the first sample was assigned")), "{rest:?}");
        // in order: if the run already had the lock, it has released it
        let status = say(&["status", &out]);
        assert!(!status.out.contains("killed"), "{}{}", status.out, status.err);
    }
    let again = say(&["run", &study, "--out", &out, "--limit", "10"]);
    assert!(again.code == 0 && again.out.contains("10 of 10 samples"), "{} {}", again.out, again.err);
}

#[test]
fn ctrl_c_ends_cleanly_and_keeps_what_is_finished() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("long.toml", &SMALL_STUDY.replace("count = 2", "count = 200"));
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let out = folder.name(signal);
        let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "2"]);
        command.env("BLADEOFF_FAULT", PAUSE).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let mut err = BufReader::new(child.stderr.take().expect("piped")).lines();
        let says_progress = |line: &String| line.contains("/1200") && line.contains("left");
        // The first progress line that reports finished samples.
        err.by_ref().map(|line| line.expect("UTF-8")).find(says_progress).expect("progress before the end");
        let prefix = shared_memory_prefix(child.id());
        assert!(Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().expect("kill").success());
        let rest: Vec<String> = err.map(|line| line.expect("UTF-8")).collect();
        let status = child.wait().expect("it ends");
        assert_eq!(status.code(), Some(code), "{rest:?}");
        let left: Vec<_> = fs::read_dir("/dev/shm")
            .expect("readable")
            .filter(|entry| entry.as_ref().is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(&prefix)))
            .collect();
        assert!(left.is_empty(), "{left:?}");
        assert!(!fs::exists(format!("{out}/results.parquet")).expect("readable"), "no table that looks complete");
        let (_, rows) = table(&out);
        assert!(!rows.is_empty() && rows.len() < 1200, "{} rows kept", rows.len());
    }
}
