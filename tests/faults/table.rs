//! Integrity of a finished table: any changed bit is detected before a row is read, and the table can be written again from the record.

use crate::running::{PAUSE, Running, STUDY};
use crate::support::{Folder, Said, say};
use bladeoff::run::{refuse_changed, refuse_changed_timings};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};

/// A complete result directory.
struct Complete {
    folder: Folder,
    study: String,
    out: String,
}

impl Complete {
    fn new() -> Self {
        let folder = Folder::new();
        let (study, out) = (folder.write("s.toml", STUDY), folder.name("out"));
        let complete = Self { folder, study, out };
        assert_eq!(complete.run().code, 0);
        complete
    }

    fn run(&self) -> Said {
        say(&["run", &self.study, "--out", &self.out, "--workers", "2"])
    }

    fn path(&self, name: &str) -> PathBuf {
        Path::new(&self.out).join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect(name)
    }

    /// Changes one bit of a file while `look` runs.
    fn with_bit_changed(&self, name: &str, at: usize, look: impl FnOnce()) {
        let whole = self.bytes(name);
        let mut changed = whole.clone();
        changed[at] ^= 1 << (at % 8);
        fs::write(self.path(name), changed).expect("written");
        look();
        fs::write(self.path(name), whole).expect("written");
    }

    fn told(&self, name: &str) -> Option<String> {
        let manifest: serde_json::Value = serde_json::from_slice(&self.bytes("manifest.json")).expect("JSON");
        manifest["tables"][name]["blake3"].as_str().map(str::to_owned)
    }
}

#[test]
fn any_changed_bit_of_a_table_is_found_before_a_row_is_read() {
    let complete = Complete::new();
    for name in ["results.parquet", "timings.parquet"] {
        let hash = blake3::hash(&complete.bytes(name)).to_hex().to_string();
        assert_eq!(complete.told(name), Some(hash), "as `b3sum` says");
    }
    assert!(refuse_changed(Path::new(&complete.out)).expect("whole"));
    // A sparse file of the size of a disk: detected by its length.
    let whole = complete.bytes("results.parquet");
    fs::File::options()
        .write(true)
        .open(complete.path("results.parquet"))
        .and_then(|file| file.set_len(1 << 33))
        .expect("sparse");
    assert!(refuse_changed(Path::new(&complete.out)).is_err());
    fs::write(complete.path("results.parquet"), whole).expect("written");
    for (name, looked) in [
        ("results.parquet", refuse_changed as fn(&Path) -> Result<bool, _>),
        ("timings.parquet", refuse_changed_timings),
    ] {
        let length = complete.bytes(name).len();
        let mut found = 0;
        for place in 0..400 {
            complete.with_bit_changed(name, place * (length - 1) / 399, || {
                found += usize::from(looked(Path::new(&complete.out)).is_err());
            });
        }
        assert_eq!(found, 400, "{name}");
    }
}

#[test]
fn a_changed_table_is_refused_by_all_that_read_it_and_made_again_by_run() {
    let complete = Complete::new();
    let out = complete.out.as_str();
    let whole = say(&["status", out, "--verify"]);
    assert_eq!(whole.code, 0, "{}", whole.out);
    for name in ["results.parquet", "timings.parquet", "study.toml", "machine.toml", "basis.bin", "plan.json"] {
        let line = whole.out.lines().find(|line| line.starts_with(&format!("{name} "))).expect(name);
        assert!(line.ends_with("as it was written"), "{line}");
    }
    assert!(whole.out.contains("all its 20 entries are whole"), "{}", whole.out);
    let results = complete.bytes("results.parquet");
    let middle = results.len() / 3;
    complete.with_bit_changed("results.parquet", middle, || {
        for command in [
            &["export", out, "--csv"][..],
            &["why", out, "3"],
            &["replay", out, "--sample", "3"],
            &["replay", out, "--worst", "max_bearing_load_N"],
        ] {
            let said = say(command);
            assert_eq!((said.code, said.out.as_str()), (6, ""), "{command:?}: {}", said.err);
            assert!(
                said.err.contains("results.parquet is damaged: it has changed since it was written"),
                "{}",
                said.err
            );
            assert!(said.err.contains("rewrites it from the record"), "{}", said.err);
        }
        let csv = complete.folder.path("t.csv");
        assert_eq!(say(&["export", out, "--csv", "--out", csv.to_str().expect("UTF-8")]).code, 6);
        assert!(!csv.exists());
        let said = say(&["status", out, "--verify"]);
        assert!(said.code == 6 && said.out.contains("damaged: not as it was written"), "{}", said.out);
        let said = say(&["status", out, "--verify", "--json"]);
        let told: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        assert_eq!((said.code, &told["verified"]["results.parquet"]["whole"]), (6, &false.into()));
        assert_eq!(told["verified"]["timings.parquet"]["whole"], true);
        assert_eq!(say(&["status", out]).code, 0, "only looked at when asked");
        let again = complete.run();
        assert!(again.code == 0 && again.err.contains("results.parquet is damaged"), "{}", again.err);
        assert!(again.err.contains("rewriting it from the record"), "{}", again.err);
        assert!(complete.bytes("results.parquet") == results);
        assert_eq!(say(&["export", out, "--csv"]).err, "");
        let quiet = complete.run();
        assert!(quiet.code == 0 && !quiet.err.contains("rewriting"), "{}", quiet.err);
    });
    // A bit in the footer, so that no part of the table can be read.
    complete.with_bit_changed("results.parquet", results.len() - 9, || {
        let again = complete.run();
        assert!(again.code == 0 && again.err.contains("rewriting it from the record"), "{}", again.err);
        assert!(complete.bytes("results.parquet") == results);
    });
    let timings = complete.bytes("timings.parquet");
    complete.with_bit_changed("timings.parquet", timings.len() / 3, || {
        let why = say(&["why", out, "3"]);
        assert!(why.code == 0 && why.out.contains("unknown: ") && why.out.contains("damaged"), "{}", why.out);
        let again = complete.run();
        assert!(again.err.contains("timings.parquet was missing or damaged"), "{}", again.err);
        assert!(complete.bytes("timings.parquet") == timings);
    });
}

