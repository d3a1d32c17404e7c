//! The reduced engine against full finite elements, quantity by quantity, on both machines with contact.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

mod common;

use common::{Row, close, machine_with, run, study_machine};

const NAMES: [&str; 9] = [
    "first_contact_s",
    "end_speed_rad_s",
    "max_bearing_load_N",
    "max_filtered_contact_force_N",
    "contact_impulse_Ns",
    "friction_energy_J",
    "max_eccentricity_m",
    "max_torsional_moment_Nm",
    "max_contact_force_N",
];

fn both(machine: &str, changes: &[(&str, &str)]) -> [Row; 2] {
    ["reduced", "full"].map(|engine| {
        let mut all = changes.to_vec();
        all.push(("run.engine", engine));
        let row = run(machine_with(&study_machine(machine), &all));
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        row
    })
}

/// Compares at the default steps, quantity by quantity: tolerances in the order of [`NAMES`].
fn compare(machine: &str, changes: &[(&str, &str)], tolerances: [f64; 9]) {
    let [reduced, full] = both(machine, changes);
    for (name, tolerance) in NAMES.into_iter().zip(tolerances) {
        let error = close(name, reduced.value(name), full.value(name), tolerance);
        println!("{machine} {name}: reduced {:.6e}, full {:.6e}, {error:.1e}", reduced.value(name), full.value(name));
    }
}

#[test]
fn lab_rig_reduced_equals_full_over_0_3_s_within_its_step_and_truncation() {
    // steps 3.4e-6 and 6.2e-7 s. The contact is first order in the step: 8e-4 of impulse and friction energy; truncation
    // (same step): 2e-3 of bearing load and force peaks, partly cancelling. The torsional moment peaks in a 7 kHz
    // oscillation: 9 % at the default step, 3 % at half, 1.4 % at the step of the full engine
    compare("lab_rig", &[("run.end_time", "0.3")], [2e-5, 5e-5, 2e-3, 2.5e-3, 1e-3, 1e-3, 2e-4, 0.1, 4e-3]);
}

#[test]
fn turbine_reduced_equals_full_over_the_rub_after_release() {
    // 1450 rpm: the swing of the release touches at 0.110 s, 0.24 mm deep of 8 mm: a graze, whose impulse is 40 times as
    // sensitive as the eccentricity (2e-4, truncation)
    let changes = [("run.end_time", "0.3"), ("rotor.initial_speed", "1450 rpm")];
    compare("lp_turbine", &changes, [5e-4, 2e-5, 1e-3, 4e-3, 2.5e-2, 2.5e-2, 5e-4, 2e-2, 5e-3]);
}

#[test]
fn complete_basis_gives_the_full_engine_s_numbers() {
    // every mode kept, the same step: another path to the same equations
    let changes = [("run.end_time", "0.165"), ("run.step", "6e-7")];
    let complete = [("run.rotor_modes", "10000"), ("run.twist_modes", "10000"), ("run.ring_modes", "10000")];
    let mut all = changes.to_vec();
    all.extend_from_slice(&complete);
    let reduced = run(machine_with(&study_machine("lab_rig"), &all));
    all.push(("run.engine", "full"));
    let full = run(machine_with(&study_machine("lab_rig"), &all));
    assert!(full.value("impacts") >= 1.0 && full.value("contact_impulse_Ns") > 0.1, "contact happened");
    for name in NAMES {
        let error = close(name, reduced.value(name), full.value(name), 1e-6);
        println!("complete basis, {name}: {error:.1e}");
    }
}

#[test]
fn the_residual_completes_the_static_flexibility() {
    for (name, bound) in [("lab_rig", 0.001), ("lp_turbine", 0.01)] {
        let machine = study_machine(name);
        let machine = machine_with(&machine, &[]);
        let structure = bladeoff_core::structure::Structure::build(&machine, None).expect("buildable");
        let ring = structure.rings[0].as_ref().expect("flexible");
        let residual = ring.residual.as_ref().expect("modes are left out");
        let flexibility = bladeoff_core::linalg::spd_inverse(&ring.matrices.stiffness).expect("clamped");
        let omega_squared = &structure.basis().rings[0].omega_squared;
        let mut largest: f64 = 0.0;
        for node in 0..ring.matrices.nodes {
            let radial = 4 * node + 2;
            let row = ring.part.coordinates.row(radial);
            let kept: f64 = row.iter().zip(omega_squared).map(|(phi, square)| phi * phi / square).sum();
            let (full, left_out) = (flexibility[(radial, radial)], residual[(radial, radial)]);
            assert!(((kept + left_out) / full - 1.0).abs() < 1e-9, "node {node}");
            largest = largest.max(left_out / full);
        }
        assert!(largest > bound, "{name}: the modes left out matter: {largest}");
    }
}
