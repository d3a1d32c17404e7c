//! Valid machine files: the shipped machines, parameters by path, records, the template.

use std::f64::consts::PI;
use std::fmt::Write;

use crate::common::{build, parse, set, shipped};
use bladeoff_model::machine::{
    ContactSurface, Detection, DiaphragmKind, Engine, MachineDef, ParamValue, PathError, PathKind, Presence, RotorKind,
    UnbalanceKind, machine_template,
};

/// Revision of the exponential engine's results; the value does not matter.
const REVISION: u8 = 16;

const POINT_MASS: &str = r#"
schema = 1
name = "jeffcott"
[run]
end_time = "2 s"
[rotor]
kind = "point-mass"
mass = "10 kg"
polar_inertia = "0.05 kg m2"
initial_speed = "600 rpm"
gravity = [0, "-9.81 m/s2"]
[rotor.bearings.springs]
stiffness = [["1e6 N/m", 2e5], [-2e5, "1 kN/mm"]]
damping = "100 N s/m"
[rotor.unbalances.one]
mass = "20 g"
radius = "10 mm"
phase = "90 deg"
kind = "lost"
present = "before"
[rotor.speed_law]
acceleration = "-400 rpm/s"
[rotor.initial]
displacement = ["1 mm", 0]
angle = "180 deg"
[diaphragms.casing]
kind = "radial-spring"
stiffness = "50 kN/mm"
[diaphragms.casing.contact]
rotor_radius = "100 mm"
gap = "1 mm"
friction = 0.1
detection = "hyp1"
surface = "mean-line"
"#;

#[test]
fn the_turbine_loads_with_the_values_of_its_file() {
    let machine = build(&shipped("lp_turbine_paper"));
    assert_eq!(
        (machine.name.as_str(), machine.run.end_time, machine.run.engine),
        ("lp_turbine_paper", 6.0, Engine::Exponential)
    );
    assert_eq!(
        (machine.run.guard.normal_work, machine.run.guard.energy_balance, machine.run.guard.penetration),
        (0.01, 1e-5, 0.02)
    );
    let reduced = build(&shipped("lp_turbine_paper").replacen("\n[run]", "\n[run]\nengine = \"reduced\" #", 1));
    assert_eq!((reduced.run.engine, reduced.run.guard.energy_balance), (Engine::Reduced, 1e-6));
    assert_eq!((machine.run.step, machine.run.rotor_modes, machine.run.end_speed), (None, None, 0.0));
    assert_eq!(machine.rotor.initial_speed, 50.0 * PI);
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { panic!() };
    assert_eq!((shaft.nodes.len(), shaft.elements.len()), (13, 12));
    for (node, z) in
        [0.0, 0.55, 1.1, 1.825, 2.55, 3.05, 3.55, 4.05, 4.55, 5.275, 6.0, 6.55, 7.1].into_iter().enumerate()
    {
        assert!((shaft.nodes[node] - z).abs() < 1e-12, "{node}");
    }
    assert_eq!(shaft.elements[4].section, 2);
    assert_eq!((shaft.elements[4].length, shaft.elements[4].diameter), (0.5, 0.64));
    assert_eq!((shaft.elements[0].young_modulus, shaft.elements[0].shear_coefficient), (210e9, Some(0.9)));
    let names: Vec<&str> = shaft.discs.iter().map(|disc| disc.name.as_str()).collect();
    assert_eq!(names, ["last_stage_front", "inner_front", "inner_rear", "last_stage_rear"]);
    assert_eq!((shaft.discs[3].node, shaft.discs[3].mass, shaft.discs[3].polar_inertia), (9, 1680.0, 910.0));
    let bearings: Vec<_> =
        machine.rotor.bearings.iter().map(|b| (b.name.as_str(), b.node, b.axial_stiffness)).collect();
    assert_eq!(bearings, [("front", 1, 1e8), ("rear", 11, 0.0)]);
    assert_eq!(machine.rotor.bearings[0].stiffness, [[6e8, 0.0], [0.0, 6e8]]);
    assert_eq!(machine.rotor.bearings[0].damping, [[6e5, 0.0], [0.0, 6e5]]);
    let unbalance = &machine.rotor.unbalances[0];
    assert_eq!((unbalance.node, unbalance.mass, unbalance.radius, unbalance.phase), (9, 12.0, 1.5, 0.0));
    assert_eq!((unbalance.kind, unbalance.presence), (UnbalanceKind::Added, Presence::AtRelease));
    assert_eq!((machine.braking.linear, machine.braking.quadratic), (30.0, 0.66));
    assert_eq!(machine.rotor.damping.stiffness_proportional, 2e-5);
    let diaphragm = &machine.diaphragms[0];
    let DiaphragmKind::Flexible(stator) = &diaphragm.kind else { panic!() };
    assert_eq!((stator.ring.mean_radius, stator.ring.thickness, stator.ring.elements), (0.353, 0.05, 48));
    let blades = stator.blades.unwrap();
    assert_eq!(
        (blades.count, blades.length, blades.thickness, blades.width, blades.elements),
        (12, 0.25, 0.02, 0.06, 2)
    );
    let contact = diaphragm.contact;
    assert_eq!((contact.node, contact.rotor_radius, contact.gap, contact.friction), (6, 0.32, 0.008, 0.2));
    assert_eq!((contact.detection, contact.surface), (Detection::Hyp2, ContactSurface::InnerFace));
}

