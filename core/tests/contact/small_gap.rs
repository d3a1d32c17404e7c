//! Contacts with a gap so small that the last digit of the radii matters.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{close, machine_with, run, study_machine};
use bladeoff_model::outcome::{Cause, Status};

/// Impulses of a rig by every method of solving the contact, against the full engine with the most accurate method for the same gap.
fn solve_in_every_way(what: &str, changes: &[(&str, &str)]) {
    for (kind, ways) in
        [("hyp1", &[("hyp1", "one")][..]), ("hyp2", &[("hyp2", "several"), ("hyp2", "one"), ("hyp2-frozen", "one")])]
    {
        let mut reference = None;
        for engine in ["full", "reduced"] {
            for (detection, points) in ways {
                let way = [("run.engine", engine), ("contact.detection", detection), ("contact.points", points)];
                let row = run(machine_with(&study_machine("lab_rig"), &[changes, &way].concat()));
                let impulse = row.value("contact_impulse_Ns");
                let steps = row.value("contact_time_s") / row.value("step_s");
                assert!(impulse > 0.0 && steps > 100.0, "contact happened");
                let reference = *reference.get_or_insert(impulse);
                let error = close(&format!("{what}, {kind}"), impulse, reference, 0.01);
                println!(
                    "{what}: {engine} {detection} {points}: {:?}, impulse {impulse:.6}, {error:.1e}, {} of {steps:.0} steps without fixed point",
                    row.outcome.causes.words(),
                    row.value("no_fixed_point_steps"),
                );
                // one point leaves penetration: with the longer step of the reduced engine more than the guard allows, which the row reports
                let only_deep =
                    row.outcome.cause == Some(Cause::Penetration) && engine == "reduced" && *points == "one";
                assert!(row.outcome.status == Status::Ok || only_deep, "{:?}", row.outcome.causes.words());
                assert!(row.outcome.status != Status::Failed);
                // steps without a fixed point are solved with several points, hardly ever with the predicted place
                let (without, with) = (row.value("no_fixed_point_steps"), row.value("several_points_steps"));
                assert!(*points == "one" || without <= 1.02 * with, "{without} {with}");
                // Hyp 1 has one place for each rotor centre, so every step has a fixed point
                assert!(*detection != "hyp1" || row.value("no_fixed_point_steps") == 0.0);
            }
        }
    }
}

#[test]
fn a_small_gap_settles_in_both_engines() {
    solve_in_every_way("10 um", &[("contact.gap", "10 um"), ("run.end_time", "0.012")]);
}

/// A single contact place leaves the penetration caused by its motion within a step, and it moves faster with a smaller gap. The full engine is
/// within the guard because of its short step, as is the reduced engine with that step. Several points leave almost none at any step.
#[test]
fn what_a_single_place_leaves_goes_with_the_step() {
    let frozen = [("contact.detection", "hyp2-frozen"), ("contact.points", "one")];
    let several = [("contact.detection", "hyp2"), ("contact.points", "several")];
    let left = |way: &[(&str, &str)], more: &[(&str, &str)]| {
        let changes = [&[("contact.gap", "10 um"), ("run.end_time", "0.012")], way, more].concat();
        let row = run(machine_with(&study_machine("lab_rig"), &changes));
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        let depth = row.value("residual_penetration_m");
        println!("{way:?} {more:?}: step {:e}, {depth:.2e} m, {:?}", row.value("step_s"), row.outcome.causes.words());
        (depth, row.outcome.cause, row.value("step_s"))
    };
    let (deep, cause, step) = left(&frozen, &[]);
    assert!(deep > 0.02 * 1e-5 && cause == Some(Cause::Penetration), "the guard holds: {deep}");
    let (full, cause, full_step) = left(&frozen, &[("run.engine", "full")]);
    assert!(full < 0.02 * 1e-5 && cause.is_none() && full_step < 0.5 * step, "{full}");
    let (same, cause, _) = left(&frozen, &[("run.step", &format!("{full_step:e}"))]);
    assert!(same < 0.3 * deep && cause.is_none(), "{same}");
    let (points, cause, _) = left(&several, &[]);
    assert!(points < 1e-2 * deep && cause.is_none(), "{points}");
}

#[test]
fn a_stiff_rotor_in_a_tiny_gap_settles_in_both_engines() {
    let changes = [
        ("contact.gap", "1 um"),
        ("run.end_time", "0.004"),
        ("rotor.shaft[0].diameter", "80 mm"),
        ("rotor.shaft[1].diameter", "80 mm"),
        ("rotor.shaft[2].diameter", "80 mm"),
        ("bearings.left.stiffness", "1e9"),
        ("bearings.right.stiffness", "1e9"),
    ];
    solve_in_every_way("stiff, 1 um", &changes);
}
