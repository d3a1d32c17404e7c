//! A limit of the model that is exceeded near a light first touch: it is exceeded with any step, whether the run ends there or continues.

use crate::common::{Row, machine_with, run, run_seen, study_machine};
use bladeoff_core::record::{Follower, Frame, columns};
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, Status};

const YIELD: &str = "diaphragms.seal.material.yield_strength";
const STEP: &str = "run.contact_step";
const ENDS: &str = "run.end_beyond";

/// Times of the steps with a contact force.
#[derive(Default)]
struct Touches(Vec<f64>);

impl Follower for Touches {
    fn contact_force(&mut self, _diaphragm: usize, time: f64, force: f64) {
        if force > 0.0 {
            self.0.push(time);
        }
    }
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        false
    }
    fn see(&mut self, _frame: &Frame<'_>) {}
}

fn exponential(text: &str, changes: &[(&str, &str)]) -> Machine {
    machine_with(text, &[&[("run.engine", "exponential")], changes].concat())
}

/// The lab rig until 0.1 ms after its first contact.
fn rig(changes: &[(&str, &str)]) -> Row {
    run(exponential(&study_machine("lab_rig"), &[&[("run.end_time", "0.1457 s")], changes].concat()))
}

/// Asserts that a run that ends at its limit and one that continues have the same time of the limit and the same guarded values.
fn same_up_to_the_limit(ended: &Row, continued: &Row, what: &str) {
    for name in ["beyond_s", "guarded_beyond_s", "guarded_max_bearing_load_N", "guarded_contact_impulse_Ns"] {
        assert_eq!(ended.get(name), continued.get(name), "{what}: {name}");
    }
}

#[test]
fn a_light_first_touch_is_a_phase_of_its_own_with_fine_steps_alone() {
    for (step, seconds, phases) in [("2 us", 2e-6, 1), ("1 us", 1e-6, 2)] {
        let changes = [("run.end_time", "0.1457 s"), (STEP, step)];
        let mut touches = Touches::default();
        run_seen(exponential(&study_machine("lab_rig"), &changes), &mut touches);
        let Touches(times) = touches;
        assert!(times.len() > 50, "there is contact");
        let gaps = times.windows(2).filter(|pair| pair[1] - pair[0] > 2.5 * seconds).count();
        assert_eq!(gaps + 1, phases, "{step}");
        let first = times.windows(2).position(|pair| pair[1] - pair[0] > 2.5 * seconds);
        assert!(first.is_none_or(|last| last < 10), "the first touch is short: {first:?}");
    }
}

#[test]
fn a_limit_near_a_light_first_touch_is_exceeded_with_any_step() {
    for limit in ["0.8 MPa", "1 MPa", "1.2 MPa", "2 MPa"] {
        let at = |step: &str, ends: &str| rig(&[(YIELD, limit), (STEP, step), (ENDS, ends)]);
        let fine = at("0.1 us", "on").value("beyond_s");
        for (step, seconds) in [("6.2 us", 6.2e-6), ("1 us", 1e-6), ("0.5 us", 5e-7), ("0.25 us", 2.5e-7)] {
            let (ended, continued) = (at(step, "on"), at(step, "off"));
            assert_eq!((ended.outcome.status, ended.outcome.cause), (Status::Beyond, Some(Cause::RingYield)), "{step}");
            assert_eq!(
                (continued.outcome.status, continued.outcome.causes.contains(Cause::RingYield)),
                (Status::Beyond, true)
            );
            assert_eq!(ended.get("beyond_s"), ended.get("guarded_beyond_s"));
            same_up_to_the_limit(&ended, &continued, step);
            // a stress near the limit moves the time by the length of the touch
            let error = (ended.value("beyond_s") - fine).abs();
            assert!(error < 2.0 * seconds + 6e-6, "{limit}, {step}: {error}");
        }
    }
}

