//! Parts with the rows finished so far: at any time each finished row is in exactly one part, with its final content.

use crate::running::{PAUSE, Running, STUDY, signal, state};
use crate::support::{Folder, bladeoff, said, say};
use bladeoff::run::directory::{PARTS, read_current, row_files};
use bladeoff::run::{own_columns, rehearsal};
use bladeoff_answers::tables::{Table, read_metadata};
use bladeoff_system::files::is_temporary;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};

/// A study whose samples take at least two seconds with pauses.
fn long() -> String {
    STUDY.replace("count = 5", "count = 12")
}

/// A study with its undisturbed table.
struct Calm {
    folder: Folder,
    study: String,
    bytes: Vec<u8>,
    rows: BTreeMap<u64, Vec<String>>,
}

impl Calm {
    fn new(text: &str) -> Self {
        let folder = Folder::new();
        let study = folder.write("s.toml", text);
        let (bytes, rows) = calm(&study, &folder.name("calm"));
        Self { folder, study, bytes, rows }
    }

    fn run(&self, out: &str, fault: &str) -> Running {
        Running::start_with(&self.folder, &self.study, out, &format!("{PAUSE};{fault}"), &["--refresh", "200 ms"])
    }

    /// Runs up to a fault that kills the orchestrator.
    fn kill(&self, out: &str, fault: &str) {
        let mut run = self.run(out, &format!("who=orchestrator,{fault},do=kill"));
        assert_eq!((run.end().signal(), run.fired()), (Some(9), 1), "{fault}: {}", run.said());
    }
}

/// Runs a study without faults: bytes of its table, and its rows.
fn calm(study: &str, out: &str) -> (Vec<u8>, BTreeMap<u64, Vec<String>>) {
    let said = say(&["run", study, "--out", out, "--workers", "2"]);
    assert_eq!(said.code, 0, "{}", said.err);
    (fs::read(format!("{out}/results.parquet")).expect("the table"), rows(&[Path::new(out).join("results.parquet")]))
}

/// Cells of all rows; asserts that no row occurs twice and that rows ascend within each file.
fn rows(files: &[PathBuf]) -> BTreeMap<u64, Vec<String>> {
    read(files).expect("readable")
}

fn read(files: &[PathBuf]) -> Result<BTreeMap<u64, Vec<String>>, bladeoff_answers::tables::TableError> {
    let mut all = BTreeMap::new();
    for file in files {
        let names = Table::names_in(file)?;
        let table = Table::read(file)?;
        let samples: Vec<u64> =
            table.numbers("sample").expect("samples").iter().map(|sample| sample.expect("a number") as u64).collect();
        assert!(!samples.is_empty() && samples.is_sorted(), "{}: {samples:?}", file.display());
        for (row, &sample) in samples.iter().enumerate() {
            let cell = |name: &String| match (table.numbers(name), table.words(name)) {
                (Some(values), _) => format!("{name}={:?}", values[row]),
                (None, Some(words)) => format!("{name}={:?}", words[row]),
                (None, None) => panic!("{name} is a column"),
            };
            assert!(all.insert(sample, names.iter().map(cell).collect()).is_none(), "sample {sample} comes twice");
        }
    }
    Ok(all)
}

/// Rows in the present parts, after a comparison with the final table.
fn parts(out: &str, table: &BTreeMap<u64, Vec<String>>) -> BTreeSet<u64> {
    let found = read_current(Path::new(out), row_files, read).expect("readable");
    for (sample, row) in &found {
        assert_eq!(table.get(sample), Some(row));
    }
    found.into_keys().collect()
}

fn part_bytes(out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    row_files(Path::new(out)).into_iter().map(|path| (path.clone(), fs::read(path).expect("readable"))).collect()
}

fn names(out: &str) -> BTreeSet<String> {
    let names = fs::read_dir(out).expect("readable").flatten().map(|entry| entry.file_name());
    names.map(|name| name.to_string_lossy().into_owned()).collect()
}

fn assert_complete(calm: &Calm, out: &str) {
    assert!(fs::read(format!("{out}/results.parquet")).expect("the table") == calm.bytes, "another table");
    let strange: Vec<String> =
        names(out).into_iter().filter(|name| name.contains("part") || name.ends_with(".tmp")).collect();
    assert!(strange.is_empty(), "{strange:?} are left");
}