#[test]
fn a_changed_copy_of_study_or_machine_is_refused_by_all_that_read_rows() {
    let complete = Complete::new();
    let out = complete.out.as_str();
    let page = complete.folder.path("page.html");
    for name in ["study.toml", "machine.toml"] {
        let text = String::from_utf8(complete.bytes(name)).expect("text");
        // the last letter of the machine's name, so that the file can still be read
        let start = text.find("name = \"").expect("has a name") + 8;
        let last = start + text[start..].find('"').expect("ends") - 1;
        complete.with_bit_changed(name, last, || {
            let page = page.to_str().expect("UTF-8");
            for command in [
                &["report", out, "--out", page][..],
                &["replay", out, "--sample", "3"],
                &["why", out, "3"],
                &["export", out, "--csv"],
            ] {
                let said = say(command);
                assert_eq!((said.code, said.out.as_str()), (6, ""), "{command:?}: {}", said.err);
                assert!(
                    said.err.contains(&format!("{name} is damaged: it has changed since it was written")),
                    "{}",
                    said.err
                );
            }
        });
        assert!(!page.exists());
        assert_eq!(say(&["why", out, "3"]).code, 0);
        // without a manifest the checksums in the table's metadata are used
        let manifest = complete.bytes("manifest.json");
        fs::remove_file(complete.path("manifest.json")).expect("removed");
        complete.with_bit_changed(name, last, || {
            let said = say(&["export", out, "--csv"]);
            assert!(said.code == 6 && said.err.contains(&format!("{name} is damaged")), "{} {}", said.code, said.err);
        });
        assert_eq!(say(&["export", out, "--csv"]).code, 0);
        fs::write(complete.path("manifest.json"), manifest).expect("written");
        // the next run reports the change and writes the copy again
        complete.with_bit_changed(name, last, || {
            let again = complete.run();
            let told = format!("{name} in {out} was changed after it was written");
            assert!(again.code == 0 && again.err.contains(&told), "{}", again.err);
            assert_eq!(complete.bytes(name), text.as_bytes());
        });
        assert!(!complete.run().err.contains("was changed"));
    }
}

