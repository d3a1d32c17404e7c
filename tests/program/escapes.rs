//! Escape sequences from files, file names, logs and the command line never reach a terminal: all output is free of control characters and
//! marks of writing direction, and shows that they were there.

use crate::support::{Folder, bladeoff, say};
use bladeoff_text::document::is_hidden;
use std::fs;
use std::path::Path;

/// Clears the screen, sets the title, begins a C1 sequence, changes the writing direction.
const EVIL: &str = "\u{1b}[2J\u{1b}]0;owned\u{7}\u{9b}31m\u{202e}";

/// Output of a command on both streams; asserts that it contains nothing that controls a terminal.
fn harmless(args: &[&str]) -> String {
    let output = bladeoff(args).output().expect("it starts");
    let both = [output.stdout, output.stderr].concat();
    let text = String::from_utf8(both).expect("UTF-8");
    let raw = text.chars().find(|c| is_hidden(*c) && *c != '\n' && *c != '\t');
    assert_eq!(raw, None, "{args:?}: {text:?}");
    assert!(!text.contains("internal error"), "{text}");
    text
}

/// Output of a command that quotes the argument; asserts that the escape is shown.
fn shown(args: &[&str]) -> String {
    let text = harmless(args);
    assert!(text.contains("\\u{1b}"), "{args:?}: {text}");
    text
}

#[test]
fn names_keys_values_and_excerpts_of_input_files() {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let study = |text: &str| folder.write("s.toml", &format!("schema = 1\nmachine = \"machines/rig.toml\"\n{text}"));
    // file name, on the command line and in a study
    let name = format!("m{EVIL}.toml");
    let machine = folder.write(&name, &rig.replace("diameter", "diamter"));
    for command in ["simulate", "modes", "paths"] {
        shown(&[command, &machine]);
        shown(&[command, &folder.name(&format!("gone{EVIL}"))]);
    }
    shown(&["check", &folder.write(&format!("s{EVIL}.toml"), "schema = 2")]);
    shown(&["run", &study("").replace("s.toml", &name)]);
    let named = "schema = 1\nmachine = \"m\\u001b[2J\\nerror: all is well.toml\"\n";
    let said = shown(&["check", &folder.write("named.toml", named)]);
    assert!(!said.contains("\nerror: all is well"), "{said}");
    // keys and values: as escapes of TOML, and raw where TOML allows it (C1, marks of direction), shown in excerpts
    let escaped = "\\u001b[2J\\u001b]0;x\\u0007";
    shown(&["check", &study(&format!("\"k{escaped}\" = 1\n"))]);
    shown(&["check", &study(&format!("name = \"n{escaped}\"\n"))]);
    shown(&["check", &study(&format!("[set]\n\"run.{escaped}\" = 1\n\"contact.gap\" = \"8 {escaped}\"\n"))]);
    shown(&["check", &study(&format!("[[vary]]\npath = \"{escaped}\"\nvalues = [1]\n"))]);
    shown(&["check", &study(&format!("[points]\nfile = \"{escaped}\"\n"))]);
    for text in ["name = \"\u{9b}31m\u{202e}\"\n", "\u{9b}31m = 2\n", "seed = 1 # \u{9b}2J\u{202e}\nsed = 2\n"] {
        harmless(&["check", &study(text)]);
    }
    shown(&["simulate", &folder.write("k.toml", &format!("{rig}\n[\"{escaped}\"]\n\"a{escaped}\" = 1\n"))]);
    harmless(&["simulate", &folder.write("n.toml", &rig.replace("name = \"", &format!("name = \"{escaped}")))]);
    shown(&["simulate", &folder.write("u.toml", &rig.replace("\"0.5 mm\"", &format!("\"0.5 {escaped}\"")))]);
    // raw control characters are invalid TOML: the excerpt shows them
    let raw = harmless(&["simulate", &folder.write("raw.toml", &format!("{rig}\nx = \"{EVIL}\"\n"))]);
    assert!(raw.contains("␛[2J"), "{raw}");
    // points
    for (at, points) in
        [format!("contact.gap{EVIL}\n0.5\n"), format!("contact.gap\n0.5{EVIL}\n"), format!("contact.gap\n{EVIL},1\n")]
            .iter()
            .enumerate()
    {
        folder.write(&format!("p{at}.csv"), points);
        harmless(&["check", &study(&format!("[points]\nfile = \"p{at}.csv\"\n"))]);
    }
}

