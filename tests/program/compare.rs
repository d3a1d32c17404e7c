//! `bladeoff compare`, end to end: studies of formulas with a known difference, tables of earlier builds, and arguments that are neither.

use crate::support::{Folder, root, say, table};
use serde_json::Value;
use std::fs;
use std::path::Path;

const STUDY: &str = r#"schema = 1
model = "function"
seed = 5

[function]
g = "10*x"
h = "x * w"
r = "sqrt(2.5 - x)"

[[uncertain]]
name = "x"
distribution = "normal"
mean = 0
sd = 1

[[uncertain]]
name = "y"
distribution = "normal"
mean = 0
sd = 1

[[vary]]
name = "w"
values = [1, 2]

[design]
kind = "monte-carlo"
samples = 1000
"#;

/// Runs a study with this text; exit code 4 is accepted, because some samples of these studies fail.
fn run(folder: &Folder, name: &str, text: &str) -> String {
    let (study, out) = (folder.write(&format!("{name}.toml"), text), folder.name(name));
    let ran = say(&["run", &study, "--out", &out]);
    assert!([0, 4].contains(&ran.code), "{}", ran.err);
    out
}

/// A study of formulas without random points: one number `x` from 1 to 3.
fn grid(folder: &Folder, name: &str, formula: &str) -> String {
    let vary = "[[vary]]\nname = \"x\"\nvalues = [1, 2, 3]\n";
    run(folder, name, &format!("schema = 1\nmodel = \"function\"\n[function]\ng = \"{formula}\"\n{vary}"))
}

fn compared(args: &[&str]) -> (i32, Value) {
    let said = say(&[&["compare", "--json"], args].concat());
    let json = serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {} {}", said.out, said.err));
    (said.code, json)
}

fn column<'a>(found: &'a Value, list: &str, name: &str) -> &'a Value {
    let all = found[list].as_array().expect("a list");
    all.iter().find(|one| one["column"] == name).unwrap_or_else(|| panic!("{name} in {list}: {found}"))
}

#[test]
fn the_interval_of_paired_differences_holds_the_known_one() {
    let folder = Folder::new();
    let a = run(&folder, "a", STUDY);
    // E(B - A) = 0.3, much smaller than the scatter of g; the values of w in reverse order give other sample numbers
    let text = STUDY.replace("10*x\"", "10*x + 0.3 + 0.2*y\"").replace("[1, 2]", "[2, 1]");
    let b = run(&folder, "b", &text);
    let (code, found) = compared(&[&a, &b]);
    assert_eq!(code, 0);
    assert_eq!((&found["matched"]["pairs"], &found["matched"]["repeated"]), (&2000.into(), &0.into()));
    assert_eq!(found["inputs"], serde_json::json!(["x", "y", "w"]));
    let g = column(&found, "paired", "g");
    let [low, high] = ["low", "high"].map(|end| g["mean"][end].as_f64().expect("a limit"));
    assert!(low < 0.3 && 0.3 < high && high - low < 0.03, "{low} to {high}");
    // both rows of a point changed by the same amount: the interval is that of 1000 pairs, t 0.2/sqrt(1000), and not that of 2000
    assert!(high - low > 0.023, "{low} to {high}");
    let h = column(&found, "paired", "h");
    assert_eq!(h["same"], h["pairs"]);
    // the pair with the largest difference is that of the tables
    let (header, rows) = table(&a);
    let at = |name: &str| header.iter().position(|column| column == name).expect("there");
    let first = &g["largest_changes"][0];
    let sample = first["a"].as_u64().expect("a number") as usize;
    assert_ne!(first["a"], first["b"], "the values of w are in another order");
    for input in ["x", "y", "w"] {
        assert_eq!(first["inputs"][input], rows[sample][at(input)].as_str(), "{input}");
    }
    let farthest = rows.iter().filter(|row| row[at("status")] == "ok");
    let y = farthest.map(|row| (0.3 + 0.2 * row[at("y")].parse::<f64>().expect("a number")).abs());
    let moved = first["value_b"].as_f64().expect("b") - first["value_a"].as_f64().expect("a");
    assert!((moved.abs() - y.fold(0.0, f64::max)).abs() < 1e-9, "{moved}");
    let words = say(&["compare", &a, &b]).out;
    for part in
        ["Matched by x, y, w: 2000 pairs\n", "function.g: 10*x in A", "The same in every pair: h, r\n", " of A, "]
    {
        assert!(words.contains(part), "{part}\nin\n{words}");
    }
}

