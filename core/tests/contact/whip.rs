//! Several contact points on one ring: heavy rub and backward whip of the turbine.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Row, machine_with, run, study_machine};
use bladeoff_model::outcome::Status;

fn turbine(friction: &str, end: &str, points: &str) -> Row {
    let changes = [
        ("contact.friction", friction),
        ("run.end_time", end),
        ("contact.points", points),
        ("run.limit.ring_displacement.on_exceed", "note"),
    ];
    let row = run(machine_with(&study_machine("lp_turbine_paper"), &changes));
    assert!(row.value("contact_impulse_Ns") > 5e4, "contact happened");
    println!(
        "friction {friction}, {points}: {:?} penetration {:.1e} m, friction energy {:.3e} J, normal work {:.2e} J, balance {:.1e}, \
         {} steps without fixed point, {} with several points, filtered force {:.4e} N, impulse {:.4e} N s",
        row.outcome.causes.words(),
        row.value("residual_penetration_m"),
        row.value("friction_energy_J"),
        row.value("normal_work_J"),
        row.value("energy_error"),
        row.value("no_fixed_point_steps"),
        row.value("several_points_steps"),
        row.value("max_filtered_contact_force_N"),
        row.value("contact_impulse_Ns"),
    );
    row
}

#[test]
fn several_points_leave_no_penetration() {
    let (one, several) = (turbine("0.2", "3.25", "one"), turbine("0.2", "3.25", "several"));
    assert!(one.value("no_fixed_point_steps") > 500.0 && several.value("several_points_steps") > 500.0);
    assert_eq!(one.value("several_points_steps"), 0.0);
    // a millionth of the gap, where one point leaves a two-hundredth of the gap
    assert!(several.value("residual_penetration_m") < 1e-6 * 8.0, "{}", several.value("residual_penetration_m"));
    assert!(one.value("residual_penetration_m") > 2e-5);
    assert_eq!((one.outcome.status, several.outcome.status), (Status::Ok, Status::Ok));
}

#[test]
fn high_friction_invents_no_energy() {
    // friction 0.5: backward whip, almost all of the speed lost within a fifth of a second
    let (several, one) = (turbine("0.5", "3.6", "several"), turbine("0.5", "3.6", "one"));
    assert_eq!(several.value("rub_regime"), 3.0, "backward whirl");
    assert!(several.value("several_minima_steps") > 100.0, "{}", several.value("several_minima_steps"));
    assert!(several.value("several_points_steps") > 1000.0);
    // friction cannot take more than the kinetic energy: 1/2 J W^2 at 1500 rpm is 2.4e7 J
    assert!(several.value("friction_energy_J") > 2e7 && several.value("friction_energy_J") < 2.4e7);
    assert!(several.value("energy_error") < 1e-6);
    // several points keep the penetration below the guard of docs/theory/03-contact.md, 2 % of the gap; one point does not
    assert!(several.value("residual_penetration_m") < 0.02 * 8e-3);
    assert!(one.value("residual_penetration_m") > 0.02 * 8e-3);
    // a rigid contact loses energy in impacts and because of the finite step, a fraction of a percent; it never adds energy
    let normal = several.value("normal_work_J") / several.value("friction_energy_J");
    assert!((0.0..0.005).contains(&normal), "{normal}");
    assert_eq!(several.outcome.status, Status::Ok);
    // one point per ring adds a tenth of the friction energy, which the row reports
    assert!(one.value("normal_work_J") < -0.05 * one.value("friction_energy_J"));
    assert_eq!(one.outcome.status, Status::Invalid);
}
