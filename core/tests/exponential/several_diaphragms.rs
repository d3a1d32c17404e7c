//! Several diaphragms on the exponential engine: an independent reference, the reference engines, and a single diaphragm.
//!
//! The reference has separate Timoshenko elements (Cowper's coefficient), radial springs with slip friction at a quarter and three
//! quarters of the span, and Radau IIA of order 5 (two tolerances agree to 1e-7 or better in forces, 1e-9 in the end speed).
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::bearing_tables;
use crate::common::{
    Row, close, machine, machine_with, run, run_seen, seal_rotor, spring_seal, study_machine, with_rings,
};
use bladeoff_core::record::{Follower, Frame, columns};
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Status;

fn rotor(of_run: &str, diaphragms: &str) -> Machine {
    machine(&seal_rotor(of_run, diaphragms))
}

const EXPONENTIAL: &str = "engine = \"exponential\"";

/// Row of the reference's rotor with springs a and b of these gaps, both of which touch.
fn pair(of_run: &str, gaps: [f64; 2]) -> Row {
    let row = run(rotor(of_run, &(spring_seal("a", 0.25, gaps[0]) + &spring_seal("b", 0.75, gaps[1]))));
    both_touch(&row);
    row
}

/// Asserts contact at both diaphragms, in a run that is ok.
#[track_caller]
fn both_touch(row: &Row) {
    for name in ["contact_impulse_a_Ns", "contact_impulse_b_Ns", "friction_energy_a_J", "friction_energy_b_J"] {
        assert!(row.value(name) > 0.01, "{name}: {}", row.value(name));
    }
    assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes);
}

/// Asserts a value near that of the reference.
#[track_caller]
fn near(row: &Row, name: &str, expected: f64, tolerance: f64) {
    let error = close(name, row.value(name), expected, tolerance);
    println!("{name}: {} ({error:.1e})", row.value(name));
}

#[test]
fn springs_have_the_forces_of_the_reference_at_the_default_step() {
    let row = pair(EXPONENTIAL, [4e-4, 4e-4]);
    near(&row, "max_contact_force_a_N", 493.309672326, 2e-6);
    near(&row, "max_contact_force_b_N", 493.309672326, 2e-6);
    near(&row, "end_speed_rad_s", 199.0380547497, 1e-6);
    assert!(row.value("energy_error") < 1e-7, "{}", row.value("energy_error"));
    let row = pair(EXPONENTIAL, [4e-4, 5.2e-4]);
    near(&row, "max_contact_force_a_N", 567.8801485, 2e-6);
    near(&row, "max_contact_force_b_N", 356.8355204, 2e-6);
    near(&row, "end_speed_rad_s", 199.1092753217, 1e-6);
    let mirrored = pair(EXPONENTIAL, [5.2e-4, 4e-4]);
    near(&mirrored, "max_contact_force_b_N", row.value("max_contact_force_a_N"), 1e-9);
    near(&mirrored, "max_contact_force_a_N", row.value("max_contact_force_b_N"), 1e-9);
    near(&mirrored, "end_speed_rad_s", row.value("end_speed_rad_s"), 1e-10);
}

/// Sums over the whole rub converge; a peak has an error from its distance to the nearest step.
#[test]
fn springs_converge_with_order_two() {
    let of = |step: f64| {
        let row = pair(&format!("{EXPONENTIAL}\ncontact_step = {step:?}"), [4e-4, 5.2e-4]);
        ["contact_impulse_a_Ns", "contact_impulse_b_Ns", "friction_energy_J"].map(|name| row.value(name))
    };
    let steps = [3.125e-5, 1.5625e-5, 7.8125e-6];
    let (rows, fine) = (steps.map(of), of(9.765_625e-7));
    for column in 0..3 {
        let error = |row: usize| (rows[row][column] / fine[column] - 1.0).abs();
        println!("{column}: {:.1e} {:.1e} {:.1e}", error(0), error(1), error(2));
        assert!(error(0) < 1e-4 && error(0) > 3.0 * error(1), "{column}: {:e} {:e}", error(0), error(1));
        assert!(error(1) > 3.0 * error(2) || error(2) < 1e-8, "{column}: {:e} {:e}", error(1), error(2));
    }
}

