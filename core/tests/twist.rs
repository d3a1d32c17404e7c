//! Masses that are lost, against what is there; and that nothing but the brake takes the spin.
#![expect(clippy::print_stdout, reason = "the measured numbers are part of the result")]

mod common;

use bladeoff_core::engine::{NoHistory, Plan, simulate};
use bladeoff_core::outcome::Status;
use bladeoff_core::structure::Structure;
use bladeoff_model::document::Problem;
use bladeoff_model::machine::MachineDef;
use common::{Every, machine, machine_with, run, run_seen, study_machine};

/// The one problem of a machine text with values replaced by path.
fn refused(text: &str, changes: &[(&str, &str)]) -> Problem {
    let built = MachineDef::parse("test.toml", text).and_then(|mut def| {
        for (path, value) in changes {
            let info = def.resolve(path).unwrap_or_else(|error| panic!("{error}"));
            let value = def.parse_value(&info, value).unwrap_or_else(|error| panic!("{error}"));
            def.set(&info, &value).unwrap_or_else(|error| panic!("{error}"));
        }
        def.build()
    });
    let problems = built.expect_err("refused");
    println!("{problems}");
    assert_eq!(problems.list.len(), 1, "{problems}");
    problems.list[0].clone()
}

const LOST: (&str, &str) = ("blade_off.kind", "lost");

/// With m r^2 above the polar inertia at its node a lost mass left a twist mass matrix that was not positive definite: 10 g at 0.4 m
/// panicked in the brake, at 0.7 m the brake drove the rotor, at 45 mm without a disc the accelerations at t = 0 were NaN.
#[test]
fn what_is_lost_was_there() {
    let rig = study_machine("lab_rig");
    for radius in ["0.4 m", "0.7 m"] {
        let problem = refused(&rig, &[LOST, ("blade_off.radius", radius)]);
        assert_eq!(problem.key, "rotor.unbalances.blade_off.radius");
        assert!(problem.line > 0 && problem.message.contains("blade_off is lost where less is"));
        let allowed = problem.allowed.expect("what is allowed");
        assert!(allowed.contains("disc right there has polar_inertia 0.00125 kg m2"), "{allowed}");
    }
    let problem = refused(&rig, &[LOST, ("blade_off.radius", "45 mm"), ("blade_off.position", "0.5 m")]);
    assert_eq!(problem.key, "rotor.unbalances.blade_off.radius");
    let allowed = problem.allowed.expect("what is allowed");
    assert!(allowed.contains("no disc stands there, the nearest is left at 400 mm"), "{allowed}");
    // more mass than the node has, which was refused without naming the unbalance
    let problem = refused(&rig, &[LOST, ("blade_off.mass", "5 kg"), ("blade_off.radius", "0 m")]);
    assert_eq!(problem.key, "rotor.unbalances.blade_off.mass");
    // each alone is there, both are not; an added mass brings its own
    let second = |kind: &str| {
        rig.replace("[rotor.damping]", &format!(
            "[rotor.unbalances.other]\nposition = \"0.6 m\"\nmass = \"10 g\"\nradius = \"0.3 m\"\nkind = \"{kind}\"\n[rotor.damping]"
        ))
    };
    machine_with(&rig, &[LOST, ("blade_off.radius", "0.3 m")]);
    let both = [LOST, ("blade_off.radius", "0.3 m")];
    assert_eq!(refused(&second("lost"), &both).key, "rotor.unbalances.other.radius");
    machine_with(&second("added"), &both);
    // half of mass and half of inertia are each there, but their body would have none of its own
    let point = "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 0.011\n\
        initial_speed = 10\n[rotor.bearings.s]\nstiffness = 1e4\n[rotor.unbalances.u]\nkind = \"lost\"\nmass = 0.5\nradius = 0.1\n";
    assert_eq!(refused(point, &[("rotor.polar_inertia", "0.0099")]).key, "rotor.unbalances.u.radius");
}

