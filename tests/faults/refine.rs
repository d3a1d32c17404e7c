//! `[refine]`: samples where a map changes, chosen by results, with any number of workers and interruptions.

use crate::running::{Running, left_behind, signal, wait_until};
use crate::support::{Folder, Said, json, say, table};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

/// A quarter of a disc of radius 0.7, on a grid with steps of 1/32.
const DISC: &str = r#"schema = 1
name = "disc"
model = "function"

[function]
g = "x * x + y * y"

[[vary]]
name = "x"
from = 0
to = 1
count = 33

[[vary]]
name = "y"
from = 0
to = 1
count = 33

[[question]]
name = "disc"
map = ["x", "y"]
of = "P(g < 0.49)"
"#;

/// A boundary at the same place, blurred by the points of a design, and a mean.
const BLURRED: &str = r#"schema = 1
name = "blurred"
model = "function"
seed = 3

[function]
g = "x * x + y * y + 0.02 * u"

[[uncertain]]
name = "u"
distribution = "normal"
mean = 0
sd = 1

[design]
kind = "monte-carlo"
samples = 20

[[vary]]
name = "x"
from = 0
to = 1
count = 17

[[vary]]
name = "y"
from = 0
to = 1
count = 17

[[question]]
name = "disc"
map = ["x", "y"]
of = "P(g < 0.49)"

[[question]]
name = "level"
mean = "g"
"#;

const ALL: &str = "\n[refine]\nmax_samples = 5000\n";

fn run(folder: &Folder, study: &str, out: &str, more: &[&str]) -> Said {
    let said = say(&[&["run", study, "--out", &folder.name(out)], more].concat());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    said
}

fn bytes(folder: &Folder, out: &str) -> Vec<u8> {
    fs::read(folder.path(out).join("results.parquet")).expect("the table")
}

fn of_file(folder: &Folder, out: &str, name: &str) -> Value {
    json(&fs::read_to_string(folder.path(out).join(name)).expect("written"))
}

/// Sample, x, y of each row.
fn rows(folder: &Folder, out: &str) -> Vec<(u64, f64, f64)> {
    let (header, rows) = table(&folder.name(out));
    let [sample, x, y] =
        ["sample", "x", "y"].map(|name| header.iter().position(|head| head == name).expect("a column"));
    let number = |cell: &String| cell.parse::<f64>().expect("a number");
    rows.iter().map(|row| (number(&row[sample]) as u64, number(&row[x]), number(&row[y]))).collect()
}

/// Reason and number of samples of the end, from manifest and status.
fn why(folder: &Folder, out: &str) -> (String, u64) {
    let manifest = of_file(folder, out, "manifest.json");
    assert_eq!((&manifest["state"], &manifest["ended"]), (&"complete".into(), &"stop".into()));
    assert_eq!(manifest["stop"], of_file(folder, out, "status.json")["stop"]);
    let stop = &manifest["stop"];
    (stop["why"].as_str().expect("a word").to_owned(), stop["samples"].as_u64().expect("a number"))
}

