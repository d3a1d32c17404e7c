//! Shipped studies with questions: each answers in one command at a reduced size. Studies that the pages show in full.

use crate::support::{Folder, json, root, say, table};
use std::collections::BTreeSet;
use std::fs;

/// Runs the first points of a study; checks its answers and its gate.
fn answers_in_one_command(name: &str, points: usize, samples: usize, names: &[&str]) {
    let folder = Folder::new();
    let (study, out) = (format!("studies/{name}.toml"), folder.name("out"));
    let ran = say(&["run", &study, "--limit", &points.to_string(), "--workers", "1", "--out", &out]);
    assert_eq!(ran.code, 0, "{name}: {}", ran.err);
    assert!(ran.out.contains(&format!("Answers, of {points} point")), "{}", ran.out);
    let (header, rows) = table(&out);
    let contact = header.iter().position(|column| column == "first_contact_s").expect("the column");
    assert_eq!(rows.len(), samples, "{name}");
    assert!(rows.iter().any(|row| !row[contact].is_empty()), "{name}: contact happened");
    let text = fs::read(format!("{out}/answers.json")).expect("answers.json");
    let answers: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    assert_eq!(answers["complete"], true);
    let answers = answers["answers"].as_array().expect("a list");
    let answered: BTreeSet<&str> = answers.iter().map(|answer| answer["name"].as_str().expect("a name")).collect();
    assert_eq!(answered, names.iter().copied().collect(), "{name}");
    for answer in answers {
        assert_eq!(answer["n"], points, "{name}: {answer}");
        assert_eq!(answer["bad"], 0, "{name}: {answer}");
        assert_eq!(answer["estimate"].is_null(), answer["kind"] == "fragility", "{name}: {answer}");
    }
    let judged = say(&["gate", &out]);
    if fs::read_to_string(root().join(&study)).expect("the study").contains("[[gate]]") {
        assert_eq!(judged.code, 5, "so few points decide nothing: {}", judged.out);
        assert!(judged.out.contains(": open, ") && judged.out.contains("more would decide"), "{}", judged.out);
    }
}

#[test]
fn the_turbine_on_films_and_pedestals_answers() {
    let names = ["pedestal-overload", "cap-bolts", "front-seal", "pedestal-by-lost-mass"];
    answers_in_one_command("lp-turbine-risk", 1, 1, &names);
}

/// Weight, bearing tables, pedestals and monitors during a rub: `exponential` against all degrees of freedom.
#[test]
fn the_shipped_turbine_has_the_loads_of_full() {
    let machine = root().join("studies/machines/lp_turbine.toml").to_string_lossy().into_owned();
    let of = |engine: &str| {
        let set = ["--engine", engine, "--set", "run.end_time=0.1 s", "--set", "contact.gap=5 mm", "--json"];
        let said = say(&[&["simulate", &machine][..], &set].concat());
        assert_eq!((said.code, said.err.contains("warning: modes")), (0, false), "{engine}: {}", said.err);
        json(&said.out)
    };
    let [full, ours] = ["full", "exponential"].map(of);
    for row in [&full, &ours] {
        assert_eq!(row["status"], "ok", "{row}");
        assert!(row["contact_impulse_Ns"].as_f64() > Some(1000.0), "contact happened: {row}");
    }
    for (column, tolerance) in [
        ("max_bearing_load_N", 1e-3),
        ("max_upward_bearing_force_rear_N", 2e-3),
        ("max_pedestal_load_rear_N", 5e-3),
        ("max_displacement_rear_seal_m", 2e-3),
        ("contact_impulse_Ns", 5e-3),
        ("friction_energy_J", 5e-3),
        ("max_bending_stress_Pa", 1e-2),
    ] {
        let [a, b] = [&full, &ours].map(|row| row[column].as_f64().expect("a number"));
        println!("{column}: {a} {b} {:.1e}", b / a - 1.0);
        assert!((b / a - 1.0).abs() < tolerance, "{column}: {a} {b}");
    }
}

#[test]
fn the_turbine_at_risk_answers() {
    let names = ["bearing-overload", "diaphragm-hit", "bearing-load-95", "overload-by-lost-mass"];
    answers_in_one_command("blade-off-risk", 1, 1, &names);
}

#[test]
fn one_blade_a_hundred_thousand_times_answers_from_its_first_points() {
    let names = [
        "bearing-overload",
        "diaphragm-hit",
        "rolls-in-the-ring",
        "bearing-load-95",
        "bearing-load-9999",
        "overload-by-friction",
    ];
    answers_in_one_command("one-blade-100k", 8, 8, &names);
}

#[test]
fn the_error_of_the_detection_answers_and_the_night_has_its_gate() {
    answers_in_one_command("detection-error", 2, 8, &["mean-load", "load-95", "overload"]);
    answers_in_one_command("ci-night", 4, 4, &["overload", "load-95"]);
}

