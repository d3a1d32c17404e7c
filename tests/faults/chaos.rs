//! One pass of the storm of `bladeoff-dev chaos`; and short runs, which must leave no files behind.

use crate::running::{Running, left_behind};
use crate::support::{Folder, say, write_script};
use bladeoff_dev::chaos::{ChaosError, Storm};
use std::fs;
use std::path::Path;
use std::time::Instant;

#[test]
fn a_study_in_a_storm_equals_the_undisturbed_one() {
    let said = say(&["chaos", "--seed", "5", "--minutes", "0"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("1 studies of 20 samples, every table equal"), "{}", said.out);
}

/// Runs a storm with a script in place of `bladeoff run STUDY --out OUT`.
fn storm_of(folder: &Path, script: &str) -> Result<(), ChaosError> {
    let program = folder.join("program");
    write_script(&program, &format!("#!/bin/sh\nmkdir -p \"$4\"\n: > \"$4/workers.log\"\n{script}\n"));
    let place = folder.join("storm");
    fs::create_dir(&place).expect("created");
    Storm::new(&program, &place, 1)?.study()
}

#[test]
fn a_storm_finds_what_is_wrong() {
    let folder = || tempfile::tempdir().expect("a folder");
    let fine = folder();
    assert!(storm_of(fine.path(), "echo same > \"$4/results.parquet\"").is_ok());
    let other = storm_of(folder().path(), "echo $$ > \"$4/results.parquet\"").expect_err("another table");
    let ChaosError::Differs { study: 1, directory } = other else { panic!("{other}") };
    assert!(directory.join("results.parquet").exists(), "it is kept");
    fs::remove_dir_all(directory).expect("removed");
    let dirty = folder();
    let script = format!(
        "echo same > \"$4/results.parquet\"; echo 'run 1 with shared memory in {}' > \"$4/workers.log\"",
        dirty.path().display()
    );
    let left = storm_of(dirty.path(), &script).expect_err("something is left");
    assert!(matches!(&left, ChaosError::Left { left, .. } if left == &[dirty.path()]), "{left}");
    let failed = storm_of(folder().path(), "exit 3").expect_err("it fails");
    assert!(matches!(failed, ChaosError::Failed { .. }), "{failed}");
}

/// Number of short runs: a file that one run in thirty leaves is detected with a probability of 99.9 %.
const SHORT_RUNS: u32 = 200;

#[test]
fn many_short_runs_leave_nothing_behind() {
    let start = Instant::now();
    let folder = Folder::new();
    let text = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.001 s\"\n";
    let study = folder.write("s.toml", text);
    for _ in 0..SHORT_RUNS {
        let out = folder.name("out");
        let mut run = Running::start(&folder, &study, &out, "");
        assert!(run.end().success(), "{}", run.said());
        assert!(!fs::read_to_string(format!("{out}/workers.log")).expect("a log").is_empty());
        assert!(left_behind(&out).is_empty(), "{:?}", left_behind(&out));
        fs::remove_dir_all(&out).expect("removed");
    }
    println!("{SHORT_RUNS} runs in {:.0} s, nothing left", start.elapsed().as_secs_f64());
}
