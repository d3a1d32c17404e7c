//! Formula studies (`model = "function"`) through the command line, with real workers, record and table.

use crate::running::{Running, left_behind, lives, wait_until};
use crate::support::{Folder, bladeoff, json, said, say, table};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::time::Instant;

const GRID: &str = r#"schema = 1
name = "grid"
model = "function"

[function]
g = "x^2 - y"
h = "sqrt(x) / y"

[[vary]]
name = "x"
from = -1
to = 3
count = 5

[[vary]]
name = "y"
values = [0, 1, 2]
"#;

/// 600 points, each with two values of `k`.
const RANDOM: &str = r#"schema = 1
name = "random"
model = "function"
seed = 7

[function]
g = "k * a - d * d"
h = "a + bb"

[design]
kind = "monte-carlo"
samples = 600

[[uncertain]]
name = "a"
distribution = "normal"
mean = 3
sd = 1

[[uncertain]]
name = "b"
as = "bb"
distribution = "lognormal"
median = 2
cv = 0.3

[[vary]]
name = "k"
values = [1, 2]

[[derived]]
name = "d"
formula = "bb / 3"
"#;

/// Rows as maps from column to cell.
fn rows(directory: &str) -> (Vec<String>, Vec<BTreeMap<String, String>>) {
    let (header, rows) = table(directory);
    let named = |row: Vec<String>| header.iter().cloned().zip(row).collect();
    (header.clone(), rows.into_iter().map(named).collect())
}

/// A number in a row; `None` for null.
fn number(row: &BTreeMap<String, String>, column: &str) -> Option<f64> {
    Some(row[column].as_str()).filter(|cell| !cell.is_empty()).map(|cell| cell.parse().expect("a number"))
}

#[test]
fn one_thread_draws_what_several_draw() {
    let folder = Folder::new();
    let study = folder.write("random.toml", RANDOM);
    let tables = ["1", "2", "5"].map(|threads| {
        let out = folder.name(threads);
        let mut command = bladeoff(&["run", &study, "--out", &out, "--workers", "1"]);
        let ran = said(command.env("RAYON_NUM_THREADS", threads).output().expect("it starts"));
        assert_eq!(ran.code, 0, "{}", ran.err);
        fs::read(folder.path(threads).join("results.parquet")).expect("a table")
    });
    assert!(tables[0].len() > 1000 && tables[1] == tables[0] && tables[2] == tables[0]);
}

#[test]
fn a_grid_of_a_function_is_a_table_of_its_values_with_failed_rows_where_it_has_none() {
    let folder = Folder::new();
    let (study, out) = (folder.write("grid.toml", GRID), folder.name("out"));
    let run = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert_eq!(run.code, 4, "seven rows fail: {}", run.err);
    assert!(run.err.contains("grid: 15 samples of 2 formulas, 2 workers"), "{}", run.err);
    let (header, rows) = rows(&out);
    assert_eq!(header, ["sample", "x", "y", "status", "cause", "causes", "end_cause", "g", "h"], "no detection");
    assert_eq!(rows.len(), 15);
    let mut failed = 0;
    for (sample, row) in rows.iter().enumerate() {
        let (x, y) = ((sample / 3) as f64 - 1.0, (sample % 3) as f64);
        assert_eq!([number(row, "x"), number(row, "y"), number(row, "g")], [Some(x), Some(y), Some(x * x - y)]);
        let h = x.sqrt() / y;
        assert_eq!(number(row, "h"), Some(h).filter(|h| h.is_finite()), "sample {sample}");
        let verdict = ["status", "cause", "causes", "end_cause"].map(|column| row[column].as_str());
        let is_failed = !h.is_finite();
        failed += usize::from(is_failed);
        let (ok, bad) = (["ok", "", "", "evaluated"], ["failed", "non_finite", "non_finite", "failure"]);
        assert_eq!(verdict, if is_failed { bad } else { ok }, "sample {sample}");
    }
    assert_eq!(failed, 7);
    let line = |start: &str| run.out.lines().find(|line| line.starts_with(start)).expect("a line").to_owned();
    assert_eq!(line("g ").split_whitespace().collect::<Vec<_>>(), ["g", "-2", "1", "8"], "{}", run.out);
    assert!(run.out.contains("Not included: 7 (7 non_finite)."), "{}", run.out);
    // no files of a machine
    let there = |name: &str| folder.path("out").join(name).exists();
    assert!(there("study.toml") && there("plan.json") && !there("machine.toml") && !there("basis.bin"));
    // failed samples are not computed again
    let again = say(&["run", &study, "--out", &out]);
    assert!(again.code == 4 && again.err.contains("nothing to compute"), "{}", again.err);
}

