//! Complete messages that name a place: a cell of a table that a machine names, a speed of the run, a sample, a parameter of `--set`.

use crate::printed::{printed, reviewed};
use crate::support::{Folder, root, say};
use std::fs;

/// A directory with the shipped turbine and its bearing table, changed by `machine` and `table`.
fn turbine(machine: impl Fn(String) -> String, table: impl Fn(String) -> String) -> Folder {
    let folder = Folder::new();
    let read = |name: &str| fs::read_to_string(root().join("studies/machines").join(name)).expect(name);
    folder.write("t.toml", &machine(read("lp_turbine.toml")));
    folder.write("lp_turbine_bearing.csv", &table(read("lp_turbine_bearing.csv")));
    folder
}

fn same(text: String) -> String {
    text
}

#[test]
fn problems_of_a_bearing_table_are_at_their_cells() {
    let cells = turbine(same, |csv| csv.replace("5.278e+08", "5.278x+08").replace("\n20,", "\n14,"));
    let text = printed(&cells, &["check", "t.toml"]);
    assert!(text.contains("lp_turbine_bearing.csv:6:4: kxx = 5.278x+08: not a number"), "{text}");
    reviewed("table-cells", &text);
    let units = turbine(same, |csv| csv.replace("kxx [N/m]", "kxx [N/q]").replace("kyy [N/m]", "k_yy [N/m]"));
    reviewed("table-header", &printed(&units, &["check", "t.toml"]));
    // three comment lines about the source, then the header and one row
    let short = turbine(same, |csv| csv.lines().take(5).map(|line| format!("{line}\n")).collect());
    reviewed("table-rows", &printed(&short, &["check", "t.toml"]));
    let study = turbine(same, |csv| csv.replace("5.278e+08", ""));
    study.write("s.toml", "schema = 1\nmachine = \"t.toml\"\n");
    reviewed("table-cell-of-a-study", &printed(&study, &["run", "s.toml", "--out", "out"]));
}

/// The machine file has no line for a value of the table, so the message names the speed of the run.
#[test]
fn a_run_beyond_its_bearing_table_is_reported_at_its_speed() {
    let slow = turbine(|machine| machine.replace("end_speed = \"100 rpm\"", "end_speed = \"50 rpm\""), same);
    reviewed("table-begins-above", &printed(&slow, &["check", "t.toml"]));
    // the last speed of the table is above the largest speed of the run, but below 1.05 times that speed
    let short = turbine(same, |csv| csv.replace("\n170,", "\n160,"));
    let text = printed(&short, &["check", "t.toml"]);
    assert!(text.contains("1.05 times the largest speed of the run, 1500 rpm"), "{text}");
    reviewed("table-ends-below", &text);
}

#[test]
fn a_bearing_saved_by_ross_is_refused_in_one_sentence() {
    let files = [
        (
            "bearing.toml",
            "[\"BearingElement_Bearing 0\"]\nn = 0\nkxx = [1e6, 2e6]\ncxx = [1e2, 1e2]\nfrequency = [0, 300]\n",
        ),
        (
            "bearing.json",
            "{\"BearingElement_Bearing 0\": {\"n\": 0, \"kxx\": [1e6], \"cxx\": [1e2], \"frequency\": [0]}}",
        ),
    ];
    for (name, text) in files {
        let folder = turbine(|machine| machine.replace("lp_turbine_bearing.csv", name), same);
        folder.write(name, text);
        folder.write("s.toml", &format!("schema = 1\nmachine = \"{name}\"\n"));
        let kind = name.replace('.', "-");
        reviewed(&format!("ross-table-{kind}"), &printed(&folder, &["check", "t.toml"]));
        reviewed(&format!("ross-machine-{kind}"), &printed(&folder, &["check", "s.toml"]));
        for command in ["check", "run", "simulate", "modes", "paths"] {
            let said = say(&[command, &folder.name(name)]);
            let is_one = said.err.matches("error: ").count() == 1 && said.err.contains("saved by ROSS");
            assert!(said.code == 3 && is_one, "{command} {name}: {} {}", said.code, said.err);
        }
    }
}

#[test]
fn a_syntax_error_hides_no_other_problem() {
    let folder = Folder::new();
    let broken = "schema = 1\nmodel = \"function\"\nsed = 3\n\n[function]\ng = \"a * k\"\n\n[design]\nkind = \"monte-carl\"\nsamples = = 60\n\n\
                  [[uncertain]]\nname = \"a\"\ndistribution = \"norml\"\nmean = 3\nsd = 1\n\n[[vary]]\nname = \"k\"\nvalues = [1, 2\nzip = 3\n";
    folder.write("s.toml", broken);
    let text = printed(&folder, &["check", "s.toml"]);
    for found in ["sed: unknown key", "monte-carlo", "s.toml:10:11: not valid TOML"] {
        assert!(text.contains(found), "{found}: {text}");
    }
    reviewed("syntax-and-others", &text);
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let machine =
        rig.replace("density = \"7850 kg/m3\"", "density = \"7850 kg\"").replace("friction = 0.15", "friction 0.15");
    folder.write("m.toml", &machine);
    let text = printed(&folder, &["check", "m.toml"]);
    assert!(text.contains("not valid TOML") && text.contains("does not fit"), "{text}");
    reviewed("syntax-and-others-of-a-machine", &text);
}

