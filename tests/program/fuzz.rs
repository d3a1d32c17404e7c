//! Arbitrary input gives an error, never a panic, a hang or a huge allocation. Valid files with pieces changed, duplicated, moved and cut,
//! and random bytes. The documented long run is `PROPTEST_CASES=25000 cargo test --release --test program fuzz` (four times that many
//! cases); without the variable every test takes 500. Memory and time of every case are bounded. Messages are in
//! `worker/protocol/tests/messages.rs`.

use crate::cap::{self, case};
use crate::support::{Folder, say};
use bladeoff::cli::{status_text, why_text};
use bladeoff::run::{own_columns, rehearsal};
use bladeoff_answers::tables::{Table, Timing, TimingsWriter, count_sound_rows};
use bladeoff_core::modal::Basis;
use bladeoff_model::machine::MachineDef;
use bladeoff_study::{Samples, load, parse_duration, parse_memory};
use bladeoff_system::files::Pending;
use bladeoff_worker::core_solver::CoreSolver;
use bladeoff_worker::function_solver::FunctionSolver;
use bladeoff_worker::job_spec::{BASIS_FILE, JobSpec, PLAN_FILE};
use proptest::prelude::*;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

/// Largest memory of a case \[bytes\].
pub const MOST: usize = 256 << 20;

/// Valid and invalid pieces of files.
const PIECES: [&str; 41] = [
    "[[vary]]\n",
    "[set]\n",
    "[points]\n",
    "path = ",
    "\"contact.gap\"",
    "values = [",
    "]",
    "count = 1000000\n",
    "from = 0.1\n",
    "to = 1e308\n",
    "spacing = \"log\"\n",
    "zip = \"a\"\n",
    "-1",
    "1e400",
    "nan",
    "inf",
    "\"0.5 mm\"",
    "\"1e-320 m\"",
    "99999999999999999999",
    "0x7fffffffffffffff",
    "\u{0}",
    "\u{feff}",
    "\"\"\"",
    "=",
    "\n",
    "{",
    "[",
    "nodes = 100000\n",
    ",,,",
    "\"\\u0000\"",
    "null",
    "1e999",
    "18446744073709551616",
    "-0.0",
    "{}",
    "\"complete\"",
    "sep=;\n",
    ";",
    "0,4",
    "carry = [\"id\"]\n",
    "ignore = [\"weight\", \"\"]\n",
];

#[derive(Debug, Clone)]
enum Change {
    Remove(prop::sample::Index, usize),
    Insert(prop::sample::Index, usize),
    Byte(prop::sample::Index, u8),
    Copy(prop::sample::Index, prop::sample::Index, usize),
    Cut(prop::sample::Index),
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let index = any::<prop::sample::Index>;
    let change = prop_oneof![
        1 => (index(), 1..40_usize).prop_map(|(at, n)| Change::Remove(at, n)),
        4 => (index(), 0..PIECES.len()).prop_map(|(at, piece)| Change::Insert(at, piece)),
        2 => (index(), any::<u8>()).prop_map(|(at, byte)| Change::Byte(at, byte)),
        1 => (index(), index(), 1..60_usize).prop_map(|(from, to, n)| Change::Copy(from, to, n)),
        1 => index().prop_map(Change::Cut),
    ];
    prop::collection::vec(change, 1..6)
}

fn changed(bytes: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for change in changes {
        let length = bytes.len();
        let place = |at: &prop::sample::Index| at.index(length + 1);
        match change {
            Change::Remove(at, n) => drop(bytes.drain(place(at)..(place(at) + n).min(length))),
            Change::Insert(at, piece) => drop(bytes.splice(place(at)..place(at), PIECES[*piece].bytes())),
            Change::Byte(at, byte) if length > 0 => bytes[at.index(length)] = *byte,
            Change::Byte(..) => {}
            Change::Copy(from, to, n) => {
                let piece = bytes[place(from)..(place(from) + n).min(length)].to_vec();
                drop(bytes.splice(place(to)..place(to), piece));
            }
            Change::Cut(at) => bytes.truncate(place(at)),
        }
    }
    bytes
}

