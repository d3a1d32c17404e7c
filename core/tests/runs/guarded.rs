//! Values that a run that is not `ok` had reached while all guards held.

use crate::common::{Row, machine, machine_with, run, study_machine};
use bladeoff_core::record::columns;
use bladeoff_model::outcome::{Cause, CauseSet, Column, Empty, Group, Growth, MAX_COLUMNS, Part, Status};

/// The lab rig until well after its first contact, at 22 ms.
const SHORT: [(&str, &str); 2] = [("run.end_time", "40 ms"), ("contact.gap", "0.4 mm")];

fn rig(changes: &[(&str, &str)]) -> Row {
    run(machine_with(&study_machine("lab_rig"), &[&SHORT, changes].concat()))
}

fn only(cause: Cause) -> CauseSet {
    let mut causes = CauseSet::default();
    causes.insert(cause);
    causes
}

/// Each column that grows in every machine and has a guarded column: name, value and guarded value.
fn guarded(row: &Row) -> Vec<(String, Option<f64>, Option<f64>)> {
    let of = |column: &Column| {
        let guarded = column.guarded()?;
        Some((column.name.clone(), row.get(&column.name), row.get(&guarded)))
    };
    let grows = |column: &&Column| column.grows() && column.empty == Empty::Absent;
    columns(&row.machine).iter().filter(grows).filter_map(of).collect()
}

/// Number of guarded values below those of the whole run; asserts that none is above.
fn below(row: &Row) -> usize {
    let all = guarded(row);
    assert!(all.len() > 8, "{}", all.len());
    for (name, value, guarded) in &all {
        let guarded = guarded.unwrap_or_else(|| panic!("{name} had reached nothing, not even zero"));
        assert!((0.0..=value.unwrap_or(0.0)).contains(&guarded), "{name}: {value:?}, {guarded}");
    }
    all.iter().filter(|(_, value, guarded)| guarded < value).count()
}

/// Number of steps of the longest run ended by a step limit in which every guard holds.
fn sound_steps(changes: &[(&str, &str)], steps: u64) -> u64 {
    let is_sound = |limit: u64| {
        let row = rig(&[changes, &[("run.step_limit", &limit.to_string())]].concat());
        assert_eq!(row.outcome.status, Status::Failed);
        row.outcome.causes == only(Cause::StepLimit)
    };
    let (mut sound, mut broken) = (1, steps);
    assert!(is_sound(sound) && !is_sound(broken));
    while broken - sound > 1 {
        let middle = sound.midpoint(broken);
        *if is_sound(middle) { &mut sound } else { &mut broken } = middle;
    }
    sound
}

/// The guarded values of a run are the values of one that its step limit ended at the last balance before the guard failed.
fn stands_as_if_it_had_ended_before(changes: &[(&str, &str)], cause: Cause) -> Row {
    let whole = rig(changes);
    assert_eq!((whole.outcome.status, whole.outcome.causes), (Status::Invalid, only(cause)));
    assert!(whole.get("first_contact_s").is_some(), "there is contact");
    assert!(below(&whole) > 4, "the guard broke before the end");
    let steps = sound_steps(changes, whole.value("steps") as u64 - 1);
    assert!(steps > 16, "and not at the start: {steps}");
    // the balance is checked with every eighth step, from step 0 on: step N is checked in a run of N + 1 steps
    let judged = (steps - 1) / 8 * 8 + 1;
    let ended = rig(&[changes, &[("run.step_limit", &judged.to_string())]].concat());
    for ((name, _, guarded), (other, reached, own)) in self::guarded(&whole).into_iter().zip(self::guarded(&ended)) {
        assert_eq!(name, other);
        assert_eq!(guarded, Some(reached.unwrap_or(0.0)), "{name}");
        assert_eq!(own, guarded, "{name} of the run that ended there: nothing broke in it");
    }
    whole
}

