//! Limits of the physical model: the run that exceeds one, its row, and its end.

use crate::common::{Every, Row, machine_with, run, run_seen, study_machine};
use bladeoff_core::record::{Follower, Frame, columns};
use bladeoff_model::outcome::{Cause, EndCause, Status};

const ENGINES: [&str; 2] = ["reduced", "exponential"];
/// The lab rig until well after its first contact, at 22 ms.
const RUBS: [(&str, &str); 3] = [("run.end_time", "60 ms"), ("contact.gap", "0.4 mm"), ("contact.detection", "hyp2")];
const RING: &str = "run.limit.ring_displacement.value";
const ENDS: &str = "run.end_beyond";

fn machine_of(engine: &str, changes: &[(&str, &str)]) -> bladeoff_model::machine::Machine {
    machine_with(&study_machine("lab_rig"), &[&RUBS[..], &[("run.engine", engine)], changes].concat())
}

fn rig(engine: &str, changes: &[(&str, &str)]) -> Row {
    run(machine_of(engine, changes))
}

/// The largest eccentricity of the rig as a limit of the ring's displacement, times `share`.
fn ring_limit(engine: &str, share: f64) -> (Row, String) {
    let whole = rig(engine, &[]);
    assert_eq!(whole.outcome.status, Status::Ok);
    assert!(whole.get("first_contact_s").is_some(), "there is contact");
    let ratio = whole.value("limit_ratio_ring_displacement");
    assert!(ratio > 0.0 && ratio < 1.0 && whole.get("beyond_s").is_none(), "{ratio}");
    (whole, format!("{:e}", share * 0.05 * ratio))
}

#[test]
fn the_ratio_is_that_of_the_eccentricity_in_the_row() {
    for engine in ENGINES {
        let whole = rig(engine, &[]);
        let radius = 0.05;
        let machine = &whole.machine.diaphragms[0];
        let bladeoff_model::machine::DiaphragmKind::Flexible(stator) = &machine.kind else { panic!("a flexible ring") };
        let pushed = whole.value("max_eccentricity_m") - machine.contact.gap;
        assert!(pushed > 0.0, "the ring is pushed out");
        let expected = pushed / stator.ring.mean_radius / radius;
        crate::common::close("ratio", whole.value("limit_ratio_ring_displacement"), expected, 1e-9);
    }
}

#[test]
fn a_run_ends_at_the_first_exceeded_limit() {
    for engine in ENGINES {
        let (whole, limit) = ring_limit(engine, 0.5);
        let row = rig(engine, &[(RING, &limit)]);
        assert_eq!((row.outcome.status, row.outcome.cause), (Status::Beyond, Some(Cause::RingDisplacement)));
        assert_eq!((row.outcome.end_cause, row.outcome.notes.words()), (EndCause::Limit, None));
        let (beyond, end, step) = (row.value("beyond_s"), row.value("end_time_s"), row.value("step_s"));
        assert!(end >= beyond && end <= beyond + 1.01 * step, "{engine}: {beyond} {end}");
        assert!(end < whole.value("end_time_s"));
        assert!(row.value("limit_ratio_ring_displacement") > 1.0);
        assert!(row.value("max_bearing_load_N") <= whole.value("max_bearing_load_N"));
        // values up to the step that exceeds the limit count, including that step; the next instant, at which the run ends, may have larger loads
        for column in columns(&row.machine).iter().filter(|column| column.grows()) {
            let Some(guarded) = column.guarded() else { continue };
            let (guarded, value) = (row.get(&guarded).unwrap_or(0.0), row.get(&column.name).unwrap_or(0.0));
            assert!(guarded <= value && guarded >= 0.9 * value, "{engine}: {} {guarded} {value}", column.name);
        }
        assert_eq!(row.get("guarded_beyond_s"), row.get("beyond_s"), "{engine}");
        assert!(row.value("guarded_limit_ratio_ring_displacement") > 1.0);
        let reached = row.value("guarded_max_bearing_load_N");
        // a run that continues exceeds the limit at the same time, and its guarded values end there
        let on = rig(engine, &[(RING, &limit), (ENDS, "off")]);
        assert_eq!((on.outcome.status, on.outcome.end_cause), (Status::Beyond, EndCause::EndTime));
        assert_eq!(on.value("beyond_s"), beyond, "{engine}");
        assert_eq!(
            on.value("max_bearing_load_N"),
            whole.value("max_bearing_load_N"),
            "a limit does not change the motion"
        );
        assert_eq!(on.value("guarded_max_bearing_load_N"), reached, "{engine}: the same with and without an end");
        assert_eq!(on.get("guarded_max_eccentricity_m"), row.get("guarded_max_eccentricity_m"));
        assert_eq!(on.get("guarded_beyond_s"), row.get("beyond_s"));
        assert!(on.value("guarded_limit_ratio_ring_displacement") <= on.value("limit_ratio_ring_displacement"));
    }
}

