//! Machines whose values are each allowed but impossible together: lost masses above the present mass, rotors outside their ring.
#![expect(clippy::print_stdout, reason = "what is said is part of the result")]

use crate::common::shipped;
use bladeoff_model::machine::{Machine, MachineDef};
use bladeoff_text::document::{Problem, Problems};

/// A machine text with values replaced by path.
fn built(text: &str, changes: &[(&str, &str)]) -> Result<Machine, Problems> {
    let mut def = MachineDef::parse("test.toml", text)?;
    for (path, value) in changes {
        let info = def.resolve(path).unwrap_or_else(|error| panic!("{error}"));
        let value = def.parse_value(&info, value).unwrap_or_else(|error| panic!("{error}"));
        def.set(&info, &value).unwrap_or_else(|error| panic!("{error}"));
    }
    def.build()
}

fn accepted(text: &str, changes: &[(&str, &str)]) {
    built(text, changes).unwrap_or_else(|problems| panic!("{problems}"));
}

/// The single problem of a machine.
fn refused(text: &str, changes: &[(&str, &str)]) -> Problem {
    let problems = built(text, changes).expect_err("refused");
    println!("{problems}");
    assert_eq!(problems.list.len(), 1, "{problems}");
    problems.list[0].clone()
}

const LOST: (&str, &str) = ("blade_off.kind", "lost");

/// With m r^2 above the polar inertia at its node a lost mass left a torsional mass matrix that was not positive definite: 10 g at 0.4 m
/// panicked in the brake, at 0.7 m the brake drove the rotor, at 45 mm without a disc the accelerations at t = 0 were NaN.
#[test]
fn what_is_lost_was_there() {
    let rig = shipped("lab_rig");
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
    assert!(allowed.contains("no disc is there: an unbalance of disc left at 400 mm has disc = \"left\""), "{allowed}");
    // the nearest disc has not enough inertia either
    let problem = refused(&rig, &[LOST, ("blade_off.radius", "0.4 m"), ("blade_off.position", "0.5 m")]);
    let allowed = problem.allowed.expect("what is allowed");
    assert!(allowed.contains("no disc is there, the nearest is left at 400 mm"), "{allowed}");
    // a mass above that of the node, which was once rejected without naming the unbalance
    let problem = refused(&rig, &[LOST, ("blade_off.mass", "5 kg"), ("blade_off.radius", "0 m")]);
    assert_eq!(problem.key, "rotor.unbalances.blade_off.mass");
    // the rotor has enough for each mass but not for both; an added mass brings its own
    let second = |kind: &str| {
        rig.replace("[rotor.damping]", &format!(
            "[rotor.unbalances.other]\nposition = \"0.6 m\"\nmass = \"10 g\"\nradius = \"0.3 m\"\nkind = \"{kind}\"\n[rotor.damping]"
        ))
    };
    accepted(&rig, &[LOST, ("blade_off.radius", "0.3 m")]);
    let both = [LOST, ("blade_off.radius", "0.3 m")];
    assert_eq!(refused(&second("lost"), &both).key, "rotor.unbalances.other.radius");
    accepted(&second("added"), &both);
    // the excess is reported together with every other mistake of the file
    let far = rig.replace("radius = \"40 mm\"", "radius = \"0.4 m\"\nkind = \"lost\"");
    assert_ne!(far, rig);
    let all = MachineDef::parse("test.toml", &far.replace("gap = \"0.5 mm\"", "gap = \"0.5 kg\""))
        .expect_err("both")
        .to_string();
    assert!(all.contains("is lost where less is") && all.contains("contact.gap"), "{all}");
    // the rotor has half of its mass and half of its inertia to lose, but the remaining body would have no inertia of its own
    let point = "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 0.011\n\
        initial_speed = 10\n[rotor.bearings.s]\nstiffness = 1e4\n[rotor.unbalances.u]\nkind = \"lost\"\nmass = 0.5\nradius = 0.1\n";
    assert_eq!(refused(point, &[("rotor.polar_inertia", "0.0099")]).key, "rotor.unbalances.u.radius");
}

/// Wrong units: an offset of 0.2 mm written as 0.2 (m) put the rotor outside the ring; at 0.101 m it rubbed the outer side. Both runs were `ok`.
#[test]
fn a_rotor_outside_its_ring_is_refused() {
    let rig = shipped("lab_rig");
    for offset in ["0.2", "0.101", "-0.0506"] {
        let problem = refused(&rig, &[("contact.offset[1]", offset)]);
        assert_eq!(problem.key, "diaphragms.seal.contact.offset[1]");
        assert!(problem.message.contains("outside diaphragm seal") && problem.message.contains("50.5 mm"));
        assert!(problem.allowed.expect("what is allowed").contains("0.5 mm; a number without a unit is in m"));
    }
    let problem = refused(&rig, &[("rotor.initial.displacement[0]", "0.06")]);
    assert_eq!(problem.key, "rotor.initial.displacement[0]");
    // displaced together with its ring, the rotor is inside
    accepted(&rig, &[("rotor.initial.displacement[0]", "0.06"), ("contact.offset[0]", "0.06")]);
    for kind in ["kind = \"rigid\"", "kind = \"radial-spring\"\nstiffness = 1e7"] {
        let text = format!(
            "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 0.01\n\
             initial_speed = 10\n[rotor.bearings.s]\nstiffness = 1e4\n[diaphragms.d]\n{kind}\n[diaphragms.d.contact]\n\
             rotor_radius = 0.05\ngap = 5e-4\nfriction = 0.1\noffset = [0.2, 0.0]\n"
        );
        assert_eq!(refused(&text, &[]).key, "diaphragms.d.contact.offset[0]");
        accepted(&text.replace("0.2, 0.0", "1e-4, 0.0"), &[]);
    }
}
