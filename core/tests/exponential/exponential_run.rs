//! Whole runs of the exponential engine: every column against the reduced engine, and the energy balance.

use crate::common::{Every, Row, machine_with, run, run_seen, study_machine};
use crate::exponential_rub::reduced_turbine;
use bladeoff_core::engine::{TimeStep, simulate};
use bladeoff_core::record::NoHistory;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};
use bladeoff_model::outcome::{EndCause, Status};

fn exponential(machine: Machine, step: f64) -> Row {
    run(of_engine(machine, step))
}

fn of_engine(mut machine: Machine, step: f64) -> Machine {
    machine.run.engine = Engine::Exponential;
    machine.run.contact_step = Some(step);
    machine
}

/// Asserts that columns agree, each within its relative tolerance.
#[track_caller]
fn agree(ours: &Row, reference: &Row, columns: &[(&str, f64)]) {
    let mut wrong = Vec::new();
    for (name, within) in columns {
        let (a, b) = (ours.value(name), reference.value(name));
        let error = if a.to_bits() == b.to_bits() { 0.0 } else { (a / b - 1.0).abs() };
        if error.is_nan() || error > *within {
            wrong.push(format!("{name}: {a} {b} {error:.1e}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

const COLUMNS: &[(&str, f64)] = &[
    ("first_contact_s", 1e-4),
    ("end_time_s", 1e-4),
    ("end_speed_rad_s", 1e-4),
    ("max_bearing_load_N", 2e-3),
    ("max_filtered_contact_force_N", 5e-3),
    ("contact_impulse_Ns", 3e-3),
    ("friction_energy_J", 3e-3),
    ("max_eccentricity_m", 1e-3),
    ("contact_time_s", 1e-2),
    ("rub_regime", 0.0),
    ("whirl_in_rub", 0.0),
    ("max_bending_stress_Pa", 5e-3),
    ("max_blade_bending_stress_Pa", 1e-2),
    ("max_ring_stress_Pa", 1e-2),
    ("max_blade_stress_Pa", 1e-2),
    ("max_shaft_von_mises_Pa", 1e-2),
    ("max_friction_power_W", 1e-2),
    ("friction_energy_per_width_J_m", 3e-3),
];

#[test]
fn every_column_of_a_rub_of_the_lab_rig_is_that_of_the_reduced_engine() {
    let change = [("run.end_time", "0.2 s")];
    let reference = run(machine_with(&study_machine("lab_rig"), &[change[0], ("run.step", "1.7e-6 s")]));
    let ours = exponential(machine_with(&study_machine("lab_rig"), &change), 1.7e-6);
    assert!(ours.value("impacts") > 0.0 && reference.value("impacts") > 0.0, "touches");
    agree(&ours, &reference, COLUMNS);
    assert!(ours.value("energy_error") < 1e-6, "{}", ours.value("energy_error"));
}

#[test]
fn every_column_of_a_rub_of_the_turbine_is_that_of_the_reduced_engine() {
    let change = [("run.end_time", "3.4 s")];
    let [_, reference] = reduced_turbine();
    let ours = exponential(machine_with(&study_machine("lp_turbine_paper"), &change), 1.25e-5);
    assert!(ours.value("impacts") > 0.0 && reference.value("impacts") > 0.0, "touches");
    let (ring, others): (Vec<_>, Vec<_>) = COLUMNS.iter().partition(|(name, _)| *name == "max_ring_stress_Pa");
    agree(&ours, reference, &others);
    // two contact points beside the foot of a blade share the force differently in each engine: the reference is a run with all ring modes
    let all_modes = [change[0], ("run.ring_modes", "10000")];
    let exact = exponential(machine_with(&study_machine("lp_turbine_paper"), &all_modes), 2.5e-6).value(ring[0].0);
    let errors = [&ours, reference].map(|row| row.value(ring[0].0) / exact - 1.0);
    println!("ring stress against all ring modes: {errors:?}, energy error {:e}", ours.value("energy_error"));
    assert!(errors.iter().all(|error| (0.0..0.08).contains(error)), "{errors:?}");
    assert!(ours.value("energy_error") < 1e-6, "{}", ours.value("energy_error"));
}

/// Static correction of impulse trains in torsional moments and ring stresses: without it torsional moments were 1 % too small on the rig and 2.8 % on the turbine, stresses of
/// the blades 0.4 and 1.2 %.
#[test]
fn moments_and_stresses_of_a_rub_do_not_hang_on_the_step() {
    for (name, end, [long, short], within) in
        [("lab_rig", "0.16 s", [6.2e-6, 8e-7], 4e-3), ("lp_turbine_paper", "3.2 s", [4.9e-5, 7e-6], 6e-3)]
    {
        let rub = |step: f64| exponential(machine_with(&study_machine(name), &[("run.end_time", end)]), step);
        let (ours, reference) = (rub(long), rub(short));
        assert!(ours.value("impacts") > 0.0 && reference.value("impacts") > 0.0, "{name} touches");
        agree(&ours, &reference, &[("max_torsional_moment_Nm", within), ("max_blade_bending_stress_Pa", within)]);
    }
}

/// Pairs of modes that come to rest within a step: a mean of the load before and after an impulse grew with the damping, to 3 kN.
#[test]
fn bearings_of_any_damping_have_the_loads_of_the_reduced_engine() {
    for damping in ["1e5", "1e6", "1e7"] {
        let change = [("run.end_time", "0.16 s"), ("rotor.bearings.left.damping", damping)];
        let ours = run(of_engine(machine_with(&study_machine("lab_rig"), &change), 3.4e-6));
        let mut reference = machine_with(&study_machine("lab_rig"), &change);
        reference.run.engine = Engine::Reduced;
        let reference = run(reference);
        assert!(ours.value("impacts") > 0.0 && reference.value("impacts") > 0.0, "touches");
        agree(&ours, &reference, &[("max_bearing_load_left_N", 1.5e-2), ("max_bearing_load_right_N", 1.5e-2)]);
    }
}

/// (Contact times count steps with a force: with 28 g both engines are 2.5e-3 apart at 0.85 us, where all else agrees to 2e-5. 35 and 35.5 g are between two ways on: their contact times scatter by a tenth between steps of either engine, and prove nothing. At 36 g the contact time is 1 % off at twice the step.)
/// Change of psi' by the impulses within their step, through strongly damped torsion: it must act on the lateral motion. Without it the spin after a hard rub was off
/// by 2e-5, of the last row by 5e-4 (its contact time by a sixth).
#[test]
fn hard_rubs_of_the_rig_end_as_on_the_reduced_engine() {
    for (mass, friction, step, speed, time) in [
        ("28 g", "0.3", 3.4e-6, 5e-6, 2e-3),
        ("40 g", "0.2", 3.4e-6, 8e-6, 1e-3),
        ("36 g", "0.3", 1.7e-6, 2.5e-4, 3e-3),
    ] {
        let change = [("run.end_time", "0.2 s"), ("blade_off.mass", mass), ("contact.friction", friction)];
        let fine = [&change[..], &[("run.step", "1.7e-6 s")]].concat();
        let reference = run(machine_with(&study_machine("lab_rig"), &fine));
        let ours = exponential(machine_with(&study_machine("lab_rig"), &change), step);
        assert!(ours.value("friction_energy_J") > 30.0 && reference.value("impacts") > 3.0, "a hard rub");
        let columns = [
            ("end_speed_rad_s", speed),
            ("contact_time_s", time),
            ("contact_impulse_Ns", 5e-4),
            ("friction_energy_J", 5e-4),
        ];
        agree(&ours, &reference, &columns);
        assert!(ours.value("energy_error") < 5e-6, "{mass}: {}", ours.value("energy_error"));
    }
}

#[test]
fn a_free_run_balances_its_energies() {
    for (name, step) in [("lp_turbine_paper", 4e-5), ("lab_rig", 5e-6)] {
        let mut machine = machine_with(&study_machine(name), &[("run.end_time", "0.5 s")]);
        machine.diaphragms.clear();
        let ours = exponential(machine, step);
        println!("{name}: energy error {:e}", ours.value("energy_error"));
        assert!(ours.value("energy_error") < 1e-6, "{name}: {}", ours.value("energy_error"));
    }
}

/// Energies of single frames, on bearings whose skew stiffness adds energy.
#[test]
fn energies_one_by_one_balance_on_skew_bearings() {
    let text = study_machine("lab_rig").replace("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 2e4], [-2e4, 2e6]]");
    assert_eq!(text.matches("[[2e6").count(), 2, "bearings are changed");
    let changes = [("run.end_time", "0.17 s")];
    let mut seen = Vec::new();
    let machine = of_engine(machine_with(&text, &changes), 3.4e-6);
    let row = run_seen(
        machine,
        &mut Every(|frame| seen.push((frame.energies.stored(), frame.energies.taken(), frame.energies.skew))),
    );
    assert!(row.value("impacts") > 0.0, "touches");
    let largest = seen.iter().map(|frame| frame.0).fold(0.0, f64::max);
    let start = seen[0].0 + seen[0].1;
    let error = seen.iter().map(|(stored, taken, _)| (stored + taken - start).abs()).fold(0.0, f64::max) / largest;
    let skew = seen.iter().map(|frame| frame.2.abs()).fold(0.0, f64::max) / largest;
    println!("energy error {error:.1e} of frames, {:.1e} of the row; skew {skew:.1e}", row.value("energy_error"));
    assert!(error < 5e-7 && skew > 3e-6, "{error} {skew}");
}

/// Energies at every step: in a whip (energy taken by damping, constant for up to seven steps, was an error of 2.7e-4) and in a rub with bounces.
#[test]
fn energies_of_shown_instants_balance() {
    for (gap, friction, end, eccentricity) in [("4 mm", "0.2", "1.15 s", 0.03), ("5 mm", "0.15", "0.5 s", 5e-3)] {
        let changes =
            [("run.end_time", end), ("contact.gap", gap), ("contact.friction", friction), ("run.end_beyond", "off")];
        let machine = of_engine(machine_with(&study_machine("lp_turbine_paper"), &changes), 4.9e-5);
        let (mut start, mut error, mut shown) = (None, 0.0_f64, 0);
        let row = run_seen(
            machine,
            &mut Every(|frame| {
                let sum = frame.energies.stored() + frame.energies.taken();
                error = error.max((sum / *start.get_or_insert(sum) - 1.0).abs());
                shown += 1;
            }),
        );
        assert!(row.value("max_eccentricity_m") > eccentricity && row.value("impacts") > 0.0, "rubs");
        assert!(f64::from(shown) > row.value("steps"), "instants in flights are among them");
        println!("{gap}: {error:.1e} of {shown} instants, {:.1e} of the row", row.value("energy_error"));
        assert!(error < 6e-7, "{gap}: {error}");
    }
}

/// Samples at the ends of free motions of 0.78 ms saw a mode of 640 Hz, which rings after each impact, always in the same phase (errors of 2.4e-6 and
/// 3.1e-6 of the energies). In a whip, with more samples while the spin falls, one part of each whirl was sampled more often than the rest (7.4e-6).
#[test]
fn bounces_and_whips_balance_their_energies() {
    for (gap, friction, end, limit) in
        [("5 mm", "0.15", "2 s", 5e-7), ("7 mm", "0.25", "6 s", 5e-7), ("4 mm", "0.2", "1.3 s", 1e-6)]
    {
        let changes = [("run.end_time", end), ("contact.gap", gap), ("contact.friction", friction)];
        let ours = exponential(machine_with(&study_machine("lp_turbine_paper"), &changes), 4.9e-5);
        assert!(ours.value("friction_energy_J") > 6e6 && ours.value("impacts") > 3.0, "rubs");
        let steps = ours.value("end_time_s") / ours.value("step_s");
        assert!(ours.value("steps") < 0.97 * steps, "{gap}: flies: {} of {steps}", ours.value("steps"));
        println!("{gap}: energy error {:e}", ours.value("energy_error"));
        assert!(ours.value("energy_error") < limit, "{gap}: {}", ours.value("energy_error"));
    }
}

/// Heavy unbalances in whips: the torque of the unbalance on the torsional modes is part of the predicted spin rate. Without it the energy error was 2.7e-5, of first order in the step.
#[test]
fn whips_with_heavy_unbalances_balance_their_energies() {
    for (mass, gap, friction, limit) in [("120 kg", "4 mm", "0.3", 8e-6), ("60 kg", "4 mm", "0.5", 6e-6)] {
        let changes = [
            ("run.end_time", "0.6 s"),
            ("run.end_beyond", "off"),
            ("blade_off.mass", mass),
            ("contact.gap", gap),
            ("contact.friction", friction),
        ];
        let ours = exponential(machine_with(&study_machine("lp_turbine_paper"), &changes), 4.86e-5);
        assert!(ours.value("friction_energy_J") > 1e7 && ours.value("contact_time_s") > 0.1, "{mass}: contact");
        assert!(ours.value("backward_whirl_time_s") > 0.1, "{mass}: a whip");
        println!("{mass}: energy error {:e}", ours.value("energy_error"));
        assert!(ours.value("energy_error") < limit, "{mass}: {:e}", ours.value("energy_error"));
    }
}

/// Normal impulses of a heavy unbalance without other losses, which would hide an error of the balance. It was 1.1e-6, of first order in the step.
#[test]
fn heavy_unbalances_without_damping_keep_their_energies() {
    let changes = [
        ("run.end_time", "0.42 s"),
        ("run.end_beyond", "off"),
        ("blade_off.mass", "120 kg"),
        ("contact.gap", "4 mm"),
        ("contact.friction", "0"),
        ("bearings.front.damping", "0 N s/m"),
        ("bearings.rear.damping", "0 N s/m"),
        ("rotor.damping.stiffness_proportional", "0 s"),
        ("braking.linear", "0 N m s"),
        ("braking.quadratic", "0 N m s2"),
        ("mid.damping.mass_proportional", "0 1/s"),
        ("mid.damping.stiffness_proportional", "0 s"),
    ];
    let ours = exponential(machine_with(&study_machine("lp_turbine_paper"), &changes), 4.8e-5);
    assert!(ours.value("contact_time_s") > 0.01, "contact");
    println!("energy error {:e}", ours.value("energy_error"));
    assert!(ours.value("energy_error") < 1e-7, "{:e}", ours.value("energy_error"));
}

/// The change of psi' by an impact acts on the rotor within the same step. When it acted from the next step on, the energies of these runs had errors
/// of 0.7e-5 to 2.2e-5, and rotors that the ring stops were `invalid`.
#[test]
fn rotors_that_their_ring_stops_keep_their_energies() {
    for (mass, friction) in [("40 g", "0.65"), ("60 g", "0.65"), ("40 g", "2"), ("60 g", "2")] {
        // the guard of the exponential engine, for both engines
        let changes = [
            ("run.end_time", "0.1 s"),
            ("blade_off.mass", mass),
            ("contact.friction", friction),
            ("run.guard.energy_balance", "1e-5"),
        ];
        let ours = exponential(machine_with(&study_machine("lab_rig"), &changes), 6.2e-6);
        assert_eq!(ours.outcome.end_cause, EndCause::Stopped, "{mass}, {friction}");
        println!("{mass}, {friction}: energy error {:e}", ours.value("energy_error"));
        assert_eq!(ours.outcome.status, Status::Ok, "{mass}, {friction}: {:?}", ours.outcome.causes.words());
        assert!(ours.value("energy_error") < 5.5e-6, "{mass}, {friction}: {:e}", ours.value("energy_error"));
    }
}

/// On anisotropic bearings, a slow spin turns planar modes into circular ones within some rad/s: with stations of 4 rad/s a whip lost 2e-4.
#[test]
fn whips_on_anisotropic_bearings_balance_their_energies() {
    let text = study_machine("lp_turbine_paper");
    for stiffness in ["[[6e8, 0.0], [0.0, 4e8]]", "[[6e8, 1e8], [1e8, 4e8]]"] {
        let changed = text.replacen("stiffness = \"6e8 N/m\"", &format!("stiffness = {stiffness}"), 1);
        assert_ne!(changed, text, "a bearing is changed");
        let changes =
            [("run.end_time", "1 s"), ("contact.gap", "4 mm"), ("contact.friction", "0.3"), ("run.end_beyond", "off")];
        let ours = exponential(machine_with(&changed, &changes), 4.9e-5);
        assert!(ours.value("backward_whirl_time_s") > 0.3 && ours.value("end_speed_rad_s") < 4.0, "whip");
        println!("{stiffness}: energy error {:e}", ours.value("energy_error"));
        assert!(ours.value("energy_error") < 4e-6, "{stiffness}: {:e}", ours.value("energy_error"));
    }
}

#[test]
fn a_run_of_a_few_steps_balances_its_energies() {
    for end in ["0.1 ms", "0.3 ms", "1 ms"] {
        let machine =
            machine_with(&study_machine("lp_turbine_paper"), &[("run.engine", "exponential"), ("run.end_time", end)]);
        let ours = run(machine);
        println!("{end}: {} steps, energy error {:e}", ours.value("steps"), ours.value("energy_error"));
        assert!(ours.value("steps") < 120.0 && ours.value("max_bearing_load_N") > 0.0);
        assert_eq!(ours.outcome.status, Status::Ok, "{end}: {:e}", ours.value("energy_error"));
    }
}

/// A machine that this engine does not cover is rejected at the key concerned, and the message names an engine that covers it.
#[test]
fn what_is_not_covered_is_refused_at_its_key() {
    let refused = |changes: &[(&str, &str)]| {
        let mut def = MachineDef::parse("rig.toml", &study_machine("lab_rig")).expect("parses");
        for (path, value) in changes {
            let info = def.resolve(path).expect("a path");
            let value = def.parse_value(&info, value).expect("a value");
            def.set(&info, &value).expect("in range");
        }
        def.build().expect_err("refused").to_string()
    };
    let engine = ("run.engine", "exponential");
    for (path, value) in [
        ("run.force_location", "current"),
        ("run.step", "1 us"),
        ("diaphragms.seal.blades.count", "0"),
        ("run.contact_step", "1 s"),
    ] {
        let said = refused(&[engine, (path, value)]);
        println!("{said}");
        let key = path.strip_prefix("contact.").map_or(path.to_owned(), |key| format!("diaphragms.seal.contact.{key}"));
        assert!(said.contains(&key), "{said}");
        assert!(said.contains("exponential") || path == "run.contact_step", "{said}");
    }
    let said = refused(&[("run.contact_step", "1 us"), ("run.engine", "reduced")]);
    assert!(said.contains("run.step, or run.engine = \"exponential\""), "{said}");
    // the message has the largest allowed step, which is accepted
    let of = |step: f64| of_engine(machine_with(&study_machine("lab_rig"), &[("run.end_time", "1 ms")]), step);
    let structure = Structure::build(&of(1e-6), None).expect("buildable");
    let plan = TimeStep::new(&of(1e-6), &structure).expect("small enough");
    assert!(TimeStep::new(&of(plan.largest_allowed()), &structure).is_ok());
    let error = TimeStep::new(&of(1.001 * plan.largest_step), &structure).expect_err("too large");
    assert!(error.to_string().starts_with("the contact step "), "{error}");
}

#[test]
fn heavy_rub_at_a_large_step_balances_its_energies() {
    let changes = [("run.end_time", "4 s"), ("contact.friction", "0.2")];
    let ours = exponential(machine_with(&study_machine("lp_turbine_paper"), &changes), 5e-5);
    assert!(ours.value("contact_time_s") > 0.3, "rubs");
    println!("energy error {:e}, normal work {:e}", ours.value("energy_error"), ours.value("normal_work_J"));
    assert!(ours.value("energy_error") < 2e-6, "{}", ours.value("energy_error"));
    assert!(ours.value("normal_work_J").abs() < 1e-3 * ours.value("friction_energy_J"));
}

/// Friction that drives the rotor into backward whip: dozens of millimetres, tens of meganewtons, contact along a fifth of the ring. (At 1.1 s the
/// motion still grows, and with half the step of the reduced engine, forces are 6 % larger there.) Limits: the change with half the contact step, and
/// twice the change with half the step of the reduced engine (docs/theory/08-exponential-engine.md).
#[test]
fn whip_is_that_of_the_reduced_engine() {
    // the guard of the exponential engine, for both engines
    let changes = [
        ("run.end_time", "1.6 s"),
        ("contact.gap", "4 mm"),
        ("contact.friction", "0.2"),
        ("run.guard.energy_balance", "1e-5"),
        // far beyond the validity of the model, for both engines
        ("run.limit.ring_displacement.on_exceed", "note"),
    ];
    let machine = || machine_with(&study_machine("lp_turbine_paper"), &changes);
    let ours = exponential(machine(), 2e-5);
    let mut reference = machine();
    reference.run.engine = Engine::Reduced;
    let theirs = run(reference);
    assert!(ours.value("backward_whirl_time_s") > 0.3 && ours.value("max_eccentricity_m") > 0.03, "whip");
    let limits = [
        ("max_contact_force_N", 1e-2),
        ("max_filtered_contact_force_N", 1e-2),
        ("contact_impulse_Ns", 1e-2),
        ("friction_energy_J", 1e-2),
        ("max_bearing_load_front_N", 1.5e-2),
        ("max_bearing_load_rear_N", 1.5e-2),
        ("max_eccentricity_m", 2e-2),
        ("backward_whirl_time_s", 1e-2),
    ];
    for (name, limit) in limits {
        let (ours, theirs) = (ours.value(name), theirs.value(name));
        println!("{name}: {ours:.4e} {theirs:.4e}, {:+.1e}", ours / theirs - 1.0);
        assert!((ours / theirs - 1.0).abs() < limit, "{name}: {ours} {theirs}");
    }
    println!("energy error {:.1e}, normal work {:.1e}", ours.value("energy_error"), ours.value("normal_work_J"));
    // forces of 10 MN that run around the ring penetrate it between the contact points by more than the guard allows
    let causes = ours.outcome.causes.words();
    assert!(matches!(causes.as_deref(), None | Some("penetration")), "{causes:?}");
    assert!(ours.value("energy_error") < 1e-5 && ours.value("normal_work_J") > 0.0);
}

/// The work of damping is computed over a whole step: the powers of mean rates missed 1.7e-4 and 4e-3 of the energies here.
#[test]
fn whips_on_strongly_damped_bearings_balance_their_energies() {
    for damping in ["5.8e4", "1e6"] {
        let changes =
            [("run.engine", "exponential"), ("rotor.initial.velocity[1]", "0.5"), ("bearings.right.damping", damping)];
        let ours = run(machine_with(&study_machine("lab_rig"), &changes));
        assert!(ours.value("backward_whirl_time_s") > 0.3, "whip: {}", ours.value("backward_whirl_time_s"));
        assert_eq!(ours.outcome.status, Status::Ok, "{:?}", ours.outcome.causes.words());
        assert!(ours.value("energy_error") < 1e-5, "{damping}: {:e}", ours.value("energy_error"));
    }
}

/// Friction of 0.5, far beyond small displacements of the ring: the rest of the run is bounded by the size of the turbine.
#[test]
fn whip_at_high_friction_is_bounded() {
    let changes =
        [("run.end_time", "4 s"), ("contact.friction", "0.5"), ("run.limit.ring_displacement.on_exceed", "note")];
    let ours = exponential(machine_with(&study_machine("lp_turbine_paper"), &changes), 2.7e-5);
    assert!(ours.value("max_eccentricity_m") > 0.05, "whip: {}", ours.value("max_eccentricity_m"));
    let (force, energy) = (ours.value("max_contact_force_N"), ours.value("friction_energy_J"));
    assert!(force < 1e8 && (2e7..3e7).contains(&energy), "{force} {energy}");
    assert!(ours.value("energy_error") < 1e-5, "{}", ours.value("energy_error"));
}

#[test]
fn a_run_ends_where_it_is_told_to() {
    let ends = |changes: &[(&str, &str)]| exponential(machine_with(&study_machine("lab_rig"), changes), 5e-6);
    let at_speed = ends(&[("run.end_time", "0.2 s"), ("run.end_speed", "290 rad/s")]);
    assert_eq!(at_speed.outcome.end_cause, EndCause::EndSpeed);
    assert!((at_speed.value("end_speed_rad_s") - 290.0).abs() < 0.1 && at_speed.value("end_time_s") < 0.2);
    let limited = ends(&[("run.step_limit", "100")]);
    assert_eq!((limited.outcome.status, limited.value("steps") as u64), (Status::Failed, 100));
    let stopped = ends(&[("run.end_time", "3 s"), ("braking.constant", "40 N m")]);
    assert_eq!(stopped.outcome.end_cause, EndCause::Stopped);
    assert!(stopped.value("end_speed_rad_s") == 0.0 && stopped.value("stop_time_s") > 0.0);
    let mut reference =
        machine_with(&study_machine("lab_rig"), &[("run.end_time", "3 s"), ("braking.constant", "40 N m")]);
    reference.run.engine = Engine::Reduced;
    let late = stopped.value("stop_time_s") - run(reference).value("stop_time_s");
    assert!(late.abs() < 1.1e-5, "{late}: two steps of 5 us, one of the reference");
}

#[test]
fn runs_that_share_bases_are_those_that_do_not() {
    let of = |friction: &str| {
        let changes = [("run.end_time", "0.16 s"), ("contact.friction", friction)];
        of_engine(machine_with(&study_machine("lab_rig"), &changes), 5e-6)
    };
    let (machine, other) = (of("0.1"), of("0.05"));
    let values = |machine: &Machine, structure: &Structure| {
        let outcome = simulate(machine, structure, &mut NoHistory).expect("covered");
        outcome.values.iter().map(|value| value.map(f64::to_bits)).collect::<Vec<_>>()
    };
    let build = || Structure::build(&machine, None).expect("buildable");
    let shared = build();
    let first = values(&other, &shared);
    let second = values(&machine, &shared);
    assert_eq!(second, values(&machine, &build()));
    assert_ne!(first, second, "friction counts");
    // from the third run on, the cells of the speed grid exist
    assert_eq!(first, values(&other, &shared));
    assert_eq!(second, values(&machine, &shared));
}

/// Initial speeds with different longest free motions, on one chain of stations.
#[test]
fn runs_from_other_speeds_leave_nothing_in_the_cells_they_share() {
    let of = |speed: &str| {
        let changes = [("run.end_time", "0.03 s"), ("rotor.initial_speed", speed)];
        of_engine(machine_with(&study_machine("lab_rig"), &changes), 3.4e-6)
    };
    let (slow, fast) = (of("340 rad/s"), of("348 rad/s"));
    let values = |machine: &Machine, structure: &Structure| {
        let outcome = simulate(machine, structure, &mut NoHistory).expect("covered");
        outcome.values.iter().map(|value| value.map(f64::to_bits)).collect::<Vec<_>>()
    };
    let build = || Structure::build(&slow, None).expect("buildable");
    let shared = build();
    let alone = [values(&fast, &build()), values(&slow, &build())];
    for _ in 0..3 {
        assert_eq!([values(&fast, &shared), values(&slow, &shared)], alone);
    }
}

/// A machine with a yield strength: a follower changes no bit, nor does the strength if stresses are far below it.
#[test]
fn yield_strengths_are_watched_whoever_follows() {
    let rub = |strength: &str, follower: &mut dyn bladeoff_core::record::Follower| {
        let change = [
            ("run.end_time", "0.16 s"),
            ("run.end_beyond", "off"),
            ("rotor.material.yield_strength", strength),
            ("diaphragms.seal.material.yield_strength", strength),
        ];
        let text = study_machine("lab_rig");
        run_seen(of_engine(machine_with(&text, &change), 3.4e-6), follower)
    };
    let alone = rub("20 MPa", &mut NoHistory);
    assert!(alone.value("impacts") > 0.0, "touches");
    assert_eq!(alone.outcome, rub("20 MPa", &mut Every(|_| {})).outcome);
    // exceeded during the rub, each at its own time
    for name in ["limit_ratio_ring_yield", "limit_ratio_shaft_yield", "limit_ratio_blade_yield"] {
        println!("{name} {:?}", alone.get(name));
    }
    assert!(alone.value("limit_ratio_ring_yield") > 1.0 && alone.get("beyond_s").is_some());
    let (far, none) = (rub("1e15 Pa", &mut NoHistory), {
        let change = [("run.end_time", "0.16 s"), ("run.end_beyond", "off")];
        run(of_engine(machine_with(&study_machine("lab_rig"), &change), 3.4e-6))
    });
    for name in ["max_ring_stress_Pa", "max_shaft_von_mises_Pa", "friction_energy_J", "steps"] {
        assert_eq!(far.get(name), none.get(name), "{name}");
    }
}
