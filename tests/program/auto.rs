//! `run.engine = "auto"`: one engine for all samples of a study, the exponential one if it covers every sample; `check` prints the choice and the
//! reason.

use crate::support::{Folder, json, say, table};
use std::fs;

/// The rig with 13 g lost and a narrow gap, with contact after 19 ms, up to 30 ms; the file names no engine.
const STUDY: &str = r#"schema = 1
name = "auto"
machine = "machines/auto.toml"

[set]
"run.end_time" = "30 ms"
"blade_off.mass" = "13 g"

[[vary]]
path = "contact.gap"
values = ["0.4 mm", "0.45 mm"]

[[vary]]
path = "contact.friction"
values = [0.1, 0.2]
"#;

/// Values of `run.force_location`, one of which `exponential` does not cover.
const LOCATIONS: &str = "\n[[vary]]\npath = \"run.force_location\"\nvalues = [\"next\", \"current\"]\n";
/// Detections, all of which `exponential` covers.
const DETECTIONS: &str = "\n[[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp2\", \"hyp1\", \"hyp2-frozen\"]\n";

fn folder() -> Folder {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let auto = rig.replace("engine = \"exponential\"\n", "");
    assert_ne!(auto, rig);
    folder.write("machines/auto.toml", &auto);
    folder
}

/// Cells of a column of a result directory.
fn cells(directory: &str, column: &str) -> Vec<String> {
    let (header, rows) = table(directory);
    let place = header.iter().position(|name| name == column).unwrap_or_else(|| panic!("no column {column}"));
    rows.into_iter().map(|mut row| row.swap_remove(place)).collect()
}

