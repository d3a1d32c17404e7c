//! Result directories of this format in tests/fixtures are read and completed, those of an earlier format are rejected (`scripts/add-fixture`
//! creates one), and stored words keep their numbers. A test that fails here after a change means that the directories of users become
//! unreadable: change the program so that they do not, and never replace a fixture.

use crate::support::{Said, root, say, table};
use bladeoff_core::NUMERICS_VERSION;
use bladeoff_core::record::columns;
use bladeoff_model::machine::MachineDef;
use bladeoff_model::outcome::ColumnKind;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Folders of tests/fixtures, one for each version.
fn versions() -> Vec<PathBuf> {
    let folders = fs::read_dir(root().join("tests/fixtures")).expect("fixtures").map(|entry| entry.expect("readable"));
    let mut found: Vec<_> = folders.map(|entry| entry.path()).filter(|path| !path.ends_with("input")).collect();
    found.sort();
    assert!(!found.is_empty(), "no fixture at all");
    found
}

/// Versions whose numbers this build reproduces.
fn of_these_numerics() -> Vec<PathBuf> {
    let mut found = versions();
    found.retain(|version| {
        json(&version.join("complete/manifest.json"))["program"]["numerics_version"] == NUMERICS_VERSION
    });
    assert!(!found.is_empty(), "numerics version {NUMERICS_VERSION} has no fixture: scripts/add-fixture makes one");
    found
}

fn json(path: &Path) -> Value {
    let text = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_slice(&text).expect("JSON")
}

/// A directory of an earlier build as its user has it: in a folder of its own, beside the study.
struct Directory {
    folder: tempfile::TempDir,
    out: String,
    study: String,
}

impl Directory {
    fn new(version: &Path, name: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (from, to) = (version.join(name), folder.path().join("out"));
        copy(&from, &to);
        // the frozen inputs, under the names that the study has for them
        for (frozen, name) in [("study.toml", "study.toml"), ("machine.toml", "rig.toml"), ("points.csv", "points.csv")]
        {
            fs::copy(from.join(frozen), folder.path().join(name)).expect("copied");
        }
        let text = |path: PathBuf| path.to_str().expect("UTF-8").to_owned();
        Self { out: text(to), study: text(folder.path().join("study.toml")), folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("out").join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn remove(&self, names: &[&str]) {
        for name in names {
            let path = self.path(name);
            if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }.expect("removed");
        }
    }

    fn run(&self) -> Said {
        let said = say(&["run", &self.study, "--out", &self.out, "--workers", "2"]);
        assert_eq!(said.code, 0, "{}", said.err);
        said
    }

    fn csv(&self) -> String {
        let said = say(&["export", &self.out, "--csv"]);
        assert_eq!(said.code, 0, "{}", said.err);
        said.out
    }

    fn status(&self) -> Value {
        let said = say(&["status", &self.out, "--json", "--verify"]);
        assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
        serde_json::from_str(&said.out).expect("JSON")
    }

    /// Every file with its bytes.
    fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let files =
            fs::read_dir(self.folder.path().join("out")).expect("readable").map(|entry| entry.expect("readable"));
        let files = files.map(|entry| (entry.file_name().into_string().expect("UTF-8"), entry.path()));
        files.map(|(name, path)| (name, fs::read(path).expect("a file"))).collect()
    }
}

/// Copies a folder, with the permissions that a run sets instead of those of the checkout.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).expect("created");
    fs::set_permissions(to, Permissions::from_mode(0o755)).expect("set");
    for entry in fs::read_dir(from).expect("readable").map(|entry| entry.expect("readable")) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::write(&to, fs::read(entry.path()).expect("readable")).expect("written");
            fs::set_permissions(&to, Permissions::from_mode(0o644)).expect("set");
        }
    }
}