#[test]
fn verify_looks_at_record_inputs_and_parts_as_well() {
    let complete = Complete::new();
    let damaged = |name: &str| {
        let said = say(&["status", &complete.out, "--verify"]);
        let line = said.out.lines().find(|line| line.starts_with(&format!("{name} "))).expect(name).to_owned();
        assert_eq!(said.code, 6, "{}", said.out);
        assert!(line.contains("damaged") || line.contains("cannot"), "{line}");
    };
    for name in ["study.toml", "machine.toml", "basis.bin", "plan.json"] {
        complete.with_bit_changed(name, complete.bytes(name).len() / 2, || damaged(name));
    }
    // The entries of the record are found by their magic number, and a byte after it is changed.
    let record = complete.bytes("ledger.redb");
    let mut changed = record.clone();
    let entries: Vec<usize> = (0..record.len() - 4).filter(|&at| record[at..].starts_with(b"bOfL")).collect();
    assert!(entries.len() >= 20);
    entries.iter().for_each(|at| changed[at + 40] ^= 1);
    fs::write(complete.path("ledger.redb"), changed).expect("written");
    damaged("ledger.redb");
    fs::write(complete.path("ledger.redb"), record).expect("written");
    // A study that is still running has partial tables.
    let out = complete.folder.name("parts");
    let long = complete.folder.write("long.toml", &STUDY.replace("count = 5", "count = 12"));
    let fault = format!("{PAUSE};who=orchestrator,at=parted,sample=1,do=kill");
    let mut run = Running::start_with(&complete.folder, &long, &out, &fault, &["--refresh", "200 ms"]);
    assert_eq!((run.end().signal(), run.fired()), (Some(9), 1), "{}", run.said());
    let said = say(&["status", &out, "--verify"]);
    assert!(
        said.code == 0 && said.out.contains("parts ") && said.out.contains("they have no checksum"),
        "{}",
        said.out
    );
    let part = Path::new(&out).join("parts/part-000001.parquet");
    let bytes = fs::read(&part).expect("a part");
    fs::write(&part, &bytes[..bytes.len() / 2]).expect("cut");
    assert_eq!(say(&["status", &out, "--verify"]).code, 6);
}

#[test]
fn a_table_without_a_checksum_is_made_again_and_said_to_be_unknown() {
    let complete = Complete::new();
    let (results, manifest) = (complete.bytes("results.parquet"), complete.bytes("manifest.json"));
    let mut old: serde_json::Value = serde_json::from_slice(&manifest).expect("JSON");
    old.as_object_mut().expect("an object").remove("tables");
    fs::write(complete.path("manifest.json"), old.to_string()).expect("written");
    let csv = say(&["export", &complete.out, "--csv"]);
    assert!(csv.code == 0 && csv.err.contains("cannot be verified"), "{}", csv.err);
    let said = say(&["status", &complete.out, "--verify"]);
    assert!(said.code == 0 && said.out.contains("unknown: manifest.json has no checksum of it"), "{}", said.out);
    let again = complete.run();
    assert!(again.code == 0 && again.err.contains("manifest.json has no checksum of it"), "{}", again.err);
    assert!(complete.bytes("results.parquet") == results && complete.told("results.parquet").is_some());
    let told: serde_json::Value = serde_json::from_slice(&complete.bytes("manifest.json")).expect("JSON");
    let before: serde_json::Value = serde_json::from_slice(&manifest).expect("JSON");
    assert_eq!(told, before, "whatever else it told stays");
    assert_eq!(told["program"]["numerics_version"], bladeoff_core::NUMERICS_VERSION);
    assert_eq!(told["program"]["exponential_revision"], bladeoff_core::engine::exponential::EXPONENTIAL_REVISION);
    assert!(told["program"]["commit"].as_str().is_some_and(|commit| !commit.is_empty()));
    // Killed after the tables were written and before the manifest that contains their checksums.
    let out = complete.folder.name("killed");
    let mut run =
        Running::start(&complete.folder, &complete.study, &out, "who=orchestrator,at=retiring,sample=0,do=kill");
    assert_eq!((run.end().signal(), run.fired()), (Some(9), 1), "{}", run.said());
    let last = say(&["run", &complete.study, "--out", &out]);
    assert!(last.code == 0 && last.err.contains("nothing to compute"), "{}", last.err);
    assert!(refuse_changed(Path::new(&out)).expect("whole"), "it has its checksum now");
}

/// The plan and the record contain the hash of the basis: a changed bit is reported as damage and not as the basis of another study.
#[test]
fn a_changed_basis_or_manifest_is_made_again_and_nothing_is_refused() {
    let complete = Complete::new();
    let table = complete.bytes("results.parquet");
    let basis = complete.bytes("basis.bin");
    for at in [basis.len() / 2, basis.len() - 9] {
        let mut changed = basis.clone();
        changed[at] ^= 1;
        fs::write(complete.path("basis.bin"), changed).expect("written");
        assert_eq!(say(&["status", &complete.out, "--verify"]).code, 6);
        let said = complete.run();
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(said.err.contains("basis.bin: it is damaged"), "{}", said.err);
        assert!(complete.bytes("basis.bin") == basis && complete.bytes("results.parquet") == table);
        assert_eq!(say(&["status", &complete.out, "--verify"]).code, 0);
    }
    let manifest = String::from_utf8(complete.bytes("manifest.json")).expect("text");
    let start = manifest.find("study_blake3").expect("a hash") + "study_blake3\": \"".len();
    for wrong in ["Z", if manifest[start..].starts_with('0') { "1" } else { "0" }] {
        let mut changed = manifest.clone();
        changed.replace_range(start..=start, wrong);
        fs::write(complete.path("manifest.json"), changed).expect("written");
        assert_eq!(say(&["status", &complete.out, "--verify"]).code, 6, "{wrong}");
        let said = complete.run();
        assert!(said.code == 0 && said.err.contains("manifest.json named other inputs"), "{}", said.err);
        assert_eq!(say(&["status", &complete.out, "--verify"]).code, 0, "{wrong}");
    }
}