/// Text of the lab rig with rings of these names, positions and gaps in place of its own.
fn rig_text(of_run: &str, rings: &[(&str, f64, f64)]) -> String {
    with_rings(&study_machine("lab_rig"), of_run, rings)
}

fn rig(of_run: &str, rings: &[(&str, f64, f64)]) -> Machine {
    machine(&rig_text(of_run, rings))
}

/// Asserts that a diaphragm `far`, which is out of reach, changes no digit of the row.
fn same_digits(alone: &Row, both: &Row, name: &str) {
    assert!(alone.value("contact_impulse_Ns") > 0.0, "contact happened");
    assert_eq!(both.value("contact_impulse_far_Ns"), 0.0);
    assert_eq!(both.get("first_contact_far_s"), None);
    let (all, own) = (columns(&both.machine), format!("_{name}"));
    let has_own =
        |column: &str| all.iter().any(|other| other.name.contains(&own) && other.name.replace(&own, "") == column);
    let mut compared = 0;
    for (column, value) in all.iter().zip(&both.outcome.values) {
        let column = &*column.name;
        if column.contains("_far") || has_own(column) || column == format!("friction_energy{own}_J") {
            continue;
        }
        let expected = alone.get(&column.replace(&own, ""));
        assert_eq!(value.map(f64::to_bits), expected.map(f64::to_bits), "{column}: {value:?}, {expected:?}");
        compared += usize::from(value.is_some());
    }
    assert!(compared > 60, "{compared}");
}

#[test]
fn a_diaphragm_out_of_reach_changes_no_digit() {
    for detection in DETECTIONS {
        let of = |rings: &[(&str, f64, f64)]| {
            let of_run = format!("end_time = 0.17\n{EXPONENTIAL}\ncontact_step = 5e-6\nrotor_modes = 16");
            let text = rig_text(&of_run, rings);
            run(machine(&text.replace("\"hyp2\"", detection)))
        };
        let alone = of(&[("seal", 0.5, 5e-4)]);
        same_digits(&alone, &of(&[("seal", 0.5, 5e-4), ("far", 0.15, 5e-4)]), "seal");
        same_digits(&alone, &of(&[("far", 0.15, 5e-4), ("seal", 0.5, 5e-4)]), "seal");
    }
    let of_run = format!("{EXPONENTIAL}\ncontact_step = 5e-6");
    let of = |diaphragms: &str| run(rotor(&of_run, diaphragms));
    let (near, far) = (spring_seal("seal", 0.25, 4e-4), spring_seal("far", 0.75, 1e-2));
    let alone = of(&near);
    same_digits(&alone, &of(&(near.clone() + &far)), "seal");
    same_digits(&alone, &of(&(far + &near)), "seal");
}

/// Rings on both sides of the disc; both are touched within the first tenth of a second, after a release at 300 rad/s within half of that.
const RINGS: [(&str, f64, f64); 2] = [("a", 0.4, 3e-4), ("b", 0.6, 3.05e-4)];

/// Detections, with one point of contact and with several.
const DETECTIONS: [&str; 4] = ["\"hyp2\"", "\"hyp1\"", "\"hyp2-frozen\"", "\"hyp2\"\npoints = \"one\""];

/// The rig released at 300 rad/s.
fn at_300(text: String) -> String {
    let changed = text.replace("initial_speed = \"3000 rpm\"", "initial_speed = 300");
    assert_ne!(changed, text, "the speed is changed");
    changed
}

fn rings_of(engine: &str, detection: &str) -> Row {
    let text = at_300(rig_text(&format!("end_time = 0.08\n{engine}\nrotor_modes = 30"), &RINGS));
    let row = run(machine(&text.replace("\"hyp2\"", detection)));
    both_touch(&row);
    row
}

#[test]
fn two_flexible_rings_at_once_close_the_energy() {
    for detection in DETECTIONS {
        let row = rings_of(EXPONENTIAL, detection);
        println!("{detection}: energy error {:e}", row.value("energy_error"));
        assert!(row.value("energy_error") < 2e-7, "{detection}: {}", row.value("energy_error"));
        let of_both = |name: [&str; 2]| name.map(|name| row.value(name));
        let [a, b] = of_both(["contact_impulse_a_Ns", "contact_impulse_b_Ns"]);
        assert_eq!(row.value("contact_impulse_Ns"), a + b);
        let [a, b] = of_both(["max_contact_force_a_N", "max_contact_force_b_N"]);
        assert_eq!(row.value("max_contact_force_N"), a.max(b));
        let [a, b] = of_both(["first_contact_a_s", "first_contact_b_s"]);
        assert_eq!(row.value("first_contact_s"), a.min(b));
        let [a, b] = of_both(["friction_energy_a_J", "friction_energy_b_J"]);
        near(&row, "friction_energy_J", a + b, 1e-12);
    }
}