/// The scripts of the steps of a workflow.
fn steps(workflow: &str) -> Vec<String> {
    let mut steps = Vec::new();
    let mut lines = workflow.lines().peekable();
    while let Some(line) = lines.next() {
        let Some((_, script)) = line.split_once("run: ") else { continue };
        let depth = |line: &str| line.len() - line.trim_start().len();
        let (mut script, own) = (script.to_owned(), depth(line));
        if script == "|" {
            script.clear();
            while let Some(next) = lines.next_if(|next| depth(next) > own) {
                script += next.trim_start();
                script.push('\n');
            }
        }
        steps.push(script);
    }
    steps
}

/// The commands of the nightly workflow, in order, with 64 points instead of five hours; the gate and the page are included.
#[test]
fn the_commands_of_the_nightly_workflow_work() {
    let folder = Folder::new();
    for name in ["ci-night.toml", "machines/lab_rig.toml"] {
        let text = fs::read_to_string(root().join("studies").join(name)).expect("shipped");
        folder.write(&format!("studies/{name}"), &text);
    }
    let workflow = fs::read_to_string(root().join(".github/workflows/ci-night.yml")).expect("the workflow");
    let steps: Vec<String> = steps(&workflow).into_iter().filter(|step| step.contains("bladeoff ")).collect();
    assert!(steps.len() == 3 && steps[0].contains("--wall \"5 h\""), "{steps:?}");
    let output = folder.name("output");
    // GitHub's shell is `bash -e`
    let run = |step: &str, path: &str, study: &str| {
        let script = format!("cd '{}'\n{step}", folder.name("."));
        let path = format!("{path}:{}", std::env::var("PATH").expect("a path"));
        let env = [("PATH", path.as_str()), ("GITHUB_OUTPUT", &output), ("STUDY", study)];
        let ran = std::process::Command::new("bash").args(["-ec", &script]).envs(env).output().expect("a shell");
        (
            ran.status.code(),
            String::from_utf8_lossy(&ran.stdout).into_owned(),
            String::from_utf8_lossy(&ran.stderr).into_owned(),
        )
    };
    let program =
        std::path::Path::new(env!("CARGO_BIN_EXE_bladeoff")).parent().expect("a folder").display().to_string();
    for step in &steps {
        let (code, _, err) = run(&step.replace("--wall \"5 h\"", "--limit 64"), &program, "0");
        assert_eq!(code, Some(0), "{step}: {err}");
    }
    assert_eq!(fs::read_to_string(&output).expect("the output of the step"), "code=0\n");
    // an undecided gate is a warning while the study is incomplete
    for (gate, study, code, warns) in [(5, "5", 0, true), (5, "0", 5, false), (4, "5", 4, false), (0, "5", 0, false)] {
        let stub = folder.write("stub/bladeoff", &format!("#!/bin/sh\nexit {gate}\n"));
        fs::set_permissions(&stub, std::os::unix::fs::PermissionsExt::from_mode(0o755)).expect("executable");
        let (ended, out, err) = run(&steps[1], &folder.name("stub"), study);
        assert_eq!((ended, out.contains("::warning")), (Some(code), warns), "gate {gate}, study {study}: {out}{err}");
    }
    let junit = fs::read_to_string(folder.name("gate.xml")).expect("the gate's file");
    assert!(junit.contains("<testcase") && !junit.contains("<failure"), "{junit}");
    assert!(
        fs::read_to_string(folder.name("ci-night.html"))
            .expect("the page")
            .contains("Verdict: 1 gate decision: 1 passed. All 64 runs passed")
    );
}

