//! Studies in shards: after any fault of the attempts the table is byte for byte equal to that of one machine.

use crate::running::{signal, state, wait_until};
use crate::support::{Folder, Said, bladeoff, said, say};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, SystemTime};

/// 120 samples in chunks of 10, with a question and a gate.
const FUNCTION: &str = r#"schema = 1
name = "f"
model = "function"
seed = 3

[function]
g = "a * k - b"

[design]
kind = "monte-carlo"
samples = 60

[[uncertain]]
name = "a"
distribution = "normal"
mean = 3
sd = 1

[[uncertain]]
name = "b"
distribution = "normal"
mean = 2
sd = 1

[[vary]]
name = "k"
values = [1, 2]

[[question]]
name = "low"
probability = "g < 0"
"#;

/// A directory with a study, its table computed by one machine in `one`, and a scratch directory.
struct World {
    folder: Folder,
    study: String,
}

impl World {
    fn of(folder: Folder, study: String) -> Self {
        let one = say(&["run", &study, "--out", &folder.name("one")]);
        assert_eq!(one.code, 0, "{}", one.err);
        Self { folder, study }
    }

    /// The lab rig: 12 transients.
    fn rig() -> Self {
        let folder = Folder::new();
        let study = folder.small_study();
        Self::of(folder, study)
    }

    fn function() -> Self {
        let folder = Folder::new();
        let study = folder.write("f.toml", FUNCTION);
        Self::of(folder, study)
    }

    fn args<'a>(&'a self, out: &'a str, shard: &'a str, scratch: &'a str, more: &[&'a str]) -> Vec<&'a str> {
        let own = ["run", &self.study, "--out", out, "--shard", shard, "--scratch", scratch, "--workers", "1"];
        [&own, more].concat()
    }

    /// Runs a shard until it ends.
    fn shard(&self, out: &str, shard: &str, more: &[&str]) -> Said {
        let (out, scratch) = (self.folder.name(out), self.folder.name("scratch"));
        say(&self.args(&out, shard, &scratch, more))
    }

    /// Starts a shard in which a fault does `what` at a state.
    fn disturbed(&self, out: &str, shard: &str, more: &[&str], fault: &str) -> (Child, std::path::PathBuf) {
        let (out, scratch) = (self.folder.name(out), self.folder.name("scratch"));
        let fired = tempfile::tempdir_in(self.folder.path("")).expect("a folder").keep();
        let mut command = bladeoff(&self.args(&out, shard, &scratch, more));
        command.env("BLADEOFF_FAULT", format!("{fault},dir={}", fired.display()));
        let child =
            command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        (child, fired)
    }

    fn merge(&self, out: &str) -> Said {
        say(&["merge", &self.folder.name(out)])
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Merges, and asserts that the table is byte for byte equal to that of one machine.
    fn merged_is_that_of_one_machine(&self, out: &str) -> Said {
        let merged = self.merge(out);
        assert_eq!(merged.code, 0, "{}", merged.err);
        assert!(self.bytes("one/results.parquet") == self.bytes(&format!("{out}/results.parquet")), "other bytes");
        assert!(
            !self.folder.path("scratch").exists()
                || fs::read_dir(self.folder.path("scratch")).expect("read").count() == 0
        );
        merged
    }

    fn chunk(&self, out: &str, number: u64) -> std::path::PathBuf {
        self.folder.path(&format!("{out}/chunks/000/chunk-{number:06}.bin"))
    }

    fn json(&self, out: &str) -> Value {
        let status = say(&["status", &self.folder.name(out), "--json"]);
        assert_eq!(status.code, 0, "{}", status.err);
        serde_json::from_str(&status.out).expect("JSON")
    }
}

fn fired(folder: &Path) -> usize {
    fs::read_dir(folder).map_or(0, Iterator::count)
}

