//! Complete outputs as reviewed snapshots in `tests/program/snapshots`: help, checks, summaries, answers, errors.
//!
//! Each command runs in a new directory as its current directory, so that outputs show relative paths. The path of the binary and times are
//! replaced.

use crate::support::{Folder, SMALL_STUDY, bladeoff, root, said};
use std::fs;

/// 500 points of strength and load at two speeds; the logarithm has no value where the load is larger than the strength.
const STUDY: &str = r#"schema = 1
name = "strength"
model = "function"
seed = 5

[function]
margin = "strength - load * speed / 340"
reserve = "ln(strength - load)"

[[uncertain]]
name = "strength"
distribution = "normal"
mean = 5
sd = 1

[[uncertain]]
name = "load"
distribution = "lognormal"
mean = 2
sd = 0.8

[[vary]]
name = "speed"
values = ["3000 rpm", "3600 rpm"]

[design]
kind = "monte-carlo"
samples = 500

[[question]]
name = "fails"
probability = "margin < 0"

[[question]]
name = "margin-low"
quantile = 0.05
of = "margin"

[[gate]]
require = "P(margin < 0) < 10 %"
"#;

/// The text with `[number]` in place of the number between `before` and `after`, at every occurrence.
fn without_number(text: &str, before: &str, after: &str) -> String {
    let mut parts = text.split(after);
    let mut shown = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let kept = shown.trim_end_matches(|letter: char| letter.is_ascii_digit() || letter == '.').len();
        if kept < shown.len() && shown[..kept].ends_with(before) {
            shown.replace_range(kept.., "[number]");
        }
        shown += after;
        shown += part;
    }
    shown
}

/// The text without the parts that depend on directory, processors and time.
fn reproducible(text: &str) -> String {
    let text = text.replace(env!("CARGO_BIN_EXE_bladeoff"), "bladeoff");
    [
        (", ", " s of CPU time"),
        ("computed in                      ", " s\n"),
        ("samples: ", " us each"),
        ("about ", " s with "),
        (" s with ", " worker"),
        ("one per core, ", " here\n"),
    ]
    .iter()
    .fold(text, |text, (before, after)| without_number(&text, before, after))
    .replace("[number] worker:", "[number] workers:")
}

/// Exit code, standard output and standard error of a command in this directory.
pub(crate) fn printed(folder: &Folder, args: &[&str]) -> String {
    let mut command = bladeoff(args);
    let said = said(
        command
            .current_dir(folder.path(""))
            .env("COLUMNS", "100")
            .env("PATH", "/usr/bin:/bin")
            .output()
            .expect("the binary starts"),
    );
    let mut text = format!("$ bladeoff {}\nexit code {}\n", args.join(" "), said.code);
    for (name, part) in [("output", said.out), ("error", said.err)] {
        if !part.is_empty() {
            text += &format!("\n--- standard {name}\n{}", reproducible(&part));
        }
    }
    text
}

