//! The command line as a user meets it: output, messages with their place, exit codes.

use crate::support::{Folder, bladeoff, said, say};
use std::io::Read;
use std::process::Stdio;

#[test]
fn impossible_combinations_are_found_before_anything_runs() {
    let folder = Folder::reduced();
    let vary = |text: &str| folder.write("s.toml", &format!("schema = 1\nmachine = \"machines/rig.toml\"\n{text}"));
    // Each value is allowed by itself; a bore as wide as its shaft is rejected.
    let file = vary("[[vary]]\npath = \"shaft[0].inner_diameter\"\nvalues = [\"10 mm\", \"25 mm\"]\n");
    let said = say(&["run", &file, "--out", &folder.name("out")]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("1 of 2 combinations"), "{}", said.err);
    assert!(said.err.contains(&format!("{file}:4:")), "{}", said.err);
    // A step with which no model of this machine is stable.
    let file = vary("[[vary]]\npath = \"run.step\"\nvalues = [1e-6, 1e-3]\n");
    let said = say(&["check", &file]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("too large"), "{}", said.err);
    // An offset larger than the gap: the rotor starts in contact.
    let file = vary("[[vary]]\npath = \"contact.offset[0]\"\nvalues = [\"0 mm\", \"0.7 mm\"]\n");
    let said = say(&["check", &file]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("contact.offset[0] = 0.7 mm"), "{}", said.err);
    assert!(!folder.path("out").exists(), "nothing was made");
}

#[test]
fn a_grid_of_a_million_millions_is_refused_with_its_count() {
    let folder = Folder::new();
    let axis = |path: &str| format!("[[vary]]\npath = \"{path}\"\nfrom = 0.1\nto = 0.2\ncount = 1000000\n");
    let text =
        format!("schema = 1\nmachine = \"machines/rig.toml\"\n{}{}", axis("contact.friction"), axis("blade_off.mass"));
    let said = say(&["check", &folder.write("s.toml", &text)]);
    assert_eq!(said.code, 3);
    let axes = "the study has 1000000000000 samples: 1000000 of diaphragms.seal.contact.friction (line 4) x 1000000 of \
                rotor.unbalances.blade_off.mass (line 9)";
    for part in ["s.toml:4:8: diaphragms.seal.contact.friction: ", axes, "at most 100000000 samples"] {
        assert!(said.err.contains(part), "{part}: {}", said.err);
    }
}

#[test]
fn files_outside_the_surroundings_of_a_study_are_not_read() {
    let folder = Folder::new();
    for named in ["/etc/passwd", "../../../etc/passwd", "machines/../../x.toml"] {
        let said = say(&["check", &folder.write("s.toml", &format!("schema = 1\nmachine = \"{named}\"\n"))]);
        assert_eq!(said.code, 3);
        assert!(said.err.contains("is outside the folders"), "{named}: {}", said.err);
    }
}

#[test]
fn check_says_what_varies_and_runs_nothing() {
    let folder = Folder::new();
    let study = folder.small_study();
    let said = say(&["check", &study]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("small: 12 samples"), "{}", said.out);
    assert!(said.out.contains("diaphragms.seal.contact.gap"), "{}", said.out);
    assert!(said.out.contains("the whole study: about"), "{}", said.out);
    let list = say(&["check", &study, "--list"]);
    assert_eq!(list.out.lines().count(), 13);
    assert_eq!(list.out.lines().nth(1), Some("0\t0.0005\t0.1\thyp1"));
    assert!(!folder.path("runs").exists() && !crate::support::root().join("runs/small").exists());
}

