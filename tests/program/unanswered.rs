//! Answers if something is missing: values of bad runs, tables, the study, a writable directory.

use crate::support::shared_studies::NORMAL_STUDY;
use crate::support::{Folder, json, say};
use std::fs;

const QUESTIONS: &str = r#"
[[question]]
name = "curve"
exceedance = "h"

[[gate]]
require = "P(g < 0) < 5 %"
"#;

#[test]
fn what_is_recorded_and_in_no_table_is_said_to_be_there() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}"));
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    fs::remove_file(folder.path("out/results.parquet")).expect("removed");
    for (command, code) in [("answer", 0), ("gate", 5)] {
        let said = say(&[command, &out]);
        assert!(
            said.code == code && said.out.contains("none yet. Points count in their order"),
            "{command}: {}",
            said.out
        );
        let what = "4000 samples of 4000 are in the record of ";
        assert!(said.err.contains(what) && said.err.contains(" run "), "{command}: {}", said.err);
    }
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let said = say(&["answer", &out]);
    assert!(said.code == 0 && said.out.contains("Answers, of 2000 points:") && said.err.is_empty(), "{}", said.err);
    // the study itself is missing: the message gives the command that writes it again
    fs::remove_file(folder.path("out/study.toml")).expect("removed");
    let said = say(&["answer", &out]);
    assert!(said.code == 3 && said.err.contains("this writes it there again: "), "{} {}", said.code, said.err);
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    assert_eq!(say(&["answer", &out]).code, 0);
}

#[test]
fn a_run_that_has_written_no_study_yet_is_beginning() {
    let folder = Folder::new();
    let out = folder.name("out");
    let held = bladeoff::run::directory::RunDirectory::claim(&folder.path("out"), false, None).expect("claimed");
    for command in ["answer", "gate"] {
        let said = say(&[command, &out]);
        assert!(said.code == 5 && said.err.contains("is starting: its study"), "{command}: {} {}", said.code, said.err);
    }
    drop(held);
}

#[test]
fn answers_that_cannot_be_written_are_a_failure() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{NORMAL_STUDY}{QUESTIONS}"));
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    fs::remove_dir_all(folder.path("out/answers")).expect("removed");
    folder.write("out/answers", "a file where the folder of curves belongs");
    for words in [vec!["answer", &out], vec!["run", &study, "--out", &out]] {
        let said = say(&words);
        assert!(said.out.contains("Answers, of 2000 points:"), "{words:?}: {}", said.out);
        assert!(said.code == 6 && said.err.contains("the answers are not written"), "{words:?}: {}", said.err);
    }
    fs::remove_file(folder.path("out/answers")).expect("removed");
    assert_eq!(say(&["answer", &out]).code, 0);
}

#[test]
fn a_derived_variable_that_does_not_exist_decides_no_gate() {
    let folder = Folder::new();
    let text = NORMAL_STUDY.replace("h = \"x * w\"", "h = \"2 * v\"").replace("values = [1, 2]", "values = [1]");
    let derived = "\n[[derived]]\nname = \"v\"\nformula = \"ln(x)\"\n";
    let study = folder.write("s.toml", &format!("{text}{derived}"));
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out]).code, 4, "half of them fail");
    for condition in ["ln(x) > 0", "v > 0", "not (v <= 0)", "h > 0"] {
        let said = say(&["gate", &out, "--require", &format!("P({condition}) < 0.3")]);
        assert!(said.code == 5 && said.out.contains("the bad runs prevent a decision"), "{condition}: {}", said.out);
    }
    // a condition that is decided without the missing value passes
    assert_eq!(say(&["gate", &out, "--require", "P(x > 1 and v > -1) < 0.3"]).code, 0);
}

#[test]
fn a_first_contact_counts_where_a_step_limit_alone_ended_the_run() {
    let folder = Folder::new();
    folder.write("rig.toml", include_str!("../../studies/machines/lab_rig.toml"));
    let study = folder.write(
        "s.toml",
        r#"schema = 1
machine = "rig.toml"
seed = 3
[set]
"contact.detection" = "hyp1"
"run.step_limit" = 4500
[design]
kind = "monte-carlo"
samples = 6
[[uncertain]]
path = "contact.gap"
distribution = "uniform"
lower = "0.15 mm"
upper = "0.3 mm"
[[question]]
name = "first"
probability = "first_contact_s < 1 s"
[[question]]
name = "touched"
probability = "contact_impulse_Ns > 0"
[[question]]
name = "later"
probability = "first_contact_s > 1 s"
"#,
    );
    let out = folder.name("out");
    let ran = say(&["run", &study, "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.contains("6 step_limit"), "{}", ran.out);
    let answers = json(&fs::read_to_string(folder.path("out/answers.json")).expect("written"));
    let of = |at: usize, key: &str| answers["answers"][at][key].as_f64().expect("a number");
    let touched = of(1, "events");
    assert!(touched > 0.0 && touched == of(0, "events"), "{answers}");
    // the number of later contacts does not change
    assert_eq!((of(2, "events"), of(2, "estimate_if_bad_harmful")), (0.0, (6.0 - touched) / 6.0), "{answers}");
}

/// The example of a gate names a column that the study has: the printed command can be copied and judged.
#[test]
fn the_example_of_a_gate_can_be_judged_by_a_study_of_formulas() {
    let folder = Folder::new();
    let (study, out) = (folder.write("s.toml", NORMAL_STUDY), folder.name("out"));
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let said = say(&["gate", &out]);
    assert!(said.code == 3 && !said.err.contains("max_bearing_load_N"), "{} {}", said.code, said.err);
    let (_, example) = said.err.split_once("P(").expect("an example");
    let (example, _) = example.split_once("1e-2").expect("its bound");
    let judged = say(&["gate", &out, "--require", &format!("P({example}1e-2")]);
    assert!(
        [0, 4, 5].contains(&judged.code) && judged.out.contains(&format!("P({example}1e-2: ")),
        "{} {}",
        judged.out,
        judged.err
    );
}