#[test]
fn the_lab_rig_loads_with_the_values_of_its_file() {
    let machine = build(&shipped("lab_rig"));
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { panic!() };
    assert_eq!((shaft.nodes.len(), shaft.discs[0].transverse_inertia), (9, 6.5e-4));
    assert_eq!((machine.rotor.unbalances[0].mass, machine.rotor.unbalances[0].radius), (0.01, 0.04));
    assert_eq!(machine.braking.constant, 0.1);
    assert_eq!(machine.diaphragms[0].contact.gap, 0.0005);
}

#[test]
fn a_mass_point_with_every_special_key_loads() {
    let machine = build(POINT_MASS);
    let RotorKind::PointMass(point) = machine.rotor.kind else { panic!() };
    assert_eq!((point.mass, point.polar_inertia), (10.0, 0.05));
    assert_eq!(machine.rotor.bearings[0].stiffness, [[1e6, 2e5], [-2e5, 1e6]]);
    assert_eq!(machine.rotor.gravity, [0.0, -9.81]);
    let unbalance = &machine.rotor.unbalances[0];
    assert_eq!(
        (unbalance.kind, unbalance.presence, unbalance.phase),
        (UnbalanceKind::Lost, Presence::Before, PI / 2.0)
    );
    let law = machine.rotor.speed_law.unwrap();
    // 600 rpm at -400 rpm/s: at rest after 1.5 s, before end_time, and constant from there.
    assert_eq!((law.times[0], law.speeds[1]), (0.0, 0.0));
    assert!((law.times[1] - 1.5).abs() < 1e-12 && law.times.len() == 2);
    assert_eq!((machine.rotor.initial.displacement, machine.rotor.initial.angle), ([0.001, 0.0], PI));
    assert_eq!(machine.diaphragms[0].kind, DiaphragmKind::RadialSpring { stiffness: 5e7 });
    assert_eq!(machine.diaphragms[0].contact.surface, ContactSurface::MeanLine);
}

