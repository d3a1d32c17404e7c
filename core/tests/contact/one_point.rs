//! `hyp2` with one contact point on the exponential engine (docs/theory/09-one-place.md): agreement with the reduced engine, order in the step, steps without a fixed point.

use crate::common::{Row, close, machine_with, run, study_machine};
use bladeoff_model::outcome::Status;

fn row(file: &str, engine: &str, changes: &[(&str, &str)]) -> Row {
    let all = [&[("run.engine", engine), ("contact.detection", "hyp2"), ("contact.points", "one")], changes].concat();
    let row = run(machine_with(&study_machine(file), &all));
    assert!(row.value("contact_impulse_Ns") > 0.0, "touches");
    row
}

/// Extrapolation to step zero of the reduced engine, which is of first order, from a step and half of it.
fn limit(column: &str, coarse: &Row, fine: &Row) -> f64 {
    2.0 * fine.value(column) - coarse.value(column)
}

/// A light rub of the rig has a fixed point in each step. The reduced engine at 0.85 us is 2e-4 to 6e-4 from its own limit.
#[test]
fn a_rub_of_the_rig_is_that_of_the_reduced_engine() {
    let end = ("run.end_time", "0.25 s");
    let [coarse, fine] = ["3.4 us", "1.7 us"].map(|step| row("lab_rig", "reduced", &[end, ("run.step", step)]));
    for ours in
        [row("lab_rig", "exponential", &[end]), row("lab_rig", "exponential", &[end, ("run.contact_step", "0.75 us")])]
    {
        assert_eq!(ours.outcome.status, Status::Ok);
        for (column, tolerance) in [
            ("max_bearing_load_left_N", 3e-4),
            ("max_bearing_load_right_N", 3e-4),
            ("max_filtered_contact_force_N", 2e-3),
            ("contact_impulse_Ns", 5e-5),
            ("friction_energy_J", 5e-5),
            ("max_eccentricity_m", 2e-5),
        ] {
            let error = close(column, ours.value(column), limit(column, &coarse, &fine), tolerance);
            println!("{column}: {error:.1e}");
        }
        assert_eq!(ours.value("no_fixed_point_steps"), 0.0);
        assert!(ours.value("energy_error") < 1e-8 && ours.value("residual_penetration_m") < 1e-8);
    }
}

/// In a heavier rub some steps have no fixed point, fewer with each halving of the step. The penetration falls with the step.
#[test]
fn steps_without_a_fixed_point_have_the_place_without_impulses() {
    let changes = [("run.end_time", "0.1 s"), ("contact.gap", "0.3 mm"), ("contact.friction", "0.3")];
    let of = |engine: &str, key: &str, step: &str| row("lab_rig", engine, &[&changes[..], &[(key, step)]].concat());
    let [coarse, fine] = ["1.7 us", "0.85 us"].map(|step| of("reduced", "run.step", step));
    let rows = ["6 us", "3 us", "1.5 us"].map(|step| of("exponential", "run.contact_step", step));
    for (ours, [impulse, load]) in rows.iter().zip([[1e-3, 5e-3], [2e-4, 2e-3], [5e-5, 2e-3]]) {
        assert_eq!(ours.outcome.status, Status::Ok);
        for (column, tolerance) in
            [("contact_impulse_Ns", impulse), ("friction_energy_J", 1e-3), ("max_bearing_load_right_N", load)]
        {
            let error = close(column, ours.value(column), limit(column, &coarse, &fine), tolerance);
            println!("{column}: {error:.1e}");
        }
    }
    for pair in rows.windows(2) {
        let counts = [0, 1].map(|at| pair[at].value("no_fixed_point_steps"));
        let penetrations = [0, 1].map(|at| pair[at].value("residual_penetration_m"));
        assert!(counts[0] > 2.0 * counts[1] && counts[1] > 0.0, "{counts:?}");
        assert!(penetrations[0] > 2.0 * penetrations[1], "{penetrations:?}");
    }
}

/// First second of the nominal turbine's rub: impulse and friction energy agree with the limit of the reduced engine.
#[test]
fn a_rub_of_the_turbine_is_that_of_the_reduced_engine() {
    let end = ("run.end_time", "3.4 s");
    let [coarse, fine] =
        ["27.2 us", "13.6 us"].map(|step| row("lp_turbine_paper", "reduced", &[end, ("run.step", step)]));
    let ours = row("lp_turbine_paper", "exponential", &[end]);
    assert_eq!(ours.outcome.status, Status::Ok);
    for (column, tolerance) in
        [("contact_impulse_Ns", 1e-3), ("friction_energy_J", 1e-3), ("max_bearing_load_rear_N", 5e-3)]
    {
        let error = close(column, ours.value(column), limit(column, &coarse, &fine), tolerance);
        println!("{column}: {error:.1e}");
    }
    assert!(ours.value("no_fixed_point_steps") > 0.0 && ours.value("energy_error") < 1e-7);
}