#[test]
fn the_border_of_a_disc_is_found_whole_with_a_fifth_of_the_grid() {
    let folder = Folder::new();
    let plain = folder.write("plain.toml", DISC);
    let study = folder.write("s.toml", &(DISC.to_owned() + ALL));
    run(&folder, &plain, "plain", &[]);
    let said = run(&folder, &study, "out", &[]);
    let (all, some) = (rows(&folder, "plain"), rows(&folder, "out"));
    assert_eq!(all.len(), 33 * 33);
    assert!(some.len() < all.len() / 4, "{} samples", some.len());
    assert_eq!(why(&folder, "out"), ("refined".to_owned(), some.len() as u64));
    let words = format!("{} samples, chosen where the map changes; as fine as its values", some.len());
    assert!(said.out.contains(&words), "{}", said.out);
    // every combination within a step of the boundary is computed, and these are a third of all: five times the share of the plain grid
    let near = |(_, x, y): &&(u64, f64, f64)| (x.hypot(*y) - 0.7).abs() <= 1.0 / 32.0;
    let [of_all, of_some] = [&all, &some].map(|rows| rows.iter().filter(near).count());
    assert!(of_all > 60 && of_some == of_all, "{of_some} of {of_all}");
    let share = |near: usize, rows: &[_]| near as f64 / rows.len() as f64;
    assert!(share(of_some, &some) > 4.5 * share(of_all, &all), "{}", share(of_some, &some));
    // every square crossed by the boundary has its four corners
    let there: BTreeSet<u64> = some.iter().map(|row| row.0).collect();
    let is_in = |x: u64, y: u64| (x * x + y * y) as f64 / 1024.0 < 0.49;
    let mut crossed = 0;
    for (x, y) in (0..32).flat_map(|x| (0..32).map(move |y| (x, y))) {
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        if corners.iter().any(|&(a, b)| is_in(a, b) != is_in(x, y)) {
            crossed += 1;
            assert!(corners.iter().all(|(a, b)| there.contains(&(33 * a + b))), "{x} {y}");
        }
    }
    assert!(crossed > 40, "{crossed}");
    // common samples have the same values as in the plain study
    let compared = say(&["compare", &folder.name("out"), &folder.name("plain")]);
    assert!(compared.code == 0 && compared.out.contains("The same in every pair: g"), "{}", compared.out);
}

#[test]
fn the_table_is_the_same_on_one_and_three_workers_and_after_kills() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &(DISC.to_owned() + ALL));
    run(&folder, &study, "one", &["--workers", "1"]);
    run(&folder, &study, "three", &["--workers", "3"]);
    assert!(bytes(&folder, "one") == bytes(&folder, "three"), "another table on three workers");
    let all = rows(&folder, "one");
    let is_first = |sample: u64| (sample / 33).is_multiple_of(4) && (sample % 33).is_multiple_of(4);
    let first = all.iter().filter(|row| is_first(row.0)).count();
    assert_eq!(first, 81);
    let added = all.iter().map(|row| row.0).find(|sample| !is_first(*sample)).expect("one that was added");
    // the first round adds the middles of every square of 4 x 4 steps whose corners differ: those rows exist in the second round
    let is_in = |(x, y): (u64, u64)| (x * x + y * y) as f64 / 1024.0 < 0.49;
    let squares = (0..32).step_by(4).flat_map(|x| (0..32).step_by(4).map(move |y| (x, y)));
    let halved =
        squares.filter(|&(x, y)| [(4, 0), (0, 4), (4, 4)].iter().any(|(a, b)| is_in((x + a, y + b)) != is_in((x, y))));
    let middles = halved.flat_map(|(x, y)| (0..9).map(move |at| (x + 2 * (at / 3), y + 2 * (at % 3))));
    let new = middles.filter(|(x, y)| !is_first(33 * x + y)).collect::<BTreeSet<_>>().len() as u64;
    let kills = [
        ("at=recorded,sample=132", "in the first stage"),
        ("at=looking,sample=81", "at the first look"),
        (&format!("at=looking,sample={}", 81 + new), "at the second look"),
        (&format!("at=recorded,sample={added}"), "while a sample that was added is recorded"),
        ("at=writing,sample=0", "while the table is written"),
    ];
    assert!(is_first(132) && new > 20);
    for (number, (fault, when)) in kills.into_iter().enumerate() {
        let out = format!("killed-{number}");
        let fault = format!("who=orchestrator,{fault},do=kill");
        let mut killed = Running::start(&folder, &study, &folder.name(&out), &fault);
        assert!(!killed.end().success(), "{when}");
        assert_eq!(killed.fired(), 1, "{when}: the kill happened");
        assert!(!folder.path(&out).join("results.parquet").exists(), "{when}");
        let status = say(&["status", &folder.name(&out)]);
        assert!(status.code == 0 && status.out.contains("killed"), "{when}: {}{}", status.out, status.err);
        let again = run(&folder, &study, &out, &[]);
        if number > 0 {
            assert!(again.err.contains(" of 1089 samples are already finished"), "{when}: {}", again.err);
        }
        assert!(bytes(&folder, "one") == bytes(&folder, &out), "{when}: another table");
        assert_eq!(left_behind(&folder.name(&out)), Vec::<PathBuf>::new(), "{when}");
        assert!(!folder.path(&out).join("look.parquet").exists(), "{when}");
    }
    // a worker dies on an added sample
    let fault = format!("who=worker,at=running,sample={added},do=kill");
    let mut killed = Running::start(&folder, &study, &folder.name("worker"), &fault);
    assert!(killed.end().success(), "{}", killed.said());
    assert_eq!(killed.fired(), 1, "the kill happened");
    assert!(bytes(&folder, "one") == bytes(&folder, "worker"));
}

