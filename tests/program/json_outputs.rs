//! `--json` of `check`, `why`, `gate`, `map`, `replay`, `plot`: one object on standard output, with the values of the text.

use crate::support::{Folder, json, say};
use serde_json::Value;
use std::collections::BTreeSet;

/// 16 runs of 0.06 s: gap x friction, four angles each.
const STUDY: &str = r#"schema = 1
name = "asked"
machine = "machines/rig.toml"
seed = 1

[set]
"run.end_time" = "0.06 s"
"run.engine" = "exponential"

[[vary]]
path = "contact.gap"
values = ["0.4 mm", "1 mm"]

[[vary]]
path = "contact.friction"
values = [0.05, 0.25]

[design]
kind = "monte-carlo"
samples = 4

[[uncertain]]
path = "blade_off.phase"
distribution = "periodic"
lower = "0 deg"
upper = "360 deg"

[[gate]]
require = "P(max_bearing_load_N > 1 N) < 0.5"
confidence = 0.9
"#;

/// Names of the keys that the page documents for a command: all words in backquotes below its heading.
fn documented(command: &str) -> BTreeSet<&'static str> {
    let page = include_str!("../../docs/json-output.md");
    let (_, after) = page.split_once(&format!("\n## `{command}`\n")).unwrap_or_else(|| panic!("no heading {command}"));
    let section = after.split("\n## ").next().expect("a section");
    section.split('`').skip(1).step_by(2).collect()
}

/// Keys of an object and of its nested objects, except objects whose keys are columns, paths or words of the study.
fn keys(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                found.insert(key.clone());
                if !["row", "result", "parameters", "group", "by_status", "by_cause", "map"].contains(&key.as_str())
                    || value.is_array()
                {
                    keys(value, found);
                }
            }
        }
        Value::Array(all) => all.iter().for_each(|one| keys(one, found)),
        _ => {}
    }
}

#[test]
fn every_key_is_documented() {
    let folder = Folder::new();
    let (study, out, rig) = (folder.write("asked.toml", STUDY), folder.name("out"), folder.name("machines/rig.toml"));
    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "2"]).code, 0);
    let questioned = folder.write(
        "questioned.toml",
        &STUDY.replace("[[gate]]", "[[question]]\nname = \"load\"\nmean = \"max_bearing_load_N\"\n\n[[gate]]"),
    );
    let answered = folder.name("answered");
    assert_eq!(say(&["run", &questioned, "--out", &answered, "--workers", "2"]).code, 0);
    let calls: [(i32, &[&str]); 10] = [
        (0, &["check", &study]),
        (0, &["check", &rig]),
        (0, &["modes", &rig]),
        (0, &["paths", &rig]),
        (0, &["status", &out]),
        (0, &["why", &out, "0"]),
        (0, &["answer", &answered]),
        (4, &["gate", &out]),
        (0, &["compare", &out, &answered]),
        (0, &["replay", &out, "--sample", "0"]),
    ];
    for (code, words) in calls {
        let found = object(code, &[words, &["--json"]].concat());
        let (known, mut all) = (documented(words[0]), BTreeSet::new());
        keys(&found, &mut all);
        assert!(all.len() > 2, "{words:?}: {found}");
        let unknown: Vec<&String> = all.iter().filter(|key| !known.contains(key.as_str())).collect();
        assert!(unknown.is_empty(), "{words:?}: keys that docs/json-output.md does not have: {unknown:?}");
    }
}

fn object(code: i32, args: &[&str]) -> Value {
    let said = say(args);
    assert_eq!(said.code, code, "{args:?}: {}{}", said.out, said.err);
    let found = json(&said.out);
    assert!(found.is_object(), "{args:?}: {}", said.out);
    found
}

