//! Commands for the installation: completion scripts, manual pages, schemas, the check of the computer.

use crate::support::{BINARY, Folder, bladeoff, json, said, say};
use std::fs;
use std::process::Command;

/// bash loads the script, and its function completes a command, an option and a value.
#[test]
fn bash_completes_commands_options_and_values() {
    let folder = Folder::new();
    let script = folder.write("bladeoff.bash", &say(&["completions", "bash"]).out);
    for (words, wanted) in [
        ("bladeoff doc", "doctor"),
        ("bladeoff run --max-f", "--max-failures"),
        ("bladeoff plot --kind orb", "orbit"),
        ("bladeoff schema mach", "machine"),
    ] {
        let last = words.split(' ').count() - 1;
        let test = format!(
            "source {script}; COMP_WORDS=({words}); COMP_CWORD={last}; _bladeoff bladeoff \"${{COMP_WORDS[{last}]}}\" \
             \"${{COMP_WORDS[{last}-1]}}\"; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        );
        let said = said(Command::new("bash").args(["-c", &test]).output().expect("bash runs"));
        assert_eq!(said.code, 0, "{words}: {}", said.err);
        assert!(said.out.lines().any(|line| line == wanted), "{words}: {:?} {}", said.out, said.err);
    }
    let unknown = say(&["completions", "cmd"]);
    assert!(unknown.code == 2 && unknown.err.contains("possible values: bash"), "{}", unknown.err);
}

#[test]
fn manual_pages_are_written_into_a_new_directory() {
    let folder = Folder::new();
    let out = folder.name("share/man/man1");
    let said = say(&["man", &out]);
    assert_eq!(said.code, 0, "{}", said.err);
    let pages = fs::read_dir(&out).expect("made").count();
    assert!(pages > 25 && said.out.lines().count() == pages, "{pages}: {}", said.out);
    let page = fs::read_to_string(folder.path("share/man/man1/bladeoff-gate.1")).expect("a page");
    assert!(page.contains(".SH OPTIONS") && page.contains("\\-\\-junit"), "{page}");
    assert_eq!(say(&["man", &out]).code, 0, "pages are replaced");
    let file = folder.write("file", "");
    assert_eq!(say(&["man", &file]).code, 6);
}

#[test]
fn templates_name_their_schema_and_the_command_that_writes_it() {
    let folder = Folder::new();
    for (format, key) in [("machine", "rotor"), ("study", "uncertain")] {
        let schema = say(&["schema", format]);
        assert_eq!(schema.code, 0, "{}", schema.err);
        assert!(json(&schema.out)["properties"][key].is_object(), "{}", schema.out);
        let first = format!("#:schema {format}.schema.json");
        assert_eq!(say(&["new", format]).out.lines().next(), Some(first.as_str()));
        let without = say(&["new", format, "--out", &folder.name(&format!("first-{format}.toml"))]);
        let command = format!("schema {format} > {}", folder.name(&format!("{format}.schema.json")));
        assert!(without.err.contains(&command), "{}", without.err);
        folder.write(&format!("{format}.schema.json"), &schema.out);
        let with = say(&["new", format, "--out", &folder.name(&format!("second-{format}.toml"))]);
        assert!(with.code == 0 && !with.err.contains("schema"), "{}", with.err);
    }
}

#[test]
fn the_doctor_finds_no_problem_here_and_leaves_nothing() {
    let folder = Folder::new();
    let before = fs::read_dir(folder.path(".")).expect("readable").count();
    let there = say(&["doctor", &folder.name("")]);
    assert_eq!(there.code, 0, "{}", there.out);
    for wanted in ["shared memory", "limit: open files (-n)", "kernels for", "no problem was found"] {
        assert!(there.out.contains(wanted), "{wanted}: {}", there.out);
    }
    let found = json(&say(&["doctor", &folder.name(""), "--json"]).out);
    assert_eq!(found["problems"], 0);
    let findings = found["findings"].as_array().expect("a list");
    assert!(findings.iter().all(|finding| finding["problem"].is_null() && finding["value"].is_string()), "{found}");
    assert_eq!(fs::read_dir(folder.path(".")).expect("readable").count(), before);
}

#[test]
fn the_doctor_names_what_would_stop_a_run() {
    let folder = Folder::new();
    let missing = say(&["doctor", &folder.name("missing"), "--json"]);
    let found = json(&missing.out);
    let problems = |found: &serde_json::Value| -> Vec<String> {
        let findings = found["findings"].as_array().expect("a list").iter();
        findings.filter(|finding| !finding["problem"].is_null()).map(|finding| finding["name"].to_string()).collect()
    };
    assert_eq!((missing.code, problems(&found)), (6, vec!["\"results\"".to_owned()]), "{found}");
    let many = json(&say(&["doctor", &folder.name(""), "--json", "--workers", "65535"]).out);
    assert_eq!(problems(&many), ["\"workers\""], "{many}");
    for limit in ["ulimit -n 40", "ulimit -v 300000"] {
        let mut few = Command::new("sh");
        few.args(["-c", &format!("{limit}; exec \"$0\" doctor \"$1\" --workers 2"), BINARY, &folder.name("")]);
        let environment = bladeoff(&[]);
        let few =
            said(few.envs(environment.get_envs().filter_map(|(key, value)| Some((key, value?)))).output().expect("sh"));
        let word = &limit[..9];
        assert!(few.code == 6 && few.out.contains("PROBLEM") && few.out.contains(word), "{limit}: {}", few.out);
    }
}