#[test]
fn an_energy_balance_that_breaks_leaves_what_was_reached_before() {
    let error = rig(&[]).value("energy_error");
    let bound = format!("{:e}", 0.3 * error);
    for engine in ["reduced", "full"] {
        // both engines have the same scheme and an error of the same size
        let changes = [("run.guard.energy_balance", bound.as_str()), ("run.engine", engine)];
        if engine == "reduced" {
            let whole = stands_as_if_it_had_ended_before(&changes, Cause::EnergyBalance);
            // a twin run changes none of these values
            let twin = rig(&[&changes[..], &[("run.twin", "1e-6")]].concat());
            assert!(twin.get("twin_status").is_some());
            assert_eq!(guarded(&twin), guarded(&whole));
        } else {
            let whole = rig(&changes);
            assert_eq!(whole.outcome.causes, only(Cause::EnergyBalance));
            assert!(below(&whole) > 4);
        }
    }
}

#[test]
fn a_penetration_counts_from_the_step_that_leaves_it() {
    let changes = [("contact.detection", "hyp2-frozen"), ("run.guard.penetration", "1e-6")];
    let whole = stands_as_if_it_had_ended_before(&changes, Cause::Penetration);
    let bound = 1e-6 * whole.machine.diaphragms[0].contact.gap;
    assert!(whole.value("residual_penetration_m") > bound);
    assert!(whole.value("guarded_residual_penetration_m") <= bound);
    assert!(whole.value("guarded_contact_impulse_Ns") > 0.0, "contacts before it are whole");
}

#[test]
fn a_normal_work_that_breaks_leaves_what_was_reached_before() {
    // at one instant of the run, because the work rises and falls
    let whole = rig(&[("run.guard.normal_work", "1e-13")]);
    assert!(whole.outcome.causes.contains(Cause::NormalWork), "{:?}", whole.outcome.causes.words());
    assert!(below(&whole) > 4);
}

#[test]
fn with_modes_that_cannot_carry_a_contact_nothing_counts_from_the_first_one_on() {
    let row = rig(&[("run.rotor_modes", "4")]);
    assert!(row.outcome.causes.contains(Cause::ModalBasis) && row.value("contact_impulse_Ns") > 0.0);
    for name in ["max_contact_force_N", "max_filtered_contact_force_N", "contact_impulse_Ns"] {
        assert_eq!(row.get(&format!("guarded_{name}")), Some(0.0), "{name}");
    }
    assert!(below(&row) > 4 && row.value("guarded_max_bearing_load_N") > 0.0);
}

#[test]
fn a_run_that_is_ok_has_none_of_it() {
    let row = rig(&[]);
    assert_eq!(row.outcome.status, Status::Ok);
    assert!(row.get("first_contact_s").is_some());
    let all = guarded(&row);
    assert!(all.len() > 8 && all.iter().all(|(_, value, guarded)| value.is_some() && guarded.is_none()), "{all:?}");
}

#[test]
fn a_run_that_fails_before_its_first_step_has_reached_nothing() {
    let mut machine = machine_with(&study_machine("lab_rig"), &[]);
    machine.run.step_limit = Some(0);
    let row = run(machine);
    assert_eq!((row.outcome.status, row.outcome.cause), (Status::Failed, Some(Cause::StepLimit)));
    assert!(guarded(&row).iter().all(|(_, _, guarded)| *guarded == Some(0.0)), "{:?}", guarded(&row));
}

/// A bearing that drives the whirl: the run diverges, and its last steps are meaningless.
#[test]
fn a_run_that_diverges_keeps_what_it_had_before() {
    let point = "schema = 1\nname = \"point\"\n[rotor]\nkind = \"point-mass\"\nmass = 1.0\npolar_inertia = 1.0\n\
        initial_speed = 50.0\n[rotor.initial]\ndisplacement = [0.01, 0.0]\n[rotor.bearings.support]\n\
        stiffness = [[1e4, 1e3], [-1e3, 1e4]]\ndamping = 1.0\n[run]\nend_time = 100.0\nstep = 1e-4\n";
    let row = run(machine(point));
    assert_eq!((row.outcome.status, row.outcome.cause), (Status::Failed, Some(Cause::Diverged)));
    let (load, guarded) = (row.value("max_bearing_load_N"), row.value("guarded_max_bearing_load_N"));
    assert!(0.0 < guarded && guarded < load, "{guarded} {load}");
    // quantities that the machine does not have are null
    for name in ["max_contact_force_N", "contact_impulse_Ns", "max_eccentricity_m", "max_torsional_moment_Nm"] {
        assert_eq!(row.get(&format!("guarded_{name}")), None, "{name}");
    }
}

