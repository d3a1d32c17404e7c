//! Stored keys, field by field.

use super::*;
use bladeoff_model::machine::{BearingTable, Interpolation, MachineDef};

fn machine(text: &str) -> Machine {
    let def = MachineDef::parse("machine.toml", text).unwrap_or_else(|problems| panic!("{problems}"));
    def.build().unwrap_or_else(|problems| panic!("{problems}"))
}

fn rig() -> Machine {
    machine(include_str!("../../../studies/machines/lab_rig.toml"))
}

/// A point mass on a spring, with numbers that Rust prints with an exponent or a sign.
fn point() -> Machine {
    let mut point = machine(
        "schema = 1\nname = \"point\"\n[run]\nend_time = 1\nstep = 1e-3\nring_modes = 8\n\
         [rotor]\nkind = \"point-mass\"\nmass = 0.00001\npolar_inertia = 0.000001\ninitial_speed = 1\n\
         [rotor.bearings.spring]\nstiffness = [[1e16, 0], [0, 12345678.9]]\ndamping = 1\n",
    );
    // no file has this value, but the text of the key differs
    point.rotor.bearings[0].stiffness[0][1] = -0.0;
    point
}

/// A table of constant coefficients.
fn table() -> BearingTable {
    BearingTable::new(vec![0.0, 500.0], vec![[1e6; 8]; 2], Interpolation::Linear)
}

fn hex(key: [u8; 32]) -> String {
    blake3::Hash::from_bytes(key).to_hex().to_string()
}

/// Existing result directories contain these keys. They must survive every renaming and move.
#[test]
fn keys_are_those_at_rest() {
    let turbine = machine(include_str!("../../../studies/machines/lp_turbine_paper.toml"));
    for (machine, key) in [
        (rig(), "df7171f9e50f6e22aed21396ea694a6cadd7cbfcccac840609c835763b39c5b8"),
        (turbine, "a16092709177d28a849752df0c3168411fcda1def19863fa4345ad576575060d"),
    ] {
        assert_eq!(hex(modal_key(&machine)).as_str(), key);
    }
    let point = point();
    let written = "basis 3\npoint-mass 3ee4f8b588e368f1 3eb0c6f7a0b5ed8d \n\
        bearing 0 4341c37937e08000 8000000000000000 0000000000000000 41678c29dccccccd \nmodes - - 8 \n";
    assert_eq!(text(&point), written);
    assert!(is_key_of(&modal_key(&point), &point) && !is_key_of(&modal_key(&point), &rig()));
}