#[test]
fn sections_may_have_their_own_material_lengths_and_bore() {
    let text = shipped("lab_rig").replacen(
        "length = \"300 mm\"\ndiameter = \"25 mm\"\nelements = 2",
        "element_lengths = [\"100 mm\", 0.2]\ndiameter = \"25 mm\"\ninner_diameter = \"5 mm\"\nshear_coefficient = \"cowper\"\n\
         [rotor.shaft.material]\ndensity = \"8000 kg/m3\"",
        1,
    );
    let RotorKind::Shaft(shaft) = build(&text).rotor.kind else { panic!() };
    assert_eq!((shaft.nodes[1], shaft.elements[1].length, shaft.elements[0].density), (0.1, 0.2, 8000.0));
    assert_eq!((shaft.elements[0].young_modulus, shaft.elements[2].density), (210e9, 7850.0));
    // m = 0.2, nu = 0.3: 6*1.3*1.0816 / (8.8*1.0816 + 23.6*0.04)
    let k = shaft.elements[0].shear_coefficient.unwrap();
    assert!((k - 8.436_48 / 10.462_08).abs() < 1e-12, "{k}");
    assert_eq!(shaft.elements[2].shear_coefficient, Some(0.9));
    let stiff = shipped("lab_rig").replace("shear_coefficient = 0.9", "shear_coefficient = \"none\"");
    let RotorKind::Shaft(shaft) = build(&stiff).rotor.kind else { panic!() };
    assert_eq!(shaft.elements[0].shear_coefficient, None);
}

#[test]
fn no_diaphragm_a_rigid_one_and_a_free_ring_load() {
    let text = shipped("lab_rig");
    let free = &text[..text.find("[diaphragms").unwrap()];
    assert!(build(free).diaphragms.is_empty());
    let rigid = format!(
        "{free}[diaphragms.seal]\nkind = \"rigid\"\n{}",
        &text[text.find("[diaphragms.seal.contact]").unwrap()..]
    );
    assert_eq!(build(&rigid).diaphragms[0].kind, DiaphragmKind::Rigid);
    let start = text.find("[diaphragms.seal.blades]").unwrap();
    let end = text.find("[diaphragms.seal.damping]").unwrap();
    let ring = format!("{}{}", &text[..start], &text[end..]);
    let DiaphragmKind::Flexible(stator) = build(&ring).diaphragms.remove(0).kind else { panic!() };
    assert_eq!(stator.blades, None);
    assert_eq!(build(&text.replace("count = 8", "count = 0")).diaphragms[0].kind, DiaphragmKind::Flexible(stator));
}

#[test]
fn a_speed_law_of_points_loads() {
    let text = shipped("lab_rig").replace(
        "[braking]",
        "[rotor.speed_law]\ntimes = [0, \"0.2 s\"]\nspeeds = [\"3000 rpm\", \"100 rad/s\"]\n\n[braking]",
    );
    let law = build(&text).rotor.speed_law.unwrap();
    assert_eq!((law.times, law.speeds), (vec![0.0, 0.2], vec![100.0 * PI, 100.0]));
}

#[test]
fn setting_a_parameter_equals_editing_the_file() {
    let text = shipped("lp_turbine_paper");
    for (path, value, from, to) in [
        ("contact.gap", "7 mm", "gap = \"8 mm\"", "gap = \"7 mm\""),
        ("contact.detection", "hyp2-frozen", "detection = \"hyp2\"", "detection = \"hyp2-frozen\""),
        ("blade_off.mass", "13", "mass = \"12 kg\"", "mass = \"13 kg\""),
        ("rotor.shaft[2].diameter", "0.65 m", "diameter = \"0.64 m\"", "diameter = \"0.65 m\""),
        ("rotor.shaft.2.diameter", "0.65 m", "diameter = \"0.64 m\"", "diameter = \"0.65 m\""),
        ("ring.elements", "96", "elements = 48", "elements = 96"),
        ("run.step", "2 us", "end_time = \"6 s\"", "end_time = \"6 s\"\nstep = \"2 us\""),
        ("contact.offset[1]", "-1 mm", "offset = [\"0 mm\", \"0 mm\"]", "offset = [0, \"-1 mm\"]"),
        ("run.guard.penetration", "5 %", "[rotor]", "[run.guard]\npenetration = 0.05\n[rotor]"),
        ("rotor.material.shear_coefficient", "cowper", "shear_coefficient = 0.9", "shear_coefficient = \"cowper\""),
        ("rotor.gravity[1]", "-9.81", "gravity = [0.0, 0.0]", "gravity = [0.0, -9.81]"),
        ("braking.constant", "2 kN m", "constant = \"0 N m\"", "constant = \"2000 N m\""),
    ] {
        let mut def = parse(&text);
        set(&mut def, path, value);
        assert!(text.contains(from), "{from}");
        let edited = build(&text.replacen(from, to, 1));
        assert_ne!(edited, build(&text), "{path}");
        assert_eq!(def.build().unwrap(), edited, "{path}");
    }
}