#[test]
fn a_map_that_changes_nowhere_is_left_as_it_is_and_says_so() {
    let folder = Folder::new();
    let flat = DISC.replace("g < 0.49", "g < 9") + ALL;
    let said = run(&folder, &folder.write("s.toml", &flat), "out", &[]);
    assert_eq!(why(&folder, "out"), ("unchanged".to_owned(), 81));
    assert!(said.out.contains("81 samples: the map changes nowhere between its first combinations"), "{}", said.out);
    assert_eq!(rows(&folder, "out").len(), 81);
    // the first combinations are all combinations: nothing was omitted
    let whole = DISC.replace("count = 33", "count = 2") + ALL;
    let said = run(&folder, &folder.write("s2.toml", &whole), "whole", &[]);
    assert_eq!(why(&folder, "whole"), ("refined".to_owned(), 4));
    assert!(!said.out.contains("changes nowhere"), "{}", said.out);
}

#[test]
fn another_rule_chooses_others_and_drops_nothing_that_was_finished() {
    let folder = Folder::new();
    let study = folder.write("s.toml", "");
    let run_with = |text: &str| {
        folder.write("s.toml", text);
        run(&folder, &study, "out", &[])
    };
    run_with(&(DISC.to_owned() + ALL));
    let all = rows(&folder, "out");
    let there = all.len();
    // fewer: surplus samples stay in the record
    let fewer = DISC.to_owned() + "\n[refine]\nmax_samples = 150\n";
    let said = run_with(&fewer);
    assert!(said.err.contains(&format!("{there} of 1089 samples are already finished")), "{}", said.err);
    let (ended, count) = why(&folder, "out");
    assert!(ended == "max_samples" && (140..=150).contains(&count), "{ended} {count}");
    assert!(said.out.contains("ended by `max_samples` of [refine]"), "{}", said.out);
    let check = say(&["check", &study]).out;
    assert!(check.contains("\nthe first round of [refine], 81 samples: about "), "{check}");
    assert!(check.contains("\nthe whole study, at most 150 samples: about "), "{check}");
    let some: BTreeSet<u64> = rows(&folder, "out").iter().map(|row| row.0).collect();
    assert!(all.iter().map(|row| row.0).collect::<BTreeSet<u64>>().is_superset(&some));
    let fresh = folder.write("fresh.toml", &fewer);
    run(&folder, &fresh, "fresh", &[]);
    assert_eq!(table(&folder.name("out")), table(&folder.name("fresh")));
    // other first combinations, another boundary
    let coarser =
        DISC.replace("g < 0.49", "g < 1.21") + "\n[refine]\nof = \"disc\"\nmax_samples = 5000\nfirst = [3, 5]\n";
    let said = run_with(&coarser);
    assert!(said.err.contains(&format!("{there} of 1089 samples are already finished")), "{}", said.err);
    // the study grows to twice the resolution
    let finer = (DISC.to_owned() + ALL).replace("count = 33", "count = 65");
    let status = of_file(&folder, "out", "status.json");
    let before = ["done", "surplus"].iter().map(|key| status[key].as_u64().expect("a count")).sum::<u64>();
    let said = run_with(&finer);
    assert!(said.err.contains(&format!("{before} of 4225 samples are already finished")), "{}", said.err);
    run(&folder, &folder.write("finer.toml", &finer), "finer", &[]);
    assert_eq!(rows(&folder, "out"), rows(&folder, "finer"));
    // then to the whole grid, without [refine]
    folder.write("s.toml", &DISC.replace("count = 33", "count = 65"));
    run(&folder, &study, "out", &[]);
    assert_eq!(rows(&folder, "out").len(), 65 * 65);
    assert_eq!(of_file(&folder, "out", "manifest.json")["stop"], Value::Null);
}