/// A changed file, or random bytes.
pub fn mutant(bytes: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        8 => changes().prop_map(move |changes| changed(&bytes, &changes)),
        1 => prop::collection::vec(any::<u8>(), 0..400),
        1 => prop::collection::vec(0..PIECES.len(), 0..60)
            .prop_map(|all| all.into_iter().flat_map(|piece| PIECES[piece].bytes()).collect()),
    ]
}

pub fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(500);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn rig() -> String {
    fs::read_to_string(crate::support::root().join("studies/machines/lab_rig.toml")).expect("the lab rig")
}

const STUDY: &str = "schema = 1\nname = \"f\"\nmachine = \"m.toml\"\nseed = 3\n[limits]\nmax_failed = \"5 %\"\n\
    time_limit = \"10 min\"\nmemory_limit = \"2 GB\"\ncrash_limit = 3\n[set]\n\"run.end_time\" = \"0.1 s\"\n[points]\nfile = \"p.csv\"\ncarry = [\"id\", \"weight\"]\n\
    [[vary]]\npath = \"blade_off.mass\"\nfrom = \"3 g\"\nto = \"10 g\"\ncount = 8\nspacing = \"log\"\n\
    [[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp1\", \"hyp2\"]\n";
const FUNCTION: &str = "schema = 1\nmodel = \"function\"\n[function]\ng = \"max(x, 2 mm)^2 - ln(y) / d\"\nh = \"x + 1\"\n\
    [[uncertain]]\nname = \"x\"\ndistribution = \"normal\"\nmean = 1\nsd = 0.5\nlower = 0\n[design]\nkind = \"sobol\"\nsamples = 32\n\
    [[vary]]\nname = \"y\"\nvalues = [1, 2.5]\n[[derived]]\nname = \"d\"\nformula = \"x - 1\"\n";
const POINTS: &str = "contact.gap, id, contact.friction, weight\n# a remark\n0.4 mm, a, 0.1, 1\n\n0.7 mm, b, 0.25, 2\n1e-3, c, 0.3, 0.5\n";

/// A folder with a complete study, in which files are replaced.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        let files = Self(tempfile::tempdir().expect("temporary directory"));
        [("s.toml", STUDY), ("m.toml", &rig()), ("p.csv", POINTS)]
            .iter()
            .for_each(|(name, text)| files.put(name, text.as_bytes()));
        files
    }
    fn put(&self, name: &str, bytes: &[u8]) {
        fs::write(self.0.path().join(name), bytes).expect("written");
    }
    /// Loads the study and, if it is valid, its first and last sample.
    fn load(&self) {
        let Ok(study) = load(&self.0.path().join("s.toml"), own_columns) else { return };
        let Ok(samples) = Samples::new(study, None, None) else { return };
        for sample in [0, samples.count().saturating_sub(1)].into_iter().take(samples.count().min(2) as usize) {
            assert_eq!(samples.values(sample).len(), samples.parameters().len());
            assert_eq!(samples.cells(sample).len(), samples.columns().len());
            if let Ok(Some(machine)) = samples.try_machine(sample) {
                let _ = machine.build();
            }
            if let Some(model) = samples.study().function() {
                let mut params = Vec::new();
                samples.params(sample, &mut params);
                model.outputs.iter().for_each(|output| {
                    let _ = output.program.value(|number| params[number], &mut Vec::new());
                });
            }
        }
    }
}

#[test]
fn what_is_changed_is_valid_at_first() {
    let files = Files::new();
    let study = load(&files.0.path().join("s.toml"), own_columns).expect("valid");
    assert_eq!(Samples::new(study, None, None).expect("small").count(), 3 * 8 * 2);
    files.put("s.toml", FUNCTION.as_bytes());
    let study = load(&files.0.path().join("s.toml"), own_columns).expect("valid");
    assert!(study.function().is_some());
    assert_eq!(Samples::new(study, None, None).expect("small").count(), 32 * 2);
}

