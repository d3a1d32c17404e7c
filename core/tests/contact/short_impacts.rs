//! Impacts shorter than the step can resolve: reported in the row and checked by a guard.

use bladeoff_core::engine::{resolved_time_step, simulate};
use bladeoff_core::record::{Follower, Frame, NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef};
use bladeoff_model::outcome::{Cause, EndCause, Status};

/// A rotor of 2.7 t that hits a stiff ring at 10 800 rpm: spikes of 33 us.
const HARD: &str = include_str!("../data/short_impacts.toml");
const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");

/// Machine and structure of a text with changes.
fn machine(text: &str, changes: &[(&str, &str)]) -> (Machine, Structure) {
    let mut def = MachineDef::parse("machine.toml", text).expect("a machine");
    for (path, value) in changes {
        let path = def.resolve(path).expect("a path");
        let value = def.parse_value(&path, value).expect("a value");
        def.set(&path, &value).expect("it can be set");
    }
    let machine = def.build().expect("a machine");
    let structure = Structure::build(&machine, None).expect("a structure");
    (machine, structure)
}

/// Status, whether the cause is `under_resolved`, steps per impact, impulse \[N s\], filtered force \[N\] and step \[s\].
fn run(text: &str, changes: &[(&str, &str)]) -> (Status, bool, [f64; 4]) {
    let (machine, structure) = machine(text, changes);
    let outcome = simulate(&machine, &structure, &mut NoHistory).expect("a run");
    let columns = columns(&machine);
    let value = |name: &str| {
        let place = columns.iter().position(|column| column.name == name).expect("a column");
        outcome.values[place]
    };
    assert!(value("contact_impulse_Ns").is_some_and(|impulse| impulse > 0.0), "there is contact");
    let found = ["steps_per_impact", "contact_impulse_Ns", "max_filtered_contact_force_N", "step_s"];
    let found = found.map(|name| value(name).expect("it touched"));
    (outcome.status, outcome.causes.contains(Cause::UnderResolved), found)
}

#[test]
fn a_coarse_step_is_invalid_and_a_fine_one_within_three_per_cent() {
    // converged at half of the finest step: 859 N s and 350 kN
    for (step, is_coarse) in [("6.9 us", true), ("2.3 us", true), ("0.8625 us", false)] {
        let (status, is_under_resolved, [steps, impulse, force, _]) = run(HARD, &[("run.contact_step", step)]);
        assert_eq!((status == Status::Invalid, is_under_resolved), (is_coarse, is_coarse), "{step}: {steps}");
        let errors = [impulse / 859.1 - 1.0, force / 350.0e3 - 1.0];
        assert_eq!(errors.iter().all(|error| error.abs() < 0.03), !is_coarse, "{step}: {errors:?}");
        // the values of a coarse step are lower bounds
        assert!(!is_coarse || errors.iter().all(|error| *error < 0.0), "{step}: {errors:?}");
    }
    let (status, is_under_resolved, _) = run(HARD, &[("run.engine", "reduced")]);
    assert_eq!((status, is_under_resolved), (Status::Invalid, true));
}

#[test]
fn a_default_step_becomes_finer_for_short_impacts() {
    let (status, _, [steps, impulse, force, step]) = run(HARD, &[]);
    assert_eq!(status, Status::Ok);
    // the default from the ring's modes is 6.9 us, with 7.6 steps per impact
    assert!((20.0..40.0).contains(&steps) && (6.9e-6 / 8.0..2e-6).contains(&step), "{steps} {step}");
    let errors = [impulse / 859.1 - 1.0, force / 350.0e3 - 1.0];
    assert!(errors.iter().all(|error| error.abs() < 0.035), "{errors:?}");
    // a run whose step is given has the same values at this step
    let given = run(HARD, &[("run.contact_step", &format!("{step} s"))]);
    assert_eq!(given, (status, false, [steps, impulse, force, step]));
    // a guard that no step satisfies: the step is an eighth of the default
    let (status, is_under_resolved, [.., step]) = run(HARD, &[("run.guard.impact_steps", "1000")]);
    assert_eq!((status, is_under_resolved, step), (Status::Invalid, true, 8.6e-7));
    // a disabled guard does not change the step
    let (status, _, [.., step]) = run(HARD, &[("run.guard.impact_steps", "0")]);
    assert_eq!((status, step), (Status::Ok, 6.9e-6));
}

