//! The paper's Table 1, its study, and the page from a blade-off to an answer, which shows it.

use crate::support::pictures::{assert_figure, text};
use crate::support::{Folder, bladeoff, root, said, say, says_the_same};
use std::collections::BTreeMap;
use std::fs;

#[test]
fn the_paper_s_table_is_computed_and_claims_nothing_without_a_range() {
    let folder = Folder::new();
    let out = folder.path("table1");
    let said = say(&["table1", "--engine", "reduced", "--scatter", "1", "--end-time", "0.05 s", "--out", &text(&out)]);
    assert_eq!(said.code, 0, "{}", said.err);
    for part in [
        "The machine is ours",
        "| CPU time [s] | paper | 7742 | 24743 | 6845 |",
        "hyp2-frozen",
        "not decided: too few starts",
        "So few starts decide nothing",
        "come out: 0; reversed: 0; not decided: 12",
    ] {
        assert!(said.out.contains(part), "{part:?} in\n{}", said.out);
    }
    assert_figure(&out, "fig07-speed", &["hyp1", "hyp2", "hyp2-frozen", "speed [rpm]"]);
    // The three results are almost equal here, so each has its own panel; in one panel two of them would be hidden.
    let svg = fs::read_to_string(out.join("fig07-speed.svg")).expect("the figure");
    assert_eq!(svg.matches("speed [rpm]").count(), 3, "a panel for each detection");
    let runs = fs::read_to_string(out.join("runs.csv")).expect("the runs");
    assert_eq!(runs.lines().count(), 4);
}

/// Every command of the page, as written except for its duration, in the order of the page and in one directory. The commands print the output that the
/// page shows, and draw its figures.
#[test]
fn the_commands_of_the_walk_through_run() {
    let page = fs::read_to_string(root().join("docs/from-blade-off-to-answer.md")).expect("the page");
    let folder = Folder::new();
    std::os::unix::fs::symlink(root().join("studies"), folder.path("studies")).expect("link");
    let (mut commands, mut shown, mut printed, mut block) = (0, 0, String::new(), "");
    let mut known: BTreeMap<&str, String> = BTreeMap::new();
    for line in page.lines() {
        match (block, line) {
            (_, "```") => block = "",
            ("", line) if line.starts_with("```") => {
                block = &line[3..];
                if block == "sh" {
                    printed.clear();
                }
            }
            ("sh", command) => {
                let mut words = split(&command.replace("cargo run --release -p bladeoff-dev --", "bladeoff"));
                assert_eq!(words[0], "bladeoff", "{command}");
                // long enough for the rub to begin, at 3.05 s
                let scaled: &[&str] = match (words[1].as_str(), words.get(2).map(String::as_str)) {
                    ("table1", _) => &["--scatter", "2", "--end-time", "3.15 s"],
                    ("run", Some("studies/sensitivity.toml")) => &["--limit", "2"],
                    _ => &[],
                };
                words.extend(scaled.iter().map(|word| (*word).to_owned()));
                let words: Vec<&str> = words[1..].iter().map(String::as_str).collect();
                commands += 1;
                // a run prints the same with and without a history: `history::a_watched_run_is_the_same_run` of tests/program
                if let Some(out) = known.get(command) {
                    printed.push_str(out);
                    continue;
                }
                let said = said(bladeoff(&words).current_dir(folder.path(".")).output().expect("the binary starts"));
                assert_eq!(said.code, 0, "{command}: {}", said.err);
                printed.push_str(&said.out);
                known.insert(command.split(" --history").next().unwrap_or_default(), said.out);
            }
            ("text", shown_line) => {
                let found = printed.lines().any(|line| says_the_same(line, shown_line));
                assert!(found, "no command prints {shown_line:?}:\n{printed}");
                shown += 1;
            }
            _ => {}
        }
    }
    assert!(commands >= 14 && shown >= 15, "{commands} commands, {shown} lines");
    let images: Vec<&str> =
        page.lines().filter_map(|line| line.split("](figures/").nth(1)?.strip_suffix(')')).collect();
    assert!(images.len() >= 9, "{images:?}");
    for image in images {
        let drawn = ["figures", "table1"].iter().any(|directory| folder.path(directory).join(image).is_file());
        assert!(drawn, "no command draws {image}");
        assert!(root().join("docs/figures").join(image).is_file(), "docs/figures has no {image}");
    }
    let table = fs::read_to_string(folder.path("table1/table1.md")).expect("the report");
    assert!(table.contains("](fig13-gap-first-impacts.png)") && !table.contains("There is no contact"), "{table}");
}

/// Words of a shell line, with quotes as the page uses them.
fn split(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ' ' if !quoted => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
            }
            letter => word.push(letter),
        }
    }
    words.push(word);
    words
}

/// The study for `table1` is accepted by `run`: three engines, three detections, five starts, the first of which is that of the machine
/// file.
#[test]
fn the_study_of_the_paper_s_table_is_an_ordinary_study() {
    use bladeoff::run::own_columns;
    use bladeoff_study::{Samples, load};
    let samples = Samples::new(load(&root().join("studies/table1.toml"), own_columns).expect("valid"), None, None)
        .expect("samples");
    assert_eq!(samples.count(), 3 * 3 * 5);
    let text = fs::read_to_string(root().join("studies/machines/lp_turbine_paper.toml")).expect("the machine");
    let own = bladeoff_model::machine::MachineDef::parse("lp_turbine_paper.toml", &text)
        .expect("valid")
        .build()
        .expect("valid");
    let mut kinds = std::collections::BTreeSet::new();
    for sample in 0..samples.count() {
        let machine = samples.machine(sample).build().expect("every sample can be built");
        let word = |what: &dyn std::fmt::Debug| format!("{what:?}");
        kinds.insert((word(&machine.run.engine), word(&machine.diaphragms[0].contact.detection)));
        let moved = machine.rotor.unbalances != own.rotor.unbalances;
        assert_eq!(moved, sample % 5 != 0, "sample {sample}");
    }
    assert_eq!(kinds.len(), 9);
}
