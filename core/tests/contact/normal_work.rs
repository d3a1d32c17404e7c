//! The guard `normal_work` on rotors that turn slowly, or rub without friction: it accepts values that agree between steps, and rejects a step that is too long.

use crate::common::{Row, machine_with, run, study_machine};
use bladeoff_model::outcome::Status;

/// The lab rig with a contact step and further changes; asserts contact.
fn rig(step: &str, changes: &[(&str, &str)]) -> Row {
    let base = [("run.engine", "exponential"), ("run.twin", "0"), ("run.contact_step", step)];
    let row = run(machine_with(&study_machine("lab_rig"), &[&base[..], changes].concat()));
    assert!(row.value("contact_impulse_Ns") > 1.0, "{changes:?} touches");
    row
}

#[test]
fn a_drop_without_spin_on_a_flexible_ring_is_ok_at_every_step() {
    for detection in ["hyp1", "hyp2"] {
        for velocity in ["0.3", "2"] {
            let changes = [
                ("rotor.initial_speed", "0 rpm"),
                ("rotor.initial.velocity[0]", velocity),
                ("contact.detection", detection),
                ("contact.gap", "0.5 mm"),
                ("run.end_time", "0.1 s"),
            ];
            let rows = ["6.2 us", "3.1 us", "1 us"].map(|step| rig(step, &changes));
            for row in &rows {
                let causes = row.outcome.causes.words();
                assert_eq!(row.outcome.status, Status::Ok, "{detection}, {velocity} m/s: {causes:?}");
                for column in ["contact_impulse_Ns", "max_bearing_load_N", "max_filtered_contact_force_N"] {
                    let change = row.value(column) / rows[2].value(column) - 1.0;
                    assert!(change.abs() < 0.01, "{detection}, {velocity} m/s, {column}: {change:e}");
                }
            }
        }
    }
}

/// Without friction the ring is the only thing that takes energy from the whirl, and the normal work falls with the step: 22 %, 4.6 % and 0.9 % of the lateral energy.
#[test]
fn a_run_up_without_friction_is_rejected_at_a_long_step_and_accepted_at_a_short_one() {
    let run_up = |acceleration: &str, step: &str| {
        let changes = [
            ("rotor.initial_speed", "0 rpm"),
            ("rotor.speed_law.acceleration", acceleration),
            ("contact.friction", "0"),
            ("contact.gap", "0.7 mm"),
            ("run.end_time", "1 s"),
        ];
        rig(step, &changes)
    };
    let slow = run_up("300", "6.2 us");
    assert_eq!(slow.outcome.status, Status::Ok, "{:?}", slow.outcome.causes.words());
    let [long, short] = ["6.2 us", "1.5 us"].map(|step| run_up("600", step));
    assert_eq!(long.outcome.causes.words().as_deref(), Some("normal_work"));
    assert_eq!(short.outcome.status, Status::Ok, "{:?}", short.outcome.causes.words());
    assert!(short.value("normal_work_J").abs() < 0.1 * long.value("normal_work_J").abs());
}