#[test]
fn a_set_kind_leaves_the_other_kinds_keys_unused() {
    let mut def = parse(&shipped("lab_rig"));
    set(&mut def, "diaphragms.seal.kind", "rigid");
    assert_eq!(def.build().unwrap().diaphragms[0].kind, DiaphragmKind::Rigid);
    assert!(def.paths().iter().all(|path| !path.path.contains(".ring.")));
    set(&mut def, "diaphragms.seal.kind", "radial-spring");
    assert!(def.build().unwrap_err().to_string().contains("diaphragms.seal.stiffness: missing"));
    set(&mut def, "diaphragms.seal.stiffness", "1 kN/mm");
    assert_eq!(def.build().unwrap().diaphragms[0].kind, DiaphragmKind::RadialSpring { stiffness: 1e6 });
    assert_eq!(parse(&def.to_toml()).build().unwrap(), def.build().unwrap());
    // Without the kind, the set stiffness would have no effect, so it is rejected.
    set(&mut def, "diaphragms.seal.kind", "flexible");
    assert!(def.build().unwrap_err().to_string().contains("does not belong to kind = \"flexible\""));
}

#[test]
fn paths_resolve_in_full_and_by_unambiguous_ending() {
    let def = parse(&shipped("lp_turbine_paper"));
    let full = |ending: &str| def.resolve(ending).map(|info| info.path);
    assert_eq!(full("contact.gap").unwrap(), "diaphragms.mid.contact.gap");
    assert_eq!(full("gap").unwrap(), "diaphragms.mid.contact.gap");
    assert_eq!(full("blade_off.mass").unwrap(), "rotor.unbalances.blade_off.mass");
    assert_eq!(full("contact.detection").unwrap(), "diaphragms.mid.contact.detection");
    assert_eq!(full("shaft.0.diameter").unwrap(), "rotor.shaft[0].diameter");
    assert_eq!(full("shaft[0].diameter").unwrap(), "rotor.shaft[0].diameter");
    // `ap` is the end of a path, but not from a dot on.
    assert!(matches!(full("ap"), Err(PathError::Unknown { .. })));
    match full("mass") {
        Err(PathError::Ambiguous { candidates, .. }) => {
            assert_eq!(candidates.len(), 7, "discs, unbalance and the pedestals of both bearings");
            assert!(candidates.contains(&"rotor.unbalances.blade_off.mass".to_owned()));
        }
        other => panic!("{other:?}"),
    }
    for (given, meant) in [
        ("contact.gpa", "diaphragms.mid.contact.gap"),
        ("contact.offset", "diaphragms.mid.contact.offset[0]"),
        ("rotor.initial_sped", "rotor.initial_speed"),
        ("blade_of.mass", "rotor.unbalances.blade_off.mass"),
        ("run.time_step", "run.step"),
        ("contact.offset.y", "diaphragms.mid.contact.offset[1]"),
        ("stiffness.xx", "rotor.bearings.front.stiffness"),
        ("rotor.bearings.front.cyy", "rotor.bearings.front.damping"),
    ] {
        assert_eq!(full(given), Err(PathError::Unknown { given: given.into(), nearest: Some(meant.into()) }));
    }
    for odd in ["", ".", "..", "[0]", "[", "0", "schema", "µ", &"a.".repeat(100_000)] {
        assert!(matches!(full(odd), Err(PathError::Unknown { .. })), "{odd}");
    }
    for (text, path) in [("name", "name"), ("disc", "rotor.unbalances.blade_off.disc")] {
        assert!(matches!(full(text), Err(PathError::Text { path: found, .. }) if found == path), "{text}");
    }
}