#[test]
fn json_of_a_run_has_the_columns_of_a_table_as_keys() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    let said = say(&["simulate", &rig, "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let object: serde_json::Value = serde_json::from_str(&said.out).expect("one JSON object");
    assert_eq!(object["status"], "ok");
    assert_eq!(object["detection"], "hyp2");
    assert!(object["first_contact_s"].as_f64().is_some_and(|time| (0.1..0.17).contains(&time)), "it rubs");
    assert!(object["cause"].is_null() && object["stop_time_s"].is_null(), "null for what did not happen");
    assert!(object["steps"].is_u64());
    let study = folder.write("one.toml", "schema = 1\nmachine = \"machines/rig.toml\"\n");
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let (header, rows) = crate::support::table(&out);
    let keys: std::collections::BTreeSet<&str> =
        object.as_object().expect("an object").keys().map(String::as_str).collect();
    assert_eq!(header[0], "sample");
    assert_eq!(header[1..].iter().map(String::as_str).collect::<std::collections::BTreeSet<_>>(), keys);
    // Compared as text, because serde_json may read a number with an error in the last bit.
    let written = |name: &str| {
        let start = format!("  \"{name}\": ");
        let line = said.out.lines().find_map(|line| line.strip_prefix(&start)).expect("one line per key");
        line.trim_end_matches(',').to_owned()
    };
    for (name, cell) in header.iter().zip(&rows[0]).skip(1) {
        match &object[name] {
            serde_json::Value::Null => assert_eq!(cell, "", "{name}"),
            serde_json::Value::String(word) => assert_eq!(cell, word, "{name}"),
            _ => {
                let bits = |text: &str| text.parse::<f64>().expect("a number").to_bits();
                assert_eq!(bits(&written(name)), bits(cell), "{name}: the study's row is the single run, bit for bit");
            }
        }
    }
}

#[test]
fn a_failed_run_is_exit_4_and_still_one_json_object() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    let said = say(&["simulate", &rig, "--json", "--set", "run.step_limit=100"]);
    assert_eq!(said.code, 4, "{}", said.err);
    let object: serde_json::Value = serde_json::from_str(&said.out).expect("one JSON object");
    assert_eq!(object["status"], "failed");
    assert_eq!(object["cause"], "step_limit");
    assert_eq!(object["causes"], "step_limit");
    assert_eq!(object["end_cause"], "failure");
    assert_eq!(object["steps"], 100);
}