#[test]
fn every_command_knows_that_combinations_were_chosen() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &(BLURRED.to_owned() + ALL));
    let check = say(&["check", &study]);
    assert!(
        check.code == 0 && check.out.contains("25 of the 289 combinations of disc come first: 500 samples"),
        "{}",
        check.out
    );
    let said = run(&folder, &study, "out", &[]);
    let out = folder.name("out");
    let (_, count) = why(&folder, "out");
    assert!(count.is_multiple_of(20) && (500..3000).contains(&count), "{count}");
    // complete designs in each combination, and no share of the map
    let notes = "[refine] chose the combinations by their results";
    assert!(
        said.out.contains(notes) && said.out.contains("limits hold for a combination that was named beforehand"),
        "{}",
        said.out
    );
    let answers = of_file(&folder, "out", "answers.json");
    assert_eq!(answers["complete"], true);
    let map = &answers["answers"][0]["map"];
    let cells = map["cells"].as_array().expect("cells");
    assert_eq!(cells.len() as u64, count / 20);
    assert!(cells.iter().all(|cell| cell["n"] == 20), "{map}");
    let has_note = |answer: &Value| answer["notes"].to_string().contains(notes);
    assert!(answers["answers"].as_array().expect("answers").iter().all(has_note), "{answers}");
    assert!(!said.out.contains("% of the cells"), "{}", said.out);
    let again = say(&["answer", &out]);
    assert!(again.code == 0 && again.out.contains("Answers, of 20 points:"), "{}", again.out);
    assert_eq!(of_file(&folder, "out", "answers.json"), answers);
    let status = say(&["status", &out]);
    assert!(status.out.contains(&format!("complete: {count} samples, chosen where the map changes")), "{}", status.out);
    assert!(!status.out.contains("forecast"), "{}", status.out);
    assert_eq!(say(&["export", &out, "--csv"]).out.lines().count() as u64, 1 + count);
    let there: BTreeSet<u64> = rows(&folder, "out").iter().map(|row| row.0).collect();
    let absent = (0..289 * 20).find(|sample| !there.contains(sample)).expect("one that was left out");
    let left_out = say(&["why", &out, &absent.to_string()]);
    assert!(left_out.code == 0 && left_out.out.contains("not among those of the table"), "{}", left_out.out);
    assert_eq!(say(&["why", &out, "0"]).code, 0);
    let gate = say(&["gate", &out, "--require", "P(g < 0.49) < 0.9"]);
    assert!(gate.code == 3 && gate.err.contains("a gate would not cover the others"), "{}{}", gate.out, gate.err);
    let moved = folder.write("moved.toml", &(BLURRED.replace("0.02", "0.03") + ALL));
    run(&folder, &moved, "moved", &[]);
    let compared = say(&["compare", &out, &folder.name("moved")]);
    let no_interval = "no interval: the combinations were chosen by their results ([refine])";
    assert!(compared.out.contains(no_interval), "{}", compared.out);
    let svg = folder.name("map.svg");
    let drawn = say(&["map", &out, "--question", "disc", "--out", &svg]);
    assert!(
        drawn.code == 0 && fs::read_to_string(&svg).expect("drawn").contains("hatched: no sample"),
        "{}",
        drawn.err
    );
    let page = folder.name("report.html");
    let report = say(&["report", &out, "--out", &page]);
    assert!(report.code == 0 && fs::read_to_string(&page).expect("written").contains(notes), "{}", report.err);
    // same command: nothing to compute, nothing changed; lost files are restored with the same content
    let before = bytes(&folder, "out");
    let nothing = run(&folder, &study, "out", &[]);
    assert!(nothing.err.contains("every sample that [refine] has chosen is already finished"), "{}", nothing.err);
    assert!(before == bytes(&folder, "out"));
    for name in ["manifest.json", "timings.parquet"] {
        fs::remove_file(folder.path("out").join(name)).expect("removed");
        run(&folder, &study, "out", &[]);
        assert!(before == bytes(&folder, "out"), "{name}");
    }
    assert_eq!(why(&folder, "out").1, count);
}