#[test]
fn paths_list_every_parameter_with_value_unit_and_meaning() {
    let def = parse(&shipped("lab_rig"));
    let paths = def.paths();
    let get = |path: &str| paths.iter().find(|info| info.path == path).unwrap_or_else(|| panic!("{path}"));
    let gap = get("diaphragms.seal.contact.gap");
    assert_eq!(
        (gap.shown.as_str(), gap.unit, gap.default, gap.column().as_str()),
        ("0.5 mm", "m", false, "diaphragms.seal.contact.gap_m")
    );
    assert_eq!((gap.value.clone(), gap.allowed.as_str()), (Some(ParamValue::Number(0.0005)), "1e-9 to 1e6 m"));
    assert_eq!(get("rotor.initial_speed").column(), "rotor.initial_speed_rad_s");
    assert_eq!(get("rotor.initial_speed").shown, "3000 rpm");
    assert_eq!(get("rotor.bearings.left.damping").column(), "rotor.bearings.left.damping_Ns_m");
    assert_eq!(get("rotor.discs.left.polar_inertia").column(), "rotor.discs.left.polar_inertia_kgm2");
    assert_eq!(get("diaphragms.seal.contact.friction").column(), "diaphragms.seal.contact.friction");
    let detection = get("diaphragms.seal.contact.detection");
    assert_eq!(
        (detection.kind, detection.shown.as_str()),
        (PathKind::Choice(&["hyp1", "hyp2", "hyp2-frozen"]), "hyp2")
    );
    for absent in ["run.end_speed", "run.guard.penetration", "rotor.initial.velocity[1]", "diaphragms.seal.angle"] {
        assert!(get(absent).default, "{absent}");
    }
    let step = get("run.step");
    assert_eq!((step.value.clone(), step.shown.as_str()), (None, "(chosen from the highest frequency of the model)"));
    let of_point_mass =
        |path: &str| path == "rotor.mass" || (path.contains("point") && !path.ends_with("contact.points"));
    assert!(paths.iter().all(|info| !of_point_mass(&info.path)));
    assert!(paths.iter().all(|info| !info.meaning.is_empty() && !info.allowed.is_empty()));
    // Every listed path resolves to itself and takes its own value.
    let mut copy = def.clone();
    for info in &paths {
        assert_eq!(&def.resolve(&info.path).unwrap(), info);
        if let Some(value) = &info.value {
            copy.set(info, value).unwrap();
        }
    }
    assert_eq!(copy.build().unwrap(), def.build().unwrap());
}

#[test]
fn values_are_checked_when_they_are_set() {
    let mut def = parse(&shipped("lab_rig"));
    for (path, text, part) in [
        ("contact.gap", "0 mm", "out of range; allowed: 1e-9 to 1e6 m"),
        ("contact.gap", "-8 mm", "-8 mm"),
        ("contact.gap", "8 kg", "does not fit"),
        ("contact.gap", "nan", "not a finite number"),
        ("contact.detection", "hyp3", "did you mean `hyp1`?"),
        ("ring.elements", "2.5", "not a whole number"),
        ("ring.elements", "1e9", "4 to 600"),
        ("material.poisson_ratio", "0.5", "ambiguous"),
        ("rotor.material.poisson_ratio", "0.5", "> -1 and < 0.5"),
        ("run.engine", "fast", "\"reduced\", \"full\""),
    ] {
        let error = match def.resolve(path) {
            Ok(info) => def.parse_value(&info, text).expect_err(text).to_string(),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(part), "{path} = {text}: {error}");
    }
    let gap = def.resolve("gap").unwrap();
    let before = def.build().unwrap();
    for wrong in [ParamValue::Number(f64::NAN), ParamValue::Number(-1.0), ParamValue::Choice("big".into())] {
        assert!(def.check_value(&gap, &wrong).is_err() && def.set(&gap, &wrong).is_err());
    }
    assert_eq!(def.build().unwrap(), before);
    // Each value is in range, but together they are impossible: found by build, at the position in the file.
    let count = def.resolve("blades.count").unwrap();
    def.set(&count, &ParamValue::Number(7.0)).unwrap();
    let problems = def.build().unwrap_err();
    assert_eq!(problems.list.len(), 1);
    assert!(problems.list[0].message.contains("not a multiple of the number of blades"));
}