/// The first finished sample of each status: number, status, cause.
fn one_of_each(directory: &Directory) -> Vec<(String, String, String)> {
    let (header, rows) = table(&directory.out);
    let column = |name: &str| header.iter().position(|column| column == name).unwrap_or_else(|| panic!("no {name}"));
    let (sample, status, cause) = (column("sample"), column("status"), column("cause"));
    let of = |wanted: &str| {
        let row = rows.iter().find(|row| row[status] == wanted).unwrap_or_else(|| panic!("no row is {wanted}"));
        (row[sample].clone(), row[status].clone(), row[cause].clone())
    };
    ["ok", "invalid", "failed"].map(of).to_vec()
}

#[test]
fn directories_of_this_format_are_read() {
    for version in of_these_numerics() {
        for (name, state) in [("halfway", "ended"), ("complete", "complete")] {
            let directory = Directory::new(&version, name);
            let status = directory.status();
            assert_eq!(status["state"], state, "{}", version.display());
            let (done, total) = (status["done"].as_u64().expect("a count"), status["total"].as_u64().expect("a count"));
            assert_eq!(directory.csv().lines().count() as u64, 1 + done);
            assert!(done > 0 && (done == total) == (name == "complete"), "{done} of {total}");
            for (sample, status, cause) in one_of_each(&directory) {
                let why = say(&["why", &directory.out, &sample]);
                assert_eq!(why.code, 0, "{}", why.err);
                assert!(why.out.contains(&status) && why.out.contains(&cause), "{status} {cause}: {}", why.out);
                assert_eq!(cause.is_empty(), status == "ok");
            }
        }
    }
}

/// Rows of an earlier format have no limits of the model: such a directory is neither read as the present format nor changed.
#[test]
fn directories_of_an_earlier_format_are_rejected_by_name() {
    let current = of_these_numerics();
    let earlier: Vec<PathBuf> = versions().into_iter().filter(|version| !current.contains(version)).collect();
    assert!(!earlier.is_empty(), "a directory of an earlier format");
    for version in earlier {
        for name in ["halfway", "complete"] {
            let directory = Directory::new(&version, name);
            let before = directory.bytes("ledger.redb");
            for command in [
                vec!["run", &*directory.study, "--out", &directory.out, "--workers", "1"],
                vec!["export", &directory.out, "--csv"],
                vec!["why", &directory.out, "0"],
                vec!["replay", &directory.out, "--sample", "0"],
                vec!["report", &directory.out, "--out", "report.html"],
            ] {
                let said = say(&command);
                assert_eq!(said.code, 3, "{command:?}: {}", said.err);
                assert!(said.err.contains("written by another version of the program"), "{command:?}: {}", said.err);
                assert!(said.err.contains("another --out"), "{command:?}: {}", said.err);
            }
            assert!(directory.bytes("ledger.redb") == before, "the record is as it was");
        }
    }
}

#[test]
fn rows_of_earlier_builds_are_replayed_bit_for_bit() {
    for version in of_these_numerics() {
        for name in ["halfway", "complete"] {
            let directory = Directory::new(&version, name);
            for (sample, ..) in one_of_each(&directory) {
                let replay = say(&["replay", &directory.out, "--sample", &sample]);
                assert_eq!(replay.code, 0, "{}", replay.err);
                assert!(replay.out.contains("equal to the row in all"), "{}", replay.out);
            }
        }
    }
}