#[test]
fn shards_make_the_table_of_one_machine_whatever_their_number_and_order() {
    let world = World::rig();
    for (out, chunk, shards) in
        [("a", "2", &["2/3", "0/3", "1/3"][..]), ("b", "5", &["0/1"]), ("c", "1", &["5/7", "0/2"])]
    {
        for shard in shards {
            let run = world.shard(out, shard, &["--chunk", chunk]);
            assert_eq!(run.code, 0, "{}", run.err);
        }
        let merged = world.merged_is_that_of_one_machine(out);
        assert!(merged.out.contains("small: 12 of 12 samples"), "{}", merged.out);
    }
    // The first shard computes all chunks, also those of the others; the other shards find nothing to do.
    let manifest: Value = serde_json::from_slice(&world.bytes("a/manifest.json")).expect("JSON");
    assert_eq!(manifest["shards"]["chunks"], 6);
    assert_eq!(manifest["shards"]["attempts"][0]["shard"], "2/3");
    assert_eq!(manifest["shards"]["attempts"][0]["samples"], 12);
    // A second merge changes nothing.
    let again = world.merge("a");
    assert!(again.code == 0 && again.err.contains("already merged"), "{}", again.err);
    // The merged directory can be used as any other.
    let replay = say(&["replay", &world.folder.name("a"), "--sample", "3"]);
    assert!(replay.code == 0 && replay.out.contains("bit for bit"), "{}{}", replay.out, replay.err);
}

#[test]
fn what_is_there_half_way_is_looked_at_as_ever_and_a_merge_says_what_is_missing() {
    let world = World::function();
    let run = world.shard("d", "0/4", &["--chunk", "10"]);
    assert_eq!(run.code, 0, "{}", run.err);
    for chunk in [3, 4, 11] {
        fs::remove_file(world.chunk("d", chunk)).expect("it was there");
    }
    let merged = world.merge("d");
    assert_eq!(merged.code, 5, "{}", merged.err);
    assert!(merged.err.contains("3 of 12 chunks are missing: 3-4, 11"), "{}", merged.err);
    assert!(!world.folder.path("d/results.parquet").exists());
    let out = world.folder.name("d");
    let status = say(&["status", &out]);
    assert!(
        status.out.contains("90 of 120 samples (75.0 %)") && status.out.contains("9 of 12 of 10 samples each"),
        "{}",
        status.out
    );
    let json = world.json("d");
    assert_eq!((&json["done"], &json["total"], &json["state"]), (&90.into(), &120.into(), &"ended".into()));
    let export = say(&["export", &out, "--csv"]);
    assert_eq!((export.code, export.out.lines().count()), (0, 91), "{}", export.err);
    assert!(export.err.contains("not merged"), "{}", export.err);
    let why = say(&["why", &out, "5"]);
    assert!(why.code == 0 && why.out.contains("computed by"), "{}{}", why.out, why.err);
    let why = say(&["why", &out, "35"]);
    assert!(why.code == 0 && why.out.contains("not finished"), "{}{}", why.out, why.err);
    // Answers use the points that are complete in both groups: samples 0 to 29 are points 0 to 14.
    let answer = say(&["answer", &out]);
    assert!(answer.code == 0 && answer.out.contains("15 of 60 points"), "{}{}", answer.out, answer.err);
    assert!(!world.folder.path("d/answers.json").exists());
    let gate = say(&["gate", &out, "--require", "P(g < 0) < 0.99"]);
    assert!([0, 5].contains(&gate.code), "{}{}", gate.out, gate.err);
    // The intermediate merges leave no temporary directories.
    let left = fs::read_dir(std::env::temp_dir()).expect("read").flatten();
    let ours = |name: String| name.starts_with("bladeoff-look-");
    let alive = |name: &str| {
        name.split('-').nth(2).and_then(|pid| pid.parse().ok()).is_some_and(|pid: u32| state(pid).is_some())
    };
    let left: Vec<String> = left
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| ours(name.clone()) && !alive(name))
        .collect();
    assert!(left.is_empty(), "{left:?}");
    // A run with another number of shards computes only the missing chunks.
    let rest = world.shard("d", "1/5", &[]);
    assert!(rest.code == 0 && rest.err.contains("3 of 12 chunks published here"), "{}", rest.err);
    world.merged_is_that_of_one_machine("d");
    assert!(world.bytes("one/answers.json") == world.bytes("d/answers.json"), "other answers");
    assert_eq!(world.json("d")["state"], "complete");
}

