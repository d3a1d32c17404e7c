//! Faults of shared directories and file systems: no locks, damaged or missing published files, chunks of any length, remains of killed merges. No
//! finished sample is lost, and the message names the file and the remedy.

use crate::support::{Folder, Said, bladeoff, root, said, say};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A directory of shards of the small study, complete and not merged, in chunks of 3 samples.
struct Shards {
    folder: Folder,
    study: String,
    out: String,
}

impl Shards {
    fn new() -> Self {
        let folder = Folder::new();
        let (study, out) = (folder.small_study(), folder.name("out"));
        let shards = Self { folder, study, out };
        let run = shards.shard();
        assert_eq!(run.code, 0, "{}", run.err);
        assert_eq!(shards.chunks(), 4);
        shards
    }

    fn shard(&self) -> Said {
        let scratch = self.folder.name("scratch");
        say(&["run", &self.study, "--out", &self.out, "--shard", "0/1", "--chunk", "3", "--scratch", &scratch])
    }

    fn merge(&self) -> Said {
        say(&["merge", &self.out])
    }

    fn path(&self, name: &str) -> PathBuf {
        Path::new(&self.out).join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect(name)
    }

    /// Number of chunks that have their final name.
    fn chunks(&self) -> usize {
        (0..4).filter(|chunk| self.path(&format!("chunks/000/chunk-{chunk:06}.bin")).exists()).count()
    }
}

/// The bytes with one bit of the middle byte changed; in text, one digit.
fn flipped(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let middle = bytes.len() / 2;
    match bytes.iter().skip(middle).position(u8::is_ascii_digit).filter(|_| bytes.is_ascii()) {
        Some(digit) => bytes[middle + digit] ^= 1,
        None => bytes[middle] ^= 4,
    }
    bytes
}

#[test]
fn a_damaged_or_missing_published_file_is_named_and_restored_byte_for_byte() {
    let shards = Shards::new();
    for name in ["basis.bin", "plan.json", "machine.toml", "study.toml"] {
        let whole = shards.bytes(name);
        let damage = |is_missing: bool| match is_missing {
            true => fs::remove_file(shards.path(name)).expect("removed"),
            false => fs::write(shards.path(name), flipped(&whole)).expect("written"),
        };
        for is_missing in [false, true] {
            damage(is_missing);
            let verified = say(&["status", &shards.out, "--verify"]);
            let what = if is_missing { "it is missing" } else { "it is damaged" };
            assert_eq!(verified.code, 6, "{name}: {}{}", verified.out, verified.err);
            assert!(verified.err.contains(name) && verified.err.contains(what), "{name}: {}", verified.err);
            assert!(verified.err.contains("copy the file from another copy"), "{name}: {}", verified.err);
            assert!(
                !verified.err.contains("grown") && !verified.err.contains("remove the directory"),
                "{}",
                verified.err
            );
            let run = shards.shard();
            assert!(run.code == 0 && run.err.contains("is restored"), "{name}: {}", run.err);
            assert!(shards.bytes(name) == whole, "{name}");
            damage(is_missing);
            let merged = shards.merge();
            assert!(merged.code == 0 && merged.err.contains("is restored"), "{name}: {}", merged.err);
            assert!(shards.bytes(name) == whole, "{name}");
            fs::remove_file(shards.path("results.parquet")).expect("merged");
        }
    }
    // the study file has changed since: the copy cannot be restored from it, and no sample is lost
    let whole = shards.bytes("study.toml");
    fs::write(shards.path("study.toml"), flipped(&whole)).expect("written");
    let study = fs::read_to_string(&shards.study).expect("text");
    fs::write(&shards.study, study.replace("\"0.9 mm\"", "\"0.8 mm\"")).expect("written");
    for refused in [shards.shard(), shards.merge()] {
        assert!(refused.code == 6 && refused.err.contains("study.toml"), "{}: {}", refused.code, refused.err);
        assert!(refused.err.contains("no finished sample is lost"), "{}", refused.err);
    }
    // the copy is correct again: the directory then belongs to a study other than the changed one
    fs::write(shards.path("study.toml"), whole).expect("written");
    let other = shards.shard();
    assert!(other.code == 3 && other.err.contains("was begun with another study"), "{}: {}", other.code, other.err);
    assert_eq!(shards.chunks(), 4);
}