#[test]
fn the_written_record_builds_the_same_machine() {
    let mut varied = parse(&shipped("lp_turbine_paper"));
    set(&mut varied, "contact.gap", "7.123456789 mm");
    set(&mut varied, "run.step_limit", "4000000000");
    set(&mut varied, "initial_speed", "1499.9 rpm");
    let points = shipped("lab_rig").replace(
        "[braking]",
        "[rotor.speed_law]\ntimes = [0, \"0.2 s\"]\nspeeds = [\"3000 rpm\", \"100 rad/s\"]\n\n[braking]",
    );
    let sections = shipped("lab_rig")
        .replacen("length = \"300 mm\"", "element_lengths = [0.1, 0.2]", 1)
        .replacen("elements = 2", "[rotor.shaft.material]\ndensity = 7000", 1)
        .replacen("name = \"lab_rig\"", "name = 'quote \" and \\ \u{b5}'", 1);
    let layers = shipped("lab_rig")
        .replacen(
            "elements = 2",
            "elements = 2\nend_diameter = \"30 mm\"\nend_inner_diameter = \"10 mm\"\nmaterial = {density = 7000}",
            1,
        )
        .replacen(
            "[rotor.discs.left]",
            "[rotor.layers.hub]\nposition = 0.1\nlength = 0.15\ndiameter = 0.05\ninner_diameter = 0.03\nmaterial = {young_modulus = 1e6}\n\
             [rotor.discs.left]",
            1,
        );
    let RotorKind::Shaft(shaft) = build(&layers).rotor.kind else { panic!() };
    assert_eq!((shaft.layers[0].elements.len(), shaft.layers[0].elements[1].length), (2, 0.1));
    for def in [
        varied,
        parse(&layers),
        parse(&shipped("lab_rig")),
        parse(POINT_MASS),
        parse(&points),
        parse(&sections),
        parse(&machine_template()),
    ] {
        let record = def.to_toml();
        let again = MachineDef::parse("record", &record).unwrap_or_else(|problems| panic!("{problems}\n{record}"));
        assert_eq!(again.build().unwrap(), def.build().unwrap(), "{record}");
        assert_eq!(again.to_toml(), record);
    }
}

#[test]
fn a_long_but_right_file_is_read() {
    let mut text = String::from(POINT_MASS.split("[rotor.speed_law]").next().unwrap());
    let (mut times, mut speeds) = (String::new(), String::new());
    for i in 0..10_000 {
        write!(times, "{}e-4,", i).unwrap();
        write!(speeds, "\"600 rpm\",").unwrap();
    }
    write!(text, "[rotor.speed_law]\ntimes = [{times}]\nspeeds = [{speeds}]\n").unwrap();
    assert_eq!(build(&text).rotor.speed_law.unwrap().times.len(), 10_000);
}