/// Records the first time at which the rotor's eccentricity leaves a circle.
struct Leaves {
    radius: f64,
    first: Option<f64>,
}

impl Follower for Leaves {
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        true
    }
    fn see(&mut self, frame: &Frame<'_>) {
        let [x, y] = frame.contacts[0].rotor;
        if (x * x + y * y).sqrt() > self.radius && self.first.is_none() {
            self.first = Some(frame.time);
        }
    }
}

#[test]
fn the_time_of_a_limit_is_that_of_its_step_and_no_observer_moves_it() {
    for engine in ENGINES {
        let (_, limit) = ring_limit(engine, 0.3);
        let machine = machine_of(engine, &[(RING, &limit)]);
        let diaphragm = &machine.diaphragms[0];
        let bladeoff_model::machine::DiaphragmKind::Flexible(stator) = &diaphragm.kind else { panic!("a ring") };
        let value: f64 = limit.parse().expect("a number");
        let mut seen = Leaves { radius: diaphragm.contact.gap + value * stator.ring.mean_radius, first: None };
        let row = run(machine.clone());
        let followed = run_seen(machine, &mut seen);
        assert_eq!(row.outcome, followed.outcome, "{engine}: a follower changes nothing");
        let first = seen.first.expect("it leaves the circle");
        let apart = (first - row.value("beyond_s")).abs();
        assert!(apart <= 1.01 * row.value("step_s"), "{engine}: {apart}");
    }
}

#[test]
fn a_noted_limit_leaves_the_status_and_the_run() {
    for engine in ENGINES {
        let (whole, limit) = ring_limit(engine, 0.5);
        let row = rig(engine, &[(RING, &limit), ("run.limit.ring_displacement.on_exceed", "note")]);
        assert_eq!((row.outcome.status, row.outcome.cause), (Status::Ok, None));
        assert_eq!(row.outcome.notes.words().as_deref(), Some("ring_displacement"));
        assert_eq!(row.outcome.end_cause, EndCause::EndTime);
        assert!(row.get("beyond_s").is_none() && row.value("limit_ratio_ring_displacement") > 1.0);
        assert_eq!(row.value("max_bearing_load_N"), whole.value("max_bearing_load_N"));
    }
}

/// The rig with a clearance on its first bearing.
fn clearance(of: &str) -> String {
    let text = study_machine("lab_rig");
    let at = text.find("[rotor.bearings.").expect("a bearing");
    let line = at + text[at..].find('\n').expect("a line") + 1;
    format!("{}clearance = \"{of}\"\n{}", &text[..line], &text[line..])
}