#[test]
fn rows_that_changed_their_status_are_counted_and_named_and_never_a_difference() {
    let folder = Folder::new();
    let a = run(&folder, "a", STUDY);
    let b = run(&folder, "b", &STUDY.replace("sqrt(2.5 - x)", "sqrt(2 - x)"));
    let x = |directory: &str| {
        let (header, rows) = table(directory);
        let at = header.iter().position(|column| column == "x").expect("there");
        rows.into_iter().map(move |row| row[at].parse::<f64>().expect("a number")).collect::<Vec<_>>()
    };
    let bad = |limit: f64| x(&a).iter().filter(|x| **x > limit).count();
    let (before, after) = (bad(2.5), bad(2.0));
    assert!(before > 0 && after > before + 10, "{before} {after}");
    let (code, found) = compared(&[&a, &b]);
    let status = &found["status"];
    assert_eq!(code, 0, "without a tolerance nothing is out of it");
    assert_eq!((&status["bad_alike"], &status["changed"]), (&before.into(), &(after - before).into()));
    assert_eq!(status["ok"], 2000 - after);
    let change = &status["changes"][0];
    assert_eq!((&change["from"], &change["to"]), (&"ok".into(), &"failed: non_finite".into()));
    assert_eq!(change["pairs"].as_array().map(Vec::len), Some((after - before).min(100)));
    let first = change["pairs"][0]["inputs"]["x"].as_str().expect("told").parse::<f64>().expect("a number");
    assert!(first > 2.0 && first <= 2.5, "{first}");
    assert_eq!(column(&found, "paired", "g")["pairs"], 2000 - after);
    // a change of status is out of tolerance, whichever column the tolerance is for
    let said = say(&["compare", &a, &b, "--tolerance", "g 0"]);
    assert_eq!(said.code, 4, "{}", said.out);
    for part in ["ok in A, failed: non_finite in B", "of another status count as out of tolerance", "g 0: within in "] {
        assert!(said.out.contains(part), "{part}\nin\n{}", said.out);
    }
    assert!(said.out.ends_with("Out of tolerance.\n"));
}

#[test]
fn the_bound_of_a_tolerance_is_within_and_of_zero_only_zero_is() {
    let folder = Folder::new();
    let (zero, seven) = (grid(&folder, "zero", "0"), grid(&folder, "seven", "0.7"));
    let exit = |a: &str, b: &str, tolerance: &str| say(&["compare", a, b, "--tolerance", tolerance]).code;
    let bound = grid(&folder, "bound", "0.707");
    assert_eq!(exit(&seven, &bound, "g 1 %"), 0);
    assert_eq!(exit(&seven, &bound, "g 0.007"), 0);
    assert_eq!(exit(&seven, &bound, "g 0.99 %"), 4);
    assert_eq!(exit(&seven, &bound, "g 0"), 4);
    let beyond = grid(&folder, "beyond", "0.7071");
    assert_eq!(exit(&seven, &beyond, "g 1 %"), 4);
    // of several tolerances all have to hold
    let both = say(&["compare", &seven, &bound, "--tolerance", "g 1 %", "--tolerance", "g 1e-3"]);
    assert_eq!(both.code, 4, "{}", both.out);
    assert!(
        both.out.contains("g 1 %: within in 3 pairs") && both.out.contains("g 1e-3: out of tolerance in 3 of 3 pairs"),
        "{}",
        both.out
    );
    let tiny = grid(&folder, "tiny", "1e-12");
    assert_eq!(exit(&zero, &zero, "g 0 %"), 0);
    assert_eq!(exit(&zero, &tiny, "g 50 %"), 4, "per cent of 0");
    assert_eq!(exit(&tiny, &zero, "g 100 %"), 0, "per cent are of A");
    assert_eq!(exit(&zero, &tiny, "g 1e-12"), 0);
}

