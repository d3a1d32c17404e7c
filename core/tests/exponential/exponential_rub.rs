//! Contact of the exponential engine: against the reduced engine at a fine step, and against itself.

use crate::common::{Row, close, machine_with, run, study_machine};
use bladeoff_core::engine::exponential::{ExponentialError, RubbingRun, StepSettings, rubbing_run};
use bladeoff_core::structure::Structure;
use bladeoff_model::outcome::Status;
use std::sync::OnceLock;

fn rub(name: &str, changes: &[(&str, &str)], step: f64, flies: bool) -> RubbingRun {
    let machine = machine_with(&study_machine(name), changes);
    let structure = Structure::build(&machine, None).expect("buildable");
    let found = rubbing_run(&machine, &structure, StepSettings::of_step(step), flies).expect("goes on");
    assert!(found.first_contact.is_some() && found.impulse > 0.0, "touches");
    found
}

/// Asserts that each value is within its relative tolerance of that of the reduced engine, the function `fine` of a column.
#[track_caller]
fn near(found: &RubbingRun, fine: impl Fn(&str) -> f64, names: &[&str], within: [f64; 6]) {
    let mut loads = 0.0_f64;
    for (ours, name) in found.largest_loads.iter().zip(names) {
        loads = loads.max((ours / fine(&format!("max_bearing_load_{name}_N")) - 1.0).abs());
    }
    let of = |ours: f64, name: &str| (ours / fine(name) - 1.0).abs();
    let errors = [
        loads,
        of(found.largest_filtered_force, "max_filtered_contact_force_N"),
        of(found.impulse, "contact_impulse_Ns"),
        of(found.friction_energy, "friction_energy_J"),
        of(found.eccentricity, "max_eccentricity_m"),
        of(found.end_speed, "end_speed_rad_s"),
    ];
    for (k, (error, within)) in errors.iter().zip(within).enumerate() {
        assert!(
            *error < within,
            "{k} of loads, filtered, impulse, friction, eccentricity, speed: {errors:?}, allowed {within:.1e}"
        );
    }
}

/// The first 3.4 s of the turbine on the reduced engine, with steps of 27 and 13.5 us.
pub fn reduced_turbine() -> &'static [Row; 2] {
    static ROWS: OnceLock<[Row; 2]> = OnceLock::new();
    ROWS.get_or_init(|| {
        ["2.7e-5 s", "1.35e-5 s"].map(|step| {
            let change = [("run.end_time", "3.4 s"), ("run.step", step)];
            let row = run(machine_with(&study_machine("lp_turbine_paper"), &change));
            assert!(row.value("impacts") > 0.0, "touches");
            row
        })
    })
}

/// The reference is extrapolated from two steps of first order. It differs from that of 13.5 and 6.75 us by 2e-4 of the force, 2e-5 of the impulse and
/// 3e-5 of a load; a run with 3.4 us has errors of 2e-4, 4e-4 and 8e-5.
#[test]
fn one_long_rub_of_the_turbine_is_that_of_the_reduced_engine() {
    let [coarse, fine] = reduced_turbine();
    let exact = |name: &str| 2.0 * fine.value(name) - coarse.value(name);
    let names = ["front", "rear"];
    let change = [("run.end_time", "3.4 s")];
    near(&rub("lp_turbine_paper", &change, 1.25e-5, true), exact, &names, [3e-4, 1e-3, 1e-3, 1e-3, 2e-4, 5e-5]);
    near(&rub("lp_turbine_paper", &change, 5e-5, true), exact, &names, [1e-3, 3e-3, 2e-3, 2e-3, 4e-4, 5e-5]);
}

#[test]
fn the_lab_rig_rubs_as_in_the_reduced_engine() {
    let change = [("run.end_time", "0.2 s")];
    let fine = run(machine_with(&study_machine("lab_rig"), &[("run.end_time", "0.2 s"), ("run.step", "8.5e-7 s")]));
    assert!(fine.value("impacts") > 0.0, "touches");
    let fine = |name: &str| fine.value(name);
    near(&rub("lab_rig", &change, 3.4e-6, true), fine, &["left", "right"], [2e-3, 3e-3, 2e-3, 2e-3, 2e-4, 1e-4]);
}