#[test]
fn arguments() {
    let folder = Folder::new();
    let (machine, study) = (folder.name("machines/rig.toml"), folder.small_study());
    for args in [
        &[EVIL][..],
        &["run", &study, &format!("--{EVIL}")],
        &["run", &study, "--rerun", &format!("cause={EVIL}")],
        &["run", &study, "--wall", EVIL],
        &["simulate", &machine, "--set", &format!("{EVIL}=1")],
        &["simulate", &machine, "--set", &format!("contact.gap={EVIL}")],
        &["simulate", &machine, "--detection", EVIL],
        &["simulate", &machine, "--history", &format!("{EVIL}.txt")],
        &["simulate", &machine, "--history", "h.mcap", "--channels", EVIL],
        &["modes", &machine, "--speed", EVIL],
        &["plot", EVIL, "--out", "x.svg"],
        &["plot", "x.mcap", "--out", &format!("{EVIL}.pdf")],
        &["recover", EVIL],
        &["why", EVIL],
        &["why", EVIL, "3"],
        &["status", EVIL],
        &["export", EVIL, "--csv"],
        &["replay", EVIL, "--sample", "3"],
    ] {
        shown(args);
    }
}

#[test]
fn whatever_a_result_directory_holds() {
    let folder = Folder::new();
    let (study, out) = (folder.small_study(), folder.name("out"));
    let foreign = folder.write(&format!("foreign/{EVIL}"), "");
    let foreign = Path::new(&foreign).parent().expect("a folder").to_str().expect("UTF-8");
    shown(&["run", &study, "--out", foreign]);
    let first = say(&["run", &study, "--out", &out]);
    assert_eq!(first.code, 0, "{}", first.err);
    // output of workers in the log of an earlier build
    let log = folder.path("out/workers.log");
    let mut text = fs::read_to_string(&log).expect("the log");
    text.push_str(&format!("worker 1: sample 3: {EVIL}\n"));
    fs::write(&log, text).expect("written");
    shown(&["why", &out, "3"]);
    // JSON files that are read back
    let json = |name: &str, change: &dyn Fn(&mut serde_json::Value)| {
        let path = folder.path(&format!("out/{name}"));
        let mut told = serde_json::from_slice(&fs::read(&path).expect(name)).expect("JSON");
        change(&mut told);
        fs::write(path, told.to_string()).expect("written");
    };
    json("status.json", &|told| {
        for key in ["study", "resume", "updated", "study_file", "directory"] {
            told[key] = format!("{EVIL}\nstate      complete").into();
        }
    });
    let said = shown(&["status", &out]);
    assert_eq!(said.matches("\nstate ").count(), 0, "one state: {said}");
    let said = harmless(&["status", &out, "--json"]);
    let told: serde_json::Value = serde_json::from_str(&said).expect("still JSON");
    assert!(told["study"].as_str().is_some_and(|study| study.starts_with(EVIL)), "with the same meaning");
    let holder = serde_json::json!({ "host": EVIL, "pid": 1, "started": EVIL });
    fs::write(folder.path("out/run.lock"), format!("{holder}\n")).expect("written");
    shown(&["status", &out]);
    // frozen inputs
    let frozen = folder.path("out/study.toml");
    fs::write(&frozen, format!("{}\n\"{EVIL}\" = 1\n", fs::read_to_string(&frozen).expect("text"))).expect("written");
    harmless(&["why", &out, "3"]);
    harmless(&["run", &study, "--out", &out]);
}

#[test]
fn a_figure_of_a_file_with_such_a_name_is_valid_xml() {
    let folder = Folder::new();
    let history = folder.name(&format!("h{EVIL}.csv"));
    let machine = folder.name("machines/rig.toml");
    shown(&["simulate", &machine, "--set", "run.end_time=0.01", "--history", &history]);
    let figure = folder.name("f.svg");
    harmless(&["plot", &history, "--out", &figure]);
    let svg = fs::read_to_string(&figure).expect("a figure");
    assert!(svg.contains('␛') && !svg.contains(|c| is_hidden(c) && c != '\n' && c != '\t'));
    // a strict reader renders the PNG from the same text
    let png = folder.name("f.png");
    harmless(&["plot", &history, "--out", &png]);
    assert!(fs::read(&png).expect("a figure").starts_with(b"\x89PNG"));
}
