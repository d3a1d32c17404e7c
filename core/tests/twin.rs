//! The twin run: what it compares, and that it tells a rub that is a draw of many from a run that is not.

mod common;

use bladeoff_core::record::columns;
use common::{machine_with, run, study_machine};

/// Without rub a shift of 1e-6 of the speed moves the load in proportion; the first run is the one without a twin.
#[test]
fn a_run_without_rub_answers_in_proportion() {
    let text = study_machine("lab_rig");
    let base = [("run.end_time", "0.3 s"), ("contact.gap", "2 mm")];
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
    let base = [("run.end_time", "0.02 s"), ("contact.gap", "2 mm"), ("run.twin", "1e-6")];
    let row = run(machine_with(&text, &base));
    assert!(row.value("twin_bearing_load_change").abs() > 1e-9, "{:?}", row.get("twin_bearing_load_change"));
    // fewer steps than the first run takes are too few for both: that one failed, nobody is compared with it
    let row = run(machine_with(&text, &[base[0], base[1], base[2], ("run.step_limit", "10")]));
    assert_eq!((row.get("twin_bearing_load_change"), row.get("twin_status")), (None, None));
}

/// A Jeffcott rotor that touches a spring on its release either leaves it again or is caught by dry whip. Between the two lies a
/// speed; next to it 1e-6 of the speed decides the load, the row is `ok`, and its twin says so.
#[test]
fn a_rub_that_a_millionth_of_the_speed_decides_is_said() {
    let text = "schema = 1\nname = \"caught or not\"\n[rotor]\nkind = \"point-mass\"\nmass = 10.0\npolar_inertia = 0.1\n\
        initial_speed = 50.0\n[rotor.speed_law]\nacceleration = 0\n[rotor.bearings.support]\nstiffness = 1e5\ndamping = 20.0\n\
        [rotor.unbalances.blade]\nmass = 0.3\nradius = 0.02\n[diaphragms.stop]\nkind = \"radial-spring\"\nstiffness = 1e6\n\
        [diaphragms.stop.contact]\nrotor_radius = 0.05\ngap = 3e-4\nfriction = 0.6\n[run]\nend_time = 1.5\nstep = 4e-5\n";
    let at = |speed: f64, twin: f64| {
        let row = run(machine_with(
            text,
            &[("rotor.initial_speed", &format!("{speed:?}")), ("run.twin", &format!("{twin:?}"))],
        ));
        assert!(row.value("impacts") > 0.0, "it touches at {speed} rad/s");
        row
    };
    let is_caught = |speed: f64| at(speed, 0.0).value("max_bearing_load_N") > 200.0;
    let (mut free, mut caught) = (50.0, 60.0);
    assert!(!is_caught(free) && is_caught(caught));
    while caught / free - 1.0 > 1e-7 {
        let middle = 0.5 * (free + caught);
        if is_caught(middle) {
            caught = middle;
        } else {
            free = middle;
        }
    }
    let row = at(free, 1e-6);
    let change = row.value("twin_bearing_load_change");
    println!("{free} rad/s: {:.1} N, the twin's {change:.2} more of it", row.value("max_bearing_load_N"));
    assert_eq!((row.outcome.status.word(), row.get("twin_status")), ("ok", Some(0.0)));
    assert!(change > 1.0, "{change}");
    // away from the border nothing is decided by so little
    assert!(at(55.0, 1e-6).value("twin_bearing_load_change").abs() < 1e-3);
}
