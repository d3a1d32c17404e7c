//! Stresses of rings with many blades, whose default modes give a half to a third of the stress beside a contact: comparison with full finite elements.

use crate::common::{Row, close, machine_with, run, study_machine};
use bladeoff_model::outcome::Status;

/// The lab rig in its first rub, with this number of blades and of ring elements.
fn rig(blades: &str, changes: &[(&str, &str)]) -> Row {
    let all = [
        ("run.end_time", "20 ms"),
        ("contact.gap", "0.3 mm"),
        ("contact.detection", "hyp2"),
        ("diaphragms.seal.ring.elements", blades),
        ("diaphragms.seal.blades.count", blades),
    ];
    run(machine_with(&study_machine("lab_rig"), &[&all, changes].concat()))
}

const EXPONENTIAL: (&str, &str) = ("run.engine", "exponential");

#[test]
fn rings_of_many_blades_have_the_stresses_of_the_full_engine() {
    for blades in ["20", "40"] {
        let full = rig(blades, &[("run.engine", "full")]);
        assert!(full.value("contact_impulse_Ns") > 0.1, "contact happened");
        for engine in ["exponential", "reduced"] {
            let row = rig(blades, &[("run.engine", engine)]);
            assert_eq!(row.outcome.status, Status::Ok);
            assert!(row.value("contact_impulse_Ns") > 0.1, "contact happened");
            for (column, tolerance) in
                [("max_ring_stress_Pa", 0.03), ("max_blade_stress_Pa", 0.015), ("max_blade_bending_stress_Pa", 0.015)]
            {
                let error = close(column, row.value(column), full.value(column), tolerance);
                println!("{blades} blades, {engine}, {column}: {error:+.4}");
            }
            close("place", row.value("max_ring_stress_angle_rad"), full.value("max_ring_stress_angle_rad"), 1e-9);
            // without the truncated modes
            let off = rig(blades, &[("run.engine", engine), ("run.static_residual", "off")]);
            let share = off.value("max_ring_stress_Pa") / full.value("max_ring_stress_Pa");
            assert!(share < 0.75, "{blades} blades, {engine}: {share}");
        }
        let all = rig(blades, &[EXPONENTIAL, ("run.ring_modes", "10000")]);
        close("all modes", all.value("max_ring_stress_Pa"), full.value("max_ring_stress_Pa"), 0.015);
    }
}

/// The limits of the exponential engine use the values of its columns.
#[test]
fn a_yield_limit_counts_the_truncated_modes() {
    for engine in ["exponential", "reduced"] {
        let of = |strength: &str, residual: &str| {
            rig(
                "40",
                &[
                    ("run.engine", engine),
                    ("run.static_residual", residual),
                    ("run.guard.penetration", "1"),
                    ("diaphragms.seal.material.yield_strength", strength),
                ],
            )
        };
        let row = of("16 MPa", "on");
        assert_eq!(row.outcome.status, Status::Beyond, "{engine}");
        assert!(row.value("beyond_s") < 0.0186, "{engine}: {}", row.value("beyond_s"));
        assert_eq!(of("22 MPa", "on").get("beyond_s"), None, "{engine}");
        // the kept modes alone have 11 MPa
        assert_eq!(of("16 MPa", "off").get("beyond_s"), None, "{engine}");
    }
}

/// With a finer step, the contact force of single steps grows; the stress does not.
#[test]
fn ring_stresses_hold_over_the_contact_step() {
    let of = |step: &str| rig("40", &[EXPONENTIAL, ("run.contact_step", step)]);
    let rows = ["10 us", "4 us", "2 us", "1 us", "0.5 us"].map(of);
    let stresses = rows.each_ref().map(|row| row.value("max_ring_stress_Pa"));
    let forces = rows.each_ref().map(|row| row.value("max_contact_force_N"));
    println!("ring stresses {stresses:?}, forces {forces:?}");
    assert!(forces[4] > 1.08 * forces[0], "{forces:?}");
    let mean = stresses.iter().sum::<f64>() / 5.0;
    assert!(stresses.iter().all(|stress| (stress / mean - 1.0).abs() < 0.025), "{stresses:?}");
    let blades = rows.each_ref().map(|row| row.value("max_blade_stress_Pa"));
    assert!(blades.iter().all(|stress| (stress / blades[4] - 1.0).abs() < 0.01), "{blades:?}");
}
