//! Impacts shorter than the step resolves, or than truncated modes follow: reported in the row and checked by guards.

use bladeoff_core::engine::{resolved_time_step, simulate};
use bladeoff_core::modal::ModeSet;
use bladeoff_core::record::{Follower, Frame, NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef};
use bladeoff_model::outcome::{Cause, EndCause, Status};

/// A rotor of 2.7 t that hits a stiff ring at 10 800 rpm: spikes of 33 us.
const HARD: &str = include_str!("../data/short_impacts.toml");
const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");
/// The lab rig whose rotor just reaches the ring: one contact of 0.4 ms.
const TOUCH: (&str, &str) = ("contact.gap", "1.3056 mm");
const STEPS: &str = "run.guard.impact_steps";

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

/// Status, whether `under_resolved` and `modal_basis` are causes, and steps per impact, impulse \[N s\], filtered force \[N\] and step \[s\].
fn run(text: &str, changes: &[(&str, &str)]) -> (Status, [bool; 2], [f64; 4]) {
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
    let causes = [Cause::UnderResolved, Cause::ModalBasis].map(|cause| outcome.causes.contains(cause));
    (outcome.status, causes, found)
}

#[test]
fn a_coarse_step_is_under_resolved_and_a_fine_one_within_three_per_cent() {
    // with the same modes, converged at half of the finest step: 859 N s and 350 kN
    for (step, is_coarse) in [("6.9 us", true), ("2.3 us", true), ("0.8625 us", false)] {
        let (_, [is_under_resolved, _], [steps, impulse, force, _]) = run(HARD, &[("run.contact_step", step)]);
        assert_eq!(is_under_resolved, is_coarse, "{step}: {steps}");
        let errors = [impulse / 859.1 - 1.0, force / 350.0e3 - 1.0];
        assert_eq!(errors.iter().all(|error| error.abs() < 0.03), !is_coarse, "{step}: {errors:?}");
        // the values of a coarse step are lower bounds
        assert!(!is_coarse || errors.iter().all(|error| *error < 0.0), "{step}: {errors:?}");
    }
    let (status, [is_under_resolved, _], _) = run(HARD, &[("run.engine", "reduced")]);
    assert_eq!((status, is_under_resolved), (Status::Invalid, true));
}

/// Impacts of 34 us on the static residual of ring modes above 2.1 kHz: the impulse is a third too large, with any step. Runs on `full`, and
/// on `reduced` with all modes, agree.
#[test]
fn impacts_that_truncated_modes_do_not_follow_are_invalid() {
    let first = ("run.end_time", "13 ms");
    let (status, _, [_, full, ..]) = run(HARD, &[first, ("run.engine", "full")]);
    assert_eq!(status, Status::Ok);
    let all = [first, ("run.ring_modes", "96"), ("run.rotor_modes", "44")];
    let (status, _, [_, impulse, ..]) = run(HARD, &[&all[..], &[("run.engine", "reduced")]].concat());
    assert_eq!(status, Status::Ok, "all modes are kept");
    assert!((impulse / full - 1.0).abs() < 0.03, "{impulse} {full}");
    // the fine steps of `exponential` with all modes are not trusted
    let (status, causes, [_, impulse, ..]) = run(HARD, &all);
    assert_eq!((status, causes), (Status::Invalid, [true, false]), "{impulse}");
    for (modes, step) in [("24", "1 us"), ("36", "0.43 us"), ("48", "0.43 us")] {
        let (status, [_, is_short], [_, impulse, ..]) =
            run(HARD, &[first, ("run.ring_modes", modes), ("run.contact_step", step)]);
        assert_eq!((status, is_short), (Status::Invalid, true), "{modes}");
        assert!(impulse / full > 1.15, "{modes}: {impulse} {full}");
    }
    // nothing of such an impact counts as reached while the guards held
    let (machine, structure) = machine(HARD, &[first, ("run.contact_step", "0.43 us")]);
    let outcome = simulate(&machine, &structure, &mut NoHistory).expect("a run");
    let place = columns(&machine).iter().position(|column| column.name == "guarded_contact_impulse_Ns");
    assert_eq!(outcome.values[place.expect("a column")], Some(0.0));
    // no finer step is tried, because it cannot help
    let (status, causes, [.., step]) = run(HARD, &[first]);
    assert_eq!((status, causes, step), (Status::Invalid, [true, true], 6.9e-6));
}

