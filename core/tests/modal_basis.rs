//! A modal basis that cannot carry a contact is said in the row.

mod common;

use bladeoff_core::outcome::{Cause, Status};
use bladeoff_core::structure::{MODAL_LAG, Structure};
use common::{Row, close, machine_with, run, study_machine};

/// A run with so many rotor modes, and the share of its contact that they cannot carry.
fn with_modes(name: &str, modes: &str, changes: &[(&str, &str)]) -> (Row, f64) {
    let machine = machine_with(&study_machine(name), &[changes, &[("run.rotor_modes", modes)]].concat());
    let share = Structure::build(&machine, None).expect("buildable").lag_at_contact(&machine);
    let row = run(machine);
    assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
    (row, share)
}

#[test]
fn a_basis_too_small_for_the_contact_is_said() {
    let rig: &[(&str, &str)] = &[("run.end_time", "0.2")];
    let turbine: &[(&str, &str)] = &[("run.end_time", "0.13"), ("contact.gap", "5 mm")];
    for (name, changes, least) in [("lab_rig", rig, 1.0), ("lp_turbine", turbine, 0.03)] {
        let force = |row: &Row| row.value("max_filtered_contact_force_N");
        let (reference, share) = with_modes(name, "36", changes);
        assert_eq!(reference.outcome.status, Status::Ok, "{:?}", reference.outcome.causes.words());
        assert!(share < 1e-3, "{share}");
        for modes in ["4", "8", "12", "16", "24"] {
            let (row, share) = with_modes(name, modes, changes);
            let error = (force(&row) / force(&reference) - 1.0).abs();
            println!("{name}, {modes} rotor modes: share {share:.5}, filtered force off by {error:.5}");
            let said = row.outcome.causes.contains(Cause::ModalBasis);
            assert_eq!(said, share > MODAL_LAG);
            // what is said is wrong by more than the engines differ, what is not said is right to 2 %
            assert_eq!(said, ["4", "8"].contains(&modes), "{name} {modes}: {share}");
            assert!(if said { error > least } else { error < 0.02 }, "{name} {modes}: {error}");
            assert_eq!(row.outcome.status, if said { Status::Invalid } else { Status::Ok });
        }
    }
    // nothing is said of a run without contact, of the full engine, and of the modes chosen by the engine
    let quiet = machine_with(&study_machine("lab_rig"), &[("run.end_time", "0.05"), ("run.rotor_modes", "4")]);
    let row = run(quiet);
    assert_eq!((row.get("first_contact_s"), row.outcome.status), (None, Status::Ok));
    for name in ["lab_rig", "lp_turbine"] {
        for (engine, most) in [("reduced", 0.01), ("full", 0.0)] {
            let machine = machine_with(&study_machine(name), &[("run.engine", engine)]);
            let share = Structure::build(&machine, None).expect("buildable").lag_at_contact(&machine);
            assert!(share <= most, "{name} {engine}: {share}");
        }
    }
}

#[test]
fn the_lag_is_that_of_the_modes_left_out() {
    // from all modes, one by one; the ring where the share is largest
    let rate: f64 = std::f64::consts::PI / 1e-3;
    for (name, kept) in [("lab_rig", ["4", "6"]), ("lp_turbine", ["8", "13"])] {
        let build = |changes: &[(&str, &str)]| {
            let machine = machine_with(&study_machine(name), changes);
            (Structure::build(&machine, None).expect("buildable"), machine)
        };
        let (all, machine) = build(&[("run.rotor_modes", "10000"), ("run.ring_modes", "10000")]);
        assert_eq!(all.lag_at_contact(&machine), 0.0, "nothing is left out");
        let (few, machine) = build(&[("run.rotor_modes", kept[0]), ("run.ring_modes", kept[1])]);
        let sums = |shapes: &dyn Fn(usize) -> f64, squares: &[f64], kept: usize| {
            let (mut lag, mut moving, mut at_rest) = (0.0, 0.0, 0.0);
            for (j, square) in squares.iter().enumerate() {
                let part = shapes(j) * shapes(j);
                let follows = part / (square + rate * rate);
                moving += follows;
                at_rest += part / square;
                lag += if j < kept { 0.0 } else { part / square - follows };
            }
            (lag, moving, at_rest)
        };
        let [u, v] = [all.rotor.u(machine.diaphragms[0].contact.node), all.rotor.v(machine.diaphragms[0].contact.node)];
        let (lateral, ring) = (&all.basis().lateral, &all.basis().rings[0]);
        let (kept_lateral, kept_ring) =
            (few.basis().lateral.omega_squared.len(), few.basis().rings[0].omega_squared.len());
        let mut largest = 0.0_f64;
        for place in [u, v] {
            let rotor = sums(&|j| lateral.shapes[(place, j)], &lateral.omega_squared, kept_lateral);
            for node in 0..all.rings[0].as_ref().expect("flexible").matrices.nodes {
                let stator = sums(&|j| ring.shapes[(4 * node + 2, j)], &ring.omega_squared, kept_ring);
                largest = largest.max((rotor.0 + stator.0) / (rotor.1 + stator.2));
            }
        }
        assert!(largest > MODAL_LAG);
        close(name, few.lag_at_contact(&machine), largest, 1e-5);
    }
}
