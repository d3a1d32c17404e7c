//! Commands of the guides, page after page in one folder, as written but for the length of their studies.

use crate::support::docs::blocks;
use crate::support::{BINARY, Folder, RUNTIME_VARIABLE, root, runtime, said};
use std::fs;
use std::process::Command;

/// Pages whose commands need the shipped studies and the files of the pages before only.
const PAGES: [&str; 6] = ["uncertainty", "failed-runs", "heavy-rub", "report", "gate", "histories"];

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
            // as many samples as the gate needs; no end at a time of the day
            let is_study = line.starts_with("bladeoff run ");
            let short = if is_study && !line.contains("--limit") {
                line.replacen(".toml", ".toml --limit 64", 1).replace("--until 06:00", "--wall 10min")
            } else {
                line.to_owned()
            };
            let script = format!("bladeoff() {{ '{BINARY}' \"$@\"; }}; COMMIT=4f2a; {short}");
            let mut shell = Command::new("bash");
            shell.args(["-ec", &script]).current_dir(folder.path(".")).env(RUNTIME_VARIABLE, runtime());
            let ran = said(shell.output().expect("a shell"));
            assert_eq!(ran.code, 0, "docs/{page}.md: {short}\n{}{}", ran.out, ran.err);
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