#[test]
fn identity_ignores_how_a_file_is_written() {
    let text = shipped("lab_rig");
    let same = parse(&text).identity(REVISION);
    let rewritten = format!("# a remark\n{}", text.replace("gap = \"0.5 mm\"", "gap = 0.0005   # in SI"));
    assert_ne!(rewritten, format!("# a remark\n{text}"), "the gap was found");
    assert_eq!(parse(&rewritten).identity(REVISION), same);
    assert_eq!(parse(&text.replacen("name = \"lab_rig\"", "name = \"other\"", 1)).identity(REVISION), same);
    assert_ne!(parse(&text.replace("gap = \"0.5 mm\"", "gap = \"0.6 mm\"")).identity(REVISION), same);
    let other_bearing = text.replacen("[rotor.bearings.", "[rotor.bearings.x", 1);
    assert_ne!(parse(&other_bearing).identity(REVISION), same, "names of bearings are columns");
}

/// Result directories store the identity: if it changes, every study is computed again. It may change with a key of the format.
#[test]
fn an_identity_stays_what_it_was() {
    // the reduced engine was the default, and a study that uses it has to name it
    let reduced = |text: &str| {
        let mut def = parse(text);
        let engine = def.resolve("run.engine").unwrap();
        let word = def.parse_value(&engine, "reduced").unwrap();
        def.set(&engine, &word).unwrap();
        def.identity(REVISION)
    };
    assert_eq!(reduced(POINT_MASS), 0xf28f37c5_47d0bca6_f86fe193_b2c48f28);
    assert_eq!(reduced(&shipped("lab_rig")), 0xc7de1a94_ed800709_1a63ea90_23b4fb57);
}

/// The default of a guard depends on the engine, so a written value never counts as the default.
#[test]
fn a_guard_counts_by_what_it_is_with_its_engine() {
    for engine in ["reduced", "exponential"] {
        let mut def = parse(&shipped("lab_rig"));
        let mut set = |path: &str, text: &str| {
            let path = def.resolve(path).unwrap();
            let value = def.parse_value(&path, text).unwrap();
            let exchanged = def.identity(REVISION).wrapping_add(def.identity_change(&path, &value, REVISION).unwrap());
            def.set(&path, &value).unwrap();
            assert_eq!(exchanged, def.identity(REVISION), "{engine}, {text}");
            def.identity(REVISION)
        };
        let default = set("run.engine", engine);
        for value in ["1e-6", "1e-5"] {
            assert_ne!(set("run.guard.energy_balance", value), default, "{engine}, {value}");
        }
    }
}

#[test]
fn exchanging_a_value_is_setting_it() {
    let def = parse(&shipped("lab_rig"));
    for (path, text) in
        [("contact.gap", "0.7 mm"), ("contact.detection", "hyp1"), ("contact.gap", "0.5 mm"), ("run.end_time", "0.1 s")]
    {
        let path = def.resolve(path).unwrap();
        let value = def.parse_value(&path, text).unwrap();
        let mut changed = def.clone();
        changed.set(&path, &value).unwrap();
        let exchanged = def.identity(REVISION).wrapping_add(def.identity_change(&path, &value, REVISION).unwrap());
        assert_eq!(exchanged, changed.identity(REVISION), "{text}");
        assert_eq!(changed.identity(REVISION) == def.identity(REVISION), text == "0.5 mm", "{text}");
    }
    let gap = def.resolve("contact.gap").unwrap();
    assert!(def.identity_change(&gap, &ParamValue::Number(-1.0), REVISION).is_err());
}

#[test]
fn a_step_limit_is_no_part_of_the_identity() {
    let def = parse(&shipped("lab_rig"));
    assert_eq!(def.step_limit(), None);
    let path = def.resolve("run.step_limit").unwrap();
    let value = def.parse_value(&path, "100").unwrap();
    let mut limited = def.clone();
    limited.set(&path, &value).unwrap();
    assert_eq!((limited.step_limit(), limited.identity(REVISION)), (Some(100), def.identity(REVISION)));
    assert_eq!(def.identity_change(&path, &value, REVISION).unwrap(), 0);
}
