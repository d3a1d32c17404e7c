//! Files that a machine names: the result directory contains their content, and results, workers, shards, merge and `replay` never read the file again.

use crate::support::{Folder, say, table};
use std::fs;

const STUDY: &str = "schema = 1\nname = \"films\"\nmachine = \"machines/film.toml\"\n\
    [[vary]]\npath = \"rotor.bearings.left.stiffness_factor\"\nvalues = [0.9, 1.0, 1.1, 1.2, 1.3, 1.4]\n";

const TABLE: &str = "speed,kxx,kyy,cxx,cyy\nrpm,N/m,N/m,N*s/m,N*s/m\n0,2e6,3e6,600,700\n4000,4e6,2e6,500,600\n";

/// The lab rig with a bearing table in a file, and a study of it.
struct World {
    folder: Folder,
    study: String,
}

impl World {
    fn new() -> Self {
        let folder = Folder::new();
        let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
        let linear = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"\naxial";
        assert!(rig.contains(linear), "the rig as this test knows it");
        folder.write("machines/film.toml", &rig.replacen(linear, "kind = \"table\"\ntable = \"film.csv\"\naxial", 1));
        folder.write("machines/film.csv", TABLE);
        let study = folder.write("study.toml", STUDY);
        Self { folder, study }
    }

    fn run(&self, out: &str, more: &[&str]) -> crate::support::Said {
        let (out, scratch) = (self.folder.name(out), self.folder.name("scratch"));
        let own = ["run", &self.study, "--out", &out, "--workers", "1"];
        let scratch = ["--scratch", scratch.as_str()];
        let is_shard = more.contains(&"--shard");
        say(&[&own[..], more, if is_shard { &scratch[..] } else { &[] }].concat())
    }

    fn delete_the_inputs(&self) {
        for name in ["machines/film.csv", "machines/film.toml", "study.toml"] {
            fs::remove_file(self.folder.path(name)).expect("there");
        }
    }
}

#[test]
fn a_result_directory_needs_no_table_file() {
    let world = World::new();
    let said = world.run("one", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    let out = world.folder.name("one");
    let saved = fs::read_to_string(world.folder.path("one/machine.toml")).expect("saved");
    assert!(saved.contains("kxx = [2e6, 4e6]") || saved.contains("kxx = [2000000.0, 4000000.0]"), "{saved}");
    assert!(!saved.contains("film.csv"), "the content in the place of the name");
    world.delete_the_inputs();
    for sample in ["0", "5"] {
        let replayed = say(&["replay", &out, "--sample", sample]);
        assert_eq!(replayed.code, 0, "{}{}", replayed.out, replayed.err);
        assert!(replayed.out.contains("equal to the row"), "{}", replayed.out);
    }
    assert_eq!(say(&["status", &out, "--verify"]).code, 0);
    // one bit of the content is changed
    let path = world.folder.path("one/machine.toml");
    let whole = fs::read(&path).expect("there");
    let at = saved.find("kxx = [").expect("the table") + "kxx = [".len();
    let mut changed = whole.clone();
    changed[at] ^= 1;
    fs::write(&path, changed).expect("written");
    let verified = say(&["status", &out, "--verify"]);
    let line = verified.out.lines().find(|line| line.starts_with("machine.toml ")).expect("its line");
    assert!(verified.code == 6 && line.contains("damaged"), "{}", verified.out);
    fs::write(&path, whole).expect("written");
    assert_eq!(say(&["status", &out, "--verify"]).code, 0);
}

#[test]
fn shards_and_merge_have_the_table_of_one_machine() {
    let world = World::new();
    assert_eq!(world.run("one", &[]).code, 0);
    for shard in ["0/2", "1/2"] {
        let said = world.run("shared", &["--shard", shard, "--chunk", "2"]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    world.delete_the_inputs();
    let out = world.folder.name("shared");
    let merged = say(&["merge", &out]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    let bytes = |name: &str| fs::read(world.folder.path(name)).expect("there");
    assert!(bytes("one/results.parquet") == bytes("shared/results.parquet"), "other bytes");
    let replayed = say(&["replay", &out, "--sample", "3"]);
    assert!(replayed.code == 0 && replayed.out.contains("equal to the row"), "{}{}", replayed.out, replayed.err);
}

/// A file of the same name with other content makes another machine: a run does not resume with it, and a shard does not join.
#[test]
fn a_changed_table_file_is_another_machine() {
    let world = World::new();
    assert_eq!(world.run("one", &[]).code, 0);
    assert_eq!(world.run("shared", &["--shard", "0/2", "--chunk", "2"]).code, 0);
    let (_, before) = table(&world.folder.name("one"));
    world.folder.write("machines/film.csv", &TABLE.replace("4e6", "5e6"));
    let other = world.run("one", &[]);
    assert_eq!(other.code, 3, "{}", other.err);
    assert_eq!(world.run("shared", &["--shard", "1/2", "--chunk", "2"]).code, 3);
    // a change that does not affect the values read is no change of the machine
    world.folder.write("machines/film.csv", &TABLE.replace("speed,", " speed,").replace("2e6,3e6", "2.0e6,3e6"));
    let same = world.run("one", &[]);
    assert_eq!(same.code, 0, "{}", same.err);
    assert_eq!(table(&world.folder.name("one")).1, before);
}

#[test]
fn a_table_file_has_a_largest_size() {
    let world = World::new();
    world.folder.write("machines/film.csv", &format!("{TABLE}{}", "\n".repeat(1 << 20)));
    let said = world.run("one", &[]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("rotor.bearings.left.table") && said.err.contains("film.csv"), "{}", said.err);
}