#[test]
fn any_study_is_read_or_refused() {
    let files = Files::new();
    proptest!(config(), |(bytes in prop_oneof![mutant(STUDY.into()), mutant(FUNCTION.into())])| {
        files.put("s.toml", &bytes);
        case(MOST, || files.load());
    });
    println!("{}", cap::figures());
}

#[test]
fn any_points_are_read_or_refused() {
    let files = Files::new();
    proptest!(config(), |(bytes in mutant(POINTS.into()))| {
        files.put("p.csv", &bytes);
        case(MOST, || files.load());
    });
    println!("{}", cap::figures());
}

#[test]
fn any_machine_is_built_or_refused() {
    proptest!(config(), |(bytes in mutant(rig().into()))| {
        case(MOST, || {
            if let Ok(text) = String::from_utf8(bytes)
                && let Ok(machine) = MachineDef::parse("m.toml", &text)
            {
                let _ = machine.build();
                let _ = machine.paths().len();
            }
        });
    });
    println!("{}", cap::figures());
}

/// A complete result directory, and a study that was changed afterwards.
struct Directory {
    folder: Folder,
    out: PathBuf,
    changed: Samples,
}

/// Files of it that the program reads, except the record (cut and changed at any byte in `tests/faults/resume.rs`).
const READ_BACK: [&str; 9] = [
    "status.json",
    "manifest.json",
    PLAN_FILE,
    BASIS_FILE,
    "study.toml",
    "machine.toml",
    "points.csv",
    "run.lock",
    "workers.log",
];

impl Directory {
    fn new() -> Self {
        let folder = Folder::new();
        folder.write("p.csv", POINTS);
        let text = "schema = 1\nname = \"d\"\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.002 s\"\n\
                    [points]\nfile = \"p.csv\"\nignore = [\"id\"]\ncarry = [\"weight\"]\n[[vary]]\npath = \"blade_off.mass\"\nvalues = [\"3 g\", \"5 g\"]\n";
        let study = folder.write("s.toml", text);
        let out = folder.name("out");
        let said = say(&["run", &study, "--out", &out, "--workers", "1"]);
        assert_eq!(said.code, 0, "{}", said.err);
        // lock file of a killed run, so that it is read
        fs::write(folder.path("out/run.lock"), "{\"host\":\"h\",\"pid\":1,\"started\":\"2026\"}\n").expect("written");
        let study = folder.write("changed.toml", &text.replace("0.002 s", "0.003 s"));
        let changed = Samples::new(load(study.as_ref(), own_columns).expect("a study"), None, None).expect("small");
        Self { out: folder.path("out"), folder, changed }
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.out.join(name)).expect("there")
    }

    /// Calls every function that reads one of these files.
    fn look(&self, name: &str, bytes: &[u8]) {
        let _ = status_text(&self.out, false);
        let _ = status_text(&self.out, true);
        match name {
            PLAN_FILE => {
                // with its own hash, so that it is parsed instead of rejected by its hash
                let hash = blake3::hash(bytes).to_hex().to_string();
                match JobSpec::read(&self.out, &hash) {
                    Ok(JobSpec::Machine(job)) => {
                        let _ = CoreSolver::new(&job).map(|solver| solver.parameter_columns().count());
                    }
                    Ok(JobSpec::Function(job)) => drop(FunctionSolver::new(&job)),
                    Err(_) => {}
                }
            }
            BASIS_FILE => drop(Basis::from_bytes(bytes)),
            "study.toml" | "machine.toml" | "points.csv" => {
                let _ = why_text(&self.out, 3);
                assert!(rehearsal::time_resume(&self.out, &self.changed).is_err(), "a changed study is refused");
            }
            _ => drop(why_text(&self.out, 3)),
        }
    }

    /// Whether every function that reads this file returns for `bytes` in place of the `whole` content.
    fn withstands(&self, name: &str, whole: &[u8], bytes: &[u8]) -> bool {
        fs::write(self.out.join(name), bytes).expect("written");
        let looked = catch_unwind(AssertUnwindSafe(|| case(MOST, || self.look(name, bytes))));
        fs::write(self.out.join(name), whole).expect("written");
        looked.is_ok()
    }
}