#[test]
fn free_motion_misses_no_contact() {
    let change = [("run.end_time", "3.2 s")];
    let (flying, stepping) =
        (rub("lp_turbine_paper", &change, 5e-5, true), rub("lp_turbine_paper", &change, 5e-5, false));
    assert!(flying.steps[2] > 1000 && stepping.steps[2] == 0, "one flies");
    assert!((flying.impulse / stepping.impulse - 1.0).abs() < 2e-3, "{flying:?} {stepping:?}");
    assert!((flying.end_speed / stepping.end_speed - 1.0).abs() < 1e-6, "{flying:?} {stepping:?}");
    let first = |run: &RubbingRun| run.first_contact.expect("touches");
    assert!((first(&flying) - first(&stepping)).abs() < 2e-4, "{flying:?} {stepping:?}");
}

/// A release and the rub after it excite every mode: the loads of a run with steps of free motion are those of one with contact steps alone.
#[test]
fn peaks_of_free_motion_are_those_of_contact_steps() {
    for (name, end, step) in [("lab_rig", "0.16 s", 3.4e-6), ("lp_turbine_paper", "3.2 s", 5e-5)] {
        let change = [("run.end_time", end)];
        let (flying, stepping) = (rub(name, &change, step, true), rub(name, &change, step, false));
        assert!(flying.steps[2] > 1000 && stepping.steps[2] == 0, "one flies");
        let eccentricity = (flying.eccentricity, stepping.eccentricity);
        for (ours, all) in
            flying.largest_loads.iter().zip(&stepping.largest_loads).map(|(a, b)| (*a, *b)).chain([eccentricity])
        {
            println!("{name}: {ours} {all} {:.1e}", ours / all - 1.0);
            assert!((ours / all - 1.0).abs() < 1e-3, "{name}: {ours} {all}");
        }
    }
}

#[test]
fn contact_that_is_not_covered_is_refused_by_name() {
    let machine = machine_with(&study_machine("lab_rig"), &[("run.force_location", "current")]);
    let structure = Structure::build(&machine, None).expect("buildable");
    let refused = rubbing_run(&machine, &structure, StepSettings::of_step(1e-5), true).expect_err("refused");
    assert!(matches!(refused, ExponentialError::NotCovered { .. }), "{refused}");
}

/// Short form of the table in docs/theory/08-exponential-engine.md: with more cells between two stations, a rub approaches that of a fine grid.
#[test]
fn a_rub_converges_with_the_cells_of_the_grid() {
    let machine = machine_with(&study_machine("lp_turbine_paper"), &[("run.end_time", "3.4 s")]);
    let structure = Structure::build(&machine, None).expect("buildable");
    let of = |spacing: f64, cells: u32| {
        let settings = StepSettings { spacing: Some(spacing), cells, ..StepSettings::of_step(1.3e-5) };
        let found = rubbing_run(&machine, &structure, settings, true).expect("goes on");
        assert!(found.impulse > 0.0, "touches");
        found.impulse
    };
    let exact = of(0.5, 80);
    let errors = [2, 10].map(|cells| (of(1.0, cells) / exact - 1.0).abs());
    println!("impulse with 2 and 10 cells: {errors:?}");
    assert!(errors[1] < 0.5 * errors[0] && errors[1] < 1e-4, "{errors:?}");
}

/// Rings of more than 200 elements have a number of points that is not a multiple of the elements: 384 on 240 elements, and on 221 elements with 13
/// blades.
#[test]
fn rings_of_many_elements_rub_as_in_the_reduced_engine() {
    for (elements, blades) in [("elements = 240", "count = 8"), ("elements = 221", "count = 13")] {
        let text = study_machine("lab_rig").replace("elements = 16", elements).replace("count = 8", blades);
        assert!(text.contains(elements) && text.contains(blades));
        let of = |engine: &str| {
            let changes = [("run.engine", engine), ("run.end_time", "0.03 s"), ("blade_off.mass", "25 g")];
            let row = run(machine_with(&text, &changes));
            assert!(row.value("contact_impulse_Ns") > 1.0 && row.value("impacts") >= 2.0, "contact happened");
            assert_eq!(row.outcome.status, Status::Ok, "{engine}: {:?}", row.outcome.causes.words());
            row
        };
        let [ours, reduced] = ["exponential", "reduced"].map(of);
        for name in [
            "contact_impulse_Ns",
            "friction_energy_J",
            "max_bearing_load_N",
            "max_filtered_contact_force_N",
            "end_speed_rad_s",
        ] {
            let error = close(name, ours.value(name), reduced.value(name), 4e-3);
            println!("{elements}: {name} {error:.1e}");
        }
    }
}