#[test]
fn a_random_function_study_has_the_same_bytes_whoever_computes_it_and_whatever_happens() {
    let folder = Folder::new();
    let study = folder.write("random.toml", RANDOM);
    let bytes = |out: &str| fs::read(folder.path(out).join("results.parquet")).expect("the table");
    for (out, workers) in [("one", "1"), ("two", "2")] {
        let run = say(&["run", &study, "--out", &folder.name(out), "--workers", workers]);
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let calm = bytes("one");
    assert!(calm == bytes("two"), "another table with two workers");

    let mut worker =
        Running::start(&folder, &study, &folder.name("worker"), "who=worker,at=running,sample=300,do=kill");
    assert!(worker.end().success(), "{}", worker.said());
    assert_eq!(worker.fired(), 1, "the kill happened");
    assert!(calm == bytes("worker"), "another table after a killed worker");

    let out = folder.name("orchestrator");
    let mut killed = Running::start(&folder, &study, &out, "who=orchestrator,at=recorded,sample=300,do=kill");
    assert_eq!(killed.end().signal(), Some(9), "{}", killed.said());
    assert_eq!(killed.fired(), 1, "the kill happened");
    let workers = killed.workers();
    wait_until("its workers leave", || workers.iter().all(|&pid| !lives(pid)));
    assert!(!folder.path("orchestrator/results.parquet").exists());
    let mut rest = Running::start(&folder, &study, &out, "");
    assert!(rest.end().success(), "{}", rest.said());
    assert!(calm == bytes("orchestrator"), "another table after a killed orchestrator");
    for run in [&worker, &rest] {
        assert!(run.workers().iter().all(|&pid| !lives(pid)), "a worker outlived its run");
    }
    assert!(left_behind(&out).is_empty() && left_behind(&folder.name("worker")).is_empty());

    // each row equals its formulas to the last bit; both groups have the same points
    let (header, rows) = rows(&folder.name("one"));
    let columns = "sample,replicate,block,a,bb,k,d,status,cause,causes,end_cause,g,h";
    assert_eq!(header.join(","), columns);
    assert_eq!(rows.len(), 1200);
    for row in &rows {
        let [a, b, k, d, g, h] = ["a", "bb", "k", "d", "g", "h"].map(|name| number(row, name).expect("a value"));
        assert_eq!([d, g, h], [b / 3.0, k * a - d * d, a + b]);
        assert_eq!(row["status"], "ok");
    }
    for pair in rows.chunks(2) {
        assert_eq!((&pair[0]["a"], &pair[0]["bb"]), (&pair[1]["a"], &pair[1]["bb"]), "the same point");
        assert_ne!(pair[0]["k"], pair[1]["k"]);
    }
    let mean = rows.iter().filter_map(|row| number(row, "a")).sum::<f64>() / 1200.0;
    assert!((mean - 3.0).abs() < 4.0 / 600f64.sqrt(), "the mean of a normal variable: {mean}");
}

#[test]
fn a_derived_variable_that_is_no_number_fails_its_sample() {
    let text = RANDOM.replace("\"bb / 3\"", "\"ln(a - 3)\"").replace("\"a + bb\"", "\"bb\"");
    let folder = Folder::new();
    let (study, out) =
        (folder.write("s.toml", &format!("{text}\n[limits]\nmax_failed = \"100 %\"\n")), folder.name("out"));
    let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let (_, rows) = rows(&out);
    let failed: Vec<_> = rows.iter().filter(|row| row["status"] == "failed").collect();
    assert!(failed.len() > 400 && failed.len() < 800, "half of all: {}", failed.len());
    for row in failed {
        assert!(number(row, "a").expect("drawn") < 3.0 && row["d"].is_empty() && row["g"].is_empty(), "{row:?}");
        assert_eq!(
            (row["cause"].as_str(), number(row, "h")),
            ("non_finite", number(row, "bb")),
            "what is finite stays"
        );
    }
    assert!(rows.iter().filter(|row| row["status"] == "ok").all(|row| number(row, "a").expect("drawn") > 3.0));
}

#[test]
fn commands_tell_of_a_function_study_or_refuse_it_in_words() {
    let folder = Folder::new();
    let (study, out) = (folder.write("grid.toml", GRID), folder.name("out"));
    let check = say(&["check", &study]);
    assert_eq!(check.code, 0, "{}", check.err);
    for words in
        ["grid: 15 samples of 2 formulas", "g = x^2 - y", "h: no finite number in 7 of 15", "the whole study: about"]
    {
        assert!(check.out.contains(words), "{words}: {}", check.out);
    }
    let list = say(&["check", &study, "--list"]);
    assert!(list.out.starts_with("sample\tx\ty\n0\t-1.0\t0.0\n"), "{}", list.out);
    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "1"]).code, 4);
    let why = say(&["why", &out, "0"]);
    assert!(
        why.out.contains("a formula gave no finite number") && why.out.contains("\nh                                -")
    );
    assert!(!why.out.contains("replay"), "it cannot be replayed: {}", why.out);
    let fine = say(&["why", &out, "4"]);
    assert!(fine.out.contains("the formulas were evaluated") && !fine.out.contains("no finite"), "{}", fine.out);
    let verified = say(&["status", &out, "--verify"]);
    assert!(verified.code == 0 && verified.out.contains("failed 7"), "{}", verified.out);
    let refused = |args: &[&str], words: &str| {
        let said = say(args);
        assert!(said.code == 3 && said.err.contains(words), "{args:?}: {}: {}", said.code, said.err);
    };
    refused(&["replay", &out, "--sample", "4"], "replay computes a transient again");
    refused(&["replay", &out, "--worst", "g"], "replay computes a transient again");
    refused(&["table1", &study, "--out", &folder.name("t")], "table1 compares contact detections");
    refused(&["simulate", &study], "is a study file, not a machine");
    refused(&["modes", &study], "is a study file, not a machine");
}

