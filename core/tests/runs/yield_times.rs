//! Times at which yield limits are first exceeded, against stresses evaluated at every contact step of a history.
//!
//! The history is that of a run without static residual, so the truncated modes, which affect stresses only through the friction force, are missing
//! in both. Ring and blades are evaluated here from the nodal displacements by the formulas of docs/theory/07-stresses-and-rub.md, the shaft by
//! [`ShaftStresses`], which is tested against textbook formulas.

use crate::common::{Every, Row, machine_with, run, run_seen, study_machine};
use bladeoff_core::record::Frame;
use bladeoff_core::stress::ShaftStresses;
use bladeoff_model::machine::{DiaphragmKind, FlexibleStator, Machine, RotorKind};

/// Yield strength far above every stress of the rig.
const FAR: &str = "1e15 Pa";

/// The lab rig until well after its first contact, with yield strengths of shaft and ring.
fn rig(shaft: &str, ring: &str) -> Machine {
    let changes = [
        ("run.engine", "exponential"),
        ("run.end_time", "60 ms"),
        ("run.end_beyond", "off"),
        ("run.static_residual", "off"),
        ("run.guard.penetration", "1"),
        ("contact.gap", "0.4 mm"),
        ("contact.detection", "hyp2"),
        ("rotor.material.yield_strength", shaft),
        ("diaphragms.seal.material.yield_strength", ring),
    ];
    machine_with(&study_machine("lab_rig"), &changes)
}

fn stator(machine: &Machine) -> FlexibleStator {
    let DiaphragmKind::Flexible(stator) = &machine.diaphragms[0].kind else { panic!("a flexible ring") };
    stator.clone()
}

/// Largest stress of ring and blades \[Pa\] by nodal displacements [u, u_s, v, v_s].
fn ring_stress(stator: &FlexibleStator, field: &[f64]) -> f64 {
    let (ring, blades) = (&stator.ring, stator.blades.expect("blades"));
    let (count, r, young) = (ring.elements, ring.mean_radius, stator.young_modulus);
    let l = 2.0 * std::f64::consts::PI * r / count as f64;
    assert_eq!(blades.elements, 1, "a blade has no inner nodes");
    let at = |node: usize| -> [f64; 4] { std::array::from_fn(|i| field[4 * (node % count) + i]) };
    let mut largest = 0.0_f64;
    for node in 0..count {
        let ([u, u_s, v, v_s], before, behind) = (at(node), at(node + count - 1), at(node + 1));
        let membrane = v / r + u_s;
        // second derivatives of the cubics on both sides of the node
        let left = (6.0 * (before[2] - v) / l + 2.0 * before[3] + 4.0 * v_s) / l;
        let right = (6.0 * (behind[2] - v) / l - 2.0 * behind[3] - 4.0 * v_s) / l;
        let foot = node % (count / blades.count) == 0;
        let curvatures = if foot { vec![left, right] } else { vec![0.5 * (left + right)] };
        for curvature in curvatures {
            let bending = 0.5 * ring.thickness * (v / (r * r) + curvature);
            largest = largest.max(young * (membrane.abs() + bending.abs()));
        }
        if foot {
            // a beam clamped at the casing; u, the slope and v at its other end
            let (length, slope) = (blades.length, v_s - u / r);
            let curvature = |t: f64, s: f64| (6.0 * u / length * t + slope * s) / length;
            let bent = curvature(1.0, -2.0).abs().max(curvature(-1.0, 4.0).abs());
            largest = largest.max(young * (v.abs() / length + 0.5 * blades.thickness * bent));
        }
    }
    largest
}

/// Largest von Mises stress of the shaft \[Pa\].
fn shaft_stress(shaft: &ShaftStresses, frame: &Frame<'_>) -> f64 {
    let of = |section: usize| {
        shaft.largest(section, frame.displacement, frame.torsion_angles).equivalent_square.sqrt()
            / shaft.moduli(section).bending
    };
    (0..shaft.sections()).map(of).fold(0.0, f64::max)
}

/// Time and both stresses of every contact step, and the row of the run.
fn history() -> (Row, Vec<(f64, [f64; 2])>) {
    let machine = rig(FAR, FAR);
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { panic!("a shaft") };
    let (shaft, stator) = (ShaftStresses::new(shaft), stator(&machine));
    let mut all = Vec::new();
    let row = run_seen(
        machine,
        &mut Every(|frame: &Frame<'_>| {
            let field = frame.contacts[0].field.expect("a flexible ring");
            all.push((frame.time, [shaft_stress(&shaft, frame), ring_stress(&stator, field)]));
        }),
    );
    (row, all)
}

#[test]
fn a_yield_limit_is_exceeded_within_one_contact_step_of_the_history() {
    let (whole, history) = history();
    let (contact, step) = (whole.value("first_contact_s"), whole.value("step_s"));
    assert!(contact > 0.01 && whole.value("contact_time_s") > 100.0 * step, "rubs");
    let mut between_looks = 0;
    for (which, limit) in [(0, "shaft_yield"), (1, "ring_yield")] {
        let largest = history.iter().map(|(_, stresses)| stresses[which]).fold(0.0, f64::max);
        for share in [0.3, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95] {
            let strength = share * largest;
            let expected = history.iter().find(|(_, stresses)| stresses[which] > strength).expect("exceeded").0;
            let text = format!("{strength:e} Pa");
            let row = run(if which == 0 { rig(&text, FAR) } else { rig(FAR, &text) });
            let found = row.value("beyond_s");
            println!("{limit} {share}: {found} {expected}, {:.2} steps", (found - expected) / step);
            assert!((found - expected).abs() < 1.01 * step, "{limit} {share}: {found} {expected}, steps of {step}");
            if which == 1 {
                assert!(found >= contact - step, "a ring at rest has no stress");
                // an engine that checks only every eight contact steps would find these later
                between_looks += usize::from(!(libm::round(found / step) as u64).is_multiple_of(8));
            }
        }
    }
    assert!(between_looks > 0, "some are exceeded between two looks");
}