#[test]
fn half_way_the_answers_are_those_of_the_last_look() {
    let folder = Folder::new();
    for (name, text, first) in [("blurred", BLURRED, 500), ("disc", DISC, 81)] {
        let study = folder.write(&format!("{name}.toml"), &(text.to_owned() + ALL));
        let out = folder.name(name);
        let fault = format!("who=orchestrator,at=looking,sample={first},do=stop");
        let mut stopped = Running::start(&folder, &study, &out, &fault);
        wait_until("the look", || stopped.fired() == 1);
        let pid = stopped.child.id();
        assert!(signal(pid, "TERM") && signal(pid, "CONT"));
        assert!(!stopped.end().success(), "{}", stopped.said());
        assert!(!folder.path(name).join("results.parquet").exists());
        let answers = say(&["answer", &out]);
        assert_eq!(answers.code, 0, "{}", answers.err);
        let head = if name == "disc" {
            "Answers so far, of "
        } else {
            "Answers so far, of all 20 points in the combinations of the last interim analysis"
        };
        assert!(answers.out.contains(head), "{}", answers.out);
        assert!(answers.out.contains("[refine] chose the combinations"), "{}", answers.out);
        assert!(!folder.path(name).join("answers.json").exists(), "answers of half a study are not kept");
        let told = json(&say(&["answer", &out, "--json"]).out);
        let cells = told["answers"][0]["map"]["cells"].as_array().expect("cells").len();
        assert!(told["complete"] == false && cells >= 25, "{cells}");
        let status = say(&["status", &out]);
        assert!(status.code == 0 && status.out.contains("resume "), "{}", status.out);
        for command in
            [&["why", &out, "0"][..], &["export", &out, "--csv"], &["report", &out, "--out", &folder.name("r.html")]]
        {
            assert_eq!(say(command).code, 0, "{command:?}");
        }
        let map = say(&["map", &out, "--question", "disc", "--out", &folder.name("half.svg")]);
        assert_eq!(map.code, 0, "{}", map.err);
        assert_eq!(say(&["compare", &out, &out]).code, 0);
        let whole = folder.name(&format!("whole-{name}"));
        assert_eq!(say(&["run", &study, "--out", &whole]).code, 0);
        assert_eq!(say(&["compare", &out, &whole]).code, 0);
        run(&folder, &study, name, &[]);
        assert!(bytes(&folder, name) == bytes(&folder, &format!("whole-{name}")));
    }
}

#[test]
fn a_part_is_refined_where_it_can_be_and_says_so_where_not() {
    let folder = Folder::new();
    let grid = folder.write("grid.toml", &(DISC.to_owned() + ALL));
    let few = run(&folder, &grid, "few", &["--limit", "40"]);
    assert!(few.err.contains("--limit takes the first samples, anywhere on the map"), "{}", few.err);
    assert_eq!(rows(&folder, "few").len(), 40);
    let coarse = run(&folder, &grid, "coarse", &["--scale", "0.3"]);
    assert!(coarse.out.contains("chosen where the map changes"), "{}", coarse.out);
    let design = folder.write("design.toml", &(BLURRED.to_owned() + ALL));
    let five = run(&folder, &design, "five", &["--limit", "5"]);
    assert!(five.out.contains("Answers, of 5 points:"), "{}", five.out);
    let (_, count) = why(&folder, "five");
    assert!(count.is_multiple_of(5) && count < 700, "{count}");
}

