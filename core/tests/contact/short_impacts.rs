//! Impacts shorter than the step resolves: stated in the row, and guarded.

use bladeoff_core::engine::simulate;
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::MachineDef;
use bladeoff_model::outcome::{Cause, Status};

/// A rotor of 2.7 t that hits a stiff ring at 10 800 rpm: spikes of 33 us.
const HARD: &str = include_str!("../data/short_impacts.toml");
const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");

/// Status, whether the cause is `under_resolved`, steps per impact, impulse \[N s\] and filtered force \[N\].
fn run(text: &str, changes: &[(&str, &str)]) -> (Status, bool, [f64; 3]) {
    let mut def = MachineDef::parse("machine.toml", text).expect("a machine");
    for (path, value) in changes {
        let path = def.resolve(path).expect("a path");
        let value = def.parse_value(&path, value).expect("a value");
        def.set(&path, &value).expect("it can be set");
    }
    let machine = def.build().expect("a machine");
    let structure = Structure::build(&machine, None).expect("a structure");
    let outcome = simulate(&machine, &structure, &mut NoHistory).expect("a run");
    let columns = columns(&machine);
    let value = |name: &str| {
        let place = columns.iter().position(|column| column.name == name).expect("a column");
        outcome.values[place]
    };
    assert!(value("contact_impulse_Ns").is_some_and(|impulse| impulse > 0.0), "there is contact");
    let found = ["steps_per_impact", "contact_impulse_Ns", "max_filtered_contact_force_N"];
    let found = found.map(|name| value(name).expect("it touched"));
    (outcome.status, outcome.causes.contains(Cause::UnderResolved), found)
}

#[test]
fn a_coarse_step_is_invalid_and_a_fine_one_within_three_per_cent() {
    // converged at half of the finest step: 859 N s and 350 kN
    for (step, is_coarse) in [("6.9 us", true), ("2.3 us", true), ("0.8625 us", false)] {
        let (status, is_under_resolved, [steps, impulse, force]) = run(HARD, &[("run.contact_step", step)]);
        assert_eq!((status == Status::Invalid, is_under_resolved), (is_coarse, is_coarse), "{step}: {steps}");
        let errors = [impulse / 859.1 - 1.0, force / 350.0e3 - 1.0];
        assert_eq!(errors.iter().all(|error| error.abs() < 0.03), !is_coarse, "{step}: {errors:?}");
    }
    let (status, is_under_resolved, _) = run(HARD, &[("run.engine", "reduced")]);
    assert_eq!((status, is_under_resolved), (Status::Invalid, true));
}

#[test]
fn long_contact_is_resolved_far_above_the_guard() {
    for (engine, least) in [("exponential", 400.0), ("reduced", 800.0)] {
        let (status, is_under_resolved, [steps, ..]) = run(RIG, &[("run.engine", engine)]);
        assert_eq!((status, is_under_resolved), (Status::Ok, false), "{engine}");
        assert!(steps > least, "{engine}: {steps}");
    }
}
