//! A mass of a disc whose force acts at another node: it rotates with the disc, and a lost mass is taken from the inertia of the disc.
#![expect(clippy::print_stdout, reason = "the measured numbers are part of the result")]

use crate::common::{Every, Row, close, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use bladeoff_model::machine::{MachineDef, ParamValue};
use bladeoff_model::outcome::Status;
use bladeoff_text::document::Problem;

/// The lab rig whose blade has these lines in place of its position.
fn rig(lines: &str) -> String {
    let own = "position = \"0.6 m\"\nmass = \"10 g\"";
    let text = study_machine("lab_rig");
    assert!(text.contains(own));
    text.replace(own, &format!("{lines}\nmass = \"10 g\""))
}

fn problems(text: &str) -> Vec<Problem> {
    let problems = MachineDef::parse("test.toml", text).map(|_| ()).expect_err("refused");
    println!("{problems}");
    problems.list
}

/// 20 g at 220 mm of a slow rotor beside its disc: 75 % of the disc's inertia, but many times the shaft's own inertia at that node.
const HEAVY: [(&str, &str); 6] = [
    ("blade_off.kind", "lost"),
    ("blade_off.mass", "20 g"),
    ("blade_off.radius", "220 mm"),
    ("rotor.initial_speed", "300 rpm"),
    ("contact.rotor_radius", "40 mm"),
    ("contact.gap", "10 mm"),
];

fn heavy(lines: &str, more: &[(&str, &str)]) -> Row {
    let (mut taken, mut steps, mut least) = (0.0, 0, f64::INFINITY);
    let row = run_seen(
        machine_with(&rig(lines), &[&HEAVY[..], more].concat()),
        &mut Every(|frame| {
            least = least.min(frame.energies.braking - taken);
            taken = frame.energies.braking;
            steps += 1;
        }),
    );
    assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome);
    assert!(steps > 1000 && taken > 0.0 && least >= 0.0, "the brake takes energy in every step: {least}");
    row
}

#[test]
fn a_heavy_lost_mass_of_a_neighbouring_disc_keeps_energy_and_is_braked_in_both_engines() {
    let lines = "position = \"0.5 m\"\ndisc = \"left\"";
    let end = ("run.end_time", "60 ms");
    let rows = ["reduced", "full"].map(|engine| heavy(lines, &[end, ("run.engine", engine)]));
    for (row, engine) in rows.iter().zip(["reduced", "full"]) {
        let (error, speed) = (row.value("energy_error"), row.value("end_speed_rad_s"));
        println!(
            "lost of a disc, {engine}: step {:e}, energy error {error:.1e}, {speed:.6} rad/s",
            row.value("step_s")
        );
        assert!(error < 1e-9, "{error}");
        assert!(speed < row.machine.rotor.initial_speed);
    }
    let [reduced, full] = &rows;
    for (name, limit) in [("end_speed_rad_s", 1e-4), ("max_bearing_load_N", 0.01), ("max_torsional_moment_Nm", 0.01)] {
        let error = close(name, reduced.value(name), full.value(name), limit);
        println!("lost of a disc, {name}: reduced {:.6e}, full {error:.1e} apart", reduced.value(name));
    }
    // the disc matters: if no inertia is lost, the brake slows the rotor less
    let own = heavy("position = \"0.5 m\"\ndisc = \"left\"", &[end, ("blade_off.mass", "0 kg")]);
    let lost = |row: &Row| row.machine.rotor.initial_speed - row.value("end_speed_rad_s");
    println!("speed lost {:.4} rad/s, of the whole rotor {:.4} rad/s", lost(reduced), lost(&own));
    assert!(lost(reduced) > 1.2 * lost(&own));
}

#[test]
fn a_disc_at_the_mass_s_own_node_changes_no_bit() {
    for engine in ["reduced", "full"] {
        for kind in ["added", "lost"] {
            let changes = [("run.end_time", "0.16"), ("run.engine", engine), ("blade_off.kind", kind)];
            let changes = if engine == "full" { [("run.end_time", "2 ms"), changes[1], changes[2]] } else { changes };
            let [without, with, alone] =
                ["position = \"0.6 m\"", "position = \"0.6 m\"\ndisc = \"right\"", "disc = \"right\""]
                    .map(|lines| run(machine_with(&rig(lines), &changes)));
            assert!(engine == "full" || without.value("contact_impulse_Ns") > 0.0, "contact happened");
            assert_eq!(without.outcome, with.outcome);
            assert_eq!(without.outcome, alone.outcome);
        }
    }
}

/// The steady state before the release has the mass rotating with its disc, and a prescribed speed keeps that state.
#[test]
fn a_mass_of_another_disc_turns_steadily() {
    for engine in ["reduced", "full"] {
        let lines = "position = \"0.5 m\"\ndisc = \"left\"\nphase = \"70 deg\"\npresent = \"before\"";
        let text = rig(lines).replace("phase = \"0 deg\"\n", "") + "\n[rotor.speed_law]\nacceleration = 0.0\n";
        let changes = [("run.end_time", "20 ms"), ("run.engine", engine), ("contact.gap", "2 mm")];
        let mut loads: Vec<f64> = Vec::new();
        let row = run_seen(
            machine_with(&text, &changes),
            &mut Every(|frame| loads.push(frame.bearing_loads[0][0].hypot(frame.bearing_loads[0][1]))),
        );
        let (low, high) = loads.iter().fold((f64::MAX, 0.0_f64), |(l, h), load| (l.min(*load), h.max(*load)));
        println!("{engine}: load {low:.6} to {high:.6} N, energy {:.1e}", row.value("energy_error"));
        assert!(low > 1.0 && (high / low - 1.0) < 1e-6, "{low} {high}");
    }
}