#[test]
fn other_points_are_two_samples() {
    let folder = Folder::new();
    let a = run(&folder, "a", STUDY);
    let b = run(&folder, "b", &STUDY.replace("seed = 5", "seed = 6").replace("10*x\"", "10*x + 8\""));
    let (code, found) = compared(&[&a, &b]);
    assert_eq!((code, &found["matched"]["pairs"], &found["matched"]["only_in_a"]), (0, &0.into(), &2000.into()));
    let limits = |found: &Value, figure: &str| {
        let g = column(found, "apart", "g");
        let found = if figure == "mean" { &g["mean"] } else { &g["quantiles"][0]["difference"] };
        ["low", "high"].map(|end| found[end].as_f64().expect("a limit"))
    };
    for (figure, wide) in [("mean", 1.9), ("median", 3.2)] {
        let [low, high] = limits(&found, figure);
        // the result of one pair of studies: the known value must be within twice the 95 % interval
        let half = 0.5 * (high - low);
        assert!(low - half < 8.0 && 8.0 < high + half && high - low < wide, "{figure}: {low} to {high}");
    }
    // different inputs from the same random numbers, and no run fails: every point differs by 5
    let whole = STUDY.replace("sqrt(2.5 - x)", "x");
    let of_whole = run(&folder, "whole", &whole);
    let alike = run(&folder, "alike", &whole.replacen("mean = 0", "mean = 0.5", 1));
    let (_, of_alike) = compared(&[&of_whole, &alike]);
    for (figure, wide) in [("mean", 0.01), ("median", 0.3)] {
        let [low, high] = limits(&of_alike, figure);
        assert!(low < 5.0 + 1e-9 && 5.0 - 1e-9 < high && high - low < wide, "{figure}: {low} to {high}");
    }
    // if no row is compared, the tolerance is not met
    let said = say(&["compare", &a, &b, "--tolerance", "g 1000 %"]);
    assert_eq!(said.code, 4, "{}", said.out);
    for part in
        ["no value of x is in both: --ignore x matches", "nothing could be compared", "without partner: not compared"]
    {
        assert!(said.out.contains(part), "{part}\nin\n{}", said.out);
    }
    // an input of only one of the studies
    let c = run(&folder, "c", &STUDY.replace("[[vary]]\nname = \"w\"\nvalues = [1, 2]\n", "").replace("x * w", "x"));
    let said = say(&["compare", &a, &c]);
    assert!(said.out.contains("w is an input only in A: rows match only with --ignore w"), "{}", said.out);
    let (_, found) = compared(&[&a, &c, "--ignore", "w"]);
    let matched = &found["matched"];
    assert_eq!(
        (&matched["pairs"], &matched["unclear_in_a"], &matched["unclear_in_b"]),
        (&0.into(), &2000.into(), &1000.into())
    );
}

#[test]
fn repeats_match_in_order_and_ignored_inputs_are_told_of_both() {
    let folder = Folder::new();
    let (a, b) = (grid(&folder, "a", "x"), grid(&folder, "b", "x + 1"));
    let (_, found) = compared(&[&a, &b, "--ignore", "x"]);
    assert_eq!((&found["matched"]["pairs"], &found["matched"]["repeated"]), (&3.into(), &3.into()));
    assert_eq!(column(&found, "paired", "g")["mean"]["estimate"], 1.0);
    let c = run(
        &folder,
        "c",
        "schema = 1\nmodel = \"function\"\n[function]\ng = \"x\"\n[[vary]]\nname = \"x\"\nvalues = [4, 5, 6]\n",
    );
    let said = say(&["compare", &a, &c, "--ignore", "x"]);
    assert!(said.out.contains("x = 1.0 in A, 4.0 in B") && said.out.contains("+3"), "{}", said.out);
    assert!(said.out.contains("a study without [design] has chosen samples"), "{}", said.out);
}

