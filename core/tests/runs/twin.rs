//! The twin run: the compared quantities, and the distinction of a rub whose result is random from a run whose result is not.

use crate::common::{machine_with, run, run_seen, study_machine};
use bladeoff_core::record::{Follower, Frame, columns};
use bladeoff_model::outcome::Status;

/// Without rub, a shift of the speed by 1e-6 changes the load in proportion. The row is that of the run without shift.
#[test]
fn a_run_without_rub_answers_in_proportion() {
    let text = study_machine("lab_rig");
    let base = [("run.end_time", "0.3 s"), ("contact.gap", "2 mm")];
    let alone = run(machine_with(&text, &base));
    assert_eq!((alone.get("first_contact_s"), alone.get("twin_bearing_load_change")), (None, None));
    let change = |shift: &str| {
        let row = run(machine_with(&text, &[base[0], base[1], ("run.twin", shift)]));
        for (at, column) in columns(&row.machine).iter().enumerate() {
            if !column.name.starts_with("twin_") && column.name != "sensitive" {
                assert_eq!(row.outcome.values[at], alone.outcome.values[at], "{}", column.name);
            }
        }
        assert_eq!(row.get("twin_status"), Some(0.0), "ok");
        // the twin is equal to a separate run with the shifted speed
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

/// The lab rig with this gap \[m\] to 0.15 s, with a twin whose initial speed is larger by a fraction `twin`.
fn rig_with_gap(gap: f64, twin: &str, limit: &str) -> crate::common::Row {
    let (text, gap) = (study_machine("lab_rig"), format!("{gap:e}"));
    let changes = [("run.end_time", "0.15 s"), ("run.twin", twin), ("contact.gap", &gap), ("run.twin_limit", limit)];
    run(machine_with(&text, &changes))
}

/// A rotor that grazes its ring: its unbalance alone determines the bearing load, while the contact impulse changes by more than `run.twin_limit`.
#[test]
fn a_run_may_be_sensitive_in_its_impulse_alone() {
    let free = rig_with_gap(2e-3, "1e-5", "0.02");
    let further = free.value("twin_eccentricity_change").abs();
    let gap = free.value("max_eccentricity_m") * (1.0 - 5.0 * further);
    let found = rig_with_gap(gap, "1e-5", "0.02");
    assert!(found.value("impacts") > 0.0 && found.value("contact_impulse_Ns") > 0.0, "touches");
    let change = |name: &str| found.value(&format!("twin_{name}_change")).abs();
    let changes = [
        "bearing_load",
        "filtered_contact_force",
        "contact_impulse",
        "friction_energy",
        "eccentricity",
        "torsional_moment",
    ]
    .map(change);
    println!("{changes:?}");
    assert!(changes[0] < 0.02 && changes[2] > 0.02, "{changes:?}");
    assert_eq!(found.get("sensitive"), Some(1.0), "yes");
    // the limit determines the flag and changes nothing else in the row
    let largest = changes.into_iter().fold(0.0, f64::max);
    let other = rig_with_gap(gap, "1e-5", &format!("{:?}", 1.01 * largest));
    assert_eq!(other.get("sensitive"), Some(0.0), "no");
    for (at, column) in columns(&found.machine).iter().enumerate().filter(|(_, column)| column.name != "sensitive") {
        assert_eq!(found.outcome.values[at], other.outcome.values[at], "{}", column.name);
    }
}

/// If only one of the two runs touches the ring, all changes may be small: contact itself is the difference.
#[test]
fn contact_in_one_of_the_two_runs_alone_is_sensitive() {
    let free = rig_with_gap(2e-3, "1e-3", "0.02");
    assert_eq!((free.get("first_contact_s"), free.get("sensitive")), (None, Some(0.0)));
    let change = free.value("twin_eccentricity_change");
    assert!(change.abs() > 1e-6 && change.abs() < 0.02, "{change}");
    let between = rig_with_gap(free.value("max_eccentricity_m") * (1.0 + 0.5 * change), "1e-3", "0.02");
    let touches = between.get("first_contact_s").is_some();
    assert_eq!(touches, change < 0.0, "the one that goes farther");
    assert_eq!(between.get("sensitive"), Some(1.0), "yes");
    // a quantity that this run does not have has no relative change
    assert_eq!(between.get("twin_contact_impulse_change"), touches.then_some(-1.0));
}

/// A prescribed speed is shifted as a whole; a failed run has no twin.
#[test]
fn a_prescribed_speed_is_shifted_and_a_failed_run_has_no_twin() {
    let text =
        study_machine("lab_rig").replace("[rotor.damping]", "[rotor.speed_law]\nacceleration = -50\n[rotor.damping]");
    let base = [("run.end_time", "0.02 s"), ("contact.gap", "2 mm"), ("run.twin", "1e-6")];
    let row = run(machine_with(&text, &base));
    assert!(row.value("twin_bearing_load_change").abs() > 1e-9, "{:?}", row.get("twin_bearing_load_change"));
    // a step limit below the need of both runs: the first one failed, so no twin is compared with it
    let row = run(machine_with(&text, &[base[0], base[1], base[2], ("run.step_limit", "10")]));
    assert_eq!((row.get("twin_bearing_load_change"), row.get("twin_status")), (None, None));
    assert_eq!((row.get("twin_contact_impulse_change"), row.get("sensitive")), (None, None));
}

/// A residual unbalance whirls steadily at the start, within the gap at W and outside it at 1.01 W: the twin cannot start.
#[test]
fn a_failed_twin_is_said() {
    // M = 10.1 kg below its resonance
    let whirl = |speed: f64| {
        let square: f64 = speed * speed;
        0.1 * 0.05 * square / (1e5 - 10.1 * square).hypot(20.0 * speed)
    };
    let row = |gap: f64, twin: &str| {
        run(machine_with(
            &format!(
                "schema = 1\nname = \"whirl\"\n[rotor]\nkind = \"point-mass\"\nmass = 10.0\npolar_inertia = 1.0\ninitial_speed = 90.0\n\
                 [rotor.speed_law]\nacceleration = 0\n[rotor.bearings.support]\nstiffness = 1e5\ndamping = 20.0\nclearance = 2.5e-3\n\
                 [rotor.unbalances.residual]\nmass = 0.1\nradius = 0.05\npresent = \"before\"\n[diaphragms.stop]\nkind = \"rigid\"\n\
                 [diaphragms.stop.contact]\nrotor_radius = 0.05\ngap = {gap:?}\nfriction = 0.1\n[run]\nend_time = 0.5\ntwin = {twin}\n"
            ),
            &[],
        ))
    };
    let (own, shifted) = (whirl(90.0), whirl(90.0 * 1.01));
    assert!(shifted > 1.05 * own);
    let between = row(0.5 * (own + shifted), "0.01");
    assert_eq!((between.outcome.status, between.get("first_contact_s")), (Status::Ok, None), "{:?}", between.outcome);
    assert_eq!((between.get("twin_status"), between.get("twin_bearing_load_change")), (Some(2.0), None), "failed");
    assert_eq!(between.get("sensitive"), None);
    // with a larger gap, or a smaller shift, the twin can start
    for (gap, twin) in [(1.1 * shifted, "0.01"), (0.5 * (own + shifted), "1e-4")] {
        let row = row(gap, twin);
        assert_eq!(row.get("twin_status"), Some(0.0), "ok");
        assert!(row.value("twin_bearing_load_change") > 0.0);
    }
}

/// Ends a run before a given step.
struct Until {
    end: u64,
    asked: Vec<u64>,
}

impl Follower for Until {
    fn goes_on(&mut self, step: u64) -> bool {
        self.asked.push(step);
        step < self.end
    }
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        false
    }
    fn see(&mut self, _frame: &Frame<'_>) {}
}

/// A follower may also end the twin, whose steps continue the count. Once, the twin ran to its end without asking the follower.
#[test]
fn a_twin_can_be_ended() {
    let machine = || machine_with(&study_machine("lab_rig"), &[("run.end_time", "0.001 s"), ("run.twin", "1e-6")]);
    let steps = run(machine()).value("steps") as u64;
    let follow = |end: u64| {
        let mut until = Until { end, asked: Vec::new() };
        let row = run_seen(machine(), &mut until);
        assert_eq!(row.value("steps") as u64, steps.min(end));
        (row.get("twin_status"), until.asked)
    };
    let (status, asked) = follow(u64::MAX);
    assert_eq!((status, asked), (Some(0.0), (0..2 * steps).collect()), "each step of both");
    let (status, asked) = follow(steps + 5);
    assert_eq!((status, asked.last()), (Some(2.0), Some(&(steps + 5))), "failed");
    let (status, asked) = follow(5);
    assert_eq!((status, asked.last()), (None, Some(&5)), "no twin of a run that was ended");
}

/// A Jeffcott rotor that touches a spring on its release either leaves the spring again or is caught by dry whip, depending on its speed. Close to the
/// boundary between both, a change of 1e-6 determines the load; the row is `ok`, and its twin shows the sensitivity.
#[test]
fn a_rub_that_a_millionth_of_the_speed_decides_is_said() {
    let text = "schema = 1\nname = \"caught or not\"\n[rotor]\nkind = \"point-mass\"\nmass = 10.0\npolar_inertia = 0.1\n\
        initial_speed = 50.0\n[rotor.speed_law]\nacceleration = 0\n[rotor.bearings.support]\nstiffness = 1e5\ndamping = 20.0\nclearance = 2.5e-3\n\
        [rotor.unbalances.blade]\nmass = 0.3\nradius = 0.02\n[diaphragms.stop]\nkind = \"radial-spring\"\nstiffness = 1e6\n\
        [diaphragms.stop.contact]\nrotor_radius = 0.05\ngap = 3e-4\nfriction = 0.6\n[run]\nend_time = 1.5\nstep = 4e-5\n";
    let limited = |speed: f64, twin: f64, on_exceed: &str| {
        let (speed, twin) = (format!("{speed:?}"), format!("{twin:?}"));
        let limit = ("run.limit.journal_clearance.on_exceed", on_exceed);
        let row = run(machine_with(text, &[("rotor.initial_speed", &speed), ("run.twin", &twin), limit]));
        assert!(row.value("impacts") > 0.0, "it touches at {speed} rad/s");
        row
    };
    let at = |speed: f64, twin: f64| limited(speed, twin, "note");
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
    assert_eq!(row.get("sensitive"), Some(1.0), "yes");
    // the whip is beyond a limit of the model: a run that ended there is not compared
    let row = limited(free, 1e-6, "beyond");
    assert_eq!((row.outcome.status.word(), row.get("twin_status")), ("ok", Some(3.0)), "beyond");
    assert_eq!((row.get("twin_bearing_load_change"), row.get("sensitive")), (None, None));
    // far from that speed, so small a shift determines nothing
    assert!(at(55.0, 1e-6).value("twin_bearing_load_change").abs() < 1e-3);
}
