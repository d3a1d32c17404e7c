//! `BLADEOFF_SIMD`: the row of a run is the same for every vector width that the processor has, and an unavailable width is rejected.

use crate::support::{Folder, bladeoff, json, said};
use bladeoff_numerics::linalg::lanes::{WIDTH_VARIABLE, Width};

#[test]
fn a_row_is_the_same_at_every_width() {
    let folder = Folder::new();
    let engines =
        [("exponential", "hyp2"), ("exponential", "hyp1"), ("exponential", "hyp2-frozen"), ("reduced", "hyp2")];
    for (engine, detection) in engines {
        let mut rows = Vec::new();
        for width in Width::ALL.into_iter().filter(|&width| width <= Width::widest()) {
            let mut command = bladeoff(&["simulate", &folder.name("machines/rig.toml"), "--json"]);
            let settings = ["blade_off.mass=13 g", "contact.gap=0.4 mm"];
            let chosen = [format!("run.engine={engine}"), format!("contact.detection={detection}")];
            for setting in settings.into_iter().chain(chosen.iter().map(String::as_str)) {
                command.args(["--set", setting]);
            }
            let row = said(command.env(WIDTH_VARIABLE, width.to_string()).output().expect("the binary starts"));
            let impacts = json(&row.out)["impacts"].as_f64();
            assert!(impacts.is_some_and(|impacts| impacts > 0.0), "touches: {} {}", row.out, row.err);
            rows.push(row.out);
        }
        assert!(!rows.is_empty());
        assert!(rows.iter().all(|row| *row == rows[0]), "{engine} {detection}: {rows:?}");
    }
}

/// A radial spring with a prescribed speed.
#[test]
fn a_rub_on_a_spring_is_the_same_at_every_width() {
    let folder = Folder::new();
    let rig = std::fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let (head, tail) = rig.split_once("[diaphragms.seal]").expect("a diaphragm");
    let contact = tail.split_once("[diaphragms.seal.contact]").expect("a contact").1;
    let stator = "[diaphragms.seal]\nkind = \"radial-spring\"\nstiffness = 1e6\n[diaphragms.seal.contact]";
    let head = head.replace("[rotor.damping]", "[rotor.speed_law]\nacceleration = -50\n[rotor.damping]");
    let machine = folder.write("machines/sprung.toml", &format!("{head}{stator}{contact}"));
    let mut rows = Vec::new();
    for width in Width::ALL.into_iter().filter(|&width| width <= Width::widest()) {
        let mut command = bladeoff(&["simulate", &machine, "--json"]);
        for setting in ["blade_off.mass=25 g", "contact.gap=0.4 mm", "run.engine=exponential"] {
            command.args(["--set", setting]);
        }
        let row = said(command.env(WIDTH_VARIABLE, width.to_string()).output().expect("the binary starts"));
        let impacts = json(&row.out)["impacts"].as_f64();
        assert!(impacts.is_some_and(|impacts| impacts > 0.0), "touches: {} {}", row.out, row.err);
        rows.push(row.out);
    }
    assert!(!rows.is_empty());
    assert!(rows.iter().all(|row| *row == rows[0]), "{rows:?}");
}

/// Eigenvalues and eigenvectors of all kinds: undamped and damped, at several speeds.
#[test]
fn modes_are_the_same_at_every_width() {
    let folder = Folder::new();
    let mut told = Vec::new();
    for width in Width::ALL.into_iter().filter(|&width| width <= Width::widest()) {
        let mut command =
            bladeoff(&["modes", &folder.name("machines/rig.toml"), "--speed", "100", "--speed", "300", "--json"]);
        let modes = said(command.env(WIDTH_VARIABLE, width.to_string()).output().expect("the binary starts"));
        assert!(modes.code == 0 && modes.out.contains("damping_ratio"), "{} {}", modes.out, modes.err);
        told.push(modes.out);
    }
    assert!(!told.is_empty() && told.iter().all(|modes| *modes == told[0]), "{told:?}");
}

#[test]
fn a_width_that_cannot_be_taken_is_refused() {
    for command in [vec!["check", "no-such-file"], vec!["bench", "engines"]] {
        let row = said(bladeoff(&command).env(WIDTH_VARIABLE, "mmx").output().expect("the binary starts"));
        assert_eq!(row.code, 2, "{}", row.err);
        assert!(row.err.contains("\"mmx\"") && row.err.contains("\"sse2\", \"avx2\" and \"avx512\""), "{}", row.err);
    }
    // an empty value, as scripts set it, is the same as none
    let folder = Folder::new();
    let check = said(
        bladeoff(&["check", &folder.name("machines/rig.toml")])
            .env(WIDTH_VARIABLE, "")
            .output()
            .expect("the binary starts"),
    );
    assert_eq!(check.code, 0, "{}", check.err);
}