/// Compares a text with the snapshot of this name.
pub(crate) fn reviewed(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(root().join("tests/program/snapshots"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

/// The commands that a help text lists.
fn commands(help: &str) -> Vec<String> {
    let Some((_, list)) = help.split_once("\nCommands:\n") else { return Vec::new() };
    let lines = list.lines().take_while(|line| !line.is_empty());
    let names = lines.filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')));
    let names = names.filter_map(|line| line.split_whitespace().next());
    names.filter(|&name| name != "help").map(str::to_owned).collect()
}

#[test]
fn help_of_every_command() {
    let folder = Folder::new();
    let mut waiting = vec![String::new()];
    let mut seen = 0;
    while let Some(command) = waiting.pop() {
        let words: Vec<&str> = command.split_whitespace().chain(["--help"]).collect();
        let text = printed(&folder, &words);
        reviewed(&format!("help {command}").trim_end().replace(' ', "-"), &text);
        let inner = commands(&text);
        let is_leaf = inner.is_empty() && !command.contains(' ');
        assert!(!is_leaf || text.contains("Examples:\n  bladeoff"), "{command}: no examples: {text}");
        waiting.extend(inner.iter().map(|name| format!("{command} {name}").trim_start().to_owned()));
        seen += 1;
    }
    assert!(seen > 25, "commands were found: {seen}");
}

#[test]
fn check_of_studies_and_of_a_machine() {
    let folder = Folder::new();
    std::os::unix::fs::symlink(root().join("studies"), folder.path("studies")).expect("linked");
    folder.write("strength.toml", STUDY);
    reviewed("check-function-study", &printed(&folder, &["check", "strength.toml"]));
    reviewed("check-machine", &printed(&folder, &["check", "studies/machines/lp_turbine_paper.toml"]));
    let text = said(bladeoff(&["check", "studies/first-look.toml"]).output().expect("the binary starts"));
    let (shown, times) = text.out.split_once("\ntimed ").expect("samples were timed");
    assert!(times.contains(" of CPU time; "), "{times}");
    reviewed("check-study", &format!("$ bladeoff check studies/first-look.toml\nexit code {}\n\n{shown}", text.code));
}

#[test]
fn a_study_from_its_run_to_its_answers() {
    let folder = Folder::new();
    folder.write("strength.toml", STUDY);
    let run = said(
        bladeoff(&["run", "strength.toml", "--out", "out", "--workers", "1"])
            .current_dir(folder.path(""))
            .output()
            .expect("the binary starts"),
    );
    reviewed("run-function-study", &format!("exit code {}\n\n{}", run.code, reproducible(&run.out)));
    reviewed("status", &printed(&folder, &["status", "out"]));
    reviewed("answer", &printed(&folder, &["answer", "out"]));
    reviewed("gate", &printed(&folder, &["gate", "out"]));
    reviewed("why", &printed(&folder, &["why", "out", "7"]));
    let failed = said(bladeoff(&["export", &folder.name("out"), "--csv"]).output().expect("the binary starts")).out;
    let failed = failed.lines().find(|line| line.contains("non_finite")).expect("a failed run");
    let sample = failed.split(',').next().expect("a cell");
    reviewed("why-failed", &printed(&folder, &["why", "out", sample]));
}

#[test]
fn a_study_of_transients() {
    let folder = Folder::new();
    folder.small_study();
    let words = ["run", "small.toml", "--out", "out", "--workers", "2"];
    let run = said(bladeoff(&words).current_dir(folder.path("")).output().expect("the binary starts"));
    reviewed("run-study", &format!("exit code {}\n\n{}", run.code, reproducible(&run.out)));
    reviewed("status-study", &printed(&folder, &["status", "out"]));
    reviewed("simulate", &printed(&folder, &["simulate", "machines/rig.toml"]));
}

#[test]
fn errors_of_the_command_line() {
    let folder = Folder::new();
    for (name, args) in [
        ("unknown-command", &["frobnicate"][..]),
        ("similar-command", &["simulat", "x.toml"]),
        ("no-study", &["run"]),
        ("scale-0", &["run", "x.toml", "--scale", "0"]),
        ("limit-0", &["run", "x.toml", "--limit", "0"]),
        ("workers-0", &["run", "x.toml", "--workers", "0"]),
        ("no-format", &["export", "x"]),
        ("unknown-option", &["check", "x.toml", "--lst"]),
    ] {
        let text = printed(&folder, args);
        assert!(text.contains("\nexit code 2\n") && !text.contains("--- standard output"), "{text}");
        reviewed(&format!("command-line-{name}"), &text);
    }
}

#[test]
fn errors_of_files() {
    let folder = Folder::new();
    folder.write("empty/note.txt", "");
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let machine = |name: &str, from: &str, to: &str| {
        assert!(rig.contains(from), "{from}");
        folder.write(name, &rig.replacen(from, to, 1));
    };
    machine("table.toml", "[rotor.material]", "[rotor.materal]");
    machine("key.toml", "friction = 0.15", "frction = 0.15");
    machine("unit.toml", "stiffness = \"2e6 N/m\"", "stiffness = \"2e6 N\"");
    machine("range.toml", "gap = \"0.5 mm\"", "gap = \"0 mm\"");
    machine("syntax.toml", "friction = 0.15", "friction = = 0.15");
    let bad = rig.replace("gap = \"0.5 mm\"", "gap = \"0 mm\"").replace("friction = 0.15", "frction = 0.15");
    folder.write("machine.toml", &bad.replacen("stiffness = \"2e6 N/m\"", "stiffness = \"2e6 N\"", 1));
    let study = SMALL_STUDY
        .replace("seed = 7", "sed = 7")
        .replace("path = \"contact.gap\"", "path = \"contact.gp\"")
        .replace("from = 0.1", "from = -0.1")
        .replace("\"hyp2-frozen\"", "\"hyp3\"");
    folder.write("study.toml", &format!("{study}\n[set]\n\"material.density\" = 1\n\"run.end_time\" = \"5 kg\"\n"));
    folder.write("formula.toml", &STUDY.replace("ln(strength - load)", "ln(margin)"));
    folder.write("question.toml", &STUDY.replace("of = \"margin\"", "of = \"margn\""));
    for (name, args) in [
        ("missing-machine", &["simulate", "nowhere.toml"][..]),
        ("missing-study", &["run", "nowhere.toml"]),
        ("missing-to-check", &["check", "nowhere.toml"]),
        ("folder-as-machine", &["paths", "machines"]),
        ("no-result-directory", &["answer", "empty"]),
        ("no-table", &["export", "empty", "--csv"]),
        ("missing-directory", &["status", "nowhere"]),
        ("table", &["check", "table.toml"]),
        ("key", &["check", "key.toml"]),
        ("unit", &["check", "unit.toml"]),
        ("range", &["check", "range.toml"]),
        ("syntax", &["simulate", "syntax.toml"]),
        ("machine", &["simulate", "machine.toml"]),
        ("study", &["check", "study.toml"]),
        ("formula", &["check", "formula.toml"]),
        ("question", &["check", "question.toml"]),
    ] {
        let text = printed(&folder, args);
        assert!(text.contains("\nexit code 3\n") && !text.contains('\u{1b}'), "{text}");
        reviewed(&format!("file-{name}"), &text);
    }
}
