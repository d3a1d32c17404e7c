//! `run.step_limit` is a budget: with a larger one a study is resumed in the same directory, and the table equals that of a fresh run.

use crate::support::{Folder, Said, say, table};
use bladeoff_record::{Entry, Reader, Record, RecordError};
use bladeoff_study::SampleKey;
use bladeoff_worker::noop::noop_outcome;
use std::fs;
use std::time::Instant;

/// Two gaps x two durations; a sample takes milliseconds.
const STUDY: &str = r#"schema = 1
name = "reuse"
machine = "machines/rig.toml"

[limits]
max_failed = "100 %"

[[vary]]
path = "contact.gap"
values = ["0.5 mm", "0.9 mm"]

[[vary]]
path = "run.end_time"
values = ["3 ms", "6 ms"]
"#;

struct Bench {
    folder: Folder,
    rig: String,
    fresh: u32,
}

impl Bench {
    fn new() -> Self {
        let folder = Folder::reduced();
        let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
        Self { folder, rig, fresh: 0 }
    }

    /// Runs a study in the existing directory; asserts that the table equals that of a fresh run.
    fn goes_on(&mut self, text: &str, more: &[&str]) -> Said {
        let said = self.run(text, "out", more);
        assert_eq!(said.code, 0, "{}", said.err);
        self.fresh += 1;
        let fresh = format!("fresh-{}", self.fresh);
        assert_eq!(self.run(text, &fresh, &[]).code, 0);
        let bytes = |out: &str| fs::read(self.folder.path(&format!("{out}/results.parquet"))).expect("the table");
        assert!(bytes("out") == bytes(&fresh), "not the table of a fresh run: {text}{}", said.err);
        said
    }