fn run(study: &str, out: &str, more: &[&str]) -> crate::support::Said {
    let said = say(&[&["run", study, "--out", out], more].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    said
}

/// The line of `check` about the engine.
fn engine_of(study: &str) -> String {
    let said = say(&["check", study]);
    assert_eq!(said.code, 0, "{}", said.err);
    let lines: Vec<&str> = said.out.lines().filter(|line| line.starts_with("Engine: ")).collect();
    assert_eq!(lines.len(), 1, "{}", said.out);
    lines[0].to_owned()
}

#[test]
fn a_study_that_is_covered_is_exponential_with_the_same_bytes_whoever_computes_it() {
    let folder = folder();
    let study = folder.write("s.toml", STUDY);
    assert_eq!(engine_of(&study), "Engine: exponential (run.engine = \"auto\": it covers every sample)");
    let (one, two) = (folder.name("one"), folder.name("two"));
    run(&study, &one, &["--workers", "1"]);
    run(&study, &two, &["--workers", "2"]);
    assert_eq!(cells(&one, "engine"), ["exponential"; 4]);
    assert!(cells(&one, "first_contact_s").iter().all(|time| !time.is_empty()), "contact happened");
    assert_eq!(table(&one).0.last().expect("columns"), "engine", "behind all others");
    let bytes = |out: &str| fs::read(format!("{out}/results.parquet")).expect("the table");
    assert!(bytes(&one) == bytes(&two), "the same bytes");
    // each row equals that of the same engine given explicitly
    let named = folder.write("named.toml", &STUDY.replace("[set]", "[set]\n\"run.engine\" = \"exponential\""));
    let third = folder.name("third");
    run(&named, &third, &[]);
    assert_eq!(table(&one).1, table(&third).1);
    for sample in ["0", "3"] {
        let replay = say(&["replay", &one, "--sample", sample]);
        assert_eq!(replay.code, 0, "{}", replay.err);
        assert!(replay.out.contains("equal to the row in all"), "{}", replay.out);
    }
    // and differs from that of the other engine
    let other = folder.write("other.toml", &STUDY.replace("[set]", "[set]\n\"run.engine\" = \"reduced\""));
    let fourth = folder.name("fourth");
    run(&other, &fourth, &[]);
    assert_eq!(cells(&fourth, "engine"), ["reduced"; 4]);
    assert_ne!(cells(&one, "max_bearing_load_N"), cells(&fourth, "max_bearing_load_N"));
}

#[test]
fn a_study_of_several_detections_is_exponential() {
    let folder = folder();
    let study = folder.write("s.toml", &format!("{STUDY}{DETECTIONS}"));
    assert!(engine_of(&study).starts_with("Engine: exponential"));
    let out = folder.name("out");
    run(&study, &out, &[]);
    assert_eq!(cells(&out, "engine"), ["exponential"; 12]);
    assert!(cells(&out, "first_contact_s").iter().all(|time| !time.is_empty()), "contact happened");
}

#[test]
fn a_study_with_another_force_location_is_reduced_whatever_part_of_it_is_computed() {
    let folder = folder();
    let study = folder.write("s.toml", &format!("{STUDY}{LOCATIONS}"));
    let why = "Engine: reduced (run.engine = \"auto\": \"exponential\" does not cover forces at the place of step n \
               (run.force_location))";
    assert_eq!(engine_of(&study), why);
    // only the first sample is covered
    let said = say(&["check", &study, "--limit", "1"]);
    assert!(said.out.contains(why), "{}", said.out);
    let (whole, part) = (folder.name("whole"), folder.name("part"));
    run(&study, &whole, &[]);
    run(&study, &part, &["--limit", "2"]);
    assert_eq!(
        (cells(&whole, "engine"), cells(&part, "engine")),
        (vec!["reduced".into(); 8], vec!["reduced".into(); 2])
    );
    assert!(cells(&whole, "first_contact_s").iter().all(|time| !time.is_empty()), "contact happened");
    let replay = say(&["replay", &whole, "--sample", "0"]);
    assert!(replay.out.contains("equal to the row in all"), "{}", replay.out);
}

#[test]
fn a_study_goes_on_with_its_engine_and_is_refused_with_another() {
    let folder = folder();
    let out = folder.name("out");
    let study = folder.write("s.toml", STUDY);
    run(&study, &out, &["--limit", "2"]);
    // grown along the existing axis
    let grown = folder.write("s.toml", &STUDY.replace("[0.1, 0.2]", "[0.1, 0.2, 0.3]"));
    let said = run(&grown, &out, &[]);
    assert!(said.err.contains("2 of 6 samples are already finished"), "{}", said.err);
    assert_eq!(cells(&out, "engine"), ["exponential"; 6]);
    let whole = fs::read(folder.path("out/results.parquet")).expect("the table");
    let fresh = folder.name("fresh");
    run(&grown, &fresh, &[]);
    assert!(fs::read(folder.path("fresh/results.parquet")).expect("the table") == whole);
    // grown by a value that the engine does not cover
    let mixed = folder.write("s.toml", &format!("{STUDY}{LOCATIONS}"));
    let said = say(&["run", &mixed, "--out", &out]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("run.engine: exponential -> reduced"), "{}", said.err);
    assert!(fs::read(folder.path("out/results.parquet")).expect("the table") == whole, "nothing is touched");
}

/// Each feature that is not covered, alone; and keys that require an engine.
#[test]
fn check_names_the_first_thing_that_is_not_covered() {
    let folder = folder();
    let with = |set: &str| folder.write("s.toml", &STUDY.replace("[set]", &format!("[set]\n{set}")));
    for (set, what) in [
        ("\"seal.blades.count\" = 0", "does not cover a ring that nothing holds (diaphragms.seal.blades.count)"),
        ("\"run.force_location\" = \"current\"", "does not cover forces at the place of step n (run.force_location)"),
        ("\"run.step\" = \"3 us\"", "run.step is given, which \"exponential\" does not have"),
    ] {
        let said = say(&["check", &with(set)]);
        assert_eq!(said.code, 0, "{set}: {}", said.err);
        let told = format!("Engine: reduced (run.engine = \"auto\": \"exponential\" {what})")
            .replace("\"exponential\" run.step", "run.step");
        assert!(said.out.contains(&told), "{set}: {}", said.out);
    }
    let wanted = "\"run.contact_step\" = \"1.5 us\"";
    let alone = engine_of(&with(wanted));
    assert_eq!(
        alone,
        "Engine: exponential (run.engine = \"auto\": run.contact_step is given, which only this engine has)"
    );
    for (set, path) in [
        ("\"run.force_location\" = \"current\"", "run.force_location"),
        ("\"seal.blades.count\" = 0", "diaphragms.seal.blades.count"),
        ("\"run.step\" = \"1 us\"", "run.step"),
    ] {
        let said = say(&["check", &with(&format!("{wanted}\n{set}"))]);
        assert_eq!(said.code, 3, "{set}: {}", said.out);
        assert!(said.err.contains(path) && said.err.contains("the engine \"exponential\""), "{}", said.err);
    }
    // the same if the location varies
    let mixed = STUDY.replace("[set]", &format!("[set]\n{wanted}")) + LOCATIONS;
    let mixed = folder.write("s.toml", &mixed);
    let said = say(&["check", &mixed]);
    assert_eq!(said.code, 3, "{}", said.out);
    assert!(said.err.contains("does not cover forces at the place of step n"), "{}", said.err);
    // a varied engine has no `auto`
    let several = format!("{STUDY}\n[[vary]]\npath = \"run.engine\"\nvalues = [\"reduced\", \"auto\"]\n");
    let said = say(&["check", &folder.write("s.toml", &several)]);
    assert_eq!(said.code, 3, "{}", said.out);
    assert!(said.err.contains("one engine for the whole study"), "{}", said.err);
}

#[test]
fn a_machine_alone_is_computed_by_what_covers_it() {
    let folder = folder();
    let machine = folder.name("machines/auto.toml");
    let check = say(&["check", &machine]);
    assert_eq!(check.code, 0, "{}", check.err);
    assert!(check.out.contains("Engine: exponential (run.engine = \"auto\": it covers the machine)"), "{}", check.out);
    let touching =
        ["--set", "run.end_time=30 ms", "--set", "blade_off.mass=13 g", "--set", "contact.gap=0.4 mm", "--json"];
    let of = |more: &[&str]| {
        let said = say(&[&["simulate", &machine], &touching[..], more].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        json(&said.out)
    };
    for (more, engine) in [
        (&[][..], "exponential"),
        (&["--engine", "auto"], "exponential"),
        (&["--engine", "full"], "full"),
        (&["--detection", "hyp1"], "exponential"),
        (&["--detection", "hyp2-frozen"], "exponential"),
        (&["--set", "contact.points=one"], "exponential"),
        (&["--set", "run.force_location=current"], "reduced"),
        (&["--step", "3 us"], "reduced"),
        (&["--set", "run.contact_step=1.5 us"], "exponential"),
    ] {
        let row = of(more);
        assert_eq!(row["engine"], engine, "{more:?}");
        assert!(row["first_contact_s"].is_number(), "{more:?}: contact happened");
    }
    assert_eq!(of(&[]), of(&["--engine", "exponential"]));
    let wanted = ["simulate", &machine, "--set", "run.contact_step=1.5 us", "--set", "run.force_location=current"];
    let said = say(&wanted);
    assert_eq!(said.code, 3, "{}", said.out);
    let why =
        "the engine \"exponential\", which run.contact_step asks for, does not cover forces at the place of step n";
    assert!(said.err.contains(why), "{}", said.err);
    // the same in a study; each piece of advice is accepted
    let one = "[set]\n\"run.force_location\" = \"current\"\n";
    let study = |set: &str| folder.write("s.toml", &STUDY.replace("[set]\n", &format!("{one}{set}")));
    let said = say(&["check", &study("\"run.contact_step\" = \"1.5 us\"\n")]);
    assert!(said.code == 3 && said.err.contains(why), "{}", said.err);
    assert!(said.err.contains("allowed: next, or no run.contact_step"), "{}", said.err);
    assert!(engine_of(&study("")).starts_with("Engine: reduced"));
    let exponential = "\"run.engine\" = \"exponential\"\n\"run.contact_step\" = \"1.5 us\"\n";
    let said = say(&["check", &study(exponential)]);
    let advice = "allowed: next, or run.engine = \"reduced\" and no run.contact_step";
    assert!(said.code == 3 && said.err.contains(advice), "{}", said.err);
    let said = say(&["check", &study(&exponential.replace("exponential", "reduced"))]);
    assert!(said.code == 3 && said.err.contains("allowed: run.step"), "{}", said.err);
    assert!(!said.err.contains("or run.engine"), "the location is refused there, too: {}", said.err);
    // --set and an option for the same parameter
    for (set, option) in [
        ("engine=reduced", ["--engine", "exponential"]),
        ("run.step=3 us", ["--step", "2 us"]),
        ("contact.detection=hyp1", ["--detection", "hyp2"]),
    ] {
        let said = say(&["simulate", &machine, "--set", set, option[0], option[1]]);
        assert!(said.code == 3 && said.err.contains("allowed: one of the two"), "{set}: {}", said.err);
        assert!(
            said.err.contains(&format!("another value, {}", set.split('=').next_back().expect("one"))),
            "{}",
            said.err
        );
    }
    assert_eq!(of(&["--set", "engine=reduced", "--engine", "reduced"])["engine"], "reduced");
    let said = say(&["simulate", &machine, "--engine", "exponential", "--set", "bearings.left.damping=1e9"]);
    assert!(said.code == 3 && said.err.contains("the whirl modes at 3018 rpm have no basis"), "{}", said.err);
    assert!(!said.err.contains("condition") && !said.err.contains("rad/s"), "{}", said.err);
    let said = say(&["simulate", &machine, "--set", "run.end_time=5 ms", "--set", "run.force_location=current"]);
    assert!(
        said.out
            .contains("reduced (run.engine = \"auto\": \"exponential\" does not cover forces at the place of step n"),
        "{}",
        said.out
    );
}

/// The benchmark in a short form, in this program and with this binary as another program.
#[test]
fn the_bench_of_engines_tells_both_and_their_ratios() {
    let short = ["bench", "engines", "--repeats", "1", "--part", "0.01"];
    let said = say(&short);
    assert_eq!(said.code, 0, "{}", said.err);
    let lines: Vec<&str> = said.out.lines().collect();
    assert!(lines[0].contains("load before and after") && lines[0].contains("core"), "{}", said.out);
    for name in
        ["turbine to 6 s  ", "turbine to 6 s, hyp1", "turbine to 6 s, hyp2-frozen", "lab rig", "6 s of free motion"]
    {
        let line = lines.iter().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {}", said.out));
        let ratios: Vec<f64> =
            line.split_whitespace().rev().take(2).map(|word| word.parse().expect("a ratio")).collect();
        assert!(ratios.iter().all(|ratio| *ratio > 0.0 && ratio.is_finite()), "{line}");
    }
    // the lab rig and its variants, per step on both engines
    let from = lines.iter().position(|line| line.starts_with("per step")).expect("a second table");
    let names =
        ["lab rig", "lab rig, tables", "lab rig, pedestals", "lab rig, tables and pedestals", "lab rig, a ring"];
    assert_eq!(lines[from + 1..].len(), names.len(), "{}", said.out);
    for (line, name) in lines[from + 1..].iter().zip(names) {
        let numbers = line.split_whitespace().rev().take(6).filter_map(|word| word.parse::<f64>().ok());
        assert!(line.starts_with(name) && numbers.count() == 6, "{line}");
    }
    let against = [&short[..], &["--against", env!("CARGO_BIN_EXE_bladeoff"), "--json"]].concat();
    let said = say(&against);
    assert_eq!(said.code, 0, "{}", said.err);
    let found = json(&said.out);
    let cases = found["cases"].as_array().expect("a list");
    assert_eq!(cases.len(), 9);
    for case in cases {
        assert_eq!(case["exponential"]["runs"].as_array().map(Vec::len), Some(5), "{case}");
        assert_eq!(case["reduced"]["runs"].as_array().map(Vec::len), Some(1), "{case}");
        assert!(case["exponential"]["least_s"].as_f64().is_some_and(|time| time > 0.0), "{case}");
    }
    let gone = say(&["bench", "engines", "--repeats", "1", "--part", "0.01", "--against", "/nowhere/bladeoff"]);
    assert_eq!(gone.code, 6, "{}", gone.err);
    assert!(gone.err.contains("/nowhere/bladeoff"), "{}", gone.err);
}

#[test]
fn what_steps_are_wrong_is_said_at_their_lines() {
    let folder = folder();
    let refused = |set: &str| {
        let study = folder.write("s.toml", &STUDY.replace("[set]\n", &format!("[set]\n{set}")));
        let said = say(&["check", &study]);
        assert_eq!(said.code, 3, "{}", said.err);
        said.err
    };
    // both keys, of which each engine has one
    let told = refused("\"run.step\" = \"3 us\"\n\"run.contact_step\" = \"3 us\"\n");
    assert!(told.contains("s.toml:6:1: run.step = 3 us") && told.contains("has no equal steps"), "{told}");
    // too large a step
    let told = refused("\"run.contact_step\" = \"3 ms\"\n");
    assert!(told.contains("s.toml:6:1: run.contact_step = 3 ms") && told.contains("largest allowed "), "{told}");
    assert!(told.contains("without run.contact_step the program chooses the step"), "{told}");
    let rig = folder.name("machines/auto.toml");
    for (setting, key) in [("run.contact_step=3 ms", "run.contact_step"), ("run.step=3 ms", "run.step")] {
        let said = say(&["simulate", &rig, "--set", setting]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(said.err.contains(&format!(": {key} = 3 ms: ")) && said.err.contains("with --set"), "{}", said.err);
    }
}

#[test]
fn check_says_whose_bases_are_their_own() {
    let folder = folder();
    let check = |more: &str| {
        let said = say(&["check", &folder.write("s.toml", &format!("{STUDY}{more}"))]);
        assert_eq!(said.code, 0, "{}", said.err);
        said.out
    };
    assert!(!check("").contains("Bases of"));
    let masses = "\n[[vary]]\npath = \"blade_off.mass\"\nvalues = [\"13 g\", \"14 g\"]\n";
    let study = STUDY.replace("\"blade_off.mass\" = \"13 g\"\n", "");
    let told = say(&["check", &folder.write("s.toml", &format!("{study}{masses}"))]).out;
    assert!(told.contains("Structure: all samples share one;"), "{told}");
    assert!(told.contains("Bases of the exponential engine: rotor.unbalances.blade_off.mass changes them;"), "{told}");
    // `reduced` has no bases
    let told = say(&["check", &folder.write("s.toml", &format!("{study}{masses}{LOCATIONS}"))]).out;
    assert!(told.contains("Structure:") && !told.contains("Bases of"), "{told}");
}

#[test]
fn a_broken_guard_says_by_how_much_and_which_step_mends_it() {
    let folder = folder();
    let study = STUDY.replace("[set]\n", "[set]\n\"run.guard.energy_balance\" = 1e-12\n");
    let (study, out) = (folder.write("s.toml", &study), folder.name("out"));
    let said = say(&["run", &study, "--out", &out]);
    assert!(said.code == 0 || said.code == 4, "{}", said.err);
    assert_eq!(cells(&out, "cause")[0], "energy_balance", "the guard broke");
    let why = say(&["why", &out, "0"]).out;
    for part in
        ["`run.guard.energy_balance`", "of the largest total energy; allowed 1e-12", "a smaller `run.contact_step`"]
    {
        assert!(why.contains(part), "{part}: {why}");
    }
    assert!(!why.contains("`run.step`"), "{why}");
    let page = folder.name("page.html");
    assert_eq!(say(&["report", &out, "--out", &page]).code, 0);
    let page = fs::read_to_string(page).expect("written");
    assert!(page.contains("run.contact_step") && !page.contains("a smaller `run.step`"), "the engine's own step");
}

#[test]
fn a_matrix_is_not_set_but_its_entries_are() {
    let folder = folder();
    let rig = folder.name("machines/auto.toml");
    let said = say(&["simulate", &rig, "--set", "bearings.left.stiffness=[[2e6, 0], [0, 3e6]]"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("one value is set at a time") && said.err.contains("machine file"), "{}", said.err);
}

/// A bearing whose damping leaves no basis of whirl modes at one of its values: all samples use `reduced`, for any part of the study.
#[test]
fn a_study_of_which_one_run_cannot_begin_is_reduced_whatever_part_of_it_is_computed() {
    let folder = folder();
    let varied = "\n[[vary]]\npath = \"bearings.left.damping\"\nvalues = [\"600 N s/m\", \"1e12 N s/m\"]\n";
    let study = folder.write("s.toml", &(STUDY.to_owned() + varied));
    let line = engine_of(&study);
    assert!(line.starts_with("Engine: reduced") && line.contains("1e12 N s/m") && line.contains("no basis"), "{line}");
    let (all, some) = (folder.name("all"), folder.name("some"));
    run(&study, &all, &[]);
    run(&study, &some, &["--limit", "1"]);
    assert_eq!(
        (cells(&all, "engine"), cells(&some, "engine")),
        (vec!["reduced".to_owned(); 8], vec!["reduced".to_owned()])
    );
    // rejected if the engine is given explicitly
    let named =
        folder.write("n.toml", &(STUDY.replace("[set]\n", "[set]\n\"run.engine\" = \"exponential\"\n") + varied));
    let refused = say(&["check", &named]);
    assert!(refused.code == 3 && refused.err.contains("very strong bearing damping"), "{}", refused.err);
}

/// Isotropic stiffness with cross stiffness on one side has no basis. Of 500 samples, 20 inside the study have it, but no corner or edge.
#[test]
fn a_run_without_a_basis_is_a_row_with_that_cause() {
    let folder = folder();
    folder.write(
        "machines/point.toml",
        "schema = 1\nname = \"point\"\n[run]\nend_time = 0.02\n[rotor]\nkind = \"point-mass\"\nmass = 2\npolar_inertia = 0.01\ninitial_speed = 300\n\
         [rotor.bearings.b]\nstiffness = [[1e5, 1e4], [1e3, 1e5]]\n[rotor.unbalances.u]\nmass = 0.01\nradius = 0.05\n",
    );
    let study = folder.write(
        "p.toml",
        "schema = 1\nname = \"p\"\nmachine = \"machines/point.toml\"\n[limits]\nmax_failed = \"100 %\"\n\
         [[vary]]\npath = \"rotor.bearings.b.stiffness[1][0]\"\nvalues = [500, 200, 0, 100, 1000]\n\
         [[vary]]\npath = \"rotor.bearings.b.stiffness[0][0]\"\nvalues = [9e4, 9.5e4, 1e5, 1.05e5, 1.1e5]\n\
         [[vary]]\npath = \"rotor.unbalances.u.mass\"\nfrom = \"10 g\"\nto = \"100 g\"\ncount = 20\n",
    );
    assert!(engine_of(&study).starts_with("Engine: exponential"));
    let out = folder.name("p");
    let said = run(&study, &out, &[]);
    assert!(said.out.contains("20 (20 no_basis)"), "{}", said.out);
    let causes = cells(&out, "cause");
    let first = causes.iter().position(|cause| cause == "no_basis").expect("one").to_string();
    let why = say(&["why", &first, "--dir", &out]);
    assert!(
        why.out.contains("has no modal basis at the start or at a speed of the run")
            && why.out.contains("run.engine = \"reduced\""),
        "{}",
        why.out
    );
}