/// Each key of status and manifest with each of these values: random changes of the text rarely give valid JSON.
#[test]
fn any_value_of_status_or_manifest_is_read_or_refused() {
    let directory = Directory::new();
    let keys = [
        "total",
        "done",
        "reused",
        "left_from_s",
        "left_to_s",
        "rate_per_s",
        "elapsed_s",
        "by_status",
        "workers",
        "state",
        "resume",
        "pid",
        "scale",
        "limit",
        "schema",
    ];
    let values = [
        "-1",
        "1e308",
        "-1e308",
        "18446744073709551615",
        "null",
        "[]",
        "{}",
        "[{}]",
        r#""""#,
        r#""x\u0000""#,
        "[[[[1]]]]",
        r#"{"ok":-1}"#,
        "0",
        "0.5",
        "1e-320",
    ];
    for name in ["status.json", "manifest.json"] {
        let whole = directory.bytes(name);
        for key in keys {
            for value in values {
                let mut json: serde_json::Value = serde_json::from_slice(&whole).expect("JSON");
                json[key] = serde_json::from_str(value).expect("JSON");
                assert!(directory.withstands(name, &whole, json.to_string().as_bytes()), "{name}: {key} = {value}");
            }
        }
    }
}

#[test]
fn anything_read_back_from_a_result_directory_is_read_or_refused() {
    let directory = Directory::new();
    assert!(status_text(&directory.out, false).expect("readable").contains("6 of 6 samples"));
    assert!(why_text(&directory.out, 3).expect("readable").contains("computed by"));
    let files = READ_BACK.map(|name| (name, directory.bytes(name)));
    let one_of_them = (0..files.len()).prop_flat_map({
        let files = files.clone();
        move |file| (Just(file), mutant(files[file].1.clone()))
    });
    proptest!(config(), |((file, bytes) in one_of_them)| {
        let (name, whole) = &files[file];
        prop_assert!(directory.withstands(name, whole, &bytes), "{}", name);
    });
    println!("{}", cap::figures());
    drop(directory.folder);
}

#[test]
fn any_cut_of_a_table_is_refused() {
    let directory = Directory::new();
    let results = directory.bytes("results.parquet");
    let path = directory.folder.path("t.parquet");
    let files = [path.clone()];
    for length in (0..results.len()).step_by(97).chain(results.len() - 100..results.len()) {
        fs::write(&path, &results[..length]).expect("written");
        case(MOST, || {
            assert!(Table::read(&path).is_err() && Table::row(&files, 3).is_err() && Table::names_in(&path).is_err());
            assert!(Table::for_each_piece(&files, &["status"], |_| Ok(())).is_err());
        });
    }
}

/// A small table with fixed content, each byte changed in three ways.
#[test]
fn a_table_that_is_changed_at_any_byte_is_read_or_refused() {
    let folder = Folder::new();
    let path = folder.path("t.parquet");
    let mut writer = TimingsWriter::create(Pending::create(&path).expect("created")).expect("begun");
    for sample in 0..20 {
        writer.push(Timing { sample, cpu_s: 0.5, worker: 1, attempt: 1 }).expect("taken");
    }
    writer.finish().expect("written");
    let whole = fs::read(&path).expect("readable");
    let files = [path.clone()];
    let mut refused = 0;
    for at in 0..whole.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            fs::write(&path, bytes).expect("written");
            refused += u32::from(case(MOST, || Timing::find(&files, 3).is_err() || count_sound_rows(&path).is_err()));
        }
    }
    println!("{refused} of {} refused; {}", 3 * whole.len(), cap::figures());
    assert!(refused > 100, "{refused}");
}

#[test]
fn any_time_and_size_is_read_or_refused() {
    proptest!(config(), |(amount in "[-0-9.e ]{0,6}[a-zA-Z]{0,4}")| {
        case(MOST, || drop((parse_duration(&amount), parse_memory(&amount))));
    });
}