    fn is_refused(&self, text: &str, lost: &str) {
        let record = || fs::read(self.folder.path("out/ledger.redb")).expect("the record");
        let before = record();
        let said = self.run(text, "out", &[]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(said.err.contains(lost) && said.err.contains("run.step_limit: "), "{}", said.err);
        assert!(record() == before);
    }

    fn run(&self, text: &str, out: &str, more: &[&str]) -> Said {
        let study = self.folder.write("s.toml", text);
        say(&[&["run", &study, "--out", &self.folder.name(out), "--workers", "2"], more].concat())
    }

    /// A column of the table.
    fn column(&self, name: &str) -> Vec<String> {
        let (header, rows) = table(&self.folder.name("out"));
        let column = header.iter().position(|found| found == name).expect("such a column");
        rows.into_iter().map(|row| row[column].clone()).collect()
    }

    fn causes(&self) -> Vec<bool> {
        self.column("cause").iter().map(|cause| cause == "step_limit").collect()
    }
}

fn set(limit: u64) -> String {
    STUDY.replace("[limits]", &format!("[set]\n\"run.step_limit\" = {limit}\n\n[limits]"))
}

fn varied(limits: &str) -> String {
    format!("{STUDY}\n[[vary]]\npath = \"run.step_limit\"\nvalues = [{limits}]\n")
}

#[test]
fn a_larger_step_limit_goes_on_and_the_table_is_that_of_a_fresh_run() {
    let mut bench = Bench::new();
    bench.goes_on(STUDY, &[]);
    let steps = bench.column("steps");
    let [short, long] = [&steps[0], &steps[1]].map(|steps| steps.parse::<u64>().expect("a count"));
    assert!(short > 100 && long > short + 100, "{steps:?}");
    fs::remove_dir_all(bench.folder.path("out")).expect("removed");
    // the limit is exact: one step less ends every run early, `short` steps complete the short ones
    bench.goes_on(&set(short - 1), &[]);
    assert_eq!(bench.causes(), [true; 4]);
    let why = say(&["why", &bench.folder.name("out"), "1"]);
    assert!(why.out.contains("raise `run.step_limit`"), "{}", why.out);
    let again = bench.goes_on(&set(short), &[]);
    assert!(
        again.err.contains("4 samples that ended early under another run.step_limit are computed again"),
        "{}",
        again.err
    );
    assert_eq!(bench.causes(), [false, true, false, true]);
    let again = bench.goes_on(&set(long - 1), &["--rerun", "failed"]);
    assert!(again.err.contains("2 of 4 samples are already finished, 2 are computed"), "{}", again.err);
    assert_eq!(bench.causes(), [false, true, false, true]);
    bench.is_refused(&set(short), "2 of its 4 finished samples");
    bench.goes_on(&set(long), &[]);
    assert_eq!(bench.causes(), [false; 4]);
    bench.is_refused(&set(long - 1), "2 of its 4 finished samples");
    // a limit that affects no sample keeps all of them: larger, in the machine file, smaller but sufficient, none
    let is_kept = |bench: &mut Bench, text: &str| {
        let again = bench.goes_on(text, &[]);
        assert!(again.err.contains("4 of 4 samples are already finished, 0 are computed"), "{}", again.err);
    };
    is_kept(&mut bench, &set(10 * long));
    let limited = bench.rig.replacen("[run]\n", &format!("[run]\nstep_limit = {}\n", 20 * long), 1);
    bench.folder.write("machines/rig.toml", &limited);
    is_kept(&mut bench, STUDY);
    is_kept(&mut bench, &set(long));
    bench.folder.write("machines/rig.toml", &bench.rig);
    is_kept(&mut bench, STUDY);
}

#[test]
fn a_step_limit_that_varies_is_each_samples_own() {
    let mut bench = Bench::new();
    bench.goes_on(STUDY, &[]);
    let long: u64 = bench.column("steps")[1].parse().expect("a count");
    // an axis with the existing values and more
    let again = bench.goes_on(&varied(&format!("100, {long}")), &[]);
    assert!(again.err.contains("4 of 8 samples are already finished, 4 are computed"), "{}", again.err);
    assert_eq!(bench.causes(), [true, false, true, false, true, false, true, false]);
    // other numbers: each sample is found by its own limit
    let again = bench.goes_on(&varied(&format!("{}, {long}, 100, 200", long + 1)), &[]);
    assert!(again.err.contains("12 of 16 samples are already finished, 4 are computed"), "{}", again.err);
    bench.is_refused(&varied("100, 200"), "8 of its 16 finished samples");
    // results with the largest limit serve all of them
    let again = bench.goes_on(STUDY, &[]);
    assert!(again.err.contains("4 of 4 samples are already finished, 0 are computed"), "{}", again.err);
}

#[test]
fn a_record_with_the_keys_of_an_earlier_build_is_refused_by_that_reason() {
    let bench = Bench::new();
    assert_eq!(bench.run(&set(100), "out", &[]).code, 0);
    // earlier builds counted the step limit: other keys for the same study
    let path = bench.folder.path("out/ledger.redb");
    let record = Reader::open(&path).expect("a whole record");
    let mut header = record.header().expect("readable");
    header.insert("samples_blake3".to_owned(), "another".to_owned());
    let header: Vec<(String, String)> = header.into_iter().collect();
    let mut entries = Vec::new();
    let taken = record.for_each::<RecordError>(|sample, entry| {
        entries.push((sample, entry));
        Ok(())
    });
    taken.expect("readable");
    let mut earlier = Record::create(&path, &header).expect("created");
    for (sample, entry) in entries {
        earlier.put(sample, SampleKey(u128::from(sample)), &entry, Instant::now()).expect("taken");
    }
    earlier.publish().expect("written");
    drop((record, earlier));
    for (limit, shown) in [(100, false), (200, true)] {
        let said = bench.run(&set(limit), "out", &[]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(said.err.contains("keys of the samples: from an earlier build"), "{}", said.err);
        assert_eq!(said.err.contains("run.step_limit: 100 -> 200"), shown, "{}", said.err);
    }
}

/// A share of the samples runs twice. Added to a finished study, it recomputes those samples and keeps the rest; in a grown study, the samples
/// whose choice differs. One and three workers write the same bytes, and a sample with a twin is replayed to its row.
#[test]
fn twins_of_a_share_of_the_samples_change_nothing_else() {
    let mut bench = Bench::new();
    let with = STUDY.replace("\n[limits]", "twin_share = 0.5\n\n[limits]");
    let first = bench.goes_on(STUDY, &[]);
    assert!(!first.out.contains("Twin runs"), "{}", first.out);
    let out = bench.folder.name("out");
    let (plain_header, plain) = table(&out);
    let said = bench.goes_on(&with, &[]);
    let (header, rows) = table(&out);
    let column = |name: &str| header.iter().position(|found| found == name).unwrap_or_else(|| panic!("no {name}"));
    let (shift, change, status) = (column("run.twin"), column("twin_bearing_load_change"), column("twin_status"));
    let twins = rows.iter().filter(|row| row[shift].parse::<f64>().expect("a number") > 0.0).count();
    assert!((1..rows.len()).contains(&twins), "{twins} of {}", rows.len());
    let summed = format!("Twin runs: {twins} of {} rows, bearing load changed by up to ", rows.len());
    assert!(said.out.contains(&summed) && said.out.contains(" for 1e-6 of the initial speed."), "{}", said.out);
    let sensitive = "with a twin are sensitive (a twin shifted by run.twin changes a result by more than 2 %).";
    assert!(said.out.contains(&format!("0 of {twins} runs {sensitive}")), "{}", said.out);
    let page = bench.folder.name("page.html");
    assert_eq!(say(&["report", &out, "--out", &page]).code, 0);
    let html = fs::read_to_string(&page).expect("the report");
    assert!(html.matches(sensitive).count() >= 2, "at the beginning and in the summary");
    let again = format!("{twins} samples are computed again because twin_share");
    assert!(said.err.contains(&again), "{}", said.err);
    for (row, before) in rows.iter().zip(&plain) {
        let chosen = row[shift].parse::<f64>().expect("a number") > 0.0;
        assert_eq!(
            (row[change].is_empty(), row[status].as_str()),
            (!chosen, if chosen { "ok" } else { "" }),
            "{row:?}"
        );
        // without rub, loads are linear in the shift
        let moved = row[change].parse::<f64>().map_or(1e-6, f64::abs);
        assert!((1e-9..1e-4).contains(&moved), "{moved}");
        for (name, value) in header.iter().zip(row).filter(|(name, _)| !name.contains("twin") && *name != "sensitive") {
            let at = plain_header.iter().position(|other| other == name).expect("the column");
            assert_eq!(*value, before[at], "{name}: the first run is the run");
        }
    }
    // other numbers, other twins
    let grown = with.replace("\"6 ms\"]", "\"6 ms\", \"9 ms\"]");
    bench.goes_on(&grown, &[]);
    let study = bench.folder.write("s.toml", &grown);
    for (out, workers) in [("three", "3"), ("one", "1")] {
        let said = say(&["run", &study, "--out", &bench.folder.name(out), "--workers", workers]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let bytes = |out: &str| fs::read(bench.folder.path(&format!("{out}/results.parquet"))).expect("the table");
    assert!(bytes("three") == bytes("one"));
    let said = say(&["replay", &bench.folder.name("one"), "--sample", "0"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("equal to the row") && said.out.contains("in a run that starts by run.twin faster"),
        "{}",
        said.out
    );
}

#[test]
fn a_share_of_twins_that_is_none_is_refused() {
    let bench = Bench::new();
    for (share, allowed) in [("1.5", "0 to 1"), ("\"5\"", "0 to 1"), ("-0.1", "0 to 1"), ("[]", "a share")] {
        let said = bench.run(&STUDY.replace("\n[limits]", &format!("twin_share = {share}\n[limits]")), "out", &[]);
        assert_eq!(said.code, 3, "{share}: {}", said.err);
        assert!(said.err.contains("twin_share") && said.err.contains(allowed), "{share}: {}", said.err);
    }
    let varied = STUDY.replace("\n[limits]", "twin_share = 0.1\n[limits]").replace("run.end_time", "run.twin");
    let varied = varied.replace("[\"3 ms\", \"6 ms\"]", "[0, 1e-6]");
    let said = bench.run(&varied, "out", &[]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("run.twin varies"), "{}", said.err);
    for (shift, word) in [("1e-15", "rounding"), ("0.5", "0.01"), ("-1e-6", "0.01")] {
        let set = STUDY.replace("\n[limits]", &format!("[set]\n\"run.twin\" = {shift}\n[limits]"));
        let said = bench.run(&set, "out", &[]);
        assert!(said.code == 3 && said.err.contains("run.twin") && said.err.contains(word), "{shift}: {}", said.err);
    }
}

/// A run opens a record before it checks it: with any byte changed, opening and closing end without a panic.
#[test]
fn a_look_at_a_damaged_record_ends_without_a_panic() {
    let folder = Folder::new();
    let path = folder.path("ledger.redb");
    let header: Vec<(String, String)> = (0..12).map(|n| (format!("key {n}"), "v".repeat(64))).collect();
    let mut record = Record::create(path.clone(), &header).expect("made");
    for sample in 0..24 {
        let entry = Entry { outcome: noop_outcome(sample, &[]), cpu_s: 0.0, worker: 1, attempt: 1 };
        record.put(sample, SampleKey(sample.into()), &entry, Instant::now()).expect("taken");
        record.commit().expect("written");
    }
    record.publish().expect("published");
    drop(record);
    let whole = fs::read(&path).expect("the record");
    let looked = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("written");
        Reader::peek(path.clone()).ok().and_then(|record| record.header().ok())
    };
    assert!(looked(&whole).is_some());
    let (mut well, mut damaged) = (0, 0);
    for at in (0..whole.len()).filter(|&at| whole[at] != 0).step_by(11) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        *if looked(&bytes).is_some() { &mut well } else { &mut damaged } += 1;
    }
    assert!(well > 50 && damaged > 10, "{well} looked well, {damaged} did not");
}