#[test]
fn two_flexible_rings_rub_as_in_the_reference_engines() {
    let row = rings_of(EXPONENTIAL, DETECTIONS[0]);
    for engine in ["full", "reduced"] {
        let other = rings_of(&format!("engine = \"{engine}\"\nstep = 1e-6"), DETECTIONS[0]);
        for name in ["contact_impulse_a_Ns", "contact_impulse_b_Ns", "max_bearing_load_N", "friction_energy_J"] {
            near(&row, name, other.value(name), 2e-3);
        }
        near(&row, "end_speed_rad_s", other.value("end_speed_rad_s"), 2e-4);
    }
}

/// Two rings beside a bearing table over the speed, against `reduced`.
#[test]
fn two_flexible_rings_rub_beside_a_bearing_table() {
    let of = |engine: &str| {
        let of_run = format!("end_time = 0.15\n{engine}\nrotor_modes = 30");
        let row = run(machine(&with_rings(&bearing_tables::rig(), &of_run, &RINGS)));
        both_touch(&row);
        row
    };
    let (row, reduced) = (of(EXPONENTIAL), of("engine = \"reduced\"\nstep = 1e-6"));
    assert!(row.value("energy_error") < 2e-7, "{}", row.value("energy_error"));
    for name in ["contact_impulse_a_Ns", "contact_impulse_b_Ns", "max_bearing_load_N", "friction_energy_J"] {
        near(&row, name, reduced.value(name), 2e-3);
    }
}

#[test]
fn two_flexible_rings_converge() {
    for detection in DETECTIONS {
        let of = |step: f64| {
            let row = rings_of(&format!("{EXPONENTIAL}\ncontact_step = {step:?}"), detection);
            ["contact_impulse_a_Ns", "contact_impulse_b_Ns", "max_bearing_load_N", "friction_energy_J"]
                .map(|name| row.value(name))
        };
        let (coarse, fine) = (of(3e-6), of(1.5e-6));
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            println!("{detection}: {coarse} {fine} {:.1e}", (coarse / fine - 1.0).abs());
            assert!((coarse / fine - 1.0).abs() < 1e-3, "{detection}: {coarse} {fine}");
        }
    }
}

/// Two close rings: the minima of one alternate between neighbouring ring points with the impulses at the other. These runs once ended with
/// `loss_of_uniqueness`.
#[test]
fn close_rings_settle_where_their_points_alternate() {
    for [one, other] in [[0.45, 0.55], [0.3, 0.31]] {
        let of = |engine: &str| {
            let of_run = format!("end_time = 0.05\nengine = \"{engine}\"");
            let text = rig_text(&of_run, &[("a", one, 3e-4), ("b", other, 3.02e-4)]);
            let row = run(machine(&text.replace("mass = \"10 g\"", "mass = \"25 g\"")));
            both_touch(&row);
            row
        };
        let (row, reduced) = (of("exponential"), of("reduced"));
        assert!(row.value("energy_error") < 2e-7, "{}", row.value("energy_error"));
        for name in ["contact_impulse_Ns", "max_bearing_load_N", "friction_energy_J"] {
            near(&row, name, reduced.value(name), 2e-3);
        }
        near(&row, "end_speed_rad_s", reduced.value("end_speed_rad_s"), 1e-4);
    }
}

