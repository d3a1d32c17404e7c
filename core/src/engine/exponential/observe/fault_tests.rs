//! Faults that the validity guards find in a run, and one that the check before it finds. Each fault is a value of [`StepSettings`] that changes one place of the
//! motion, while the energy balance keeps the right formula. Steps and speed grid are the default ones.
//!
//! | fault | machine | error of the balance | normal work |
//! |---|---|---:|---:|
//! | none | overhung disc, lab rig, hard impact | below 0.1, 0.01, 0.1 | 0, below 0.01, 0.1 |
//! | gyroscopic matrix with the opposite sign in the motion | overhung disc | above 10 | 0 |
//! | modal state not transformed between two speed intervals | overhung disc | above 2 | 0 |
//! | friction without a torque on the spin | lab rig | above 1000 | below 0.01 |
//! | 5 % more damping in the motion | lab rig, overhung disc | above 3, 5 | below 0.1 |
//! | impacts that give back more than they take | hard impact | below 0.1 | above 20 |
//! | static correction of the ring with the opposite sign | all with a ring | no run: `StaticCompliance` | |
//!
//! Errors are in units of their guards. A static correction moves the places of contact and adds no energy, so no guard finds a wrong one; the check of
//! [`crate::engine::exponential::contact::static_compliance`] does. Not found by any balance is an error that the motion and the balance share, such as a wrong
//! matrix of the structure: `bladeoff verify` compares with published reference values.

use super::run::run;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::settings::{Fault, StepSettings};
use crate::engine::time_step::TimeStep;
use crate::record::NoHistory;
use crate::structure::Structure;
use bladeoff_model::machine::MachineDef;

/// Overhung disc with a large unbalance that is braked from 1500 to 850 rad/s, without contact: much of the energy is in tilting motions. Below 600 rad/s its
/// spin is so slow beside the whirl that the balance of the default grid is at its guard without a fault.
const OVERHUNG: &str = "schema = 1\nname = \"overhung\"\n[run]\nengine = \"exponential\"\nend_time = 0.4\n[rotor]\ninitial_speed = 1500\n\
    [rotor.material]\nyoung_modulus = 2.1e11\npoisson_ratio = 0.3\ndensity = 7850\n\
    [[rotor.shaft]]\nlength = 0.4\nelements = 4\ndiameter = 0.03\n[[rotor.shaft]]\nlength = 0.2\nelements = 2\ndiameter = 0.03\n\
    [rotor.discs.wheel]\nposition = 0.6\nmass = 5\ntransverse_inertia = 0.02\npolar_inertia = 0.035\n\
    [rotor.bearings.left]\nposition = 0\nstiffness = 2e7\ndamping = 500\naxial_stiffness = 1e6\n\
    [rotor.bearings.right]\nposition = 0.4\nstiffness = 2e7\ndamping = 500\n\
    [rotor.unbalances.blade]\nposition = 0.6\nmass = 0.2\nradius = 0.1\n[braking]\nconstant = 60\n";

/// Runs a machine with the default step and speed grid. Returns the error of the balance and the normal work, in units of their guards.
fn guarded(text: &str, fault: Option<Fault>) -> Result<[f64; 2], ExponentialError> {
    let machine = MachineDef::parse("test.toml", text).expect("parses").build().expect("valid");
    let structure = Structure::build(&machine, None).expect("buildable");
    let step = TimeStep::new(&machine, &structure).expect("a step").step;
    let (recorders, _) =
        run(&machine, &structure, StepSettings { fault, ..StepSettings::of_step(step) }, &mut NoHistory)?;
    let (energies, guard) = (&recorders.energies, &machine.run.guard);
    let normal_work = energies.now.normal.abs() / energies.normal_work_reference() / guard.normal_work;
    let found = [energies.relative_error() / guard.energy_balance, normal_work];
    println!("{fault:?}: balance {:e}, normal work {:e} of their guards", found[0], found[1]);
    Ok(found)
}

fn overhung(fault: Option<Fault>) -> [f64; 2] {
    guarded(OVERHUNG, fault).expect("covered")
}

/// The lab rig with the exponential engine and these changes.
fn lab_rig_with(changes: &[(&str, &str)]) -> String {
    let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a machine of the repository");
    let text = text.replacen("[run]", "[run]\nengine = \"exponential\"", 1);
    changes.iter().fold(text, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// The lab rig in a rub.
fn lab_rig(fault: Option<Fault>) -> Result<[f64; 2], ExponentialError> {
    let found = guarded(&lab_rig_with(&[]), fault);
    found.inspect(|found| assert!(found[1] > 0.0, "there is contact"))
}

/// The lab rig at 300 rpm that hits its ring with 2 m/s.
fn hard_impact(fault: Option<Fault>) -> [f64; 2] {
    let velocity = "[rotor]\ninitial = { velocity = [2, 0] }";
    let text = lab_rig_with(&[("[rotor]", velocity), ("\"3000 rpm\"", "\"300 rpm\""), ("\"0.6 s\"", "\"0.02 s\"")]);
    let found = guarded(&text, fault).expect("covered");
    assert!(found[1] > 0.0, "there is contact");
    found
}

#[test]
fn runs_without_a_fault_are_below_their_guards() {
    for (found, most) in [(overhung(None), 0.1), (lab_rig(None).expect("covered"), 0.01), (hard_impact(None), 0.1)] {
        assert!(found[0] < most && found[1] < most, "{found:?}");
    }
}

#[test]
fn the_balance_finds_a_wrong_sign_of_the_gyroscopic_matrix() {
    assert!(overhung(Some(Fault::GyroscopicSign))[0] > 10.0);
}

#[test]
fn the_balance_finds_a_lost_basis_change() {
    assert!(overhung(Some(Fault::LostBasisChange))[0] > 2.0);
}

#[test]
fn the_balance_finds_a_missing_torque() {
    assert!(lab_rig(Some(Fault::MissingTorque)).expect("covered")[0] > 1000.0);
}

#[test]
fn the_balance_finds_wrong_damping() {
    assert!(lab_rig(Some(Fault::Damping)).expect("covered")[0] > 3.0);
    assert!(overhung(Some(Fault::Damping))[0] > 5.0);
}

#[test]
fn the_guard_of_normal_work_finds_impacts_that_give_back_more_than_they_take() {
    let found = hard_impact(Some(Fault::Restitution));
    assert!(found[0] < 0.1 && found[1] > 20.0, "{found:?}");
}

#[test]
fn a_wrong_static_correction_is_found_before_the_run() {
    let found = lab_rig(Some(Fault::StaticCorrection));
    let Err(ExponentialError::StaticCompliance { diaphragm, found, expected }) = found else { panic!("{found:?}") };
    assert!(diaphragm == "seal" && found < 0.95 * expected, "{found} {expected}");
}