/// Up to the bound, in both engines at their default steps: the run is sound, and the brake takes energy in every step.
#[test]
fn a_brake_never_drives_a_rotor_that_lost_a_mass() {
    let rig = study_machine("lab_rig");
    for (radius, position, speed) in
        [("40 mm", "0.6 m", "3000 rpm"), ("350 mm", "0.6 m", "300 rpm"), ("39 mm", "0.5 m", "3000 rpm")]
    {
        for engine in ["reduced", "full"] {
            let changes = [
                LOST,
                ("blade_off.radius", radius),
                ("blade_off.position", position),
                ("rotor.initial_speed", speed),
                ("contact.rotor_radius", "40 mm"),
                ("contact.gap", "10 mm"),
                ("run.end_time", "20 ms"),
                ("run.engine", engine),
            ];
            let (mut taken, mut steps, mut least) = (f64::NEG_INFINITY, 0, f64::INFINITY);
            let row = run_seen(
                machine_with(&rig, &changes),
                &mut Every(|frame| {
                    least = least.min(frame.energies.braking - taken.min(f64::MAX));
                    taken = frame.energies.braking;
                    steps += 1;
                }),
            );
            println!(
                "{radius} at {position}, {engine}: step {:e}, energy error {:.1e}, braking {taken:.3e} J",
                row.value("step_s"),
                row.value("energy_error")
            );
            assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome);
            assert!(steps > 1000 && taken > 0.0 && least >= 0.0, "{least}");
            assert!(row.value("end_speed_rad_s") < row.machine.rotor.initial_speed);
        }
    }
}

/// What is left of a node that lost most of its inertia turns faster than any twist mode of the shaft: the step limit knows, with the
/// coupling to deflection in it. It was that of the shaft, and the run grew without bound.
#[test]
fn the_step_limit_is_that_of_what_is_left() {
    let rig = study_machine("lab_rig");
    let free = rig.split("[diaphragms").next().expect("a first part");
    let changes = [
        LOST,
        ("blade_off.radius", "43.4 mm"),
        ("blade_off.position", "0.5 m"),
        ("run.engine", "full"),
        ("run.end_time", "5 ms"),
    ];
    let lost = machine_with(free, &changes);
    let structure = Structure::build(&lost, None).expect("buildable");
    let plan = Plan::new(&lost, &structure).expect("it can start");
    let whole = structure.twist.highest.max(structure.lateral.highest);
    println!("highest frequency {:.4e}, of the shaft {whole:.4e} rad/s", plan.highest_frequency);
    assert!(plan.highest_frequency > 1.05 * whole);
    let with_step = |step: f64| machine_with(free, &[&changes[..], &[("run.step", &format!("{step:e}"))]].concat());
    let row = run(with_step(0.99 * plan.largest_step));
    assert!(row.outcome.status == Status::Ok && row.value("energy_error") < 1e-9, "{:?}", row.outcome);
    let refused = simulate(&with_step(1.01 * plan.largest_step), &structure, &mut NoHistory).expect_err("too large");
    assert!(refused.to_string().contains("too large"), "{refused}");
}

/// A unit is wrong: 0.2 mm written as 0.2 (m) stood outside the ring, 0.101 m rubbed it from outside, both were `ok`.
#[test]
fn a_rotor_outside_its_ring_is_refused() {
    let rig = study_machine("lab_rig");
    for offset in ["0.2", "0.101", "-0.0506"] {
        let problem = refused(&rig, &[("contact.offset[1]", offset)]);
        assert_eq!(problem.key, "diaphragms.seal.contact.offset[1]");
        assert!(problem.message.contains("outside diaphragm seal") && problem.message.contains("50.5 mm"));
        assert!(problem.allowed.expect("what is allowed").contains("0.5 mm; a number without a unit is in m"));
    }
    let problem = refused(&rig, &[("rotor.initial.displacement[0]", "0.06")]);
    assert_eq!(problem.key, "rotor.initial.displacement[0]");
    // moved with its ring it stands inside
    machine_with(&rig, &[("rotor.initial.displacement[0]", "0.06"), ("contact.offset[0]", "0.06")]);
    for kind in ["kind = \"rigid\"", "kind = \"radial-spring\"\nstiffness = 1e7"] {
        let text = format!(
            "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 0.01\n\
             initial_speed = 10\n[rotor.bearings.s]\nstiffness = 1e4\n[diaphragms.d]\n{kind}\n[diaphragms.d.contact]\n\
             rotor_radius = 0.05\ngap = 5e-4\nfriction = 0.1\noffset = [0.2, 0.0]\n"
        );
        assert_eq!(refused(&text, &[]).key, "diaphragms.d.contact.offset[0]");
        machine(&text.replace("0.2, 0.0", "1e-4, 0.0"));
    }
}