/// The share of the truncated modes is the explicit sum over them, taken from structures with all modes.
#[test]
fn the_share_of_short_impacts_is_the_sum_over_the_truncated_modes() {
    let (machine, few) = machine(RIG, &[("run.rotor_modes", "12"), ("run.ring_modes", "16")]);
    let all = self::machine(RIG, &[("run.rotor_modes", "36"), ("run.ring_modes", "64")]).1;
    let node = machine.diaphragms[0].contact.node;
    for length in [2e-5, 1e-4, 5e-4] {
        let square = (std::f64::consts::PI / length).powi(2);
        // error and flexibility at a degree of freedom, with the first `kept` modes kept
        let sums = |modes: &ModeSet, kept: usize, place: usize| {
            let mut sums = [0.0; 2];
            for (mode, omega) in modes.omega_squared.iter().enumerate() {
                let shape = modes.shapes[(place, mode)].powi(2);
                sums[1] += shape / (omega + square);
                if mode >= kept {
                    sums[0] += shape / omega * square / (omega + square);
                }
            }
            sums
        };
        let kept = |of: &Structure| (of.basis().lateral.omega_squared.len(), of.basis().rings[0].omega_squared.len());
        let ((lateral, ring), (all_lateral, all_ring)) = (kept(&few), kept(&all));
        assert!(lateral < all_lateral && ring < all_ring, "modes are truncated");
        let shaft = sums(&all.basis().lateral, lateral, all.rotor.plane_places(node)[0]);
        let nodes = all.rings[0].as_ref().expect("a flexible ring").matrices.nodes;
        let shares = (0..nodes).map(|node| {
            let ring = sums(&all.basis().rings[0], ring, 4 * node + 2);
            (shaft[0] + ring[0]) / (shaft[1] + ring[1])
        });
        let expected = shares.fold(0.0, f64::max).min(1.0);
        let found = few.share_of_impacts(&machine, 0, length);
        assert!(expected > 1e-4 && (found / expected - 1.0).abs() < 1e-3, "{length}: {found} {expected}");
        assert_eq!(all.share_of_impacts(&machine, 0, length), 0.0, "nothing is truncated");
    }
}

#[test]
fn a_default_step_becomes_finer_for_short_impacts() {
    let (status, _, [steps, _, _, step]) = run(RIG, &[TOUCH]);
    assert_eq!((status, step), (Status::Ok, 6.2e-6));
    assert!((40.0..100.0).contains(&steps), "{steps}");
    let (status, causes, [steps, impulse, force, step]) = run(RIG, &[TOUCH, (STEPS, "150")]);
    assert_eq!((status, causes), (Status::Ok, [false; 2]));
    assert!((150.0..300.0).contains(&steps) && (6.2e-6 / 8.0..4e-6).contains(&step), "{steps} {step}");
    let (.., [_, fine, ..]) = run(RIG, &[TOUCH, ("run.contact_step", "0.3 us")]);
    assert!((impulse / fine - 1.0).abs() < 1e-3, "{impulse} {fine}");
    // a run whose step is given has the same values at this step
    let given = run(RIG, &[TOUCH, (STEPS, "150"), ("run.contact_step", &format!("{step} s"))]);
    assert_eq!(given, (status, causes, [steps, impulse, force, step]));
    // a guard that no step satisfies: the step is an eighth of the default
    let (status, causes, [.., step]) = run(RIG, &[TOUCH, (STEPS, "100000")]);
    assert_eq!((status, causes, step), (Status::Invalid, [true, false], 7.7e-7));
    // a disabled guard does not change the step
    let (status, _, [.., step]) = run(RIG, &[TOUCH, (STEPS, "0")]);
    assert_eq!((status, step), (Status::Ok, 6.2e-6));
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
    let (machine, structure) = machine(RIG, &[TOUCH, (STEPS, "150")]);
    let alone = simulate(&machine, &structure, &mut NoHistory).expect("a run");
    let plan = resolved_time_step(&machine, &structure, &mut NoHistory).expect("a step");
    assert!(plan.step < 6.2e-6, "the step is finer than the default: {}", plan.step);
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
        let (status, causes, [steps, ..]) = run(RIG, &[("run.engine", engine)]);
        assert_eq!((status, causes), (Status::Ok, [false; 2]), "{engine}");
        assert!(steps > least, "{engine}: {steps}");
    }
}