/// One warning for each quantity instead of one for each corner.
#[test]
fn implausible_values_of_corners_are_one_warning_with_their_range() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"1 ms\"\n\"run.engine\" = \"reduced\"\n\
         [[vary]]\npath = \"rotor.material.density\"\nas = \"rho\"\nvalues = [6, 7.85, 9, 7850]\n\
         [[vary]]\npath = \"contact.friction\"\nas = \"mu\"\nvalues = [0.1, 15]\n",
    );
    let text = printed(&folder, &["check", "s.toml"]);
    let warnings: Vec<&str> = text.lines().filter(|line| line.contains("plausible")).collect();
    assert_eq!(warnings.len(), 2, "{text}");
    let lines = text.lines().filter(|line| line.contains("warning: rotor") || line.contains("warning: diaphragms"));
    reviewed("implausible-corners", &lines.map(|line| format!("{line}\n")).collect::<String>());
}

/// `why` and `replay` accept the same forms, and both name the correct command for an invalid form.
#[test]
fn a_sample_is_named_in_the_same_forms_by_why_and_replay() {
    let folder = Folder::new();
    let study = folder.small_study();
    let study = fs::read_to_string(study).expect("the study");
    folder.write("s.toml", &study);
    let ran = printed(&folder, &["run", "s.toml", "--out", "runs/d", "--limit", "6"]);
    assert!(ran.contains("exit code 0"), "{ran}");
    let first = |command: &str, words: &[&str]| {
        let said = printed(&folder, &[&[command], words].concat());
        let lines: Vec<&str> =
            said.lines().filter(|line| !line.is_empty() && !line.starts_with("---")).take(4).collect();
        lines.join("\n") + "\n"
    };
    let mut text = String::new();
    for command in ["why", "replay"] {
        for words in [
            &["runs/d", "3"][..],
            &["runs/d#3"],
            &["runs/d/", "3"],
            &["3"],
            &["3", "runs/d"],
            &["runs/d"],
            &["runs/d", "three"],
            &["runs/d#three"],
            &["runs/d", "99"],
            &["runs/d#99"],
            &["runs/d/results.parquet", "3"],
            &["s.toml", "3"],
            &["none", "3"],
            &["runs/d", "99999999999999999999999"],
        ] {
            text += &(first(command, words) + "\n");
        }
    }
    for words in [
        &["runs/d", "3", "--sample", "4"][..],
        &["runs/d", "3", "--worst", "max_bearing_load_N"],
        &["runs/d", "--sample", "3"],
    ] {
        text += &(first("replay", words) + "\n");
    }
    reviewed("forms-of-a-sample", &text);
}

#[test]
fn replay_set_takes_the_names_of_the_study() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"20 ms\"\n\
         [[vary]]\npath = \"contact.gap\"\nas = \"clearance\"\nvalues = [\"0.4 mm\", \"1 mm\"]\n\
         [[vary]]\npath = \"blade_off.mass\"\nas = \"lost\"\nvalues = [\"7 g\"]\n",
    );
    assert!(printed(&folder, &["run", "s.toml", "--out", "d"]).contains("exit code 0"));
    let set = |words: &str| {
        let text = printed(&folder, &["replay", "d", "1", "--set", words]);
        text.lines()
            .filter(|line| line.starts_with("set ") || line.starts_with("error"))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let gap = ["set                              diaphragms.seal.contact.gap = 0.5 mm, in the row 1 mm"];
    assert_eq!(set("clearance=0.5 mm"), gap);
    assert_eq!(set("contact.gap=0.5 mm"), gap);
    assert_eq!(
        set("lost=8 g"),
        ["set                              rotor.unbalances.blade_off.mass = 8 g, in the row 7 g"]
    );
    assert_eq!(
        set("clearence=0.5 mm"),
        [
            "error: --set clearence=0.5 mm: neither the study nor its machine has a parameter `clearence`; did you mean `clearance`?"
        ]
    );
    assert!(set("contact.gpa=0.5 mm")[0].contains("did you mean `diaphragms.seal.contact.gap`?"));
    assert_eq!(set("clearance=0.5 kg").len(), 1);
    // a derived parameter keeps its value
    folder.write(
        "k.toml",
        "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"20 ms\"\n\
         [[vary]]\npath = \"contact.gap\"\nas = \"clearance\"\nvalues = [\"0.4 mm\", \"1 mm\"]\n\
         [[derived]]\npath = \"blade_off.mass\"\nformula = \"20 kg * clearance / (1 m)\"\n",
    );
    let ran = printed(&folder, &["run", "k.toml", "--out", "k"]);
    assert!(ran.contains("exit code 0"), "{ran}");
    let note = "note: derived parameters keep the values of the row; --set changes each alone: rotor.unbalances.blade_off.mass";
    assert!(printed(&folder, &["replay", "k", "1", "--set", "clearance=0.5 mm"]).contains(note));
    assert!(!printed(&folder, &["replay", "k", "1", "--set", "blade_off.mass=9 g"]).contains("note: derived"));
    // a short name that is also the end of another path
    folder.write(
        "t.toml",
        "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"20 ms\"\n\
         [[vary]]\npath = \"contact.gap\"\nas = \"friction\"\nvalues = [\"0.4 mm\", \"1 mm\"]\n",
    );
    let ran = printed(&folder, &["run", "t.toml", "--out", "e"]);
    if ran.contains("exit code 0") {
        let text = printed(&folder, &["replay", "e", "1", "--set", "friction=0.2"]);
        assert!(text.contains("`friction` names two parameters: diaphragms.seal.contact.gap by the study"), "{text}");
    } else {
        assert!(ran.contains("friction"), "{ran}");
    }
}