/// A limit within the first impact is exceeded within two steps of the converged time, also with a step that resolves the impact badly: the forces
/// of such a step are too small, so what exceeds the limit with it exceeds it.
#[test]
fn a_limit_within_the_first_impact_is_exceeded_with_any_step() {
    let limit_time = |step: &str| {
        let changes = [("diaphragms.seal.material.yield_strength", "100 MPa"), ("run.contact_step", step)];
        let (machine, structure) = machine(HARD, &changes);
        let outcome = simulate(&machine, &structure, &mut NoHistory).expect("a run");
        assert!(outcome.causes.contains(Cause::RingYield) && outcome.end_cause == EndCause::Limit);
        assert_eq!(outcome.status, Status::Beyond);
        let place = columns(&machine).iter().position(|column| column.name == "beyond_s").expect("a column");
        outcome.values[place].expect("a limit is exceeded")
    };
    let fine = limit_time("0.43 us");
    for (text, step) in [("6.9 us", 6.9e-6), ("3.8 us", 3.8e-6), ("1 us", 1e-6)] {
        let error = (limit_time(text) - fine).abs();
        assert!(error < 2.0 * step, "{text}: {error}");
    }
}

/// Follower that records the times and contact forces shown to it.
#[derive(Default)]
struct Times {
    shown: Vec<f64>,
    touches: usize,
    begins_again: bool,
}

impl Follower for Times {
    fn contact_force(&mut self, _diaphragm: usize, _time: f64, force: f64) {
        self.touches += usize::from(force > 0.0);
    }
    fn wants(&mut self, step: u64, _time: f64) -> bool {
        step.is_multiple_of(1000)
    }
    fn begins_again(&self) -> bool {
        self.begins_again
    }
    fn see(&mut self, frame: &Frame<'_>) {
        self.shown.push(frame.time);
    }
}

#[test]
fn a_follower_sees_one_run_with_the_step_of_a_run_without_it() {
    let (machine, structure) = machine(HARD, &[("run.end_time", "30 ms")]);
    let alone = simulate(&machine, &structure, &mut NoHistory).expect("a run");
    let plan = resolved_time_step(&machine, &structure, &mut NoHistory).expect("a step");
    assert!(plan.step < 6.9e-6, "impacts are short: {}", plan.step);
    let mut once = Times::default();
    assert_eq!(simulate(&machine, &structure, &mut once).expect("a run"), alone);
    assert!(once.touches > 0 && once.shown.is_sorted_by(|before, after| before < after), "{:?}", once.shown);
    assert!((once.shown[1] - 1000.0 * plan.step).abs() < 1e-12);
    // a follower that begins again is shown each run
    let mut again = Times { begins_again: true, ..Times::default() };
    assert_eq!(simulate(&machine, &structure, &mut again).expect("a run"), alone);
    let starts = again.shown.iter().filter(|&&time| time == 0.0).count();
    assert!(starts > 1 && again.shown.ends_with(&once.shown), "{starts}");
}

#[test]
fn long_contact_is_resolved_far_above_the_guard() {
    for (engine, least) in [("exponential", 400.0), ("reduced", 800.0)] {
        let (status, is_under_resolved, [steps, ..]) = run(RIG, &[("run.engine", engine)]);
        assert_eq!((status, is_under_resolved), (Status::Ok, false), "{engine}");
        assert!(steps > least, "{engine}: {steps}");
    }
}
