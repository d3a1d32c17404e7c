//! Two diaphragms on one shaft, against an independent reference.
//!
//! The reference has separate Timoshenko elements (Cowper's coefficient), radial springs with slip friction at a quarter and three quarters of
//! the span, integrated by Radau IIA of order 5 (two tolerances agree to 1e-7 or better in forces, 1e-9 in the end speed).
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Row, machine, run, seal_rotor, spring_seal, study_machine, with_rings};
use bladeoff_core::record::columns;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Status;

/// The rotor of the reference on the full engine.
fn rotor(step: f64, diaphragms: &str) -> String {
    seal_rotor(&format!("engine = \"full\"\nstep = {step:?}"), diaphragms)
}

fn pair(step: f64, gaps: [f64; 2]) -> Row {
    let diaphragms = spring_seal("a", 0.25, gaps[0]) + &spring_seal("b", 0.75, gaps[1]);
    let row = run(machine(&rotor(step, &diaphragms)));
    assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
    row
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (found - expected).abs() / expected;
    println!("{what}: {found} ({error:.1e} from {expected})");
    assert!(error <= tolerance, "{what}: {found}, not {expected}: {error:e}");
}

const STEP: f64 = 4e-6;
const EQUAL: [f64; 2] = [4e-4, 4e-4];

#[test]
fn one_diaphragm_has_the_force_of_the_reference() {
    let row = run(machine(&rotor(STEP, &spring_seal("a", 0.25, 4e-4))));
    near(row.value("max_contact_force_N"), 629.2825138, 1e-5, "force");
    near(row.value("end_speed_rad_s"), 199.1478310655, 1e-7, "end speed");
}

#[test]
fn two_equal_diaphragms_share_the_force() {
    let row = pair(STEP, EQUAL);
    near(row.value("max_contact_force_a_N"), 493.309672326, 1e-5, "force at a");
    near(row.value("max_contact_force_b_N"), 493.309672326, 1e-5, "force at b");
    near(row.value("end_speed_rad_s"), 199.0380547497, 1e-7, "end speed");
}

#[test]
fn unequal_gaps_have_the_forces_of_the_reference_and_those_of_the_mirrored_machine() {
    let (row, mirrored) = (pair(STEP, [4e-4, 5.2e-4]), pair(STEP, [5.2e-4, 4e-4]));
    near(row.value("max_contact_force_a_N"), 567.8801485, 1e-5, "force at a");
    near(row.value("max_contact_force_b_N"), 356.8355204, 1e-5, "force at b");
    near(row.value("end_speed_rad_s"), 199.1092753217, 1e-7, "end speed");
    near(mirrored.value("max_contact_force_b_N"), row.value("max_contact_force_a_N"), 1e-7, "mirrored");
    near(mirrored.value("max_contact_force_a_N"), row.value("max_contact_force_b_N"), 1e-7, "mirrored");
    near(mirrored.value("end_speed_rad_s"), row.value("end_speed_rad_s"), 1e-9, "mirrored");
}

/// The test rig with rings of these names, positions and gaps in place of its own, released at 300 rad/s: a gap of 0.5 mm closes after 47 ms.
fn rig(of_run: &str, rings: &[(&str, f64, f64)]) -> Machine {
    let text = study_machine("lab_rig").replace("initial_speed = \"3000 rpm\"", "initial_speed = 300");
    assert!(text.contains("initial_speed = 300\n"), "the speed is changed");
    machine(&with_rings(&text, of_run, rings))
}

#[test]
fn a_diaphragm_out_of_reach_changes_no_digit() {
    for engine in ["full", "reduced"] {
        let of_run = format!("end_time = 0.06\nengine = \"{engine}\"\nstep = 1.2e-6\nrotor_modes = 16");
        let alone = run(rig(&of_run, &[("seal", 0.5, 5e-4)]));
        assert!(alone.value("contact_impulse_Ns") > 0.0, "contact happened");
        for order in [[("seal", 0.5, 5e-4), ("far", 0.15, 5e-4)], [("far", 0.15, 5e-4), ("seal", 0.5, 5e-4)]] {
            let both = run(rig(&of_run, &order));
            assert_eq!(both.value("contact_impulse_far_Ns"), 0.0);
            assert_eq!(both.get("first_contact_far_s"), None);
            let all = columns(&both.machine);
            let is_of_seal = |name: &str| name.contains("_seal");
            let has_own = |name: &str| {
                all.iter().any(|column| is_of_seal(&column.name) && column.name.replace("_seal", "") == name)
            };
            let mut compared = 0;
            for (column, value) in all.iter().zip(&both.outcome.values) {
                let name = &*column.name;
                if name.contains("_far") || has_own(name) || name == "friction_energy_seal_J" {
                    continue;
                }
                let expected = alone.get(&name.replace("_seal", ""));
                assert_eq!(
                    value.map(f64::to_bits),
                    expected.map(f64::to_bits),
                    "{engine}: {name}: {value:?}, {expected:?}"
                );
                compared += usize::from(value.is_some());
            }
            assert!(compared > 60, "{compared}");
        }
    }
}

/// A rub of two flexible rings at once: the energy balance closes, both engines agree, and the columns without a name cover both rings.
#[test]
fn two_flexible_rings_at_once_close_the_energy() {
    let rings = [("a", 0.4, 3e-4), ("b", 0.6, 3.05e-4)];
    let of_engine = |engine: &str, step: f64| {
        run(rig(&format!("end_time = 0.08\nengine = \"{engine}\"\nstep = {step:?}\nrotor_modes = 30"), &rings))
    };
    let row = of_engine("full", 1e-6);
    let of_both = |name: [&str; 2]| name.map(|name| row.value(name));
    let [a, b] = of_both(["contact_impulse_a_Ns", "contact_impulse_b_Ns"]);
    assert!(a > 0.1 && b > 0.1, "both touch: {a} and {b} N s");
    assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes);
    assert!(row.value("energy_error") < 1e-6, "{}", row.value("energy_error"));
    assert_eq!(row.value("contact_impulse_Ns"), a + b);
    let [a, b] = of_both(["max_contact_force_a_N", "max_contact_force_b_N"]);
    assert_eq!(row.value("max_contact_force_N"), a.max(b));
    let [a, b] = of_both(["first_contact_a_s", "first_contact_b_s"]);
    assert_eq!(row.value("first_contact_s"), a.min(b));
    let [a, b] = of_both(["friction_energy_a_J", "friction_energy_b_J"]);
    near(row.value("friction_energy_J"), a + b, 1e-12, "friction energy");
    let reduced = of_engine("reduced", 1e-6);
    for (name, tolerance) in [("contact_impulse_Ns", 2e-3), ("max_bearing_load_N", 2e-3), ("friction_energy_J", 2e-3)] {
        near(reduced.value(name), row.value(name), tolerance, name);
    }
}