#[test]
fn what_is_named_wrongly_is_told_all_at_once() {
    let folder = Folder::new();
    let vary = "[[vary]]\nname = \"speed\"\nvalues = [1, 2, 3]\n";
    let study = format!("schema = 1\nmodel = \"function\"\n[function]\nload = \"speed\"\n{vary}");
    let a = run(&folder, "a", &study);
    let said = say(&[
        "compare",
        &a,
        &a,
        "--tolerance",
        "laod 1 %",
        "--tolerance",
        "load",
        "--tolerance",
        "speed 1",
        "--ignore",
        "sped",
        "--ignore",
        "load",
        "--tolerance",
        "load -1",
        "--ignore",
        "sample",
    ]);
    assert_eq!(said.code, 3, "{}", said.err);
    for part in [
        "--tolerance \"laod 1 %\": there is no column laod; did you mean load?",
        "--tolerance \"load\": it has no value",
        "--tolerance \"speed 1\": speed is an input",
        "--tolerance \"load -1\": a tolerance is 0 or more",
        "--ignore \"sped\": neither table has such an input; did you mean speed?",
        "--ignore \"load\": that is a result",
        "--ignore \"sample\": the number of a sample is not an input",
    ] {
        assert!(said.err.contains(part), "{part}\nin\n{}", said.err);
    }
    assert!(said.out.is_empty());
    let text = folder.write("text.parquet", "not a table");
    for other in [folder.name("gone"), text, folder.name("a/timings.parquet"), folder.name("machines")] {
        for args in [["compare", &a, &other], ["compare", &other, &a]] {
            let said = say(&args);
            assert!(said.code == 3 && said.out.is_empty(), "{args:?}: {} {}", said.code, said.err);
            assert!(
                said.err.contains(Path::new(&other).file_name().expect("a name").to_str().expect("UTF-8")),
                "{}",
                said.err
            );
        }
    }
    assert_eq!(say(&["compare", &a]).code, 2);
    // a table that was changed after it was written is not compared
    let path = folder.path("a/results.parquet");
    let mut bytes = fs::read(&path).expect("there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).expect("written");
    let said = say(&["compare", &a, &a]);
    assert!(said.code == 6 && said.err.contains("has changed since it was written"), "{} {}", said.code, said.err);
}

#[test]
fn names_and_values_from_outside_stay_in_their_line() {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    // the id contains a character that changes the writing direction; the loader rejects line feeds
    folder.write("points.csv", "contact.gap,id\n0.5 mm,\"a\u{202e}b\"\n0.9 mm,c\n");
    let out = |name: &str, end: &str| {
        folder.write("rig.toml", &rig.replace("\"0.17 s\"", end));
        let study = "schema = 1\nmachine = \"rig.toml\"\n[points]\nfile = \"points.csv\"\ncarry = [\"id\"]\n";
        let (file, out) = (folder.write(&format!("{name}.toml"), study), folder.name(&format!("{name}\nINJECTED")));
        let ran = say(&["run", &file, "--out", &out]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        out
    };
    let (a, b) = (out("a", "\"0.01 s\""), out("b", "\"0.012 s\""));
    let said = say(&["compare", &a, &b, "--tolerance", "max_bearing_load_N 0"]);
    assert_eq!(said.code, 4, "{} {}", said.out, said.err);
    assert!(said.out.contains("id = a\\u{202e}b") && said.out.contains("run.end_time: 10 ms in A"), "{}", said.out);
    assert!(!said.out.lines().any(|line| line.trim_start().starts_with("INJECTED")), "{}", said.out);
    let (_, found) = compared(&[&a, &b]);
    let movers = column(&found, "paired", "max_bearing_load_N")["largest_changes"].as_array().expect("a list").clone();
    assert!(movers.iter().any(|mover| mover["inputs"]["id"] == "a\u{202e}b"), "{movers:?}");
    let gone = say(&["compare", &folder.name("gone\nINJECTED"), &b]);
    assert!(gone.code == 3 && gone.err.contains("gone\\u{a}INJECTED"), "{} {}", gone.code, gone.err);
}

/// A copy of a result directory of the present format.
fn fixture(folder: &Folder, name: &str) -> String {
    let from = root().join("tests/fixtures/0.1.0-d2e886c").join(name);
    copy(&from, &folder.path(name));
    folder.name(name)
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("created");
    for entry in fs::read_dir(from).expect("there").flatten() {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            fs::copy(from, to).expect("copied");
        }
    }
}

#[test]
fn a_table_alone_and_a_study_half_done_are_compared_for_what_they_are() {
    let folder = Folder::new();
    let (whole, half) = (fixture(&folder, "complete"), fixture(&folder, "halfway"));
    let alone = folder.name("copied.parquet");
    fs::copy(folder.path("complete/results.parquet"), &alone).expect("copied");
    let load = ["--tolerance", "max_bearing_load_N 0"];
    let (code, found) = compared(&[&[whole.as_str(), &alone], &load[..]].concat());
    assert_eq!((code, &found["differs"], &found["beyond"]), (0, &serde_json::json!([]), &false.into()), "{found}");
    assert_eq!(found["matched"]["pairs"], found["a"]["rows"]);
    let all = found["a"]["rows"].as_u64().expect("a number");
    // runs without contact have no value in this column, which is not a difference
    let empty = column(&found, "paired", "first_contact_s")["empty"].as_u64().expect("a number");
    assert!(empty > 0, "some do not touch");
    // samples that the unfinished study does not have make the comparison out of tolerance
    let said = say(&[&["compare", whole.as_str(), &half], &load[..]].concat());
    assert!(said.code == 4 && said.err.contains("warning: B: the study is incomplete"), "{} {}", said.code, said.err);
    let (code, found) = compared(&[&[half.as_str(), &whole], &load[..]].concat());
    let pairs = found["matched"]["pairs"].as_u64().expect("a number");
    assert!(code == 0 && 0 < pairs && pairs < all, "{code} {found}");
    assert_eq!(found["matched"]["only_in_b"], all - pairs);
}

#[test]
fn a_few_unchanged_columns_are_named_and_many_are_counted() {
    let folder = Folder::new();
    let outputs = |count: usize, changed: &str| {
        let same: String = (0..count).map(|k| format!("f{k} = \"{k} + x\"\n")).collect();
        format!(
            "schema = 1\nmodel = \"function\"\n[function]\ng = \"{changed}\"\n{same}[[vary]]\nname = \"x\"\nvalues = [1, 2, 3]\n"
        )
    };
    let names: Vec<String> = (0..10).map(|k| format!("f{k}")).collect();
    for (count, line) in
        [(10, names.join(", ")), (11, "11 other columns".to_owned()), (99, "99 other columns".to_owned())]
    {
        let [a, b] =
            ["x", "2*x"].map(|changed| run(&folder, &format!("{count}-{}", changed.len()), &outputs(count, changed)));
        let said = say(&["compare", &a, &b]);
        let line = format!("\nThe same in every pair: {line}\n");
        assert!(said.code == 0 && said.out.contains(&line), "{count}: {} {}", said.out, said.err);
    }
}