#[test]
fn what_the_modes_depend_on_is_in_the_key_and_nothing_else() {
    fn shaft(machine: &mut Machine) -> &mut Shaft {
        let RotorKind::Shaft(shaft) = &mut machine.rotor.kind else { unreachable!("a shaft") };
        shaft
    }
    fn stator(machine: &mut Machine) -> &mut FlexibleStator {
        let DiaphragmKind::Flexible(stator) = &mut machine.diaphragms[0].kind else { unreachable!("a ring") };
        stator
    }
    fn blades(machine: &mut Machine) -> &mut Blades {
        stator(machine).blades.as_mut().expect("blades")
    }
    type Change = fn(&mut Machine);
    let changes: &[Change] = &[
        |m| shaft(m).nodes[1] += 1e-9,
        |m| shaft(m).nodes.push(2.0),
        |m| shaft(m).elements[3].length += 1e-9,
        |m| shaft(m).elements[3].diameter += 1e-9,
        |m| shaft(m).elements[3].inner_diameter += 1e-9,
        |m| shaft(m).elements[3].end_diameter += 1e-9,
        |m| shaft(m).elements[3].end_inner_diameter += 1e-9,
        |m| {
            let part = shaft(m).elements[3];
            shaft(m).layers.push(Layer { name: String::new(), first: 3, elements: vec![part] });
        },
        |m| {
            let part = shaft(m).elements[3];
            shaft(m).layers.push(Layer { name: String::new(), first: 2, elements: vec![part] });
        },
        |m| shaft(m).elements[3].young_modulus += 1.0,
        |m| shaft(m).elements[3].poisson_ratio += 1e-9,
        |m| shaft(m).elements[3].density += 1e-9,
        |m| shaft(m).elements[3].shear_coefficient = Some(0.8),
        |m| shaft(m).elements[3].shear_coefficient = None,
        |m| shaft(m).elements.swap(1, 2),
        |m| assert!(shaft(m).elements.pop().is_some()),
        |m| shaft(m).discs[1].node += 1,
        |m| shaft(m).discs[1].mass += 1e-9,
        |m| shaft(m).discs[1].transverse_inertia += 1e-9,
        |m| shaft(m).discs[1].polar_inertia += 1e-9,
        |m| assert!(shaft(m).discs.pop().is_some()),
        |m| m.rotor.bearings[1].node -= 1,
        |m| m.rotor.bearings[1].stiffness[0][1] = 1.0,
        |m| m.rotor.bearings[1].stiffness[1][0] = 1.0,
        |m| m.rotor.bearings[1].stiffness[0][0] += 1.0,
        |m| m.rotor.bearings[1].stiffness[1][1] += 1.0,
        |m| m.rotor.bearings[1].table = Some(table()),
        |m| assert!(m.rotor.bearings.pop().is_some()),
        |m| stator(m).young_modulus += 1.0,
        |m| stator(m).density += 1e-9,
        |m| stator(m).ring.mean_radius += 1e-9,
        |m| stator(m).ring.thickness += 1e-9,
        |m| stator(m).ring.width += 1e-9,
        |m| stator(m).ring.elements += 8,
        |m| stator(m).blades = None,
        |m| blades(m).count += 8,
        |m| blades(m).length += 1e-9,
        |m| blades(m).thickness += 1e-9,
        |m| blades(m).width += 1e-9,
        |m| blades(m).elements += 1,
        |m| m.diaphragms.clear(),
        |m| m.diaphragms.push(m.diaphragms[0].clone()),
        |m| m.run.rotor_modes = Some(8),
        |m| m.run.torsional_modes = Some(8),
        |m| m.run.ring_modes = Some(8),
        |m| m.rotor.kind = RotorKind::PointMass(PointMass { mass: 1.0, polar_inertia: 2.0 }),
        |m| m.rotor.kind = RotorKind::PointMass(PointMass { mass: 2.0, polar_inertia: 1.0 }),
    ];
    let mut keys = std::collections::BTreeSet::from([modal_key(&rig())]);
    for (number, change) in changes.iter().enumerate() {
        let mut machine = rig();
        change(&mut machine);
        assert!(keys.insert(modal_key(&machine)), "change {number} is not in the key");
    }
    let nothing: &[Change] = &[
        |m| m.name.push('x'),
        |m| shaft(m).discs[0].name.push('x'),
        |m| shaft(m).elements[3].section += 1,
        |m| m.rotor.bearings[0].name.push('x'),
        |m| m.rotor.bearings[0].damping[0][0] += 1.0,
        |m| m.rotor.unbalances.clear(),
        |m| m.rotor.initial_speed += 1.0,
        |m| stator(m).poisson_ratio += 0.01,
        |m| stator(m).damping.mass_proportional += 1.0,
        |m| m.diaphragms[0].contact.gap += 1e-4,
        |m| m.run.end_time += 1.0,
    ];
    for (number, change) in nothing.iter().enumerate() {
        let mut machine = rig();
        change(&mut machine);
        assert_eq!(modal_key(&machine), modal_key(&rig()), "change {number} is in the key");
    }
}

/// Rust names must not enter a key through the Debug output of a struct: only numbers and text are printed.
#[test]
fn keys_are_not_made_of_what_rust_prints_of_a_struct() {
    let printed = |source: &str| -> Vec<String> {
        let code = source.split("#[cfg(test)]").next().expect("code").lines();
        code.filter(|line| line.contains(":?")).map(|line| line.trim().to_owned()).collect()
    };
    assert_eq!(printed(include_str!("key.rs")), [""; 0]);
}
