//! Input from anywhere: an error, never a panic, a hang or a huge allocation. Valid files with pieces changed, doubled, moved and cut,
//! and bytes of no meaning. The documented long run is `PROPTEST_CASES=25000 cargo test --release --test fuzz` (four times that many
//! cases); without the variable every test takes 500.

mod support;

use bladeoff::study::{Samples, load, parse_duration, parse_memory};
use bladeoff_core::machine::MachineDef;
use bladeoff_protocol::messages::{FromWorker, FromWorkerBlock, RunId, ToWorker, ToWorkerBlock, WorkerId};
use bladeoff_worker::plan::{PLAN_FILE, WorkPlan};
use proptest::prelude::*;
use std::fs;

/// Pieces that files are made of, and some they should not be.
const PIECES: [&str; 30] = [
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

fn changed(text: &str, changes: &[Change]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
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

/// A file changed, or bytes of no meaning.
fn mutant(text: String) -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        8 => changes().prop_map(move |changes| changed(&text, &changes)),
        1 => prop::collection::vec(any::<u8>(), 0..400),
        1 => prop::collection::vec(0..PIECES.len(), 0..60)
            .prop_map(|all| all.into_iter().flat_map(|piece| PIECES[piece].bytes()).collect()),
    ]
}

fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(500);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn rig() -> String {
    fs::read_to_string(support::root().join("studies/machines/lab_rig.toml")).expect("the lab rig")
}

const STUDY: &str = "schema = 1\nname = \"f\"\nmachine = \"m.toml\"\nseed = 3\n[limits]\nmax_failed = \"5 %\"\n\
    time_limit = \"10 min\"\nmemory_limit = \"2 GB\"\ncrash_limit = 3\n[set]\n\"run.end_time\" = \"0.1 s\"\n[points]\nfile = \"p.csv\"\n\
    [[vary]]\npath = \"blade_off.mass\"\nfrom = \"3 g\"\nto = \"10 g\"\ncount = 8\nspacing = \"log\"\n\
    [[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp1\", \"hyp2\"]\n";
const POINTS: &str = "contact.gap, contact.friction\n# a remark\n0.4 mm, 0.1\n\n0.7 mm, 0.25\n1e-3, 0.3\n";

/// A folder with a whole study, in which files are exchanged.
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
    /// Loads the study and, if it is one, looks at its first and last sample.
    fn load(&self) {
        let Ok(study) = load(&self.0.path().join("s.toml")) else { return };
        let Ok(samples) = Samples::new(study, None, None) else { return };
        for sample in [0, samples.count().saturating_sub(1)].into_iter().take(samples.count().min(2) as usize) {
            assert_eq!(samples.values(sample).len(), samples.parameters().count());
            let _ = samples.machine(sample).build();
        }
    }
}

#[test]
fn what_is_changed_is_valid_at_first() {
    let files = Files::new();
    let study = load(&files.0.path().join("s.toml")).expect("valid");
    assert_eq!(Samples::new(study, None, None).expect("small").count(), 3 * 8 * 2);
}

#[test]
fn any_study_is_read_or_refused() {
    let files = Files::new();
    proptest!(config(), |(bytes in mutant(STUDY.to_owned()))| {
        files.put("s.toml", &bytes);
        files.load();
    });
}

#[test]
fn any_points_are_read_or_refused() {
    let files = Files::new();
    proptest!(config(), |(bytes in mutant(POINTS.to_owned()))| {
        files.put("p.csv", &bytes);
        files.load();
    });
}

#[test]
fn any_machine_is_built_or_refused() {
    proptest!(config(), |(bytes in mutant(rig()))| {
        if let Ok(text) = String::from_utf8(bytes)
            && let Ok(machine) = MachineDef::parse("m.toml", &text)
        {
            let _ = machine.build();
            let _ = machine.paths().len();
        }
    });
}

#[test]
fn any_plan_message_time_and_size_is_read_or_refused() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let plan = WorkPlan { machine_file: "m".into(), machine_toml: "[rotor]\n".into(), ..WorkPlan::default() };
    plan.write(dir.path()).expect("written");
    let text = fs::read_to_string(dir.path().join(PLAN_FILE)).expect("the plan");
    // A block is words; these are put where headers and counts are.
    let words = prop::collection::vec((0..64_usize, any::<u64>()), 0..40);
    proptest!(config(), |(bytes in mutant(text), words in words, amount in "[-0-9.e ]{0,6}[a-zA-Z]{0,4}")| {
        fs::write(dir.path().join(PLAN_FILE), &bytes).expect("written");
        // With its own hash, so that it is parsed and not refused for being another.
        let hash = blake3::hash(&bytes).to_hex().to_string();
        let _ = WorkPlan::read(dir.path(), &hash);
        let (mut to, mut from) = (ToWorkerBlock::empty(), FromWorkerBlock::empty());
        let run = RunId(1);
        ToWorker::Stop.encode(run, WorkerId(1), &mut to).expect("valid");
        for (at, word) in words {
            to.words[at] = word;
            from.words[at] = word;
        }
        let _ = ToWorker::decode(&to, run, WorkerId(1));
        let _ = FromWorker::decode(&from, run);
        let _ = (parse_duration(&amount), parse_memory(&amount));
    });
}
