//! Rotors saved by ROSS, as whole files: conversion, notes, mistakes, damaged files.

use bladeoff_import::{Imported, from_ross};
use bladeoff_model::machine::{MachineDef, RotorKind};
use proptest::prelude::*;

/// Saved by ROSS 2.3.0 (`core/tests/data/ross_rotor.py`).
const ROTOR: &str = include_str!("../../../core/tests/data/ross_rotor.toml");
const ROTOR_JSON: &str = include_str!("../../../core/tests/data/ross_rotor.json");
/// Expected machine file: `core/tests/rotor/tapers.rs` compares the modes of this file with those of ROSS.
const MACHINE: &str = include_str!("../../../core/tests/data/ross_rotor.machine.toml");

fn import(text: &str) -> Imported {
    from_ross("ross_rotor.toml", text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// The file with one piece replaced.
fn changed(from: &str, to: &str) -> String {
    assert!(ROTOR.contains(from), "{from}");
    ROTOR.replacen(from, to, 1)
}

/// Notes of a valid file.
fn notes(text: &str) -> Vec<String> {
    import(text).notes.iter().map(ToString::to_string).collect()
}

#[test]
fn a_rotor_becomes_the_machine_whose_modes_are_compared() {
    let imported = import(ROTOR);
    assert!(imported.machine == MACHINE, "the machine file has changed:\n{}", imported.machine);
    MachineDef::parse("machine", MACHINE).unwrap_or_else(|problems| panic!("{problems}"));
}

#[test]
fn toml_and_json_become_the_same_machine() {
    let body = |text: &str| text[text.find("\nschema").expect("a machine")..].to_owned();
    let (toml, json) = (import(ROTOR), import(ROTOR_JSON));
    assert_eq!(body(&toml.machine), body(&json.machine));
    assert_eq!(toml.notes, json.notes);
}

#[test]
fn the_places_to_fill_in_are_valid_as_soon_as_they_are_not_comments() {
    let filled: String = MACHINE
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some(rest) if rest.starts_with('[') || rest.contains(" = ") && !rest.starts_with("FILL") => {
                format!("{rest}\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let filled =
        filled.replace("position = \"1 m\"", "position = \"0.4 m\"").replace("mass = \"1 kg\"", "mass = \"5 g\"");
    let machine = MachineDef::parse("filled", &filled).unwrap_or_else(|problems| panic!("{problems}\n{filled}"));
    let machine = machine.build().expect("valid");
    assert_eq!((machine.rotor.unbalances.len(), machine.diaphragms.len(), machine.rotor.gravity[1]), (1, 1, -9.81));
    assert!(machine.braking.linear > 0.0);
}

#[test]
fn what_cannot_be_converted_is_named_with_its_reason() {
    let cases = [
        ("axial_force = 0", "axial_force = 1000", "ShaftElement_Shaft Element 0: an axial force"),
        ("torque = 0", "torque = 5.0", "ShaftElement_Shaft Element 0: a constant torque"),
        ("rotary_inertia = true", "rotary_inertia = false", "rotary inertia cannot be switched off"),
        ("gyroscopic = true", "gyroscopic = false", "gyroscopic moment cannot be switched off"),
        ("mxx = [ 0,]", "mxx = [ 5,]", "BearingElement_Bearing 0: added mass"),
        ("czz = [ 0,]", "czz = [ 5,]", "BearingElement_Bearing 0: axial damping"),
        ("alpha = 0.0", "alpha = 1.0", "alpha and beta differ between elements"),
        (
            "[\"SealElement_Seal 3\"]\n",
            "[\"SealElement_Seal 3\"]\nn_link = 5\n",
            "a bearing between nodes 3 and 5 of the shaft is left out",
        ),
        ("kxx = [ 500000000.0,]", "kxx = [ 0.0,]", "support node 7 is not held"),
        ("mx = 40.0", "mx = 40.0\nextra = 1", "no bearing has an axial stiffness"),
        ("n = 7\nscale_factor = 1\n", "n = 7\nn_link = 8\nscale_factor = 1\n", "a support on another support"),
        ("rated_w = 600.0", "rated_w = 1200.0", "a bearing table ends at 1200.0 rad/s, below 1.05 times rated_w"),
        (
            "[\"PointMass_Point Mass 0\"]\nn = 7",
            "[\"PointMass_Point Mass 0\"]\nn = 6",
            "different masses along X and Y",
        ),
        ("[\"DiskElement_Disk A\"]\nn = 2", "[\"DiskElement_Disk A\"]\nn = 7", "a disc on a support is left out"),
        ("[\"DiskElement_Disk A\"]", "[\"GearElement_Disk A\"]", "the mesh of a gear"),
        ("[\"DiskElement_Disk A\"]\nn = 2\nm = 25.0\nId", "[\"Other_Disk A\"]\nn = 2\nm = 25.0\nJ", "an unknown class"),
        (
            "[\"DiskElement_Disk A\"]\nn = 2\nm = 25.0\nId",
            "[\"DiskElement_Disk A\"]\nn = 2\nm = 25.0\nJ",
            "DiskElement_Disk A: an element without Ip and Id is left out",
        ),
        (
            "[\"SealElement_Seal 3\"]\n",
            "[\"SealElement_Seal 4\"]\nn = 3\n[\"SealElement_Seal 3\"]\n",
            "SealElement_Seal 4: an element without kxx is left out",
        ),
        (
            "[parameters]",
            "[[\"DiskElement_Disk 9\"]]\nn = 3\n[parameters]",
            "DiskElement_Disk 9: an array in the place",
        ),
        ("[parameters]", "\"DiskElement_Disk 9\" = 3\n[parameters]", "DiskElement_Disk 9: a whole number in the place"),
        ("kxx = [ 50000000.0,]", "kxx = []", "BearingElement_Bearing 0: kxx has no value: 0 is taken"),
        ("kyy = [ 100000.0,]", "kyy = []", "SealElement_Seal 3: kyy has no value: the xx coefficient is taken"),
    ];
    for (from, to, expected) in cases {
        let found = notes(&changed(from, to));
        assert!(found.iter().any(|note| note.contains(expected)), "{expected}: {found:#?}");
        // every note is in the file as well
        let machine = import(&changed(from, to)).machine;
        assert!(found.iter().all(|note| machine.contains(&format!("# - {note}\n"))), "{expected}");
        MachineDef::parse("machine", &machine).unwrap_or_else(|problems| panic!("{expected}: {problems}"));
    }
}

#[test]
fn every_mistake_of_a_file_is_reported_at_its_place() {
    let cases = [
        ("L = 0.1", "L = -0.1", "ShaftElement_Shaft Element 0.L = -0.1: not a usable number; allowed: a number > 0"),
        ("L = 0.1", "L = nan", "ShaftElement_Shaft Element 0.L"),
        ("L = 0.1", "L = \"long\"", "a number is expected, not a string"),
        ("L = 0.1\n", "", "ShaftElement_Shaft Element 0.L: missing"),
        ("odl = 0.08", "odl = 0.0", "ShaftElement_Shaft Element 0.odl"),
        ("idl = 0.0\n", "idl = 0.09\n", "inner diameter 0.09 m, outer diameter 0.08 m"),
        ("n = 0\n", "n = 0.5\n", "not a node"),
        ("n = 0\n", "n = 99\n", "no shaft element begins at node 0"),
        ("G_s = 81200000000.0", "G_s = 70e9", "Poisson's ratio E/(2 G_s) - 1 is 0.5071"),
        ("shear_method_calc = \"cowper\"", "shear_method_calc = \"other\"", "cowper, hutchinson"),
        ("shear_effects = true", "shear_effects = 1", "true or false is expected"),
        (
            "[\"ShaftElement_Shaft Element 7\"]\nL = 0.2",
            "[\"ShaftElement_Shaft Element 7\"]\nL = 0.3",
            "length 0.3 m on an element of 0.2 m",
        ),
        ("frequency = [ 0.0, 200.0,", "frequency = [ 300.0, 200.0,", "speeds that do not ascend"),
        ("frequency = [ 0.0, 200.0, 500.0, 1200.0,]", "frequency = [ 0.0, 200.0,]", "4 coefficients and 2 speeds"),
        ("kxx = [ 50000000.0,]", "kxx = [ [1.0, 2.0],]", "coefficients over speed and frequency"),
        ("kxx = [ 50000000.0,]", "kxx = [ inf,]", "BearingElement_Bearing 0.kxx"),
        ("n = 2\nm = 25.0", "n = 70\nm = 25.0", "node 70 does not exist; allowed: a node of the shaft, 0 to 6"),
        ("[\"DiskElement_Disk A\"]", "[\"CouplingElement_A\"]", "a coupling between two shafts is not available"),
        ("rated_w = 600.0", "rated_w = -1.0", "parameters.rated_w"),
    ];
    for (from, to, expected) in cases {
        let found = from_ross("rotor.toml", &changed(from, to)).expect_err(expected).to_string();
        assert!(found.contains(expected) && found.starts_with("rotor.toml:"), "{expected}: {found}");
    }
    let all = changed("L = 0.1", "L = -1").replace("m = 25.0", "m = -25.0").replace("n_link = 7", "n_link = -7");
    assert_eq!(from_ross("rotor.toml", &all).expect_err("three mistakes").list.len(), 3);
    for nothing in ["", "{}", "a = 1", "[parameters]\nrated_w = 1\n"] {
        let found = from_ross("rotor.toml", nothing).expect_err("no rotor").to_string();
        assert!(found.contains("no shaft elements"), "{found}");
    }
}

#[test]
fn bearings_tables_and_shared_supports_are_as_the_file_says() {
    let machine = |text: &str| MachineDef::parse("m", &import(text).machine).expect("valid").build().expect("valid");
    // constant coefficients do not make a table
    let constant = changed("kxx = [ 40000000.0, 50000000.0, 60000000.0, 70000000.0,]", "kxx = 4e7")
        .replace("kxy = [ 1000000.0, 2000000.0, 3000000.0, 4000000.0,]", "")
        .replace("kyx = [ -1000000.0, -2000000.0, -3000000.0, -4000000.0,]", "kyx = [0]")
        .replace("kyy = [ 50000000.0, 60000000.0, 65000000.0, 70000000.0,]", "")
        .replace("cxx = [ 30000.0, 20000.0, 15000.0, 10000.0,]", "cxx = [100,]")
        .replace("cyy = [ 30000.0, 20000.0, 15000.0, 10000.0,]", "");
    let found = machine(&constant);
    let bearing = found.rotor.bearings.iter().find(|bearing| bearing.pedestal.is_some()).expect("a pedestal");
    assert_eq!((bearing.stiffness, bearing.damping), ([[4e7, 0.0], [0.0, 4e7]], [[100.0, 0.0], [0.0, 100.0]]));
    assert!(bearing.table.is_none());
    // two bearings on one support have half of it each
    let shared = changed("[\"SealElement_Seal 3\"]\n", "[\"SealElement_Seal 3\"]\nn_link = 7\n");
    let found = machine(&shared);
    let masses: Vec<[f64; 2]> =
        found.rotor.bearings.iter().filter_map(|bearing| Some(bearing.pedestal?.mass)).collect();
    assert_eq!(masses, [[20.0, 25.0]; 2]);
    assert!(notes(&shared).iter().any(|note| note.contains("2 bearings share support node 7")));
    // with a table that does not begin at rest, the run ends at the first speed of the table
    let late = changed("frequency = [ 0.0, 200.0,", "frequency = [ 50.0, 200.0,");
    assert_eq!(machine(&late).run.end_speed, 50.0);
    // Rayleigh damping of all elements, shear coefficients
    let damped = ROTOR.replace("beta = 0.0", "beta = 1e-5").replace("\"cowper\"", "\"hutchinson\"");
    let found = machine(&damped);
    assert_eq!(found.rotor.damping.stiffness_proportional, 1e-5);
    let RotorKind::Shaft(shaft) = &found.rotor.kind else { unreachable!("a shaft") };
    // solid: 6 (1+nu)/(7 + 12 nu + 4 nu^2), nu = E/(2 G) - 1
    let nu = 211.0 / 162.4 - 1.0;
    let expected = 6.0 * (1.0 + nu) / (7.0 + 12.0 * nu + 4.0 * nu * nu);
    assert!((shaft.elements[0].shear_coefficient.expect("shear") - expected).abs() < 1e-14);
}

/// A rotor with many seals has one note for all of them.
#[test]
fn the_same_note_of_many_elements_is_one() {
    let text = ROTOR.replace("rotary_inertia = true", "rotary_inertia = false");
    let found = notes(&text);
    let expected = "ShaftElement_Shaft Element 0, ShaftElement_Shaft Element 1, ShaftElement_Shaft Element 8 and 6 more: rotary inertia";
    assert!(found.len() == 3 && found.iter().any(|note| note.starts_with(expected)), "{found:#?}");
}

/// An unreadable bearing or a coupling is one mistake: its consequences are not reported as well.
#[test]
fn one_mistake_is_one_problem() {
    let single = |text: &str| from_ross("rotor.toml", text).expect_err("a mistake").list.len();
    let one_bearing = &ROTOR[..ROTOR.find("[\"SealElement_Seal 3\"]").expect("a seal")];
    let shaft = |text: &str| {
        format!("{text}\n{}", &ROTOR[ROTOR.find("[\"ShaftElement_Shaft Element 0\".material]").expect("materials")..])
    };
    assert_eq!(single(&shaft(&one_bearing.replace("kxx = [ 50000000.0,]", "kxx = [ \"stiff\",]"))), 1);
    let coupling = changed("[\"ShaftElement_Shaft Element 3\"]", "[\"CouplingElement_A\"]")
        .replace("[\"ShaftElement_Shaft Element 3\".material]", "[\"CouplingElement_A\".material]");
    assert_eq!(single(&coupling), 1);
}

/// Fluid-film bearings of ROSS have other names for their speeds.
#[test]
fn speeds_have_one_of_three_names() {
    for name in ["speed", "omega"] {
        let text = changed("frequency = [", &format!("{name} = ["));
        assert_eq!(import(&text).machine.replace(' ', "").matches("speeds=[0.0,200.0").count(), 1, "{name}");
    }
}

/// Names and tags of a file become comments of one line: no part is read as TOML.
#[test]
fn names_and_tags_cannot_leave_their_comments() {
    let odd = "Bearing\\n[rotor]\\ninitial_speed = 1e9 # \\u001b[31m\\u202e";
    let text = ROTOR
        .replace("BearingElement_Bearing 0", &format!("BearingElement_{odd}"))
        .replace("name = \"steel\"", &format!("name = \"{odd}\""));
    let imported = from_ross("evil\n[run]\nend_time = 1\n.toml", &text).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(imported.machine.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{202e}'));
    let machine = MachineDef::parse("m", &imported.machine).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(machine.build().expect("valid").rotor.initial_speed, 600.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    /// Files with lines removed, doubled or exchanged, as TOML and as JSON, give a readable machine file or problems with valid positions.
    #[test]
    fn any_change_of_a_file_is_converted_or_refused(
        json in any::<bool>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..4, prop::sample::select(PIECES.to_vec())), 1..6),
    ) {
        let mut lines: Vec<String> = (if json { ROTOR_JSON } else { ROTOR }).lines().map(str::to_owned).collect();
        for (at, what, piece) in edits {
            let at = at.index(lines.len());
            match what {
                0 => drop(lines.remove(at)),
                1 => lines.insert(at, lines[at].clone()),
                2 => lines[at] = match lines[at].split_once(['=', ':']) {
                    Some((name, _)) if !json => format!("{name}= {piece}"),
                    Some((name, _)) => format!("{name}: {piece},"),
                    None => piece.to_owned(),
                },
                _ => lines.insert(at, piece.to_owned()),
            }
        }
        let text = lines.join("\n");
        match from_ross("rotor", &text) {
            Ok(imported) => {
                let rejected = imported.notes.iter().any(|note| note.element == "machine file");
                prop_assert!(MachineDef::parse("machine", &imported.machine).is_ok() != rejected, "{}", imported.machine);
            }
            Err(problems) => prop_assert!(problems.list.iter().all(|problem| problem.span.end <= text.len())),
        }
    }
}

const PIECES: [&str; 18] = [
    "0",
    "-1",
    "1e308",
    "1e-308",
    "nan",
    "[]",
    "[1, 2]",
    "[[1]]",
    "\"x\"",
    "true",
    "{}",
    "{\"a\": 1}",
    "7",
    "100000",
    "99999999999999999999",
    "[\"ShaftElement_\"]",
    "\u{0}",
    "1e6",
];