#[test]
fn finished_rows_are_in_one_part_each_during_a_run_after_a_kill_and_after_going_on() {
    let calm = Calm::new(&long());
    let out = calm.folder.name("out");
    // stopped after the first and the second part, so that both can be read
    let stop = |part: u32| format!("who=orchestrator,at=parted,sample={part},do=stop");
    let mut run = calm.run(&out, &format!("{};{};who=orchestrator,at=parted,sample=3,do=kill", stop(1), stop(2)));
    let (mut seen, mut bytes, mut looks) = (BTreeSet::new(), BTreeMap::<PathBuf, Vec<u8>>::new(), 0);
    while run.child.try_wait().expect("a child").is_none() {
        let pid = run.child.id();
        let is_stopped = state(pid) == Some('T');
        let now = parts(&out, &calm.rows);
        assert!(now.is_superset(&seen), "rows are gone");
        looks += u32::from(now.len() > seen.len());
        seen = now;
        for (path, before) in std::mem::take(&mut bytes) {
            assert!(fs::read(&path).expect("a part stays") == before, "{} has changed", path.display());
        }
        bytes = part_bytes(&out);
        if is_stopped {
            assert!(signal(pid, "CONT"));
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert_eq!((run.end().signal(), run.fired()), (Some(9), 3), "{}", run.said());
    assert!(looks >= 2, "parts came one after another");
    let killed = parts(&out, &calm.rows);
    assert!(killed.is_superset(&seen) && row_files(Path::new(&out)).len() == 3);
    let told = run.count("sample");
    assert!(killed.len() <= calm.rows.len() && !killed.is_empty() && told >= killed.len(), "{told} {}", killed.len());
    // all recorded rows are in the new parts with which the next run begins
    let mut again = calm.run(&out, &stop(1));
    let mut seen = killed;
    let mut is_fresh = false;
    while again.child.try_wait().expect("a child").is_none() {
        let pid = again.child.id();
        let is_stopped = state(pid) == Some('T');
        if !Path::new(&out).join("results.parquet").exists() {
            let files = row_files(Path::new(&out));
            let now = read_current(Path::new(&out), row_files, read).expect("readable");
            let now: BTreeSet<u64> = now.into_keys().collect();
            // the parts are removed when the table exists
            if !Path::new(&out).join("results.parquet").exists() {
                assert!(now.is_superset(&seen), "rows are gone");
                is_fresh |= files.len() == 1 && now.len() >= seen.len();
                seen = now;
            }
        }
        if is_stopped {
            assert!(signal(pid, "CONT"));
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert!(again.end().success() && is_fresh, "{}", again.said());
    assert!(again.events()[0]["recorded"].as_u64() >= Some(told as u64));
    assert_complete(&calm, &out);
}

#[test]
fn a_kill_at_any_step_of_writing_parts_leaves_none_that_is_wrong() {
    let calm = Calm::new(&long());
    let out = calm.folder.name("out");
    calm.kill(&out, "at=parting,sample=1");
    let begun = names(&out).into_iter().filter(|name| is_temporary(name.as_ref(), PARTS)).count();
    assert!(parts(&out, &calm.rows).is_empty() && begun == 1, "{:?}", names(&out));
    calm.kill(&out, "at=swapping,sample=0");
    assert!(parts(&out, &calm.rows).is_empty() && names(&out).contains("parts.aside"), "{:?}", names(&out));
    calm.kill(&out, "at=parted,sample=2");
    let before = parts(&out, &calm.rows);
    assert!(before.len() > 1 && row_files(Path::new(&out)).len() == 2 && !names(&out).contains("parts.aside"));
    // the old parts stay until the new ones are complete
    calm.kill(&out, "at=swapping,sample=0");
    assert_eq!(parts(&out, &calm.rows), before);
    calm.kill(&out, "at=retiring,sample=0");
    let left = names(&out);
    assert!(left.contains("results.parquet") && left.contains("parts"), "{left:?}");
    let last = say(&["run", &calm.study, "--out", &out, "--workers", "2"]);
    assert!(last.code == 0 && last.err.contains("nothing to compute"), "{}", last.err);
    assert_complete(&calm, &out);
}

#[test]
fn a_run_that_is_ended_leaves_all_that_is_finished_in_parts() {
    let calm = Calm::new(&long());
    let out = calm.folder.name("out");
    // parts do not affect the result
    for refresh in ["0", "0.2"] {
        // a busy machine needs longer until a sample is finished
        let run = |attempt: u32| {
            let wall = format!("{}.8 s", attempt / 2);
            let mut command = bladeoff(&["run", &calm.study, "--out", &out, "--workers", "2"]);
            command.args(["--refresh", refresh, "--wall", &wall]).env("BLADEOFF_FAULT", PAUSE);
            let ran = said(command.output().expect("it starts"));
            assert_eq!(ran.code, 5, "{}", ran.err);
            ran
        };
        let ran = (0..20).map(run).find(|_| !row_files(Path::new(&out)).is_empty()).expect("a finished sample");
        assert!(ran.out.contains(&format!("{out}/{PARTS}/*.parquet")), "{}", ran.out);
        let status = say(&["status", &out, "--json"]);
        let status: serde_json::Value = serde_json::from_str(&status.out).expect("JSON");
        let found = parts(&out, &calm.rows);
        assert_eq!(status["done"].as_u64(), Some(found.len() as u64));
        assert!(!names(&out).contains("results.parquet") && !names(&out).contains("timings.parquet"));
    }
    let files = row_files(Path::new(&out));
    let whole = calm.folder.path("calm/results.parquet");
    assert_eq!(Table::names_in(&files[0]).expect("columns"), Table::names_in(&whole).expect("columns"));
    let metadata = |path: &Path| read_metadata(path).expect("metadata").into_iter().collect::<BTreeMap<_, _>>();
    let (part, mut whole) = (metadata(&files[0]), metadata(&whole));
    assert_eq!(part.get("bladeoff.incomplete").map(String::as_str), Some("true"));
    whole.extend([("bladeoff.incomplete", "true"), ("bladeoff.part", "1")].map(|(k, v)| (k.into(), v.into())));
    assert_eq!(part, whole, "the rest says the same");
    // every command that reads rows accepts parts
    let some = *parts(&out, &calm.rows).iter().next_back().expect("rows");
    let why = say(&["why", &out, &some.to_string()]);
    assert!(why.code == 0 && why.out.contains("computed by"), "{}{}", why.out, why.err);
    let replay = say(&["replay", &out, "--sample", &some.to_string()]);
    assert!(replay.code == 0 && replay.out.contains("bit for bit"), "{}{}", replay.out, replay.err);
    assert_eq!(say(&["replay", &out, "--worst", "max_bearing_load_N"]).code, 0);
    let exported = say(&["export", &out, "--csv"]);
    assert!(exported.out.lines().count() == parts(&out, &calm.rows).len() + 1 && exported.err.contains("incomplete"));
    let last = say(&["run", &calm.study, "--out", &out, "--workers", "2"]);
    assert_eq!(last.code, 0, "{}", last.err);
    assert_complete(&calm, &out);
}

#[test]
fn a_growth_replaces_the_parts_of_other_numbers() {
    // one more value of an axis before the others: every sample has another number
    let gaps = "from = \"0.5 mm\"\nto = \"0.9 mm\"\ncount = 4";
    let small = long().replace(gaps, "values = [\"0.5 mm\", \"0.7 mm\", \"0.9 mm\"]");
    let grown = long().replace(gaps, "values = [\"0.6 mm\", \"0.5 mm\", \"0.7 mm\", \"0.9 mm\"]");
    let calm = Calm::new(&grown);
    let out = calm.folder.name("out");
    let (_, small_rows) = self::calm(&calm.folder.write("s.toml", &small), &calm.folder.name("small"));
    calm.kill(&out, "at=parted,sample=2");
    let before = parts(&out, &small_rows);
    calm.folder.write("s.toml", &grown);
    // killed while the new record is created: the directory of the small study; before the new parts are in place: no parts; then the parts of
    // the grown study
    calm.kill(&out, "at=growing,sample=any");
    assert_eq!(parts(&out, &small_rows), before);
    calm.kill(&out, "at=swapping,sample=0");
    assert!(parts(&out, &calm.rows).is_empty());
    calm.kill(&out, "at=parted,sample=2");
    assert!(parts(&out, &calm.rows).len() > before.len());
    let last = say(&["run", &calm.study, "--out", &out, "--workers", "2"]);
    assert_eq!(last.code, 0, "{}", last.err);
    assert_complete(&calm, &out);
}

#[test]
fn many_rows_are_cut_into_parts() {
    let folder = Folder::new();
    let text = STUDY.replace("count = 5", "count = 17500");
    let study = bladeoff_study::load(Path::new(&folder.write("s.toml", &text)), own_columns).expect("a study");
    let samples = bladeoff_study::Samples::new(study, None, None).expect("70 000");
    rehearsal::fill(&folder.path("out"), &samples).expect("filled");
    rehearsal::time_parts(&folder.path("out"), &samples).expect("written");
    let files = row_files(&folder.path("out"));
    let counts: Vec<usize> = files.iter().map(|file| Table::read(file).expect("readable").rows()).collect();
    assert_eq!(counts, [65_536, 4_463]);
    assert_eq!(rows(&files).len(), 69_999);
    // found by its number, by reading the column of one part, or not at all
    for (sample, place) in [(7, Some(0)), (65_535, Some(0)), (65_536, Some(1)), (69_998, Some(1)), (69_999, None)] {
        let found = Table::row(&files, sample).expect("readable");
        assert_eq!(found.as_ref().map(|(_, path)| path), place.map(|place: usize| &files[place]));
        let cell = found.map(|(row, _)| row.numbers("sample").expect("samples").to_vec());
        assert_eq!(cell, place.map(|_| vec![Some(sample as f64)]));
    }
}