#[test]
fn a_changed_formula_is_refused_and_a_grown_study_keeps_what_is_there() {
    let folder = Folder::new();
    let (study, out) = (folder.write("random.toml", RANDOM), folder.name("out"));
    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "2"]).code, 0);
    let before = fs::read(folder.path("out/results.parquet")).expect("the table");
    folder.write("random.toml", &RANDOM.replace("\"a + bb\"", "\"a - bb\""));
    let refused = say(&["run", &study, "--out", &out]);
    assert_eq!(refused.code, 3, "{}", refused.err);
    assert!(refused.err.contains("function.h") && refused.err.contains("a - bb"), "{}", refused.err);
    assert!(before == fs::read(folder.path("out/results.parquet")).expect("the table"));
    folder.write("random.toml", &RANDOM.replace("samples = 600", "samples = 700"));
    let grown = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert!(grown.code == 0 && grown.err.contains("1200 of 1400 samples are already finished"), "{}", grown.err);
    let fresh = folder.name("fresh");
    assert_eq!(say(&["run", &study, "--out", &fresh, "--workers", "2"]).code, 0);
    let bytes = |out: &str| fs::read(folder.path(out).join("results.parquet")).expect("the table");
    assert!(bytes("out") == bytes("fresh"), "a grown study is that from the beginning");
}

#[test]
fn mistakes_of_a_function_study_are_told_all_at_once_with_their_places() {
    let folder = Folder::new();
    let text = GRID
        .replace("\"x^2 - y\"", "\"x^2 - z\"")
        .replace("h = \"sqrt", "status = \"sqrt")
        .replace("name = \"grid\"", "machine = \"m.toml\"");
    let study = folder.write("grid.toml", &text);
    let said = say(&["check", &study]);
    assert_eq!(said.code, 3, "{}", said.err);
    for words in ["there is no variable `z`", "a column of every table has the name `status`", "has none"] {
        assert!(said.err.contains(words), "{words}: {}", said.err);
    }
    let at = |line: &str| 1 + text.lines().position(|found| found.starts_with(line)).expect("the line");
    for line in ["g =", "status =", "machine ="] {
        assert!(said.err.contains(&format!("grid.toml:{}:", at(line))), "{line}: {}", said.err);
    }
}

/// The number of samples per second is shown (`--nocapture`) but not checked, because it depends on the machine.
#[test]
fn a_hundred_thousand_samples_run_through_workers_record_and_table() {
    let folder = Folder::new();
    let study = folder.write("random.toml", &RANDOM.replace("samples = 600", "samples = 50000"));
    let out = folder.name("out");
    let begun = Instant::now();
    let run = say(&["run", &study, "--out", &out, "--workers", "2"]);
    let seconds = begun.elapsed().as_secs_f64();
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("100000 of 100000 samples") && run.out.contains("All runs are included."), "{}", run.out);
    println!("100000 samples of two formulas in {seconds:.1} s: {:.0} a second", 1e5 / seconds);
}

