//! The twin run: what it compares, and that it tells a rub that is a draw of many from a run that is not.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

mod common;

use bladeoff_core::outcome::columns;
use common::{machine_with, run, study_machine};

/// Without rub a shift of 1e-6 of the speed moves the load in proportion; the first run is the one without a twin.
#[test]
fn a_run_without_rub_answers_in_proportion() {
    let text = study_machine("lab_rig");
    let base = [("run.end_time", "0.3 s"), ("contact.gap", "5 mm")];
    let alone = run(machine_with(&text, &base));
    assert_eq!((alone.get("first_contact_s"), alone.get("twin_bearing_load_change")), (None, None));
    let change = |shift: &str| {
        let row = run(machine_with(&text, &[base[0], base[1], ("run.twin", shift)]));
        for (at, column) in columns(&row.machine).iter().enumerate() {
            if !column.name.starts_with("twin_") {
                assert_eq!(row.outcome.values[at], alone.outcome.values[at], "{}", column.name);
            }
        }
        assert_eq!(row.get("twin_status"), Some(0.0), "ok");
        // the twin is a run that can be made by hand
        let speed = format!("{:?}", row.machine.rotor.initial_speed * (1.0 + shift.parse::<f64>().expect("a number")));
        let other = run(machine_with(&text, &[base[0], base[1], ("rotor.initial_speed", &speed)]));
        let (own, other) = (row.value("max_bearing_load_N"), other.value("max_bearing_load_N"));
        assert!((row.value("twin_bearing_load_change") - (other - own) / own).abs() < 1e-12);
        row.value("twin_bearing_load_change")
    };
    let (small, large) = (change("1e-6"), change("1e-5"));
    println!("1e-6 of the speed: {small:.2e}, 1e-5: {large:.2e}");
    assert!((1e-8..1e-4).contains(&small.abs()) && (large / small / 10.0 - 1.0).abs() < 0.05);
}

/// A prescribed speed is shifted as a whole; a twin that begins inside its diaphragm has failed, and there is no change.
#[test]
fn a_prescribed_speed_is_shifted_and_a_failed_twin_is_said() {
    let text =
        study_machine("lab_rig").replace("[rotor.damping]", "[rotor.speed_law]\nacceleration = -50\n[rotor.damping]");
    let base = [("run.end_time", "0.02 s"), ("contact.gap", "5 mm"), ("run.twin", "1e-6")];
    let row = run(machine_with(&text, &base));
    assert!(row.value("twin_bearing_load_change").abs() > 1e-9, "{:?}", row.get("twin_bearing_load_change"));
    // fewer steps than the first run takes are too few for both: that one failed, nobody is compared with it
    let row = run(machine_with(&text, &[base[0], base[1], base[2], ("run.step_limit", "10")]));
    assert_eq!((row.get("twin_bearing_load_change"), row.get("twin_status")), (None, None));
}