/// `short_impacts.toml` hits its ring in the first milliseconds and again 0.17 s later.
#[test]
fn a_run_that_continues_is_judged_at_its_limit_too() {
    let text = include_str!("../data/short_impacts.toml");
    let at =
        |limit: &str, step: &str, ends: &str| run(exponential(text, &[(YIELD, limit), (STEP, step), (ENDS, ends)]));
    // a limit within the first contact: the guards judge the whole run if it continues
    let (ended, continued) = (at("100 MPa", "1.4 us", "on"), at("100 MPa", "1.4 us", "off"));
    assert_eq!((ended.outcome.status, continued.outcome.cause), (Status::Beyond, Some(Cause::ModalBasis)));
    assert!(ended.value("steps_per_impact") < 20.0 && continued.value("steps_per_impact") > 20.0);
    same_up_to_the_limit(&ended, &continued, "100 MPa");
    assert!(ended.get("guarded_beyond_s").is_some());
    // a limit 0.17 s after impacts that the step does not resolve, and that the finest step exceeds in the first contact
    let (ended, continued) = (at("200 MPa", "6.9 us", "on"), at("200 MPa", "6.9 us", "off"));
    for row in [&ended, &continued] {
        assert!(row.value("beyond_s") > 0.17 && row.outcome.causes.contains(Cause::RingYield));
        assert_eq!(row.outcome.status, Status::Invalid);
        assert!(row.outcome.causes.contains(Cause::UnderResolved) && row.outcome.causes.contains(Cause::ModalBasis));
    }
    same_up_to_the_limit(&ended, &continued, "200 MPa");
    assert_eq!(ended.get("guarded_beyond_s"), None);
}

/// The ring with the largest friction energy over width at the limit is not that at the end.
#[test]
fn guarded_values_of_several_rings_are_those_at_the_limit() {
    let at = |ends: &str| {
        let limit = ("run.limit.ring_displacement.value", "2.4e-6");
        run(exponential(
            &study_machine("gas_turbine"),
            &[("run.end_time", "50 ms"), (STEP, "5 us"), limit, (ENDS, ends)],
        ))
    };
    let (ended, continued) = (at("on"), at("off"));
    assert!(ended.value("guarded_contact_impulse_Ns") > 0.0 && ended.value("end_time_s") < 0.01, "it ended in contact");
    let guarded: Vec<String> = columns(&ended.machine).iter().filter_map(|column| column.guarded()).collect();
    assert!(guarded.len() > 20);
    for name in guarded {
        assert_eq!(ended.get(&name), continued.get(&name), "{name}");
    }
}

/// The normal work of the first touch falls after the limit.
#[test]
fn a_guard_that_is_broken_at_the_limit_stays_broken() {
    let at = |limit: &str, ends: &str, guard: &str| {
        let changes = [("run.end_time", "0.1456 s"), ("run.guard.normal_work", guard)];
        rig(&[&changes[..], &[(YIELD, limit), (ENDS, ends)]].concat())
    };
    let is_broken = |row: &Row| row.outcome.causes.contains(Cause::NormalWork);
    // a guard that the normal work at the limit breaks and that at the end of a run without a limit does not
    let guards = (0..40).map(|k| format!("{:e}", 1e-9 * 1.5_f64.powi(k)));
    let mut between =
        guards.filter(|guard| is_broken(&at("1 MPa", "on", guard)) && !is_broken(&at("1 GPa", "on", guard)));
    let between = between.next().expect("the normal work falls after the limit");
    let (ended, continued) = (at("1 MPa", "on", &between), at("1 MPa", "off", &between));
    for row in [&ended, &continued] {
        assert!(row.value("contact_impulse_Ns") > 0.0, "there is contact");
        assert_eq!((row.outcome.status, row.outcome.cause), (Status::Invalid, Some(Cause::NormalWork)));
        assert_eq!(row.get("guarded_beyond_s"), None);
    }
}
