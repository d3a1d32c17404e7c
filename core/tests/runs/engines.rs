//! The reduced engine against full finite elements, quantity by quantity, on both machines with contact.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{close, machine_with, run, study_machine};

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

/// Compares full and reduced engine at the default steps. The bound is predicted, not fitted: twice the change of the reduced run with half the step
/// (of first order, the remaining error equals that change), plus three times the largest change with more modes (`richer`: of rotor and ring).
/// The largest of several, because truncation is not monotonic: a single change may be almost zero by chance. Never above `limit`, the
/// accuracy of the defaults for robust quantities.
fn compare(machine: &str, changes: &[(&str, &str)], limit: f64, richer: &[[&str; 2]]) {
    let reduced = |more: &[(&str, &str)]| {
        let row = run(machine_with(&study_machine(machine), &[changes, more].concat()));
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        row
    };
    let ours = reduced(&[]);
    let step = ours.value("step_s");
    let length = step;
    let (step, half) = (format!("{step:e}"), format!("{:e}", 0.5 * step));
    let finer = reduced(&[("run.step", &half)]);
    let richer: Vec<_> = richer
        .iter()
        .map(|[rotor, ring]| reduced(&[("run.step", &half), ("run.rotor_modes", rotor), ("run.ring_modes", ring)]))
        .collect();
    let full = reduced(&[("run.engine", "full")]);
    println!("{machine}: reduced step {step}, full {:e}", full.value("step_s"));
    for name in NAMES {
        let [ours, finer, full] = [&ours, &finer, &full].map(|row| row.value(name));
        let by = |a: f64, b: f64| (a / b - 1.0).abs();
        // a time is resolved to one step
        let quantum = if name == "first_contact_s" { length / ours } else { 0.0 };
        let truncation = richer.iter().map(|row| by(finer, row.value(name))).fold(0.0, f64::max);
        let (error, bound) = (by(ours, full), 2.0 * by(ours, finer) + 3.0 * truncation + quantum);
        println!(
            "{machine} {name}: reduced {ours:.6e}, full {full:.6e}, {error:.2e} of {bound:.2e}; step {:.1e}, modes {truncation:.1e}",
            by(ours, finer)
        );
        assert!(error <= bound + 1e-6, "{name}: {error} against {bound}");
        let robust = !["max_contact_force_N", "max_torsional_moment_Nm"].contains(&name);
        assert!(!robust || error <= limit, "{name}: {error} against {limit}");
    }
}

#[test]
fn lab_rig_reduced_equals_full_over_0_15_s_as_its_convergence_predicts() {
    // touches after 47 ms; one per cent for robust quantities
    compare(
        "lab_rig",
        &[("run.end_time", "0.15"), ("rotor.initial_speed", "300")],
        0.01,
        &[["30", "45"], ["36", "54"]],
    );
}

#[test]
fn turbine_reduced_equals_full_over_the_rub_after_release_as_its_convergence_predicts() {
    // 1450 rpm: the transient of the release touches at 0.110 s, 0.24 mm deep in 8 mm: a graze, whose impulse is 40 times as sensitive as the
    // eccentricity
    compare(
        "lp_turbine_paper",
        &[("run.end_time", "0.3"), ("rotor.initial_speed", "1450 rpm")],
        0.03,
        &[["36", "54"], ["48", "72"], ["60", "90"]],
    );
}

#[test]
fn turbine_reduced_equals_full_in_heavy_rub_torsional_moments_included() {
    // a gap of 3 mm: the transient of the release causes contact from 0.032 s on, almost every step with several contact points
    let changes = [("run.end_time", "0.058"), ("contact.gap", "3 mm")];
    let [ours, full] = ["reduced", "full"].map(|engine| {
        let row =
            run(machine_with(&study_machine("lp_turbine_paper"), &[&changes[..], &[("run.engine", engine)]].concat()));
        assert!(row.value("several_points_steps") > 0.3 * row.value("steps"), "several points, a third of the run");
        row
    });
    let sections =
        ["max_torsional_moment_section0_Nm", "max_torsional_moment_section1_Nm", "max_torsional_moment_section2_Nm"];
    for name in NAMES.into_iter().chain(sections) {
        // 1 % is the accuracy of the defaults for robust quantities; the raw peak is that of the contact step and not converged
        let limit = if name == "max_contact_force_N" { 0.05 } else { 0.01 };
        let error = close(name, ours.value(name), full.value(name), limit);
        println!("heavy rub, {name}: reduced {:.6e}, full {:.6e}, {error:.1e}", ours.value(name), full.value(name));
    }
}