/// The Ishigami function with this design.
fn ishigami(design: &str) -> String {
    let parameter = |name: &str| {
        format!(
            "\n[[uncertain]]\nname = \"{name}\"\ndistribution = \"uniform\"\nlower = -3.141592653589793\nupper = 3.141592653589793\n"
        )
    };
    let parameters: String = ["a", "b", "c"].map(parameter).concat();
    format!(
        "schema = 1\nname = \"ishigami\"\nmodel = \"function\"\n\n[function]\n\
         y = \"sin(a) + 7 * sin(b)^2 + 0.1 * c^4 * sin(a)\"\n\n[design]\n{design}\n{parameters}\n\
         [[question]]\nname = \"high\"\nprobability = \"y > 8\"\n"
    )
}

/// Published reference: plain Joe-Kuo points from index 0, rows A, AB_i, B of 1024 base points; first order (Saltelli 2010), total (Jansen).
#[test]
fn a_saltelli_study_has_the_rows_of_the_published_estimates() {
    let folder = Folder::new();
    let study = folder.write("ishigami.toml", &ishigami("kind = \"saltelli\"\nsamples = 1024\nscramble = false"));
    let run = say(&["run", &study, "--out", &folder.name("out"), "--workers", "2"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let (_, rows) = rows(&folder.name("out"));
    assert_eq!((rows.len(), number(&rows[5119], "block"), number(&rows[5], "block")), (5120, Some(1023.0), Some(1.0)));
    let y: Vec<f64> = rows.iter().map(|row| number(row, "y").expect("a value")).collect();
    let blocks: Vec<&[f64]> = y.chunks_exact(5).collect();
    let both = || blocks.iter().flat_map(|block| [block[0], block[4]]);
    let mean = both().sum::<f64>() / 2048.0;
    let variance = both().map(|y| (y - mean) * (y - mean)).sum::<f64>() / 2048.0;
    for (i, first, total) in
        [(1, 0.332739378383, 0.558179045711), (2, 0.441313938544, 0.443284584030), (3, 0.018399909008, 0.242149373355)]
    {
        let over = |of: &dyn Fn(&[f64]) -> f64| blocks.iter().map(|block| of(block)).sum::<f64>() / 1024.0 / variance;
        assert!((over(&|y| y[4] * (y[i] - y[0])) - first).abs() < 1e-11, "{i}");
        assert!((over(&|y| 0.5 * (y[0] - y[i]) * (y[0] - y[i])) - total).abs() < 1e-11, "{i}");
    }
    // dependent rows: an estimate without interval
    assert!(run.out.contains("P(y > 8) = ") && run.out.contains("(no interval)"), "{}", run.out);
}

#[test]
fn a_morris_study_grows_by_trajectories_and_is_limited_to_whole_ones() {
    let folder = Folder::new();
    let design = |trajectories: u32| ishigami(&format!("kind = \"morris\"\ntrajectories = {trajectories}"));
    let (study, out) = (folder.write("ishigami.toml", &design(20)), folder.name("out"));
    let check = say(&["check", &study]);
    assert!(
        check.code == 0 && check.out.contains("Design: morris, 80 points of 3 uncertain parameters"),
        "{}",
        check.out
    );
    assert_eq!(say(&["run", &study, "--out", &folder.name("part"), "--limit", "11"]).code, 0);
    assert_eq!(rows(&folder.name("part")).1.len(), 8, "two of four points each");
    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "2"]).code, 0);
    let all = rows(&out).1;
    for pair in all.windows(2).filter(|pair| pair[0]["block"] == pair[1]["block"]) {
        let moved = ["a", "b", "c"].iter().filter(|name| pair[0][**name] != pair[1][**name]).count();
        assert_eq!(moved, 1, "{pair:?}");
    }
    folder.write("ishigami.toml", &design(30));
    let grown = say(&["run", &study, "--out", &out, "--workers", "2"]);
    // points of the previous grid are not computed again
    let there = grown.err.lines().find_map(|line| line.split_once(" of 120 samples are already finished"));
    let there: u32 = there.and_then(|(count, _)| count.parse().ok()).unwrap_or_else(|| panic!("{}", grown.err));
    assert!(grown.code == 0 && (80..120).contains(&there), "{}", grown.err);
    assert_eq!(rows(&out).1[..80], all[..]);
    let correlated = format!("{}\n[[correlation]]\nbetween = [\"a\", \"b\"]\nrank = 0.5\n", design(20));
    let refused = say(&["check", &folder.write("correlated.toml", &correlated)]);
    assert!(refused.code == 3 && refused.err.contains("changes one parameter at a time"), "{}", refused.err);
    let gated = format!("{}\n[[gate]]\nrequire = \"P(y > 8) < 0.5\"\n", design(20));
    let refused = say(&["check", &folder.write("gated.toml", &gated)]);
    assert!(refused.code == 3 && refused.err.contains("points of kind \"morris\" have none"), "{}", refused.err);
}

