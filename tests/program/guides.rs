//! Commands of the guides, page by page in one directory, as written except for the length of their studies.

use crate::support::docs::blocks;
use crate::support::{BINARY, Folder, RUNTIME_VARIABLE, root, runtime, said, says_the_same};
use std::fs;
use std::process::Command;

/// Pages whose commands need only the shipped studies and the files of earlier pages.
const PAGES: [&str; 6] = ["uncertainty", "failed-runs", "heavy-rub", "report", "gate", "histories"];

/// Runs a line of a page in the directory; returns its output.
fn run(folder: &Folder, page: &str, line: &str) -> String {
    let script = format!("bladeoff() {{ '{BINARY}' \"$@\"; }}; COMMIT=4f2a; {line}");
    let mut shell = Command::new("bash");
    shell.args(["-ec", &script]).current_dir(folder.path(".")).env(RUNTIME_VARIABLE, runtime());
    let ran = said(shell.output().expect("a shell"));
    assert_eq!(ran.code, 0, "docs/{page}.md: {line}\n{}{}", ran.out, ran.err);
    ran.out
}

#[test]
fn the_commands_of_the_guides_run() {
    let folder = Folder::new();
    for name in ["machines/lab_rig.toml", "ci-night.toml"] {
        let text = fs::read_to_string(root().join("studies").join(name)).expect("shipped");
        folder.write(&format!("studies/{name}"), &text);
    }
    std::os::unix::fs::symlink(root().join("docs"), folder.path("docs")).expect("link");
    let (mut commands, mut studies) = (0, 0);
    for page in PAGES {
        for line in blocks(&format!("docs/{page}.md"), "").iter().flat_map(|block| block.lines()) {
            // only as many samples as the gate needs; no limit on the time of day
            let is_study = line.starts_with("bladeoff run ");
            let short = if is_study && !line.contains("--limit") {
                line.replacen(".toml", ".toml --limit 64", 1).replace("--until 06:00", "--wall 10min")
            } else {
                line.to_owned()
            };
            run(&folder, page, &short);
            commands += 1;
            studies += usize::from(is_study);
        }
    }
    assert!(commands >= 23 && studies >= 5, "{commands} commands, {studies} studies");
    let made = [
        "my-risk.html",
        "report.html",
        "sample-17.mcap",
        "gate.xml",
        "runs/4f2a/results.parquet",
        "run.parquet",
        "rig.json",
        "figures/run-time.svg",
        "figures/run-orbit.svg",
        "orbit.html",
    ];
    for name in made {
        assert!(folder.path(name).is_file(), "no command of the guides makes {name}");
    }
}

/// The page shows its studies in full, and the output of the refined map.
#[test]
fn the_maps_of_the_page_are_drawn_and_the_refined_one_prints_what_it_shows() {
    let folder = Folder::new();
    std::os::unix::fs::symlink(root().join("studies"), folder.path("studies")).expect("link");
    let page = fs::read_to_string(root().join("docs/maps.md")).expect("the page");
    for study in page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()) {
        if let Some(name) = study.lines().next().and_then(|line| line.strip_prefix("# ")) {
            folder.write(name, study);
        }
    }
    let printed: String = blocks("docs/maps.md", "")
        .iter()
        .flat_map(|block| block.lines())
        .fold(String::new(), |printed, line| printed + &run(&folder, "maps", line));
    let shown = page.split("```text\n").nth(1).and_then(|rest| rest.split("```").next()).expect("the output");
    let shown: Vec<&str> = shown.lines().filter(|line| !line.is_empty() && *line != "...").collect();
    assert!(shown.len() >= 5, "{shown:?}");
    for line in shown {
        assert!(printed.lines().any(|found| says_the_same(found, line)), "not printed: {line:?}\n{printed}");
    }
    assert!(["map-rig.png", "map-refined.png"].iter().all(|name| folder.path("figures").join(name).is_file()));
}