#[test]
fn stiff_bearings_carry_what_stands_on_them() {
    // Loads from the weight of a rotor at rest, whatever its bearings: the kept modes alone miss 0.01 to 6 % of it.
    for (name, stiffnesses) in
        [("lab_rig", ["2e6", "1e8", "1e10", "1e12"]), ("lp_turbine_paper", ["6e8", "1e10", "1e11", "1e12"])]
    {
        for stiffness in stiffnesses {
            let machine = study_machine(name);
            let bearings = machine_with(&machine, &[]).rotor.bearings;
            let mut changes: Vec<(String, &str)> =
                bearings.iter().map(|b| (format!("bearings.{}.stiffness", b.name), stiffness)).collect();
            changes.extend([("rotor.gravity[1]", "-9.81"), ("blade_off.mass", "0 kg")].map(|(k, v)| (k.to_owned(), v)));
            changes.push(("run.end_time".to_owned(), "1 ms"));
            let changes: Vec<(&str, &str)> = changes.iter().map(|(key, value)| (key.as_str(), *value)).collect();
            let machine = machine_with(&machine, &changes);
            let structure = bladeoff_core::structure::Structure::build(&machine, None).expect("buildable");
            let weight: f64 = structure.rotor.weight([0.0, -9.81]).iter().sum::<f64>().abs();
            let row = run(machine.clone());
            let carried: f64 = bearings.iter().map(|b| row.value(&format!("max_bearing_load_{}_N", b.name))).sum();
            close(&format!("{name} on {stiffness} N/m"), carried, weight, 1e-6);
        }
    }
    // A blade lost over the right bearing of the lab rig: loads [N] in 10 ms from an independent finite-element model (Timoshenko elements, Radau to
    // 1e-10); m e W^2 is 39.5 N. In the last case, the modes above those of the ring are truncated and follow statically.
    for (stiffness, reference, limit) in [("2e6", 46.913, 5e-4), ("5e7", 50.756, 1e-3), ("1e8", 52.502, 1.5e-3)] {
        let changes = [
            ("bearings.left.stiffness", stiffness),
            ("bearings.right.stiffness", stiffness),
            ("blade_off.position", "1 m"),
            ("run.end_time", "10 ms"),
        ];
        let row = run(machine_with(&study_machine("lab_rig"), &changes));
        let error = close(stiffness, row.value("max_bearing_load_right_N"), reference, limit);
        println!("blade lost over a bearing of {stiffness} N/m: {error:.1e}");
    }
}

#[test]
fn complete_basis_gives_the_full_engine_s_numbers() {
    // every mode kept, the same step: another form of the same equations
    let changes = [("run.end_time", "0.06"), ("rotor.initial_speed", "300"), ("run.step", "6e-7")];
    let complete = [("run.rotor_modes", "10000"), ("run.torsional_modes", "10000"), ("run.ring_modes", "10000")];
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
    for (name, bound) in [("lab_rig", 0.001), ("lp_turbine_paper", 0.01)] {
        let machine = study_machine(name);
        let machine = machine_with(&machine, &[]);
        let structure = bladeoff_core::structure::Structure::build(&machine, None).expect("buildable");
        let ring = structure.rings[0].as_ref().expect("flexible");
        let residual = ring.residual.as_ref().expect("modes are left out");
        let flexibility = bladeoff_numerics::linalg::spd_inverse(&ring.matrices.stiffness).expect("clamped");
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