#[test]
fn a_damaged_list_of_shards_puts_no_chunk_aside() {
    let shards = Shards::new();
    let whole = String::from_utf8(shards.bytes("shards.json")).expect("text");
    let said: serde_json::Value = serde_json::from_str(&whole).expect("JSON");
    let digest = said["samples_blake3"].as_str().expect("a hash").to_owned();
    let basis = said["provenance"]["basis_blake3"].as_str().expect("a hash").to_owned();
    let hash = |key: &str| said["provenance"][key].as_str().expect("a hash").to_owned();
    let other = |hash: &str| format!("{}{}", if hash.starts_with('a') { 'b' } else { 'a' }, &hash[1..]);
    for changed in [
        whole.replace("small.toml", "smell.toml"),
        whole.replace(&digest, &other(&digest)),
        whole.replace(&basis, &other(&basis)),
        whole.replace("\"samples\": \"12\"", "\"samples\": \"13\""),
        whole.replace("\"chunk\": 3", "\"chunk\": 4"),
        whole.replace(&hash("study_blake3"), &other(&hash("study_blake3"))),
        whole.replace(&hash("plan_blake3"), &other(&hash("plan_blake3"))),
        whole.replace("\"checksum\": \"", "\"checksum\": \"x"),
    ] {
        assert_ne!(changed, whole);
        fs::write(shards.path("shards.json"), &changed).expect("written");
        let merged = shards.merge();
        let run = say(&["run", &shards.study, "--out", &shards.out, "--shard", "0/1"]);
        let status = |more: &[&str]| say(&[&["status", shards.out.as_str()], more].concat());
        let expected = format!(
            "error: {}/shards.json: it is damaged: its contents do not have the recorded checksum; no finished sample is lost; copy \
             shards.json from another copy of this directory, or compute the study in a new directory (--out NEW)\n",
            shards.out
        );
        for said in [merged, run, status(&["--verify"]), status(&[])] {
            assert!(said.code == 6 && said.err.ends_with(&expected), "{changed}: {}: {}", said.code, said.err);
        }
        assert_eq!(shards.chunks(), 4, "{changed}");
    }
    fs::write(shards.path("shards.json"), &whole).expect("written");
    assert_eq!(shards.merge().code, 0);
}

#[test]
fn a_list_of_shards_without_a_checksum_is_damaged_and_puts_no_chunk_aside() {
    let shards = Shards::new();
    let whole = String::from_utf8(shards.bytes("shards.json")).expect("text");
    let mut fields: serde_json::Value = serde_json::from_str(&whole).expect("JSON");
    fields.as_object_mut().expect("an object").remove("checksum").expect("there");
    fs::write(shards.path("shards.json"), fields.to_string()).expect("written");
    let merged = shards.merge();
    let expected = "shards.json: it is damaged: it has no checksum; no finished sample is lost";
    assert!(merged.code == 6 && merged.err.contains(expected), "{}", merged.err);
    assert_eq!(shards.chunks(), 4);
    // The list of another run of the study, valid in itself: the chunks name the list to which they belong.
    fields["study_file"] = "smell.toml".into();
    let checksum = blake3::hash(fields.to_string().as_bytes()).to_hex().to_string();
    fields["checksum"] = checksum.into();
    fs::write(shards.path("shards.json"), fields.to_string()).expect("written");
    let merged = shards.merge();
    let expected = "shards.json: it has changed since the chunks were made";
    assert!(merged.code == 6 && merged.err.contains(expected), "{}", merged.err);
    assert_eq!(shards.chunks(), 4);
}

/// Seed and number of samples are also in the metadata of the table.
#[test]
fn a_manifest_that_contradicts_its_table_is_reported() {
    let folder = Folder::new();
    let (study, out) = (folder.small_study(), folder.name("out"));
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let manifest = folder.path("out/manifest.json");
    let whole = fs::read_to_string(&manifest).expect("text");
    for (from, to, message) in [
        ("\"seed\": \"7\"", "\"seed\": \"8\"", "its seed is \"8\", that of results.parquet is \"7\""),
        ("\"samples\": \"12\"", "\"samples\": \"13\"", "its samples is \"13\", that of results.parquet is \"12\""),
        ("\"samples\": 12", "\"samples\": 120", "its samples is \"120\", that of results.parquet is \"12\""),
        (
            "\"study\": \"small\"",
            "\"study\": \"smell\"",
            "its study is \"smell\", that of results.parquet is \"small\"",
        ),
        ("\"numerics_version\": \"", "\"numerics_version\": \"1", "its numerics_version is"),
    ] {
        let changed = whole.replace(from, to);
        assert_ne!(changed, whole, "{from} is in {whole}");
        fs::write(&manifest, changed).expect("written");
        let status = say(&["status", &out, "--verify"]);
        assert_eq!(status.code, 6, "{}", status.out);
        let line = status.out.lines().find(|line| line.starts_with("manifest.json")).unwrap_or_default();
        assert!(line.contains("damaged: ") && line.contains(message), "{to}: {}", status.out);
        // the next run writes the manifest again
        assert_eq!(say(&["run", &study, "--out", &out]).code, 0, "{to}");
        let status = say(&["status", &out, "--verify"]);
        assert_eq!(status.code, 0, "{to}: {}", status.out);
    }
}

#[test]
fn a_chunk_that_is_too_long_is_put_aside_and_computed_again() {
    let shards = Shards::new();
    let chunk = shards.path("chunks/000/chunk-000001.bin");
    let whole = fs::read(&chunk).expect("there");
    fs::File::options().write(true).open(&chunk).and_then(|file| file.set_len(1 << 40)).expect("sparse");
    let merged = shards.merge();
    assert!(merged.code == 5 && merged.err.contains("1 put aside, damaged: 1"), "{}: {}", merged.code, merged.err);
    let run = shards.shard();
    assert!(run.code == 0 && run.err.contains("1 of 4 chunks published here"), "{}", run.err);
    // the chunk contains measured times, whose number of digits varies
    assert!(fs::read(&chunk).expect("there").len().abs_diff(whole.len()) < whole.len() / 10);
    assert_eq!(shards.merge().code, 0);
}