#[test]
fn columns_say_which_of_them_grow_and_which_are_guarded() {
    let all = columns(&rig(&[]).machine);
    let column = |name: &str| all.iter().find(|column| column.name == name).unwrap_or_else(|| panic!("no {name}"));
    for name in ["max_bearing_load_left_N", "contact_impulse_Ns", "impacts", "contact_time_s", "end_time_s", "steps"] {
        assert!(column(name).grows(), "{name}");
    }
    for name in ["end_speed_rad_s", "max_bearing_load_at_s", "rub_regime", "energy_error"] {
        assert!(!column(name).grows() && column(name).guarded().is_none(), "{name}");
    }
    for column in &all {
        let Some(guarded) = column.guarded() else { continue };
        let found = self::guarded_column(&all, &guarded);
        assert!(
            column.growth != Growth::Free && found.growth == Growth::Free && found.guarded().is_none(),
            "{guarded}"
        );
        assert_eq!((found.unit, found.group, found.part), (column.unit, column.group, Part::Guarded));
        assert!(found.kind == column.kind && found.meaning.contains(&column.name), "{found:?}");
    }
    let guarded = all.iter().filter(|column| column.part == Part::Guarded).count();
    assert_eq!(guarded, all.iter().filter(|column| column.guarded().is_some()).count());
    for name in ["friction_energy_J", "friction_energy_per_width_J_m", "contact_time_s", "impacts", "beyond_s"] {
        assert!(column(name).guarded().is_some(), "{name}");
    }
    for column in all.iter().filter(|column| column.part == Part::Peak || column.name.starts_with("limit_ratio_")) {
        assert!(column.guarded().is_some(), "{}", column.name);
    }
    assert!(all.len() < MAX_COLUMNS && all[all.len() - guarded..].iter().all(|column| column.part == Part::Guarded));
    assert!(all.iter().any(|column| column.group == Group::Contact && column.part == Part::Guarded));
}

fn guarded_column<'a>(all: &'a [bladeoff_model::outcome::Column], name: &str) -> &'a bladeoff_model::outcome::Column {
    all.iter().find(|column| column.name == name).unwrap_or_else(|| panic!("no {name}"))
}

/// Two diaphragms: column names are unique, and each column has the values of its own diaphragm.
#[test]
fn columns_of_several_rings_carry_their_names() {
    let alone = rig(&[]);
    let mut machine = alone.machine.clone();
    let name = machine.diaphragms[0].name.clone();
    let mut wide = machine.diaphragms[0].clone();
    wide.name = "wide".to_owned();
    wide.contact.gap *= 20.0;
    machine.diaphragms.push(wide);
    let both = run(machine);
    let all = columns(&both.machine);
    let mut names: Vec<&str> = all.iter().map(|column| &*column.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all.len(), "no name stands twice");
    assert_eq!(both.outcome.values.len(), all.len());
    let own_columns = all.iter().filter(|column| column.name.contains(&format!("_{name}")));
    let mut compared = 0;
    for own in own_columns {
        let of_both = own.name.replace(&format!("_{name}"), "");
        // the other diaphragm is not touched: both columns equal those of the machine with this one alone
        for found in [&*own.name, &*of_both] {
            assert_eq!(both.get(found), alone.get(&of_both), "{found}");
        }
        compared += 1;
    }
    assert!(compared > 40, "{compared}");
    assert!(both.get(&format!("first_contact_{name}_s")).is_some());
    assert_eq!((both.get("first_contact_wide_s"), both.get("max_contact_force_wide_at_s")), (None, None));
    assert_eq!(both.get("max_eccentricity_wide_m"), alone.get("max_eccentricity_m"));
    assert!(names.contains(&&*format!("guarded_max_contact_force_{name}_N")) && names.contains(&"impacts_wide"));
}