#[test]
fn a_killed_attempt_loses_an_unfinished_chunk_at_most_and_one_on_the_same_node_not_even_that() {
    let world = World::rig();
    // Chunks of 3 samples, in their order: the second chunk stays incomplete, because its last sample hangs.
    let (mut child, hangs) = world.disturbed("d", "0/1", &["--chunk", "3"], "who=worker,at=running,sample=5,do=hang");
    wait_until("the first chunk is there, the second hangs", || fired(&hangs) == 1 && world.chunk("d", 0).exists());
    child.kill().expect("it is there");
    assert_eq!(child.wait().expect("it ends").code(), None, "it was killed");
    assert_eq!(world.json("d")["state"], "running", "nobody can know yet that it is dead");
    assert!(!world.chunk("d", 1).exists());
    let replay = say(&["replay", &world.folder.name("d"), "--sample", "1"]);
    assert!(replay.code == 0 && replay.out.contains("bit for bit"), "{}{}", replay.out, replay.err);
    // The same shard ignores the hint of its killed predecessor and continues its record.
    let run = world.shard("d", "0/1", &[]);
    assert!(run.code == 0 && run.err.contains("of an earlier attempt on this node"), "{}", run.err);
    assert!(run.err.contains("3 of 4 chunks published here"), "{}", run.err);
    world.merged_is_that_of_one_machine("d");
    let manifest: Value = serde_json::from_slice(&world.bytes("d/manifest.json")).expect("JSON");
    assert_eq!(manifest["shards"]["attempts"].as_array().map(Vec::len), Some(2));
}

#[test]
fn an_attempt_that_comes_back_after_another_did_its_work_drops_its_own() {
    let world = World::rig();
    let (child, stops) = world.disturbed("d", "0/1", &["--chunk", "3"], "who=orchestrator,at=sent,sample=2,do=stop");
    wait_until("the orchestrator is stopped", || fired(&stops) == 1 && state(child.id()) == Some('T'));
    assert!(!world.chunk("d", 0).exists());
    let other = world.shard("d", "0/1", &[]);
    assert!(other.code == 0 && other.err.contains("4 of 4 chunks published here"), "{}", other.err);
    let before = fs::read(world.chunk("d", 0)).expect("there");
    assert!(signal(child.id(), "CONT"), "it is there");
    let Said { code, err, .. } = said(child.wait_with_output().expect("it ends"));
    assert_eq!(code, 0, "{err}");
    assert!(
        err.contains("chunk 0 was already published by another attempt")
            && err.contains("0 of 4 chunks published here; "),
        "{err}"
    );
    assert!(fs::read(world.chunk("d", 0)).expect("there") == before, "the first one stays");
    world.merged_is_that_of_one_machine("d");
}

#[test]
fn many_attempts_at_once_compute_every_sample_once_in_the_table() {
    let world = World::function();
    let (out, scratch) = (world.folder.name("d"), world.folder.name("scratch"));
    // The shards start at the same time, so that each finds no directory.
    let start = |shard: &str| {
        let mut command = bladeoff(&world.args(&out, shard, &scratch, &["--chunk", "7"]));
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts")
    };
    let all: Vec<Child> = ["0/3", "1/3", "2/3", "0/3", "0/2"].into_iter().map(start).collect();
    let ended: Vec<Output> = all.into_iter().map(|child| child.wait_with_output().expect("it ends")).collect();
    for output in ended {
        let Said { code, err, .. } = said(output);
        assert_eq!(code, 0, "{err}");
    }
    world.merged_is_that_of_one_machine("d");
    assert!(world.bytes("one/plan.json") == world.bytes("d/plan.json"));
}