#[test]
fn what_killed_merges_of_this_system_leave_goes_with_the_next_one() {
    let shards = Shards::new();
    let start = fs::read_to_string("/proc/sys/kernel/random/boot_id").expect("Linux has it");
    let container = fs::read_link("/proc/self/ns/pid").expect("Linux has it");
    let system = format!("{} {}", start.trim(), container.display());
    // a process that has ended, and a live process whose start time differs from the recorded one
    let mut child = Command::new("true").spawn().expect("it starts");
    let dead = child.id();
    child.wait().expect("it ends");
    let note = |system: &str, pid: u32, tables: &[&str]| {
        serde_json::json!({ "system": system, "pid": pid, "began": 1, "tables": tables }).to_string()
    };
    let (ours, alive, far) =
        ("results.parquet.00000001.tmp", "timings.parquet.00000002.tmp", "results.parquet.00000003.tmp");
    for (name, text) in [
        (ours, "begun".to_owned()),
        (alive, "begun".to_owned()),
        (far, "begun".to_owned()),
        ("merge.0000000a.tmp", note(&system, dead, &[ours, "machine.toml", "../small.toml"])),
        ("merge.0000000b.tmp", note(&system, std::process::id(), &[alive])),
        ("merge.0000000c.tmp", note("another system", dead, &[far])),
    ] {
        fs::write(shards.path(name), text).expect("written");
    }
    assert_eq!(shards.merge().code, 0);
    let there = |name: &str| shards.path(name).exists();
    assert!(!there(ours) && !there(alive), "their processes are gone");
    assert!(there(far) && there("machine.toml") && Path::new(&shards.study).exists());
    assert!(!there("merge.0000000a.tmp") && there("merge.0000000c.tmp"));
    // a merge without work removes the remains, too
    fs::write(shards.path(ours), "begun").expect("written");
    fs::write(shards.path("merge.0000000a.tmp"), note(&system, dead, &[ours])).expect("written");
    let again = shards.merge();
    assert!(again.code == 0 && again.err.contains("already merged"), "{}", again.err);
    assert!(!there(ours));
}

/// Compiles the library that makes lock calls fail.
fn no_locks(folder: &Folder) -> String {
    let library = folder.name("no_locks.so");
    let source = root().join("tests/program/no_locks.c");
    let compiled = Command::new("cc").args(["-shared", "-fPIC", "-o", &library]).arg(source).arg("-ldl").status();
    assert!(compiled.expect("a C compiler, which the build needs as well").success());
    library
}

#[test]
fn a_file_system_without_locks_is_named_and_the_printed_way_out_works() {
    let folder = Folder::new();
    let (study, library) = (folder.small_study(), no_locks(&folder));
    fs::create_dir(folder.path("shared")).expect("made");
    let shared = fs::canonicalize(folder.path("shared")).expect("there");
    let without_locks = |error: i32, args: &[&str]| {
        let mut command = bladeoff(args);
        command.env("LD_PRELOAD", &library).env("NO_LOCKS_BELOW", &shared).env("NO_LOCKS_ERROR", error.to_string());
        said(command.output().expect("it starts"))
    };
    let out = shared.join("out").to_str().expect("UTF-8").to_owned();
    // ENOLCK, ENOSYS, EOPNOTSUPP, the error 524 of NFS, EBADF
    for error in [37, 38, 95, 524, 9] {
        let run = without_locks(error, &["run", &study, "--out", &out]);
        assert_eq!(run.code, 6, "{}", run.err);
        for words in ["grants no locks", "local disk", "run STUDY --shard 0/1 --scratch LOCAL", "bladeoff merge"] {
            assert!(run.err.contains(words), "{error}: {words}: {}", run.err);
        }
        assert!(run.err.contains(&format!("os error {error}")) && !run.err.contains("Unknown error"), "{}", run.err);
        fs::remove_dir_all(&out).expect("begun");
    }
    let scratch = folder.name("local");
    let shard = without_locks(37, &["run", &study, "--out", &out, "--shard", "0/1", "--scratch", &scratch]);
    assert_eq!(shard.code, 0, "{}", shard.err);
    let merged = without_locks(37, &["merge", &out]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    // the alternative: computed on a local disk and copied
    let local = folder.name("elsewhere");
    assert_eq!(say(&["run", &study, "--out", &local]).code, 0);
    let copy = shared.join("copy").to_str().expect("UTF-8").to_owned();
    assert!(Command::new("cp").args(["-r", &local, &copy]).status().expect("cp").success());
    for args in [&["status", &copy, "--verify"][..], &["why", &copy, "3"], &["export", &copy, "--csv"]] {
        let looked = without_locks(37, args);
        assert_eq!(looked.code, 0, "{args:?}: {}", looked.err);
    }
}