/// A ring and a spring at once, in both orders of the file.
#[test]
fn a_ring_and_a_spring_touch_at_once() {
    let of = |is_ring_first: bool, engine: &str| {
        let text = at_300(rig_text(&format!("end_time = 0.08\n{engine}\nrotor_modes = 30"), &[("a", 0.4, 3e-4)]));
        let at = text.find("[diaphragms.a]").expect("has a ring");
        let spring = spring_seal("b", 0.6, 3.05e-4).replace("0.04", "0.02").replace("2e6", "2e5");
        let text = if is_ring_first { text + &spring } else { format!("{}{spring}{}", &text[..at], &text[at..]) };
        let row = run(machine(&text));
        both_touch(&row);
        row
    };
    let (row, other) = (of(true, EXPONENTIAL), of(false, EXPONENTIAL));
    assert!(row.value("energy_error") < 2e-7, "{}", row.value("energy_error"));
    let reduced = of(true, "engine = \"reduced\"\nstep = 1e-6");
    for name in ["contact_impulse_a_Ns", "contact_impulse_b_Ns", "max_bearing_load_N", "friction_energy_J"] {
        near(&other, name, row.value(name), 1e-6);
        near(&row, name, reduced.value(name), 3e-3);
    }
}

/// Sums of the forces on each diaphragm, and on those in frames.
#[derive(Default)]
struct Forces {
    impulses: [f64; 2],
    last: [f64; 2],
    seen: [u32; 2],
    energies: Vec<f64>,
}

impl Follower for Forces {
    fn contact_force(&mut self, diaphragm: usize, _time: f64, force: f64) {
        self.impulses[diaphragm] += force;
        self.last[diaphragm] = force;
    }
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        true
    }
    fn see(&mut self, frame: &Frame<'_>) {
        assert_eq!(frame.contacts.len(), 2);
        for (diaphragm, contact) in frame.contacts.iter().enumerate() {
            assert!(contact.field.is_some() && contact.rotor.iter().all(|part| part.is_finite()));
            if contact.normal_force > 0.0 {
                assert_eq!(contact.normal_force, self.last[diaphragm]);
                assert!(contact.gap < 1e-6, "{}", contact.gap);
                self.seen[diaphragm] += 1;
            }
        }
        self.energies.push(frame.energies.stored() + frame.energies.taken());
    }
}

#[test]
fn a_history_has_the_forces_of_each_diaphragm_and_changes_no_digit() {
    let of_run = format!("end_time = 0.03\n{EXPONENTIAL}\ncontact_step = 6e-6");
    let mut forces = Forces::default();
    let followed = run_seen(rig(&of_run, &RINGS), &mut forces);
    let alone = run(rig(&of_run, &RINGS));
    for (name, diaphragm) in [("contact_impulse_a_Ns", 0), ("contact_impulse_b_Ns", 1)] {
        assert!(forces.seen[diaphragm] > 10, "contact happened");
        close(name, 6e-6 * forces.impulses[diaphragm], followed.value(name), 1e-12);
    }
    assert_eq!(followed.outcome.values, alone.outcome.values);
    let first = forces.energies[0];
    let largest = forces.energies.iter().map(|energy| (energy / first - 1.0).abs()).fold(0.0, f64::max);
    println!("largest energy error of a frame: {largest:e}");
    assert!(largest < 1e-6, "{largest:e}");
}

/// The release and the rub of the shipped gas turbine on both nozzle rings. The values are those of `reduced` with a step of 1.3 us, 40 rotor
/// modes and 80 modes of each ring; docs/gas-turbine.md compares more engines and steps.
#[test]
fn the_shipped_gas_turbine_has_the_loads_of_reduced() {
    let changes = [("run.engine", "exponential"), ("run.end_time", "0.05 s")];
    let row = run(machine_with(&study_machine("gas_turbine"), &changes));
    for column in ["contact_impulse_nozzle_2_Ns", "contact_impulse_nozzle_3_Ns"] {
        assert!(row.value(column) > 300.0, "touches: {column} {}", row.value(column));
    }
    assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes);
    near(&row, "max_bearing_load_front_N", 256_225.0, 2e-3);
    near(&row, "max_bearing_load_rear_N", 183_431.0, 2e-3);
    near(&row, "max_pedestal_load_front_N", 347_633.0, 2e-3);
    near(&row, "max_displacement_front_oil_seal_m", 1.287801e-3, 2e-3);
    near(&row, "max_eccentricity_nozzle_3_m", 1.044777e-3, 2e-3);
    near(&row, "contact_impulse_nozzle_2_Ns", 412.2476, 1e-2);
    near(&row, "contact_impulse_nozzle_3_Ns", 375.7715, 1e-2);
    near(&row, "friction_energy_J", 29_191.2, 1e-2);
    assert!(row.value("energy_error") < 1e-6, "{}", row.value("energy_error"));
}
