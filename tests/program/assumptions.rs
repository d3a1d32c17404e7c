//! Context of the numbers in `check`, summary and report: assumptions, expected contact, runs that are not ok, versions.

use crate::support::{Folder, json, root, say};
use bladeoff_core::NUMERICS_VERSION;
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use std::fs;

fn rig() -> String {
    fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the rig")
}

#[test]
fn check_prints_assumptions_and_the_contact_that_is_expected() {
    let folder = Folder::new();
    let plain = say(&["check", &folder.write("rig.toml", &rig())]);
    assert_eq!(plain.code, 0, "{}", plain.err);
    for said in [
        "Assumptions:",
        "  gravity: off",
        "  bearings: linear",
        "  torsional damping: taken from the lateral value, 20 us",
        "  diaphragm: planar linear ring",
        "  friction: Coulomb, constant coefficient 0.15",
        "  engine: exponential",
        "  seal: contact expected: 1.31 mm after the release (2.6 of the gap), unbalance response",
        "for a gap of 0.5 mm",
        "Limits of the model:",
        "  ring_yield: not judged: no diaphragms.NAME.material.yield_strength",
        "  warning: stresses of ring, blades and shaft are not judged",
    ] {
        assert!(plain.out.contains(said), "{said}: {}", plain.out);
    }
    let other = rig()
        .replace("gravity = [0.0, 0.0]", "gravity = [0.0, -9.81]")
        .replace("initial_speed = \"3000 rpm\"", "initial_speed = \"1500 rpm\"");
    let other = say(&["check", &folder.write("other.toml", &other)]);
    assert!(other.out.contains("gravity: on, 0 m/s2 along X and -9.81 m/s2 along Y"), "{}", other.out);
    assert!(other.out.contains("  seal: no contact expected: "), "{}", other.out);
    assert!(other.out.contains("are taken at rest by sag and offset"), "{}", other.out);
    let limit = other.out.lines().find(|line| line.starts_with("  ring_displacement")).expect("in the table of limits");
    assert!(limit.contains(" (0.05 of mean radius)  default") && limit.ends_with("beyond"), "{limit}");
    // an unstable machine may come into contact at any time, so no forecast is made from the linear response
    let unstable = rig().replace("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 3e6], [-3e6, 2e6]]");
    let unstable = say(&["check", &folder.write("unstable.toml", &unstable)]);
    assert!(unstable.out.contains("Contact:\n  no forecast: unstable between "), "{}", unstable.out);
    assert!(!unstable.out.contains("contact expected"), "{}", unstable.out);
    assert!(say(&["new", "machine"]).out.contains("gravity = [0.0, -9.81]"));
}

/// One of two equal runs has a guard that no run passes: it is invalid from its first step on, and appears in every list.
#[test]
fn a_run_that_is_not_ok_is_in_every_list_of_summary_and_report() {
    let folder = Folder::new();
    folder.write("rig.toml", &rig());
    let study = "schema = 1\nname = \"judged\"\nmachine = \"rig.toml\"\n[set]\n\"run.end_time\" = \"0.17 s\"\n\
        [[vary]]\npath = \"run.guard.energy_balance\"\nvalues = [1e-4, 1e-30]\n\
        [[vary]]\npath = \"rotor.gravity[1]\"\nvalues = [0, -9.81]\n";
    let study = folder.write("judged.toml", study);
    let check = say(&["check", &study]);
    assert_eq!(check.code, 0, "{}", check.err);
    assert!(check.out.contains("gravity: off") && check.out.contains("; this is sample 0, another sample has: on,"));
    assert!(check.out.contains("contact expected in 4 of 4 samples that were checked"), "{}", check.out);

    let out = folder.name("judged");
    let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
    assert!(
        run.out.contains(
            "Highest values of the runs that are not ok, before a guard or limit was exceeded (lower bounds):"
        ),
        "{}",
        run.out
    );
    let line = run.out.lines().find(|line| line.contains("largest bearing load: ")).expect("the line");
    assert!(line.contains(", invalid); the worst ok run: "), "{line}");

    let manifest = json(&fs::read_to_string(folder.path("judged/manifest.json")).expect("written"));
    assert_eq!(manifest["program"]["exponential_revision"], EXPONENTIAL_REVISION, "{manifest}");
    assert_eq!(manifest["provenance"]["exponential_revision"], EXPONENTIAL_REVISION.to_string(), "{manifest}");
    assert_eq!(manifest["provenance"]["numerics_version"], NUMERICS_VERSION.to_string());

    let page = folder.name("judged.html");
    let made = say(&["report", &out, "--out", &page]);
    assert_eq!(made.code, 0, "{}", made.err);
    let page = fs::read_to_string(page).expect("UTF-8");
    let (_, body) = page.split_once("</style>").expect("a style");
    let (body, _) = body.split_once("<script>").expect("the library");
    for said in [
        "4 runs: 2 ok, 2 invalid. 2 runs (50 %) are failed, invalid or quarantined: values are not for design.",
        "id=\"assumptions\"",
        "gravity: off",
        "invalid: energy_balance",
        "of all runs that have one: 2 ok, 2 invalid.",
        "exponential revision",
    ] {
        assert!(body.contains(said), "{said}");
    }
}