#[test]
fn a_study_has_the_same_values_in_every_json() {
    let folder = Folder::new();
    let (study, out) = (folder.write("asked.toml", STUDY), folder.name("out"));
    let checked = object(0, &["check", &study, "--json"]);
    assert_eq!(
        (&checked["samples"], &checked["design"]["points"], &checked["combinations"]),
        (&16.into(), &4.into(), &4.into())
    );
    assert_eq!(checked["engine"], "exponential");
    assert_eq!(checked["gates"][0]["confidence"], 0.9);
    let origin = |path: &str| {
        let mut all = checked["parameters"].as_array().expect("a list").iter();
        let found = all.find(|one| one["path"].as_str().is_some_and(|known| known.ends_with(path)));
        found.unwrap_or_else(|| panic!("{path}: {checked}"))["origin"].clone()
    };
    assert_eq!([origin("contact.gap"), origin("blade_off.phase")], ["varied", "uncertain"]);
    let durations = &checked["estimate"]["durations"][0];
    assert!(durations["samples"] == 16 && durations["wall_s"][0].as_f64() > Some(0.0), "{checked}");
    let both = say(&["check", &study, "--json", "--list"]);
    assert_eq!(both.code, 2, "{}", both.err);

    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "2"]).code, 0);
    let why = object(0, &["why", &out, "0", "--json"]);
    assert_eq!((&why["sample"], &why["samples"], &why["row"]["sample"]), (&0.into(), &16.into(), &0.into()));
    assert_eq!(why["parameters"]["diaphragms.seal.contact.gap"], 0.0004);
    assert!(why["lines"].as_array().expect("a list").iter().any(|line| line["name"] == "compute it"), "{why}");

    // replay: the values of the row, computed again
    let replayed = object(0, &["replay", &out, "--sample", "0", "--json"]);
    assert!(
        replayed["compared"].as_u64() > Some(50) && replayed["differences"] == Value::Array(Vec::new()),
        "{replayed}"
    );
    let load = &why["row"]["max_bearing_load_N"];
    assert!(load.as_f64() > Some(0.0) && replayed["result"]["max_bearing_load_N"] == *load, "{load}");
    let set = object(0, &["replay", &out, "--sample", "0", "--set", "contact.gap=0.9 mm", "--json"]);
    assert_eq!((&set["set"][0]["now"], &set["row"]["max_bearing_load_N"]), (&"0.9 mm".into(), load));
    assert!(set["result"]["max_bearing_load_N"] != *load && set.get("compared").is_none(), "{set}");

    // every load is above 1 N
    let gate = object(4, &["gate", &out, "--json"]);
    assert_eq!((&gate["verdict"], &gate["complete"], &gate["points"]), (&"failed".into(), &true.into(), &4.into()));
    let decisions = gate["decisions"].as_array().expect("a list");
    assert_eq!(decisions.len(), 4);
    assert!(decisions.iter().all(|one| one["events"] == 4 && one["low"].as_f64() > Some(0.5)), "{gate}");

    let picture = folder.name("map.svg");
    let words =
        ["map", &out, "--x", "contact.gap", "--y", "contact.friction", "--of", "max_bearing_load_N", "--out", &picture];
    let map = object(0, &[&words[..], &["--json"]].concat());
    assert!(map["file"] == picture.as_str() && map["answers"][0]["kind"] == "map", "{map}");
    assert!(map["answers"][0]["map"].is_object() && folder.path("map.svg").exists());
}

#[test]
fn a_machine_and_its_history_have_json() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    let machine = object(0, &["check", &rig, "--json"]);
    assert_eq!((&machine["machine"], &machine["engine"]), (&"lab_rig".into(), &"exponential".into()));
    let history = folder.name("a.csv");
    let set = ["--set", "run.end_time=0.02 s"];
    assert_eq!(say(&[&["simulate", &rig, "--history", &history], &set[..]].concat()).code, 0);
    let plot = object(0, &["plot", &history, "--out", &folder.name("figures"), "--json"]);
    assert_eq!((&plot["kind"], &plot["histories"][0]), (&"time".into(), &history.as_str().into()));
    let files = plot["files"].as_array().expect("a list");
    assert!(files.len() == 2 && files.iter().all(|file| folder.path(file.as_str().expect("text")).exists()), "{plot}");
}
