//! Two diaphragms on one shaft, against an independent reference.
//!
//! The reference: own Timoshenko elements (Cowper's coefficient), radial springs with slip friction at a quarter and three quarters of
//! the span, integrated by Radau IIA of order 5 (two tolerances agree to 1e-7 or better in forces, 1e-9 in the end speed).
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Row, machine, run};
use bladeoff_core::record::columns;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Status;

/// The rotor of the reference: 1 m long, a disc of 20 kg in the middle, 250 rad/s at the start.
fn rotor(step: f64, diaphragms: &str) -> String {
    format!(
        "schema = 1\nname = \"two\"\n[run]\nend_time = 0.25\nengine = \"full\"\nstep = {step:?}\nend_beyond = \"off\"\n\
         [rotor]\ninitial_speed = 250\n\
         [rotor.material]\nyoung_modulus = 200e9\npoisson_ratio = 0.3\ndensity = 7800\nshear_coefficient = {:?}\n\
         [[rotor.shaft]]\nlength = 1\ndiameter = 0.05\nelements = 4\n\
         [rotor.discs.middle]\nposition = 0.5\nmass = 20\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.bearings.left]\nposition = 0\nstiffness = 1e7\ndamping = 2000\naxial_stiffness = 1e6\n\
         [rotor.bearings.right]\nposition = 1\nstiffness = 1e7\ndamping = 2000\n\
         [rotor.unbalances.blade_off]\nposition = 0.5\nmass = 0.1\nradius = 0.1\n\
         [rotor.damping]\nstiffness_proportional = 2e-5\n\
         [braking]\nconstant = 20\nlinear = 0.05\nquadratic = 2e-4\n{diaphragms}",
        7.8 / 8.8,
    )
}

fn spring(name: &str, position: f64, gap: f64) -> String {
    format!(
        "[diaphragms.{name}]\nkind = \"radial-spring\"\nstiffness = 2e6\n[diaphragms.{name}.contact]\nposition = {position:?}\n\
         rotor_radius = 0.04\ngap = {gap:?}\nfriction = 0.15\nfriction_law = \"slip\"\n"
    )
}

fn pair(step: f64, gaps: [f64; 2]) -> Row {
    let diaphragms = spring("a", 0.25, gaps[0]) + &spring("b", 0.75, gaps[1]);
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
    let row = run(machine(&rotor(STEP, &spring("a", 0.25, 4e-4))));
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

const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");

/// The test rig with rings of these names, places and gaps in the place of its own.
fn rig(run: &str, rings: &[(&str, f64, f64)]) -> Machine {
    let (before, ring) = RIG.split_at(RIG.find("[diaphragms.seal]").expect("has a ring"));
    let rings = rings.iter().map(|(name, position, gap)| {
        ring.replace("seal", name)
            .replace("position = \"0.5 m\"", &format!("position = {position:?}"))
            .replace("gap = \"0.5 mm\"", &format!("gap = {gap:?}"))
    });
    let before = before.replace("end_time = \"0.6 s\"", run);
    machine(&(before + &rings.collect::<String>()))
}

#[test]
fn a_diaphragm_out_of_reach_changes_no_digit() {
    for engine in ["full", "reduced"] {
        let of_run = format!("end_time = 0.17\nengine = \"{engine}\"\nstep = 1.2e-6\nrotor_modes = 16");
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

/// A rub of two flexible rings at once: the energy closes, both engines agree, and the columns without a name are those of both.
#[test]
fn two_flexible_rings_at_once_close_the_energy() {
    let rings = [("a", 0.4, 3e-4), ("b", 0.6, 3.05e-4)];
    let of_engine = |engine: &str, step: f64| {
        run(rig(&format!("end_time = 0.15\nengine = \"{engine}\"\nstep = {step:?}\nrotor_modes = 30"), &rings))
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
