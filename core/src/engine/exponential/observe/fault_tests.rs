//! Faults that the guards of energy find. Each fault is a value of [`StepSettings`] that changes one place of the motion, while the energy balance keeps the right formula.
//!
//! | fault | error of the balance, in units of its guard |
//! |---|---:|
//! | none | below 0.3 |
//! | gyroscopic matrix with the opposite sign in the motion | above 10 |
//! | modal state not transformed between two speed intervals | above 1.5 |
//! | friction without a torque on the spin | above 1000 |
//! | 5 % more damping in the motion | above 3 |
//! | static correction of the ring with the opposite sign | below 0.1: not found |
//!
//! A static correction moves the places of contact and adds no energy: the works are those of the impulses on the motion that they make. It is therefore verified by
//! `a_steady_train_of_impulses_makes_the_static_displacement` ([`crate::engine::exponential::contact::impulsed_ring`]). Not found by any balance is an error that the motion and
//! the balance share, such as a wrong matrix of the structure: `bladeoff verify` compares with published reference values.

use super::run::run;
use crate::engine::exponential::settings::{Fault, StepSettings};
use crate::record::NoHistory;
use crate::structure::Structure;
use bladeoff_model::machine::MachineDef;

/// Overhung disc with a large unbalance that is braked through a critical speed, without contact: much of the energy is in tilting motions.
const OVERHUNG: &str = "schema = 1\nname = \"overhung\"\n[run]\nengine = \"exponential\"\nend_time = 0.4\n[rotor]\ninitial_speed = 600\n\
    [rotor.material]\nyoung_modulus = 2.1e11\npoisson_ratio = 0.3\ndensity = 7850\n\
    [[rotor.shaft]]\nlength = 0.4\nelements = 4\ndiameter = 0.03\n[[rotor.shaft]]\nlength = 0.2\nelements = 2\ndiameter = 0.03\n\
    [rotor.discs.wheel]\nposition = 0.6\nmass = 5\ntransverse_inertia = 0.02\npolar_inertia = 0.035\n\
    [rotor.bearings.left]\nposition = 0\nstiffness = 2e7\ndamping = 500\naxial_stiffness = 1e6\n\
    [rotor.bearings.right]\nposition = 0.4\nstiffness = 2e7\ndamping = 500\n\
    [rotor.unbalances.blade]\nposition = 0.6\nmass = 0.2\nradius = 0.1\n[braking]\nconstant = 30\n";

/// Error of the balance, and normal work, in units of their guards.
fn guarded(text: &str, settings: StepSettings) -> [f64; 2] {
    let machine = MachineDef::parse("test.toml", text).expect("parses").build().expect("valid");
    let structure = Structure::build(&machine, None).expect("buildable");
    let (recorders, _) = run(&machine, &structure, settings, &mut NoHistory).expect("covered");
    let (energies, guard) = (&recorders.energies, &machine.run.guard);
    let normal_work = energies.now.normal.abs() / energies.normal_work_reference() / guard.normal_work;
    let found = [energies.relative_error() / guard.energy_balance, normal_work];
    println!("{:?}: balance {:e}, normal work {:e} of their guards", settings.fault, found[0], found[1]);
    found
}

/// The overhung disc on a fine grid: at the default one the balance is at its guard without a fault.
fn overhung(fault: Option<Fault>) -> [f64; 2] {
    guarded(OVERHUNG, StepSettings { spacing: Some(4.0), cells: 160, fault, ..StepSettings::of_step(3e-6) })
}

/// The lab rig in a rub.
fn lab_rig(fault: Option<Fault>) -> [f64; 2] {
    let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a machine of the repository");
    guarded(
        &text.replacen("[run]", "[run]\nengine = \"exponential\"", 1),
        StepSettings { fault, ..StepSettings::of_step(6.2e-6) },
    )
}

#[test]
fn runs_without_a_fault_are_below_their_guards() {
    for (found, most) in [(overhung(None), 0.3), (lab_rig(None), 0.01)] {
        assert!(found[0] < most && found[1] < most, "{found:?}");
    }
}

#[test]
fn the_balance_finds_a_wrong_sign_of_the_gyroscopic_matrix() {
    assert!(overhung(Some(Fault::GyroscopicSign))[0] > 10.0);
}

#[test]
fn the_balance_finds_a_lost_basis_change() {
    assert!(overhung(Some(Fault::LostBasisChange))[0] > 1.5);
}

#[test]
fn the_balance_finds_a_missing_torque() {
    assert!(lab_rig(Some(Fault::MissingTorque))[0] > 1000.0);
}

#[test]
fn the_balance_finds_wrong_damping() {
    assert!(lab_rig(Some(Fault::Damping))[0] > 3.0);
}

#[test]
fn no_guard_of_energy_finds_a_wrong_static_correction() {
    let found = lab_rig(Some(Fault::StaticCorrection));
    assert!(found[0] < 0.1 && found[1] < 0.1, "{found:?}");
}