#[test]
fn journals_are_noted_against_their_clearance_and_found_to_a_contact_step_in_free_motion() {
    let base = [("run.end_time", "60 ms"), ("contact.gap", "1.9 mm"), ("contact.detection", "hyp2")];
    let with = |engine: &str, changes: &[(&str, &str)]| {
        let changes = [&base[..], &[("run.engine", engine)], changes].concat();
        machine_with(&clearance("10 mm"), &changes)
    };
    let mut largest = Vec::new();
    for engine in ENGINES {
        // reference: every step of the motion
        let machine = with(engine, &[]);
        let node = machine.rotor.bearings[0].node;
        let structure = bladeoff_core::structure::Structure::build(&machine, None).expect("a structure");
        let [u, v] = structure.rotor.plane_places(node);
        let mut times = Vec::new();
        let row = run_seen(
            machine,
            &mut Every(|frame: &Frame<'_>| {
                let [x, y] = [frame.displacement[u], frame.displacement[v]];
                times.push((frame.time, (x * x + y * y).sqrt()));
            }),
        );
        assert!(row.get("first_contact_s").is_none(), "free motion");
        assert_eq!(row.outcome.status, Status::Ok);
        let ratio = row.value("limit_ratio_journal_clearance");
        let seen = times.iter().fold(0.0_f64, |most, (_, size)| most.max(*size));
        crate::common::close("journal", ratio * 10e-3, seen, 5e-3);
        largest.push(ratio);
        // early in the run, on a long free step, and close to the largest displacement
        for share in [0.3, 0.6, 0.95] {
            let allowed = share * ratio;
            let limits = [
                ("run.limit.journal_clearance.value", format!("{allowed:e}")),
                ("run.limit.journal_clearance.on_exceed", "beyond".to_owned()),
            ];
            let limits: Vec<(&str, &str)> = limits.iter().map(|(path, value)| (*path, value.as_str())).collect();
            let beyond = run(with(engine, &limits));
            assert_eq!((beyond.outcome.status, beyond.outcome.cause), (Status::Beyond, Some(Cause::JournalClearance)));
            let first = times.iter().find(|(_, size)| *size > allowed * 10e-3).expect("exceeded").0;
            let (time, step) = (beyond.value("beyond_s"), beyond.value("step_s"));
            assert!((first - time).abs() <= 1.01 * step, "{engine}, {share}: {first} {time}");
            assert_eq!(beyond.outcome.end_cause, EndCause::Limit);
            let end = beyond.value("end_time_s");
            assert!(end >= time && end <= time + 1.01 * step, "{engine}, {share}: {time} {end}");
            let noted = run(with(engine, &limits[..1]));
            assert_eq!(
                (noted.outcome.status, noted.outcome.notes.words().as_deref()),
                (Status::Ok, Some("journal_clearance"))
            );
        }
    }
    crate::common::close("journal of both engines", largest[1], largest[0], 1e-2);
}

#[test]
fn a_broken_guard_comes_before_a_limit() {
    let (_, limit) = ring_limit("reduced", 0.5);
    let row = rig("reduced", &[(RING, &limit), ("run.guard.energy_balance", "1e-14")]);
    assert_eq!((row.outcome.status, row.outcome.cause), (Status::Invalid, Some(Cause::EnergyBalance)));
    assert_eq!(row.outcome.causes.words().as_deref(), Some("energy_balance,ring_displacement"));
    assert!(row.get("beyond_s").is_some(), "known in an invalid row too");
}

#[test]
fn a_limit_without_its_quantity_is_null() {
    let row = rig("reduced", &[]);
    for limit in ["journal_clearance", "ring_yield", "blade_yield", "shaft_yield"] {
        assert_eq!(row.get(&format!("limit_ratio_{limit}")), None, "{limit}");
    }
}

#[test]
fn a_limit_of_what_the_machine_lacks_is_rejected() {
    for (limit, needed) in [
        ("ring_yield", "yield_strength"),
        ("blade_yield", "yield_strength"),
        ("shaft_yield", "yield_strength"),
        ("journal_clearance", "clearance"),
    ] {
        let text = format!("{}\n[run.limit.{limit}]\nvalue = 0.9\n", study_machine("lab_rig"));
        let problems = bladeoff_model::machine::MachineDef::parse("rig.toml", &text).and_then(|def| def.build());
        let problems = problems.expect_err("it would be ignored").to_string();
        assert!(problems.contains(limit) && problems.contains(needed), "{problems}");
    }
}