#[test]
fn damaged_and_foreign_chunks_are_put_aside_and_computed_again() {
    let world = World::function();
    assert_eq!(world.shard("d", "0/1", &["--chunk", "10"]).code, 0);
    // One chunk with a changed bit, and one with the contents of another chunk.
    let mut bytes = fs::read(world.chunk("d", 2)).expect("there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(world.chunk("d", 2), bytes).expect("written");
    fs::copy(world.chunk("d", 6), world.chunk("d", 7)).expect("copied");
    let other = fs::read_to_string(world.folder.path("f.toml")).expect("there").replacen("seed = ", "seed = 1", 1);
    let (other, out) = (world.folder.write("other.toml", &other), world.folder.name("other"));
    assert_eq!(say(&["run", &other, "--out", &out, "--shard", "0/1", "--chunk", "10"]).code, 0);
    fs::copy(world.chunk("other", 5), world.chunk("d", 5)).expect("copied");
    fs::remove_file(world.chunk("d", 4)).expect("there");
    for (name, age) in [("results.parquet.0123abcd.tmp", 7200), ("results.parquet.0123abce.tmp", 0)] {
        let file = fs::File::create(world.folder.path("d").join(name)).expect("made");
        file.set_modified(SystemTime::now() - Duration::from_secs(age)).expect("dated");
    }
    // A path that is not a regular file.
    fs::remove_file(world.chunk("d", 9)).expect("there");
    fs::create_dir(world.chunk("d", 9)).expect("made");
    let verified = say(&["status", &world.folder.name("d"), "--verify"]);
    assert!(verified.code == 6 && verified.out.contains("chunk-000002.bin: damaged"), "{}", verified.out);
    let merged = world.merge("d");
    assert_eq!(merged.code, 5, "{}", merged.err);
    let told = merged.err.split("5 of 12 chunks are missing: 2, 4-5, 7, 9\n").nth(1).unwrap_or_default();
    for what in ["2 put aside, damaged: 2, 9 (", "1 put aside, of another", "1 put aside, with", "is 6, not 7"] {
        assert!(told.contains(what), "{what}: {}", merged.err);
    }
    assert!(!world.chunk("d", 2).exists() && !world.folder.path("d/results.parquet").exists());
    assert_eq!(world.shard("d", "0/1", &[]).code, 0);
    world.merged_is_that_of_one_machine("d");
    let is_there = |name: &str| world.folder.path("d").join(name).exists();
    assert!(!is_there("results.parquet.0123abcd.tmp") && is_there("results.parquet.0123abce.tmp"));
    let verified = say(&["status", &world.folder.name("d"), "--verify"]);
    assert!(verified.code == 0 && verified.out.contains("12 chunks are as written"), "{}", verified.out);
}

#[test]
fn nothing_is_begun_over_chunks_and_a_signal_ends_patience() {
    let world = World::function();
    assert_eq!(world.shard("d", "0/1", &["--chunk", "10"]).code, 0);
    // Without shards.json the study of the chunks is unknown: no new run starts in this directory.
    fs::rename(world.folder.path("d/shards.json"), world.folder.path("kept.json")).expect("moved");
    let lost = world.shard("d", "0/1", &[]);
    assert!(lost.code == 6 && lost.err.contains("missing although its chunks exist"), "{}: {}", lost.code, lost.err);
    fs::rename(world.folder.path("kept.json"), world.folder.path("d/shards.json")).expect("moved");
    // A missing chunk has to be computed; merging does not help.
    let absent = fs::read(world.chunk("d", 3)).expect("there");
    fs::remove_file(world.chunk("d", 3)).expect("there");
    let why = say(&["why", &world.folder.name("d"), "35"]);
    assert!(why.out.contains("--shard 0/1") && !why.out.contains(" merge "), "{}{}", why.out, why.err);
    fs::write(world.chunk("d", 3), absent).expect("back");
    // A path that is not a result directory is rejected before the new directory is made.
    let none = world.shard("new", "0/1", &["--reuse", &world.folder.name("nowhere")]);
    assert!(none.code == 3 && !world.folder.path("new").exists(), "{}: {}", none.code, none.err);
    // The chunk directory is inaccessible and the shard receives a signal: it ends before its ten minutes of retries are over.
    fs::remove_file(world.chunk("d", 0)).expect("it was there");
    fs::rename(world.folder.path("d/chunks"), world.folder.path("chunks")).expect("moved");
    fs::write(world.folder.path("d/chunks"), "none").expect("written");
    let (out, scratch) = (world.folder.name("d"), world.folder.name("scratch"));
    let words = world.folder.path("words");
    let mut command = bladeoff(&world.args(&out, "0/1", &scratch, &[]));
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(fs::File::create(&words).expect("made"));
    let mut child = command.spawn().expect("it starts");
    wait_until("it waits", || fs::read_to_string(&words).expect("read").contains("retrying for at most"));
    assert!(signal(child.id(), "TERM"), "it is there");
    let mut ended = None;
    wait_until("it ends", || {
        ended = child.try_wait().expect("a child");
        ended.is_some()
    });
    assert!(ended.is_some_and(|ended| !ended.success()), "{}", fs::read_to_string(&words).expect("read"));
}

#[test]
fn what_cannot_be_meant_is_refused_and_nothing_is_touched() {
    let world = World::function();
    assert_eq!(world.shard("d", "0/1", &["--chunk", "10"]).code, 0);
    let shards = world.bytes("d/shards.json");
    let refused = |code: i32, words: &str, run: Said| {
        assert_eq!(run.code, code, "{}", run.err);
        assert!(run.err.contains(words), "{words:?} is not in: {}", run.err);
    };
    refused(3, "--chunk: 10 -> 11", world.shard("d", "0/1", &["--chunk", "11"]));
    refused(3, "limit: null -> 20", world.shard("d", "0/1", &["--limit", "20"]));
    refused(2, "must be I/N", world.shard("d", "1/1", &[]));
    refused(2, "cannot be used with", world.shard("d", "0/1", &["--rerun", "failed"]));
    refused(2, "--out", say(&["run", &world.study, "--shard", "0/1"]));
    refused(3, "at most 65536", world.shard("e", "0/1", &["--chunk", "70000"]));
    refused(3, "study_blake3", {
        world.folder.write("f.toml", &FUNCTION.replace("mean = 3", "mean = 3.5"));
        world.shard("d", "0/1", &[])
    });
    refused(3, "holds shards", say(&["run", &world.study, "--out", &world.folder.name("d")]));
    world.folder.write("g/mine.txt", "mine");
    refused(3, "mine.txt", world.shard("g", "0/1", &[]));
    refused(3, "neither a directory of shards", say(&["merge", &world.folder.name("one")]));
    assert!(world.bytes("d/shards.json") == shards);
    // Write permission for everybody is rejected.
    let mode = |mode: u32| {
        fs::set_permissions(world.folder.path("d"), fs::Permissions::from_mode(mode)).expect("own");
    };
    world.folder.write("f.toml", FUNCTION);
    mode(0o777);
    refused(3, "--trust-dir", world.shard("d", "0/1", &[]));
    assert_eq!(world.shard("d", "0/1", &["--trust-dir"]).code, 0);
    refused(3, "--trust-dir", world.merge("d"));
    // Write permission for the group is usual on clusters: only a warning.
    if rustix::process::geteuid().is_root() {
        std::os::unix::fs::chown(world.folder.path("d"), None, Some(12_345)).expect("root may");
        mode(0o775);
        let said = world.shard("d", "0/1", &[]);
        assert!(said.code == 0 && said.err.contains("can be written by its group (mode 0775)"), "{}", said.err);
    }
    mode(0o755);
    world.merged_is_that_of_one_machine("d");
}

#[test]
fn a_shared_directory_that_is_away_is_waited_for_with_a_word_and_not_for_ever() {
    let world = World::function();
    assert_eq!(world.shard("d", "0/1", &["--chunk", "10"]).code, 0);
    fs::remove_file(world.chunk("d", 0)).expect("it was there");
    let (folder, aside) = (world.folder.path("d/chunks"), world.folder.path("d/chunks.aside"));
    fs::rename(&folder, &aside).expect("away");
    fs::write(&folder, "not to be entered").expect("in its place");
    let given_up = world.shard("d", "0/1", &["--patience", "1s"]);
    assert_eq!(given_up.code, 6, "{}", given_up.err);
    assert!(given_up.err.contains("retrying for at most") && given_up.err.contains("given up"), "{}", given_up.err);
    let (out, scratch) = (world.folder.name("d"), world.folder.name("scratch"));
    let words = world.folder.path("words");
    let mut command = bladeoff(&world.args(&out, "0/1", &scratch, &[]));
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(fs::File::create(&words).expect("made"));
    let mut child = command.spawn().expect("it starts");
    wait_until("it says that it waits", || fs::read_to_string(&words).expect("read").contains("retrying for at most"));
    fs::remove_file(&folder).expect("removed");
    fs::rename(&aside, &folder).expect("back");
    assert!(child.wait().expect("it ends").success(), "{}", fs::read_to_string(&words).expect("read"));
    assert!(fs::read_to_string(&words).expect("read").contains("is available again"));
    world.merged_is_that_of_one_machine("d");
}

#[test]
fn a_grown_study_takes_over_what_is_there_of_a_run_or_of_shards() {
    let world = World::rig();
    // One more value of friction: 12 of 18 samples are in the old results.
    let grown = crate::support::SMALL_STUDY
        .replace("count = 2", "values")
        .replace("from = 0.1\nto = 0.2\nvalues", "values = [0.1, 0.2, 0.15]");
    assert!(grown.contains("values = [0.1, 0.2, 0.15]"), "{grown}");
    assert_eq!(world.shard("old", "0/1", &["--chunk", "5"]).code, 0);
    let study = world.folder.write("small.toml", &grown);
    assert_eq!(say(&["run", &study, "--out", &world.folder.name("one")]).code, 0, "it goes on in the old directory");
    for (new, old) in [("by-shards", "old"), ("by-run", "two")] {
        if old == "two" {
            let study = world.folder.write("before.toml", crate::support::SMALL_STUDY);
            assert_eq!(say(&["run", &study, "--out", &world.folder.name("two")]).code, 0);
        }
        let old = world.folder.name(old);
        let run = world.shard(new, "0/1", &["--chunk", "6", "--reuse", &old]);
        assert!(run.code == 0 && run.err.contains("12 of 18 samples taken over"), "{}", run.err);
        assert!(run.err.contains("(1 chunk whole)"), "{}", run.err);
        assert!(run.err.contains("2 of 3 chunks published here"), "{}", run.err);
        world.merged_is_that_of_one_machine(new);
    }
    let none = world.shard("c", "0/1", &["--reuse", &world.folder.name("machines")]);
    assert!(none.code == 3 && none.err.contains("neither a directory of shards"), "{}", none.err);
}

/// A study with many points, in three of ten of which the event occurs.
fn stopping(stop: &str) -> World {
    let folder = Folder::new();
    let study = FUNCTION.replace("samples = 60", "samples = 20000").replace("mean = 3", "mean = 2.5");
    let study = folder.write("f.toml", &format!("{study}\n[stop]\n{stop}\n"));
    World::of(folder, study)
}

fn end(world: &World, out: &str) -> Value {
    let manifest: Value = serde_json::from_slice(&world.bytes(&format!("{out}/manifest.json"))).expect("JSON");
    assert_eq!(manifest["state"], "complete");
    manifest["stop"].clone()
}

#[test]
fn where_a_study_ends_by_its_precision_is_decided_at_merge_by_the_looks_of_one_machine() {
    let world = stopping("relative = \"15 %\"");
    let points = end(&world, "one")["points"].as_u64().expect("it ended early");
    assert!((512..20000).contains(&points), "{points}");
    let run = world.shard("d", "0/1", &["--chunk", "100"]);
    assert!(run.code == 0 && run.err.contains("`bladeoff merge` determines where [stop] ends"), "{}", run.err);
    // Only the chunks before the evaluation that ends the study count; without one of them there is no end.
    let last = 2 * points / 100;
    for chunk in last + 1..400 {
        fs::remove_file(world.chunk("d", chunk)).expect("it was there");
    }
    let aside = world.folder.path("aside");
    fs::rename(world.chunk("d", 3), &aside).expect("it was there");
    let merged = world.merge("d");
    assert!(merged.code == 5 && merged.err.contains("missing: 3"), "{}", merged.err);
    fs::rename(&aside, world.chunk("d", 3)).expect("back");
    let status = say(&["status", &world.folder.name("d")]);
    assert!(status.out.contains(&format!("the interim analysis of {points} points can be made")), "{}", status.out);
    let merged = world.merged_is_that_of_one_machine("d");
    assert!(merged.out.contains(&format!("precise enough at {points} of 20000 points")), "{}", merged.out);
    assert_eq!(end(&world, "d"), end(&world, "one"));
    assert!(world.bytes("one/answers.json") == world.bytes("d/answers.json"), "other answers");
    let more = world.shard("d", "0/1", &[]);
    assert!(more.code == 0 && more.err.contains("already merged, ended by [stop]"), "{}", more.err);
    assert!(world.merge("d").err.contains("already merged"));
}

#[test]
fn samples_of_stop_are_all_that_shards_compute_and_its_wall_ends_them() {
    let world = stopping("samples = 300");
    let run = world.shard("d", "0/1", &["--chunk", "100"]);
    assert!(run.code == 0 && run.err.contains("6 of 6 chunks published here"), "{}", run.err);
    world.merged_is_that_of_one_machine("d");
    assert_eq!(end(&world, "d")["why"], "samples");
    let world = stopping("relative = 1e-9\nwall = \"1 s\"");
    let run = world.shard("d", "0/1", &["--chunk", "2", "--wall", "1 h"]);
    assert!(run.code == 0 && run.err.contains("stop: "), "{}", run.err);
    let merged = world.merge("d");
    assert_eq!(merged.code, 0, "{}", merged.err);
    let found = end(&world, "d");
    assert!(["wall", "design"].contains(&found["why"].as_str().expect("a word")), "{found}");
    let rows = say(&["export", &world.folder.name("d"), "--csv"]).out.lines().count() as u64 - 1;
    assert_eq!(Some(rows), found["samples"].as_u64());
}