#[test]
fn what_a_disc_carries_is_read_and_mistakes_are_named() {
    let beside = machine(&rig("position = \"0.5 m\"\ndisc = \"left\""));
    let site = &beside.rotor.unbalances[0];
    assert_eq!((site.node, site.torsional_node), (4, 3));
    let alone = machine(&rig("disc = \"left\""));
    assert_eq!((alone.rotor.unbalances[0].node, alone.rotor.unbalances[0].torsional_node), (3, 3));
    for (lines, key, words) in [
        ("disc = \"lefft\"", "disc", ["no disc has this name", "left, right", "left"]),
        ("disc = 3", "disc", ["text in quotes is expected, not", "1 to 200 characters", ""]),
        ("disc = \"\"", "disc", ["not a usable name", "1 to 200 characters", ""]),
        ("disc = \"left\"\nposition = \"2 m\"", "position", ["outside the shaft", "0 to 1 m", ""]),
        ("kind = \"lost\"", "position", ["missing: position along the shaft", "0 to 1e6 m", ""]),
        ("discs = \"left\"\nposition = 0.5", "discs", ["unknown key", "disc, position, mass", "disc"]),
    ] {
        let [problem] = &problems(&rig(lines))[..] else { panic!("{lines}: one problem") };
        assert_eq!(problem.key, format!("rotor.unbalances.blade_off.{key}"));
        assert!(problem.line > 0 && problem.message.contains(words[0]), "{}", problem.message);
        assert!(problem.allowed.as_deref().is_some_and(|allowed| allowed.contains(words[1])), "{:?}", problem.allowed);
        assert_eq!(problem.nearest.as_deref().unwrap_or_default(), words[2]);
    }
    // a shaft without discs, and a rotor that is not a shaft
    let none = rig("position = 0.5\ndisc = \"left\"").replace("[rotor.discs.left]", "[rotor.discs.first]");
    assert!(problems(&none)[0].allowed.as_deref() == Some("first, right"));
    let point = "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 0.01\n\
        initial_speed = 10\n[rotor.bearings.s]\nstiffness = 1e4\n[rotor.unbalances.u]\nmass = 0.1\nradius = 0.1\ndisc = \"left\"\n";
    let [problem] = &problems(point)[..] else { panic!("one problem") };
    assert_eq!(problem.key, "rotor.unbalances.u.disc");
    assert!(problem.message.contains("does not belong to kind = \"point-mass\""), "{}", problem.message);
    // a lost mass of the disc with more inertia than disc and shaft have together
    let [problem] = &problems(
        &rig("position = 0.5\ndisc = \"left\"\nkind = \"lost\"\n").replace("radius = \"40 mm\"", "radius = \"400 mm\""),
    )[..] else {
        panic!("one problem")
    };
    assert_eq!(problem.key, "rotor.unbalances.blade_off.radius");
    assert!(problem.message.contains("kg m2 of its disc, together"), "{}", problem.message);
    assert!(problem.allowed.as_deref().is_some_and(|a| a.contains("disc left has polar_inertia 0.00125 kg m2")));
}

/// The identity of a machine without the key `disc` is that from before the key existed.
#[test]
fn a_disc_counts_in_the_identity_where_it_is_named() {
    let def = |text: &str| MachineDef::parse("test.toml", text).unwrap_or_else(|problems| panic!("{problems}"));
    let lab = study_machine("lab_rig");
    let plain = def(&lab);
    assert!(plain.texts().next().is_none() && !plain.to_toml().contains("disc ="));
    assert!(plain.paths().iter().all(|info| !info.path.ends_with(".disc")));
    let [left, right] = ["left", "right"].map(|disc| def(&rig(&format!("position = \"0.6 m\"\ndisc = \"{disc}\""))));
    let [of_plain, of_left, of_right] = [&plain, &left, &right].map(|def| def.identity(EXPONENTIAL_REVISION));
    assert!(of_plain != of_left && of_left != of_right);
    assert_eq!(left.texts().collect::<Vec<_>>(), [("rotor.unbalances.blade_off.disc", "left")]);
    let again = def(&left.to_toml());
    assert_eq!((again.build().expect("valid"), again.to_toml()), (left.build().expect("valid"), left.to_toml()));
    // the position is that of the disc, until one is set
    let mut moved = def(&rig("disc = \"left\""));
    let position = moved.resolve("blade_off.position").expect("a parameter");
    assert_eq!((position.value.clone(), position.shown.as_str()), (None, "(that of its disc; required without)"));
    moved.set(&position, &ParamValue::Number(0.5)).expect("in range");
    let site = moved.build().expect("valid").rotor.unbalances[0].clone();
    assert_eq!((site.node, site.torsional_node), (4, 3));
}