/// Every second gap and friction of the map, one angle per cell: a bad run is a row like any other. The guard of the study rejects none; a hundredth
/// of it does.
#[test]
fn the_map_of_one_detection_is_drawn_in_one_command() {
    let folder = Folder::new();
    let shipped = |name: &str| fs::read_to_string(root().join("studies").join(name)).expect("shipped");
    folder.write("machines/lp_turbine_paper.toml", &shipped("machines/lp_turbine_paper.toml"));
    let text = shipped("gap-friction-hyp2.toml").replace("[set]\n", "[set]\n\"run.guard.normal_work\" = 1e-4\n");
    assert!(text.contains("normal_work"), "set");
    let (study, out) = (folder.write("map.toml", &text), folder.name("map"));
    let ran = say(&["run", &study, "--scale", "0.5", "--limit", "1", "--workers", "1", "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let (header, rows) = table(&out);
    let column = |name: &str| header.iter().position(|column| column == name).expect("the column");
    let status = column("status");
    // the last column, because several causes contain commas
    let engine = |row: &Vec<String>| row.last().cloned();
    assert!(rows.len() == 20 && rows.iter().all(|row| engine(row).as_deref() == Some("exponential")), "{header:?}");
    for word in ["ok", "invalid"] {
        assert!(rows.iter().any(|row| row[status] == word), "{word}: {}", ran.out);
    }
    assert!(ran.out.contains("max_bearing_load_N over diaphragms.mid.contact.gap_m"), "{}", ran.out);
    let picture = folder.name("loads.svg");
    let drawn = say(&["map", &out, "--question", "loads", "--out", &picture]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    assert!(fs::read_to_string(picture).expect("a picture").contains("cross: bad runs"));
}

/// Two complete trajectories, and two complete base points, of the rig.
#[test]
fn what_decides_answers_by_trajectories_and_then_by_base_points() {
    let folder = Folder::new();
    for (name, limit, samples, blocks, index) in
        [("sensitivity", "18", 18, 2, "mu_star"), ("sensitivity-sobol", "14", 14, 2, "total")]
    {
        let (study, out) = (format!("studies/{name}.toml"), folder.name(name));
        let ran = say(&["run", &study, "--limit", limit, "--out", &out]);
        assert_eq!(ran.code, 0, "{name}: {}", ran.err);
        let (header, rows) = table(&out);
        let contact = header.iter().position(|column| column == "first_contact_s").expect("the column");
        assert_eq!(rows.len(), samples, "{name}");
        assert!(rows.iter().any(|row| !row[contact].is_empty()), "{name}: contact happened");
        let text = fs::read(format!("{out}/answers.json")).expect("answers.json");
        let answers: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        let answer = &answers["answers"][0];
        assert_eq!((&answer["name"], &answer["kind"]), (&"what-decides-the-load".into(), &"sensitivity".into()));
        assert_eq!(answer["n"].as_u64().expect("a number") + answer["left_out"].as_u64().expect("a number"), blocks);
        let indices = answer["indices"].as_object().expect("indices");
        assert!(indices.contains_key("gap_m"), "{answer}");
        let found = indices.values().filter(|of| of[index]["estimate"].as_f64().is_some_and(|value| value > 0.0));
        assert!(found.count() >= 3, "{name}: {answer}");
        // so few do not show their scatter
        assert!(ran.out.contains("no interval: 2 "), "{name}: {}", ran.out);
    }
}

#[test]
fn check_says_what_it_understood_of_the_risk_template() {
    let folder = Folder::new();
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the rig");
    folder.write("machines/lab_rig.toml", &rig);
    let study = folder.name("risk.toml");
    assert_eq!(say(&["new", "study", "--kind", "risk", "--out", &study]).code, 0);
    let text = fs::read_to_string(&study).expect("written");
    assert!(text.contains("\"0.1 s\""));
    folder.write("risk.toml", &text.replace("\"0.1 s\"", "\"1 ms\""));
    let told = say(&["check", &study]);
    assert_eq!(told.code, 0, "{}", told.err);
    for part in [
        "lognormal, median 10 g, cv 0.2, cut at 4 g and 20 g: mean 10.2 g, sd 2.033 g",
        "periodic, lower 0 deg, upper 360 deg: uniform, both ends are the same",
        "  = cold_gap - growth\ncold_gap and growth: rank correlation 0.3\n\nEngine: exponential (run.engine = \"auto\": it covers every sample)\n\nFixed by [set]:",
        "\n\nQuestions:\n  overload",
        "\n\nGates:\n  P(max_bearing_load_N > 200 N) < 0.05 (confidence 95 %)\n",
    ] {
        assert!(told.out.contains(part), "{part}\nis not in\n{}", told.out);
    }
    // the release angle is uncertain over the whole turn, eight times the angle between two blades
    assert!(!(told.out + &told.err).contains("the same angle"));
}

#[test]
fn studies_that_the_pages_show_in_full_are_valid() {
    let folder = Folder::new();
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the rig");
    folder.write("machines/lab_rig.toml", &rig);
    let mut seen = 0;
    for page in ["docs/studies.md", "docs/study-distributions.md", "docs/study-formulas.md", "docs/runs-not-ok.md"] {
        let text = fs::read_to_string(root().join(page)).expect("the page");
        let block = |block: &str| block.split("```").next().map(str::to_owned);
        for rows in text.split("```csv\n").skip(1).filter_map(block) {
            if let Some(name) = rows.lines().next().and_then(|line| line.strip_prefix("# ")) {
                folder.write(name, &rows);
            }
        }
        for study in text.split("```toml\n").skip(1).filter_map(block).filter(|study| study.contains("schema = 1")) {
            let told = say(&["check", &folder.write("s.toml", &study), "--list"]);
            assert_eq!(told.code, 0, "{page}:\n{study}\n{}", told.err);
            assert!(told.out.lines().count() > 1, "{page}: {study}");
            seen += 1;
        }
    }
    assert!(seen >= 4, "{seen}");
}
