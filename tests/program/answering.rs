//! Questions and gates of studies, end to end: parsing, answers, output files and rejected studies.

use crate::support::shared_studies::NORMAL_STUDY;
use crate::support::{Folder, json, say};
use std::fs;
use std::os::unix::fs::PermissionsExt;

const QUESTIONS: &str = r#"
[[question]]
name = "fails"
probability = "g < 0"

[[question]]
name = "curve"
exceedance = "h"

[[question]]
name = "less"
difference = [2, 1]
vary = "w"
mean = "h"

[[gate]]
require = "P(g < 0) < 5 %"
"#;

fn metadata(directory: &str, key: &str) -> Option<String> {
    let table = std::path::Path::new(directory).join("results.parquet");
    let metadata = bladeoff_answers::tables::read_metadata(&table).expect("a table");
    metadata.into_iter().find(|(name, _)| name == key).map(|(_, value)| value)
}

#[test]
fn questions_are_answered_at_the_end_of_a_run_and_later() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}"));
    let (one, two) = (folder.name("one"), folder.name("two"));
    let ran = say(&["run", &study, "--out", &one, "--workers", "1"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    for part in ["Answers, of 2000 points:", "  w = 1: P(g < 0) = 2", "less\n  mean of h, w = 2 less 1 = "] {
        assert!(ran.out.contains(part), "{part}\nin\n{}", ran.out);
    }
    let answers = json(&fs::read_to_string(folder.path("one/answers.json")).expect("written"));
    assert_eq!((&answers["schema"], &answers["complete"]), (&1.into(), &true.into()));
    let list = answers["answers"].as_array().expect("a list");
    let names: Vec<&str> = list.iter().filter_map(|answer| answer["name"].as_str()).collect();
    assert_eq!(names, ["fails", "fails", "curve", "curve", "less"]);
    let first = &list[0];
    assert_eq!((&first["n"], &first["group"]["w"], &first["bad"]), (&2000.into(), &1.0.into(), &0.into()));
    let [low, high] = ["low", "high"].map(|key| first[key].as_f64().expect("a number"));
    assert!(low < 0.0228 && 0.0228 < high && high - low < 0.02, "{low} to {high}");
    // every figure of g is the same in both groups, because both have the same points
    assert_eq!(first["events"], list[1]["events"]);
    let curve = bladeoff_answers::tables::read_numbers(&folder.path("one/answers/curve.parquet")).expect("a curve");
    assert!(curve.0.iter().any(|column| column.name == "level" && column.values.len() > 1000), "{:?}", curve.0.len());
    // the same study again with a different number of workers, and through `answer`
    assert_eq!(say(&["run", &study, "--out", &two, "--workers", "2"]).code, 0);
    for name in ["answers.json", "answers/curve.parquet", "results.parquet"] {
        let read = |directory: &str| fs::read(folder.path(directory).join(name)).expect("written");
        assert!(read("one") == read("two"), "{name}");
    }
    let written = fs::read(folder.path("one/answers.json")).expect("written");
    fs::remove_file(folder.path("one/answers.json")).expect("removed");
    let answered = say(&["answer", &one, "--json"]);
    assert_eq!((answered.code, json(&answered.out)), (0, answers), "{}", answered.err);
    assert_eq!(fs::read(folder.path("one/answers.json")).expect("written again"), written);
    assert!(metadata(&one, "bladeoff.questions").is_some_and(|text| text.contains("\"fails\"")));
}

#[test]
fn other_questions_compute_nothing_and_are_taken_over() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}"));
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let record = fs::read(folder.path("out/timings.parquet")).expect("written");
    let others = "\n[[question]]\nname = \"other\"\nquantile = 0.9\nof = \"h\"\n";
    // questions from another file are answered, but no file is written
    let before = fs::read(folder.path("out/answers.json")).expect("written");
    let other = folder.write("other.toml", others);
    let answered = say(&["answer", &out, "--study", &other]);
    assert!(answered.code == 0 && answered.out.contains("w = 2: 90 % quantile of h = 2.6"), "{}", answered.out);
    assert!(
        !answered.out.contains("answers.json") && fs::read(folder.path("out/answers.json")).expect("there") == before
    );
    let study = folder.write("s.toml", &format!("{NORMAL_STUDY}{others}"));
    let ran = say(&["run", &study, "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.err.contains("0 are computed"), "{}", ran.err);
    assert!(ran.out.contains("other\n"), "{}", ran.out);
    assert!(fs::read_to_string(folder.path("out/study.toml")).expect("there").contains("\"other\""));
    let told = metadata(&out, "bladeoff.questions").expect("told");
    assert!(told.contains("other") && !told.contains("fails"), "{told}");
    assert!(!folder.path("out/answers").exists(), "the curve of a question that is gone");
    assert_eq!(fs::read(folder.path("out/timings.parquet")).expect("written"), record, "nothing was computed");
    // a study without questions: the earlier answers are removed
    let study = folder.write("s.toml", NORMAL_STUDY);
    let ran = say(&["run", &study, "--out", &out]);
    assert!(ran.code == 0 && !ran.out.contains("Answers"), "{}", ran.out);
    assert!(!folder.path("out/answers.json").exists() && metadata(&out, "bladeoff.questions").is_none());
    let asked = say(&["answer", &out]);
    assert!(asked.code == 3 && asked.err.contains("asks no question"), "{} {}", asked.code, asked.err);
    let asked = say(&["gate", &out]);
    assert!(asked.code == 3 && asked.err.contains("--require"), "{} {}", asked.code, asked.err);
}

/// A study in which ten of a hundred points fail.
fn failing(folder: &Folder) -> String {
    let text =
        NORMAL_STUDY.replace("h = \"x * w\"", "h = \"sqrt(1.28 - x)\"").replace("samples = 2000", "samples = 20000");
    folder.write("s.toml", &format!("{text}{QUESTIONS}"))
}

#[test]
fn half_way_the_first_points_answer_and_nothing_is_written() {
    let folder = Folder::new();
    let (study, out) = (failing(&folder), folder.name("out"));
    let ran = say(&["run", &study, "--out", &out, "--workers", "1", "--max-failures", "300"]);
    assert_eq!(ran.code, 5, "{}", ran.err);
    assert!(ran.out.contains("Answers so far, of the first "), "{}", ran.out);
    let answered = say(&["answer", &out, "--json"]);
    let answers = json(&answered.out);
    let n = answers["answers"][0]["n"].as_u64().expect("points");
    assert!(answered.code == 0 && answers["complete"] == false && n > 0 && n < 20_000, "{n}");
    let said = say(&["answer", &out]);
    assert!(said.out.contains(&format!("Answers so far, of the first {n} of 20000 points:")), "{}", said.out);
    assert!(!folder.path("out/answers.json").exists() && !folder.path("out/answers").exists());
    // the gate is judged at the last evaluation: 256, 512, ... points
    let judged = say(&["gate", &out]);
    let look = 1u64 << n.ilog2();
    if look >= 256 {
        assert!(judged.out.contains(&format!(" of {look}")), "{n}: {}", judged.out);
    }
    // failed runs do not make a study with questions fail, because its answers account for them
    let ran = say(&["run", &study, "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let answers = json(&fs::read_to_string(folder.path("out/answers.json")).expect("written"));
    let first = &answers["answers"][0];
    assert_eq!((&answers["complete"], &first["n"]), (&true.into(), &20_000.into()));
    let bad = first["bad"].as_u64().expect("a count");
    assert!((1700..2300).contains(&bad), "{bad}");
    let [estimate, harmful] = ["estimate", "estimate_if_bad_harmful"].map(|key| first[key].as_f64().expect("a number"));
    assert!(estimate == 0.0 && harmful > 0.08, "{estimate} to {harmful}: g < 0 where h is none");
}

#[test]
fn a_gate_is_an_exit_code_and_a_file_for_build_servers() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}"));
    let (out, xml) = (folder.name("out"), folder.name("gate.xml"));
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let gate = |require: &str| say(&["gate", &out, "--require", require, "--junit", &xml]);
    let passed = say(&["gate", &out]);
    assert_eq!(passed.code, 0, "{}", passed.err);
    assert!(passed.out.contains("w = 2: P(g < 0) < 5 %: passed"), "{}", passed.out);
    let failed = gate("P(h > 0) < 0.4");
    assert!(failed.code == 4 && failed.out.contains("failed, at least 49 %"), "{}", failed.out);
    let text = fs::read_to_string(&xml).expect("written");
    assert!(text.contains("<testsuite name=\"s\" tests=\"2\" failures=\"2\" errors=\"0\">"), "{text}");
    let open = gate("P(h > 0) < 0.5");
    assert_eq!(open.code, 5, "{}", open.out);
    let text = fs::read_to_string(&xml).expect("written again");
    assert!(text.contains("failures=\"0\" errors=\"2\"") && text.contains("type=\"undecided\""), "{text}");
    // one group fails, the other passes; a failed gate determines the exit code of several gates
    assert_eq!(gate("P(h > 2) < 0.1").code, 4);
    assert_eq!(say(&["gate", &out, "--require", "P(h > 0) < 0.5", "--require", "P(h > 2) < 0.1"]).code, 4);
    assert_eq!(say(&["gate", &out, "--require", "P(g < 0) < 3 %", "--confidence", "0.5"]).code, 0);
    for (words, code, part) in [
        (["--require", "P(g < 0) < 5 kg"], 3, "plain number"),
        (["--require", "P(gg < 0) < 5 %"], 3, "there is no variable `gg`"),
        (["--confidence", "0.5"], 2, "--require"),
    ] {
        let said = say(&[&["gate", &out][..], &words[..]].concat());
        assert!(said.code == code && said.err.contains(part), "{words:?}: {} {}", said.code, said.err);
    }
    // a table that was changed after it was written is rejected
    let table = folder.path("out/results.parquet");
    let mut bytes = fs::read(&table).expect("there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&table, bytes).expect("written");
    assert_eq!((say(&["gate", &out]).code, say(&["answer", &out]).code), (6, 6));
}

#[test]
fn every_mistake_of_a_file_is_told_at_its_place_at_once() {
    let folder = Folder::new();
    let text = format!(
        "{NORMAL_STUDY}{}",
        r#"
[[question]]
name = "a b"
probability = "y > 1"

[[question]]
name = "c"
mean = "gg"
confidence = 95

[[question]]
name = "d"
difference = [1, 3]
vary = "w"
quantile = 0.5
of = "status"

[[question]]
name = "f"
fragility = "xx"
probability = "x > 1 and"

[[gate]]
require = "P(hh > 1) < 2"
"#
    );
    let all = [
        "s.toml:24:8: question[0].name",
        "s.toml:25:16: question[0].probability = y: there is no variable `y`",
        "s.toml:29:8: question[1].mean = \"gg\": there is no column `gg`",
        "s.toml:30:14: question[1].confidence = 95: 95 is not between 0 and 1",
        "s.toml:34:14: question[2].difference = [1, 3]: 3 is not a value of `w`: 1, 2",
        "s.toml:37:6: question[2].of = \"status\": `status` is a column of words",
        "s.toml:41:13: question[3].fragility = \"xx\": `xx` is neither varied nor uncertain",
        "s.toml:42:25: question[3].probability",
        "s.toml:45:14: gate[0].require = hh: there is no variable `hh`",
        "s.toml:45:23: gate[0].require = 2: a bound is above 0 and at most 1, not 2",
    ];
    let told = say(&["check", &folder.write("s.toml", &text)]);
    assert_eq!(told.code, 3);
    all.iter().for_each(|part| assert!(told.err.contains(part), "{part}\nin\n{}", told.err));
    // if another table has a mistake, too, existing names are not reported as unknown
    let other = text.replace("sd = 1\n", "sd = -1\n");
    let told = say(&["check", &folder.write("s.toml", &other)]);
    assert!(told.err.contains("uncertain[0].sd"), "{}", told.err);
    for part in all.iter().filter(|part| !part.contains("is not a value of")) {
        assert!(told.err.contains(part), "{part}\nin\n{}", told.err);
    }
    let sound = text.replace("sd = 1\n", "sd = -1\n").replace("[[question]]", "[[question]] # ");
    let sound = sound.split("\n[[question]]").next().expect("the study").to_owned() + QUESTIONS;
    let told = say(&["check", &folder.write("s.toml", &sound)]);
    assert!(told.err.contains("1 problem") || told.err.matches("  × ").count() == 1, "{}", told.err);
    // a study without random points can have no questions
    let grid = "schema = 1\nmachine = \"machines/rig.toml\"\n[[vary]]\npath = \"contact.gap\"\nvalues = [\"0.5 mm\", \"0.9 mm\"]\n\
                [[question]]\nname = \"q\"\nmean = \"max_bearing_load_N\"\n";
    let told = say(&["check", &folder.write("grid.toml", grid)]);
    assert!(told.code == 3 && told.err.contains("questions and gates need random points"), "{}", told.err);
    // exact limits require independent points
    let sobol = NORMAL_STUDY.replace("monte-carlo", "sobol").replace("2000", "2048") + QUESTIONS;
    let told = say(&["check", &folder.write("sobol.toml", &sobol)]);
    assert!(told.code == 3 && told.err.contains("gate[0].require"), "{}", told.err);
}

#[test]
fn paths_units_and_short_names_of_a_machine_are_understood() {
    let folder = Folder::new();
    let text = r#"schema = 1
machine = "machines/rig.toml"
seed = 3

[[uncertain]]
path = "contact.friction"
as = "mu"
distribution = "uniform"
lower = 0.05
upper = 0.25

[[vary]]
path = "contact.gap"
values = ["0.5 mm", "0.9 mm"]

[[vary]]
path = "contact.detection"
values = ["hyp1", "hyp2"]

[design]
kind = "monte-carlo"
samples = 3

[[question]]
name = "rub"
probability = "first_contact_s > 0 s and mu < 0.3 and `contact.gap` < 0.7 mm"

[[question]]
name = "gap"
difference = ["900 um", "0.0005 m"]
vary = "contact.gap"
mean = "max_bearing_load_N"

[[question]]
name = "over"
fragility = "contact.detection"
probability = "max_bearing_load_N > 0"
"#;
    let out = folder.name("out");
    let ran = say(&["run", &folder.write("s.toml", text), "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let answers = json(&fs::read_to_string(folder.path("out/answers.json")).expect("written"));
    let list = answers["answers"].as_array().expect("a list");
    let groups: Vec<String> = list.iter().map(|answer| answer["group"].to_string()).collect();
    let gap = "diaphragms.seal.contact.gap_m";
    // the JSON reader of this test does not keep the order of keys
    assert_eq!(groups[0], format!("{{\"detection\":\"hyp1\",\"{gap}\":0.0005}}"));
    assert_eq!(groups[4..6], ["{\"detection\":\"hyp1\"}", "{\"detection\":\"hyp2\"}"]);
    assert_eq!(groups[6..], [format!("{{\"{gap}\":0.0005}}"), format!("{{\"{gap}\":0.0009}}")]);
    let figure = |at: usize| list[at]["estimate"].as_f64();
    assert_eq!((figure(0), figure(2)), (Some(1.0), Some(0.0)), "the rig rubs at 0.5 mm; 0.9 mm is above 0.7 mm");
    assert!(ran.out.contains("0.0009 less 0.0005"), "{}", ran.out);
}

/// Failed runs count with the values that they reached while all guards held: in these runs the energy balance fails.
#[test]
fn a_failed_run_counts_by_what_it_had_reached() {
    let folder = Folder::new();
    let text = r#"schema = 1
machine = "machines/rig.toml"
seed = 3

[set]
"run.guard.energy_balance" = 1e-11

[[uncertain]]
path = "contact.friction"
distribution = "uniform"
lower = 0.05
upper = 0.25

[design]
kind = "monte-carlo"
samples = 4

[[question]]
name = "any"
probability = "max_bearing_load_N >= 0"

[[question]]
name = "huge"
probability = "max_bearing_load_N > 1 GN"
"#;
    let out = folder.name("out");
    let ran = say(&["run", &folder.write("s.toml", text), "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let (header, rows) = crate::support::table(&out);
    let place = |name: &str| header.iter().position(|column| column == name).expect("a column");
    assert!(rows.iter().all(|row| row[place("status")] == "invalid"), "{rows:?}");
    assert!(rows.iter().all(|row| !row[place("guarded_max_bearing_load_N")].is_empty()), "{rows:?}");
    let answers = json(&fs::read_to_string(folder.path("out/answers.json")).expect("written"));
    let figures = |at: usize| {
        let answer = &answers["answers"][at];
        ["bad", "events", "estimate", "estimate_if_bad_harmful"].map(|key| answer[key].as_f64().expect("a number"))
    };
    // the first question is decided by the values reached; for the second the rest of the run is unknown
    assert_eq!(figures(0), [4.0, 4.0, 1.0, 1.0]);
    assert_eq!(figures(1), [4.0, 0.0, 0.0, 1.0]);
}

#[test]
fn where_others_could_write_answers_are_only_told() {
    let folder = Folder::new();
    let (study, out) = (folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}")), folder.name("out"));
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    fs::remove_file(folder.path("out/answers.json")).expect("removed");
    fs::set_permissions(folder.path("out"), fs::Permissions::from_mode(0o777)).expect("own");
    let said = say(&["answer", &out]);
    assert!(said.code == 0 && said.out.contains("w = 1: P(g < 0) = 2"), "{} {}", said.code, said.err);
    assert!(said.err.contains("the answers are not written: ") && said.err.contains("mode 0777"), "{}", said.err);
    assert!(!folder.path("out/answers.json").exists() && !said.out.contains("answers.json"));
    assert_eq!(say(&["gate", &out]).code, 0);
}

#[test]
fn a_fragility_has_a_bin_for_each_word_in_the_order_of_its_list() {
    let folder = Folder::new();
    let text = r#"schema = 1
machine = "machines/rig.toml"

[set]
"run.end_time" = "2 ms"

[[uncertain]]
path = "contact.detection"
distribution = "discrete"
values = ["hyp2", "hyp1"]

[[uncertain]]
path = "run.engine"
distribution = "discrete"
values = ["reduced", "full"]
weights = [1, 0]

[design]
kind = "monte-carlo"
samples = 6

[[question]]
name = "ok"
probability = "max_bearing_load_N >= 0"

[[question]]
name = "f"
fragility = "contact.detection"
probability = "max_bearing_load_N >= 0"

[[question]]
name = "engine"
fragility = "run.engine"
probability = "max_bearing_load_N >= 0"
"#;
    let out = folder.name("rig");
    let ran = say(&["run", &folder.write("rig.toml", text), "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.contains("over detection: 2 values from hyp2 to hyp1, 6 runs"), "{}", ran.out);
    assert!(ran.out.contains("P(max_bearing_load_N >= 0) = 100 %"), "{}", ran.out);
    let bins = |name: &str, column: &str| {
        let curve = bladeoff_answers::tables::read_numbers(&folder.path("rig/answers").join(name)).expect("a curve");
        curve.0.iter().find(|found| found.name == column).expect("a column").values.clone()
    };
    let n = bins("f.parquet", "n");
    assert!(n.len() == 2 && n[0] > 0.0 && n[1] > 0.0 && n[0] + n[1] == 6.0, "{n:?}");
    // the bin of a word that is never drawn has no estimate
    assert_eq!(bins("engine.parquet", "n"), [6.0, 0.0]);
    let share = bins("engine.parquet", "estimate");
    assert!(share[0] == 1.0 && !share[1].is_finite(), "{share:?}");
}

#[test]
fn what_bad_runs_leave_open_is_told_of_each_group() {
    let folder = Folder::new();
    let (text, out) = (fs::read_to_string(failing(&folder)).expect("written"), folder.name("out"));
    let asks = "\n[[question]]\nname = \"given\"\nprobability = \"x > 1.28\"\n";
    let ran = say(&["run", &folder.write("s.toml", &format!("{text}{asks}")), "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let part = |from: &str, to: &str| {
        let rest = ran.out.split_once(from).expect(from).1;
        rest.split_once(to).map_or(rest, |(part, _)| part).to_owned()
    };
    let fails = part("\nfails\n", "\ncurve\n");
    assert_eq!(fails.matches("more runs will not help: runs that are not ok").count(), 2, "{fails}");
    // formulas have no guards
    let given = part("\ngiven\n", "\nAnswers: ");
    assert!(given.contains(" bad runs counted by their inputs") && !given.contains("guard"), "{given}");
}

#[test]
fn every_gate_of_the_command_line_is_told_its_mistakes() {
    let folder = Folder::new();
    let (study, out) = (folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}")), folder.name("out"));
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let said = say(&["gate", &out, "--require", "P(gg < 0) < 5 %", "--require", "P(g < 0) < 2", "--require", "Q"]);
    assert_eq!(said.code, 3, "{}", said.err);
    for part in
        ["--require \"P(gg < 0) < 5 %\": at `gg`: there is no variable", "a bound is above 0", "\"Q\": a gate is"]
    {
        assert!(said.err.contains(part), "{part}\nin\n{}", said.err);
    }
}

#[test]
fn one_mistake_is_told_once() {
    let folder = Folder::new();
    let twice = format!("{NORMAL_STUDY}\n[[derived]]\nname = \"x\"\nformula = \"w\"\n{QUESTIONS}");
    let told = say(&["check", &folder.write("s.toml", &twice)]);
    assert!(told.code == 3 && told.err.contains("`x` is already the name of x"), "{}", told.err);
    assert_eq!(told.err.matches("  × ").count(), 1, "{}", told.err);
    assert!(told.err.contains("s.toml:24:8: derived[0]"), "{}", told.err);
    // a parameter that is there by two tables with mistakes elsewhere is one
    let other = NORMAL_STUDY.replace("sd = 1\n", "sd = -1\n")
        + "\n[[question]]\nname = \"f\"\nfragility = \"x\"\nprobability = \"g < 0\"\n";
    let told = say(&["check", &folder.write("s.toml", &other)]);
    assert!(told.err.contains("uncertain[0].sd") && !told.err.contains("could be"), "{}", told.err);
}