#[test]
fn a_question_about_a_value_that_a_part_leaves_out_is_refused_before_anything_is_computed() {
    let folder = Folder::new();
    let axis = "[[vary]]\nname = \"k\"\nvalues = [1, 2, 3, 4, 5, 6, 7, 8]\n";
    let asked = "\n[[question]]\nname = \"apart\"\ndifference = [1, 4]\nvary = \"k\"\nmean = \"g\"\n";
    let text = RANDOM.replace("[[vary]]\nname = \"k\"\nvalues = [1, 2]\n", axis) + asked;
    assert!(text.contains(axis));
    let (study, out) = (folder.write("random.toml", &text), folder.name("out"));
    let refused = say(&["run", &study, "--out", &out, "--scale", "0.1"]);
    assert_eq!(refused.code, 3, "{}", refused.err);
    let line = 1 + text.lines().position(|line| line.starts_with("difference")).expect("the line");
    assert!(refused.err.contains(&format!("random.toml:{line}:14: question[0].difference")), "{}", refused.err);
    assert!(
        refused.err.contains("4 is not a value of `k`: 1, 8") && refused.err.contains("--scale"),
        "{}",
        refused.err
    );
    assert!(!folder.path("out").exists(), "nothing was begun");
    let limited = say(&["run", &study, "--out", &out, "--limit", "10"]);
    assert!(limited.code == 0 && limited.out.contains("k = 1 less 4"), "{}{}", limited.out, limited.err);
}

#[test]
fn a_parameter_of_a_file_with_another_mistake_is_one_parameter() {
    let folder = Folder::new();
    let asked = "\n[[question]]\nname = \"by-a\"\nfragility = \"a\"\nprobability = \"g > 0\"\n";
    let study = folder.write("random.toml", &(RANDOM.replace("sd = 1\n", "sd = -1\n") + asked));
    let refused = say(&["check", &study]);
    assert!(refused.code == 3 && refused.err.contains("uncertain[0].sd"), "{}", refused.err);
    assert!(refused.err.contains("1 problem in"), "{}", refused.err);
}

#[test]
fn the_benchmark_of_answers_measures_every_figure() {
    let said = say(&["bench", "answers", "--rows", "4000", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let found = json(&said.out);
    assert_eq!(found["rows"].to_string(), "[4000,4096]");
    let figures = found["figures"].as_array().expect("figures");
    assert_eq!(figures.len(), 8);
    assert!(figures.iter().all(|figure| figure["value"].as_f64().is_some_and(|value| value > 0.0)), "{}", said.out);
}

#[test]
fn parameters_that_clash_or_are_too_many_are_told_at_their_own_key() {
    let folder = Folder::new();
    let vary = |name: &str| format!("\n[[vary]]\nname = \"{name}\"\nvalues = [1]\n");
    let many: String = (0..97).map(|n| vary(&format!("v{n}"))).collect();
    let more: String = (0..30).map(|n| format!("\n[[derived]]\nname = \"d{n}\"\nformula = \"1\"\n")).collect();
    let text = format!("{GRID}{}{many}{more}", vary("sample"));
    let said = say(&["check", &folder.write("grid.toml", &text)]);
    assert_eq!(said.code, 3, "{}", said.err);
    let at = |line: &str| 1 + text.lines().position(|found| found == line).expect("the line");
    for part in [
        format!("grid.toml:{}:8: vary = \"sample\": the table already has a column", at("name = \"sample\"")),
        // the 129th
        format!("grid.toml:{}:8: derived[28]: 130 parameters differ from sample to sample", at("name = \"d28\"")),
        "2 problems in".to_owned(),
    ] {
        assert!(said.err.contains(&part), "{part}\nin\n{}", said.err);
    }
}