/// A study with a question that has a curve.
const ASKED: &str = r#"schema = 1
name = "asked"
model = "function"
seed = 3

[function]
g = "a * 2"

[design]
kind = "monte-carlo"
samples = 200

[[uncertain]]
name = "a"
distribution = "normal"
mean = 3
sd = 1

[[question]]
name = "low"
probability = "g < 6"

[[question]]
name = "over"
exceedance = "g"
"#;

#[test]
fn verify_finds_any_changed_bit_of_answers_and_curves_and_answer_writes_them_anew() {
    let folder = Folder::new();
    let (study, out) = (folder.write("s.toml", ASKED), folder.name("out"));
    let run = say(&["run", &study, "--out", &out]);
    assert_eq!(run.code, 0, "{}", run.err);
    let whole = say(&["status", &out, "--verify"]);
    assert!(whole.code == 0, "{}{}", whole.out, whole.err);
    for name in ["answers.json", "answers/over.parquet"] {
        let line = whole.out.lines().find(|line| line.starts_with(name)).unwrap_or_default();
        assert!(line.ends_with("as it was written"), "{name}: {}", whole.out);
        let path = Path::new(&out).join(name);
        let bytes = fs::read(&path).expect(name);
        for place in 0..20 {
            let mut changed = bytes.clone();
            changed[place * (bytes.len() - 1) / 19] ^= 1 << (place % 8);
            fs::write(&path, &changed).expect("written");
            let verified = say(&["status", &out, "--verify"]);
            let line = verified.out.lines().find(|line| line.starts_with(name)).unwrap_or_default();
            assert!(verified.code == 6 && line.contains("damaged"), "{name}: {}{}", verified.out, verified.err);
        }
        assert_eq!(say(&["answer", &out]).code, 0);
        assert!(fs::read(&path).expect("there") == bytes, "{name}: written anew");
        assert_eq!(say(&["status", &out, "--verify"]).code, 0);
        fs::remove_file(&path).expect("there");
        let gone = say(&["status", &out, "--verify"]);
        assert!(gone.code == 6 && gone.out.contains("missing"), "{name}: {}", gone.out);
        assert_eq!(say(&["answer", &out]).code, 0);
    }
    // `b3sum --check` reads the file; lines with other names are damage
    let sums = Path::new(&out).join("answers.b3sum");
    let text = fs::read_to_string(&sums).expect("text");
    let hash = blake3::hash(&fs::read(Path::new(&out).join("answers.json")).expect("there")).to_hex().to_string();
    assert!(text.starts_with(&format!("{hash}  answers.json\n")), "{text}");
    for odd in ["", "x", "../s.toml", "\u{0}"] {
        fs::write(&sums, format!("{hash}  {odd}\n{text}")).expect("written");
        let verified = say(&["status", &out, "--verify"]);
        assert!(
            verified.code == 6 && verified.out.contains("answers.b3sum"),
            "{odd}: {}{}",
            verified.out,
            verified.err
        );
    }
    // without a line for the answers their checksum is unknown
    fs::write(&sums, "").expect("written");
    let empty = say(&["status", &out, "--verify"]);
    assert!(empty.code == 6 && empty.out.contains("it has no line of answers.json"), "{}", empty.out);
    fs::remove_file(&sums).expect("there");
    let unknown = say(&["status", &out, "--verify"]);
    assert!(unknown.code == 0 && unknown.out.contains("answers.b3sum has no checksum of it"), "{}", unknown.out);
}

#[test]
fn a_manifest_that_is_no_object_is_no_panic() {
    let complete = Complete::new();
    for text in ["[]", "3", "\"x\"", "null", "[{}]", "{\"provenance\": []}", "{\"tables\": 3}"] {
        fs::write(complete.path("manifest.json"), text).expect("written");
        for args in
            [&["status", &complete.out, "--verify"][..], &["status", &complete.out], &["why", &complete.out, "3"]]
        {
            let said = say(args);
            let is_damaged = args.contains(&"--verify") && !text.starts_with("{\"");
            assert_eq!(said.code, if is_damaged { 6 } else { 0 }, "{text}: {args:?}: {}", said.err);
            assert_eq!(said.out.contains("it is no JSON object"), is_damaged, "{text}: {args:?}: {}", said.out);
        }
    }
    assert_eq!(complete.run().code, 0);
}
