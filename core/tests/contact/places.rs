//! Discs and contacts between two nodes of the shaft, and close to a node.

use crate::common::{machine, study_machine};
use bladeoff_core::modal::report;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef, RotorKind, Shaft};

/// Steel shaft of 1 m on two bearings. All lengths are sums of powers of two, so positions of nodes and their differences are exact.
fn rotor(sections: &str, disc: &str, contact: &str) -> String {
    format!(
        "schema = 1\nname = 'r'\n[run]\nend_time = 0.1\n[rotor]\ninitial_speed = 300\n[rotor.material]\nyoung_modulus = 2.1e11\n\
         poisson_ratio = 0.3\ndensity = 7850\n{sections}\n[rotor.discs.d]\nposition = {disc}\nmass = 2\ntransverse_inertia = 2e-3\n\
         polar_inertia = 4e-3\n[rotor.bearings.a]\nposition = 0\nstiffness = 2e6\ndamping = 100\naxial_stiffness = 1e6\n\
         [rotor.bearings.b]\nposition = 1\nstiffness = 2e6\ndamping = 100\n[rotor.unbalances.u]\nposition = {disc}\n\
         mass = 0.01\nradius = 0.05\n[diaphragms.c]\nkind = 'rigid'\n[diaphragms.c.contact]\nposition = {contact}\n\
         rotor_radius = 0.05\ngap = 1e-3\nfriction = 0.1\n"
    )
}

fn section(lengths: &str) -> String {
    format!("[[rotor.shaft]]\nelement_lengths = [{lengths}]\ndiameter = 0.02\n")
}

fn shaft(machine: &Machine) -> &Shaft {
    match &machine.rotor.kind {
        RotorKind::Shaft(shaft) => shaft,
        RotorKind::PointMass(_) => panic!("a shaft"),
    }
}

#[test]
fn a_split_element_is_the_mesh_written_by_hand_bit_for_bit() {
    let split = machine(&rotor(&section("0.25, 0.25, 0.25, 0.25"), "0.375", "0.8125"));
    let by_hand = machine(&rotor(&section("0.25, 0.125, 0.125, 0.25, 0.0625, 0.1875"), "0.375", "0.8125"));
    assert_eq!(shaft(&split).nodes, [0.0, 0.25, 0.375, 0.5, 0.75, 0.8125, 1.0]);
    assert_eq!(
        (shaft(&split).discs[0].node, split.rotor.unbalances[0].node, split.diaphragms[0].contact.node),
        (2, 2, 5)
    );
    assert_eq!(split, by_hand);
    let frequencies = |machine: &Machine| {
        let report = report(machine, &[0.0, 300.0]).expect("modes");
        format!("{report:?}")
    };
    assert_eq!(frequencies(&split), frequencies(&by_hand));
}

#[test]
fn a_split_section_keeps_its_frequencies() {
    // The same disc on a mesh with a node there and on a mesh that must be split: the continuum is the same.
    let node = "[[rotor.shaft]]\nlength = 1\nelements = 10\ndiameter = 0.02\n";
    let other = "[[rotor.shaft]]\nlength = 1\nelements = 9\ndiameter = 0.02\n";
    let [split, meshed] = [other, node].map(|sections| machine(&rotor(sections, "0.3", "0.6")));
    assert_eq!((shaft(&split).nodes.len(), shaft(&meshed).nodes.len()), (12, 11));
    let lowest = |machine: &Machine| {
        let structure = Structure::build(machine, None).expect("a structure");
        let mut found: Vec<f64> = structure.basis().lateral.omega_squared.iter().map(|square| square.sqrt()).collect();
        found.sort_by(f64::total_cmp);
        found
    };
    let (split, meshed) = (lowest(&split), lowest(&meshed));
    for i in 0..4 {
        assert!((split[i] / meshed[i] - 1.0).abs() < 1e-4, "{i}: {} {}", split[i], meshed[i]);
    }
}

#[test]
fn a_place_that_is_off_by_rounding_is_the_node() {
    let text = study_machine("lab_rig");
    let exact = machine(&text);
    for off in ["0.4000009", "0.3999991", "0.40000000000000013"] {
        let snapped = machine(&text.replacen("position = \"0.4 m\"", &format!("position = {off}"), 1));
        assert_eq!(snapped, exact, "{off}");
    }
}

#[test]
fn things_that_stand_together_share_a_node_in_any_order() {
    let text = rotor(&section("0.5, 0.5"), "0.3", "0.3000005");
    let together = machine(&text);
    assert_eq!(shaft(&together).nodes.len(), 4);
    assert_eq!(together.diaphragms[0].contact.node, shaft(&together).discs[0].node);
    let swapped = machine(&rotor(&section("0.5, 0.5"), "0.3000005", "0.3"));
    assert_eq!(shaft(&swapped).nodes, shaft(&together).nodes, "the leftmost makes the node");
    let close =
        MachineDef::parse("m", &rotor(&section("0.5, 0.5"), "0.3", "0.3005")).expect_err("half a millimetre apart");
    assert!(close.to_string().contains("0.5 mm from the node at 300 mm"), "{close}");
}

#[test]
fn a_place_may_vary_over_the_nodes_and_between_them() {
    let mut def = MachineDef::parse("lab_rig.toml", &study_machine("lab_rig")).expect("the lab rig");
    let info = def.resolve("discs.left.position").expect("a parameter");
    for (place, nodes) in [(0.4, 9), (0.42, 10), (0.45, 10), (0.5, 9)] {
        let value = def.parse_value(&info, &format!("{place}")).expect("allowed");
        def.set(&info, &value).expect("allowed");
        assert_eq!(shaft(&def.build().expect("a machine")).nodes.len(), nodes, "{place}");
    }
}