#[test]
fn regimes_of_a_machine_are_refined() {
    let folder = Folder::new();
    let study = folder.write(
        "rig.toml",
        r#"schema = 1
name = "rig"
machine = "machines/rig.toml"
[[vary]]
path = "contact.gap"
from = "0.4 mm"
to = "2 mm"
count = 9
[[vary]]
path = "contact.friction"
values = [0.1, 0.15, 0.2]
[[question]]
name = "loads"
map = ["contact.gap", "contact.friction"]
of = "max_bearing_load_N"
[refine]
max_samples = 27
first = [3, 2]
"#,
    );
    run(&folder, &study, "out", &[]);
    let (header, rows) = table(&folder.name("out"));
    let column = |name: &str| header.iter().position(|head| head.contains(name)).expect("a column");
    let regimes: BTreeSet<&str> = rows.iter().map(|row| row[column("rub_regime")].as_str()).collect();
    assert!(regimes.len() > 1, "a map with a border: {regimes:?}");
    assert!((7..27).contains(&rows.len()), "{} rows", rows.len());
    assert_eq!(why(&folder, "out").0, "refined");
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let folder = Folder::new();
    let refused = |text: &str| {
        let check = say(&["check", &folder.write("wrong.toml", text)]);
        assert_eq!(check.code, 3, "{}{}", check.out, check.err);
        check.err
    };
    for (rule, part) in [
        ("", "refine.max_samples"),
        ("max_samples = 0", "refine.max_samples = 0"),
        ("max_samples = \"many\"", "refine.max_samples"),
        ("max_samples = 80", "81 samples come first, and max_samples = 80 allows no more"),
        ("max_sampels = 500", "did you mean `max_samples`?"),
        ("max_samples = 500\nof = \"disk\"", "did you mean `disc`?"),
        ("max_samples = 500\nfirst = [1, 9]", "refine.first = [1, 9]: is not two whole numbers from 2 on"),
        ("max_samples = 500\nfirst = 9", "refine.first"),
        ("max_samples = 5000\nfirst = [34, 9]", "34 and 9 values come first, of 33 and 33"),
    ] {
        let err = refused(&format!("{DISC}\n[refine]\n{rule}\n"));
        assert!(err.contains(part), "{rule}: {err}");
        assert!(err.contains("wrong.toml:"), "{rule}: {err}");
    }
    let with = |text: &str| refused(&(text.to_owned() + ALL));
    let [question, of] = [DISC.find("[[question]]").expect("asked"), DISC.find("of = ").expect("asked")];
    assert!(with(&DISC[..question]).contains("needs a [[question]] with a map, which this study does not have"));
    let two = format!("{DISC}\n[[question]]\nname = \"other\"\nmap = [\"x\", \"y\"]\nof = \"P(g < 1)\"\n");
    assert!(with(&two).contains("does not say which map"), "{}", with(&two));
    let plain = format!("{}of = \"g\"\n", &DISC[..of]);
    assert!(with(&plain).contains("formulas have no regime"), "{}", with(&plain));
    let together = DISC.replace("count = 33", "count = 33\nzip = \"pair\"");
    assert!(with(&together).contains("x and y advance together"), "{}", with(&together));
    let twice = DISC.replacen("from = 0\nto = 1\ncount = 33", "values = [0, 1, 1]", 1);
    assert!(with(&twice).contains("x has the value 1 twice"), "{}", with(&twice));
    folder.write("points.csv", "contact.gap,contact.friction\n5e-4,0.1\n5e-4,0.2\n9e-4,0.1\n9e-4,0.2\n");
    let of_points = "schema = 1\nname = \"p\"\nmachine = \"machines/rig.toml\"\n[points]\nfile = \"points.csv\"\n[[question]]\n\
                     name = \"loads\"\nmap = [\"contact.gap\", \"contact.friction\"]\nof = \"max_bearing_load_N\"\n";
    assert!(with(of_points).contains("contact.friction advance together"), "{}", with(of_points));
    let uncertain = BLURRED.replace("map = [\"x\", \"y\"]", "map = [\"u\", \"y\"]");
    assert!(with(&uncertain).contains("u has no given values to choose from"), "{}", with(&uncertain));
    let gated = BLURRED.to_owned() + "\n[[gate]]\nrequire = \"P(g < 0.49) < 0.9\"\n";
    assert!(with(&gated).contains("a [[gate]] would not cover them"), "{}", with(&gated));
    let stopped = BLURRED.to_owned() + "\n[stop]\nsamples = 10\n";
    assert!(with(&stopped).contains("[stop] ends a study after a number of points"), "{}", with(&stopped));
}
