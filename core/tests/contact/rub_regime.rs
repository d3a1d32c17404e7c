//! Rub regime of runs that end within one turn of the shaft.

use crate::common::{machine_with, run, study_machine};
use bladeoff_model::outcome::{EndCause, Status};

/// The kinetic energy of the lab rig at 30 rpm becomes friction heat: there is no braking torque, and the weight presses the rotor onto the ring.
const STOPPED_BY_THE_RING: &[(&str, &str)] = &[
    ("run.end_time", "1 s"),
    ("rotor.initial_speed", "30 rpm"),
    ("rotor.gravity[1]", "-9.81 m/s2"),
    ("braking.constant", "0 N m"),
    ("braking.linear", "0 N m s"),
    ("braking.quadratic", "0 N m s2"),
    // the static deflection is 0.233 mm; the added mass closes the gap
    ("diaphragms.seal.contact.gap", "0.234 mm"),
    ("diaphragms.seal.contact.friction", "0.5"),
    ("rotor.unbalances.blade_off.mass", "100 g"),
    ("rotor.unbalances.blade_off.radius", "1 mm"),
];

#[test]
fn a_rotor_that_its_ring_stops_within_a_turn_rubs_heavily_in_both_engines() {
    let stop_times = ["reduced", "exponential"].map(|engine| {
        let changes = [STOPPED_BY_THE_RING, &[("run.engine", engine)]].concat();
        let row = run(machine_with(&study_machine("lab_rig"), &changes));
        assert!(row.value("contact_impulse_Ns") > 0.3, "{engine}: there is contact");
        assert_eq!((row.outcome.status, row.outcome.end_cause), (Status::Ok, EndCause::Stopped), "{engine}");
        let time = row.value("stop_time_s");
        // spin falls from the initial speed: less than half a turn even at constant speed
        let most_turns = 30.0 / 60.0 * time;
        assert!(most_turns < 0.5, "{engine}: {most_turns} turns");
        assert_eq!(row.value("rub_regime"), 2.0, "{engine}: heavy");
        time
    });
    assert!((stop_times[0] / stop_times[1] - 1.0).abs() < 1e-3, "{stop_times:?}");
}