#[test]
fn an_invalid_run_warns_and_is_exit_0() {
    let folder = Folder::new();
    let said =
        say(&["simulate", &folder.name("machines/rig.toml"), "--set", "run.guard.energy_balance=1e-30", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let object: serde_json::Value = serde_json::from_str(&said.out).expect("one JSON object");
    assert_eq!(object["status"], "invalid");
    assert_eq!(object["cause"], "energy_balance");
    assert!(object["max_bearing_load_N"].is_f64(), "values are kept");
    assert!(said.err.contains("warning: the run is invalid"), "{}", said.err);
}

#[test]
fn a_step_that_is_too_large_is_refused_with_the_largest_allowed() {
    let folder = Folder::reduced();
    let said = say(&["simulate", &folder.name("machines/rig.toml"), "--step", "1 ms"]);
    assert_eq!(said.code, 3);
    assert!(said.err.contains("largest allowed"), "{}", said.err);
    assert!(said.out.is_empty());
}

#[test]
fn options_of_simulate_are_what_is_simulated() {
    let folder = Folder::reduced();
    let rig = folder.name("machines/rig.toml");
    let said = say(&[
        "simulate",
        &rig,
        "--detection",
        "hyp1",
        "--step",
        "2 us",
        "--set",
        "run.end_time=0.01 s",
        "--engine",
        "reduced",
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    let line = |start: &str| said.out.lines().find(|line| line.starts_with(start)).unwrap_or_default().to_owned();
    assert!(line("detection").ends_with("hyp1"), "{}", said.out);
    assert!(line("time step").contains(" 2 us"), "{}", said.out);
    assert!(line("end ").contains("10 ms"), "{}", said.out);
    let set: Vec<&str> = said.out.lines().filter(|line| line.starts_with("set ")).collect();
    assert!(set.len() == 1 && set[0].ends_with(" run.end_time = 10 ms"), "{}", said.out);
    let twice =
        say(&["simulate", &rig, "--set", "end_time=1", "--set", "run.end_time=5e-3", "--set", "contact.friction=0"]);
    let set: Vec<_> = twice.out.lines().filter(|line| line.starts_with("set ")).map(|line| line[3..].trim()).collect();
    assert_eq!(set[0], "run.end_time = 5 ms", "{}", twice.out);
    assert!(set.len() == 2 && set[1].ends_with(".contact.friction = 0"), "{}", twice.out);
    let said = say(&["simulate", &rig, "--set", "contact.gapp=1"]);
    assert_eq!(said.code, 3);
    assert!(said.err.contains("did you mean"), "{}", said.err);
}

#[test]
fn modes_are_shown_at_the_speeds_asked_for() {
    let machine = "studies/machines/lp_turbine_paper.toml";
    let said = say(&["modes", machine, "--speed", "0", "--speed", "1500 rpm", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let speeds: Vec<f64> = report["whirl"]
        .as_array()
        .expect("speeds")
        .iter()
        .map(|at| at["speed_rad_s"].as_f64().expect("a number"))
        .collect();
    assert_eq!(speeds[0], 0.0);
    assert!((speeds[1] - 157.079_632_679_489_66).abs() < 1e-12);
    assert!(report["critical_speeds"].as_array().is_some_and(|all| !all.is_empty()));
    assert!(report["rings"][0]["modes"][0]["nodal_diameters"].is_u64());
    let text = say(&["modes", machine]);
    assert!(text.out.contains("whirl at 1500 rpm"), "{}", text.out);
    for speed in ["-3 rpm", "1e300", "1.001e6 rad/s"] {
        let said = say(&["modes", machine, &format!("--speed={speed}")]);
        assert!(said.code == 3 && said.err.contains("from 0 to 1e6 rad/s"), "{} {}", said.code, said.err);
    }
}

#[test]
fn paths_lists_what_set_takes() {
    let said = say(&["paths", "studies/machines/lab_rig.toml"]);
    assert_eq!(said.code, 0);
    let gap = said.out.lines().find(|line| line.starts_with("diaphragms.seal.contact.gap ")).expect("the gap");
    assert!(gap.contains("0.5 mm"), "{gap}");
    assert!(said.out.lines().any(|line| line.starts_with("run.step ")), "also what the file leaves out");
}

#[test]
fn paths_as_json_say_what_the_table_says() {
    let said = say(&["paths", "studies/machines/lab_rig.toml", "--json"]);
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    let told: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let parameters = told["parameters"].as_array().expect("a list");
    let lines = say(&["paths", "studies/machines/lab_rig.toml"]).out;
    assert_eq!(parameters.len(), lines.lines().count() - 1);
    let of = |path: &str| parameters.iter().find(|parameter| parameter["path"] == path).expect(path);
    let gap = of("diaphragms.seal.contact.gap");
    assert_eq!((&gap["value"], &gap["unit"], &gap["default"]), (&5e-4.into(), &"m".into(), &false.into()));
    assert_eq!((&gap["column"], &gap["kind"]), (&"diaphragms.seal.contact.gap_m".into(), &"number".into()));
    let detection = of("diaphragms.seal.contact.detection");
    assert_eq!(detection["choices"], serde_json::json!(["hyp1", "hyp2", "hyp2-frozen"]));
    assert!(of("run.step")["value"].is_null());
}

#[test]
fn the_version_names_commit_and_numerics() {
    let said = say(&["--version"]);
    let engine = bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
    let numerics = format!("numerics {}, exponential engine {engine})\n", bladeoff_core::NUMERICS_VERSION);
    assert!(
        said.code == 0 && said.out.starts_with("bladeoff 0.1.0 (commit ") && said.out.ends_with(&numerics),
        "{}",
        said.out
    );
    assert!(said.out.contains(bladeoff::version::COMMIT));
}

#[test]
fn a_figure_of_another_format_makes_no_folder() {
    let folder = Folder::new();
    let machine = folder.name("machines/rig.toml");
    for (command, option) in [("plot", "--out"), ("modes", "--figures")] {
        let pdf = folder.name("fig.pdf");
        let said = say(&[command, &machine, option, &pdf]);
        assert_eq!(said.code, 3, "{command}: {}", said.err);
        assert!(said.err.contains(".pdf") && said.err.contains("svg") && said.err.contains("png"), "{}", said.err);
        assert!(said.out.is_empty() && !folder.path("fig.pdf").exists());
    }
}

#[test]
fn templates_are_valid_and_overwrite_nothing() {
    let folder = Folder::new();
    let machine = folder.name("new_machine.toml");
    assert_eq!(say(&["new", "machine", "--out", &machine]).code, 0);
    let said = say(&["paths", &machine]);
    assert_eq!(said.code, 0, "{}", said.err);
    let again = say(&["new", "machine", "--out", &machine]);
    assert_eq!(again.code, 3);
    assert!(again.err.contains("not overwritten"), "{}", again.err);
    let study = say(&["new", "study"]).out.replace("lab_rig", "rig");
    let said = say(&["check", &folder.write("new_study.toml", &study), "--list"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(said.out.lines().count(), 1 + 3 * 3 * 6, "several starts a cell");
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let mut child = bladeoff(&["paths", "studies/machines/lp_turbine_paper.toml"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    let mut first = [0];
    child.stdout.take().expect("piped").read_exact(&mut first).expect("one byte");
    let said = said(child.wait_with_output().expect("it ends"));
    assert_eq!((said.code, said.err.as_str()), (0, ""));
}

#[test]
fn a_full_disk_behind_standard_output_is_exit_6() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let output = bladeoff(&["new", "study"]).stdout(full).output().expect("the binary starts");
    assert_eq!(output.status.code(), Some(6));
}

#[test]
fn a_word_too_many_is_refused_with_what_was_probably_meant() {
    for (line, meant) in [
        (&["new", "machine", "mine.toml"][..], "--out mine.toml"),
        (&["simulate", "rig.toml", "run.step=1e-5"], "--set run.step=1e-5"),
        (&["simulate", "rig.toml", "-set", "run.step=1e-5"], "two dashes: --set"),
    ] {
        let said = say(line);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("unexpected argument") && said.err.contains(meant), "{}", said.err);
        assert!(!said.err.contains("tip:"), "one hint: {}", said.err);
    }
}