#[test]
fn a_directory_begun_by_an_earlier_build_is_finished() {
    for version in of_these_numerics() {
        let directory = Directory::new(&version, "halfway");
        let (done, basis) = (directory.status()["done"].clone(), directory.bytes("basis.bin"));
        let bad =
            directory.csv().lines().filter(|line| line.contains(",invalid,") || line.contains(",failed,")).count();
        assert!(bad > 1, "rows that are not ok");
        let said = directory.run();
        assert!(said.err.contains(&format!("{done} of 12 samples are already finished")), "{}", said.err);
        assert!(directory.bytes("basis.bin") == basis, "what is frozen stays frozen");
        assert_eq!(directory.status()["state"], "complete");
        // the same basis without finished samples: the last digits of another basis may depend on the processor
        let fresh = Directory::new(&version, "halfway");
        fresh.remove(&["ledger.redb", "parts", "timings-parts", "status.json", "manifest.json"]);
        assert!(!fresh.run().err.contains("are already finished"));
        assert!(fresh.bytes("basis.bin") == basis);
        let earlier = Directory::new(&version, "complete").csv();
        assert_eq!(
            rows_without_guarded_values(&directory.csv(), &fresh.csv(), &earlier),
            if earlier.lines().next().expect("a header").contains("guarded_") { 0 } else { bad },
            "a table in two builds is that of one, and that of the earlier build"
        );
        for (sample, ..) in one_of_each(&directory) {
            let replay = say(&["replay", &directory.out, "--sample", &sample]);
            assert_eq!(replay.code, 0, "{}", replay.err);
        }
    }
}

/// Compares a table of two builds with a table of this build and one of the earlier build, which may lack the last columns: values reached by rows
/// that are not `ok` while all guards held, and the engine. Returns the number of rows in which the table of two builds lacks these values.
fn rows_without_guarded_values(both: &str, ours: &str, earlier: &str) -> usize {
    let [both, ours, earlier] = [both, ours, earlier].map(|csv| csv.lines().collect::<Vec<_>>());
    assert_eq!([both.len(), ours.len()], [earlier.len(); 2]);
    let beyond = |line: &'_ str, earlier: &str| {
        line.strip_prefix(earlier).unwrap_or_else(|| panic!("not as it was:\n{earlier}\n{line}")).to_owned()
    };
    let header = beyond(ours[0], earlier[0]);
    assert!(header.split(',').skip(1).all(|name| name.starts_with("guarded_") || name == "engine"), "{header}");
    assert_eq!(both[0], ours[0]);
    let mut without = 0;
    for ((both, ours), earlier) in both.iter().zip(&ours).zip(&earlier) {
        let (both, ours) = (beyond(both, earlier), beyond(ours, earlier));
        if both != ours {
            assert!(
                both.strip_suffix("reduced").is_some_and(|both| both.chars().all(|c| c == ',')),
                "other values than a fresh run has: {both}\n{ours}"
            );
            without += 1;
        }
    }
    without
}

#[test]
fn a_directory_completed_by_an_earlier_build_is_left_as_it_is() {
    for version in of_these_numerics() {
        let directory = Directory::new(&version, "complete");
        let (before, csv) = (directory.files(), directory.csv());
        let said = directory.run();
        assert!(said.err.contains("nothing to compute"), "{}", said.err);
        let after = directory.files();
        for name in ["results.parquet", "timings.parquet", "basis.bin", "plan.json", "study.toml", "machine.toml"] {
            assert!(before[name] == after[name], "{name} was written again");
        }
        assert!(directory.csv() == csv);
        assert_eq!(directory.status()["state"], "complete");
    }
}

#[test]
fn words_at_rest_by_their_place_keep_it() {
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the lab rig");
    let machine = MachineDef::parse("rig.toml", &rig).expect("a machine").build().expect("a machine");
    let all = columns(&machine);
    let mut stored: Vec<(&str, &[&str])> = Vec::new();
    for column in &all {
        if let ColumnKind::Choice(words) = column.kind {
            stored.push((&column.name, words));
        }
    }
    stored.sort_unstable();
    // a record stores the number of a word: words are added at the end, never moved or removed
    let wanted: [(&str, &[&str]); 4] = [
        ("rub_regime", &["free", "light", "heavy", "backward-whirl"]),
        ("sensitive", &["no", "yes"]),
        ("twin_status", &["ok", "invalid", "failed", "beyond"]),
        ("whirl_in_rub", &["forward", "backward", "mixed"]),
    ];
    assert_eq!(stored, wanted);
}
