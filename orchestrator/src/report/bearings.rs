//! Bearings whose peak loads are not the machine's, whatever happens in a run: what machine, modes and step say of them before anything has moved.

use bladeoff_core::engine::{UnresolvedDamping, unresolved_damping};
use bladeoff_core::structure::Structure;
use bladeoff_model::document::units::format_digits;
use bladeoff_model::machine::{Engine, Machine};

/// Part of a bearing's flexibility in modes left out, or in motions faster than the step, from which on its load under a sudden force is off by as much.
const WITHOUT: f64 = 0.05;
/// The same of what the shaft yields where a damper holds it: up to here loads of rubs are off by 2 % (`docs/theory/05-reduction.md`).
const HELD: f64 = 0.1;
/// Shortest `run.step` \[s\].
const LEAST_STEP: f64 = 1e-10;

/// What is not right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Beyond {
    /// So stiff that most of what the bearing yields is in modes left out.
    Stiff,
    /// Held by its damper, and what the shaft yields beside it is in modes left out.
    Held,
    /// So strongly damped that the step does not resolve it.
    Damped,
    /// So stiff that motions which the modes have are faster than the contact step.
    Fast,
}

/// What to say of a bearing.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingNote {
    /// What is not right.
    pub beyond: Beyond,
    /// Name of the bearing.
    pub bearing: String,
    /// How far it is beyond: to be compared with others of the kind.
    pub far: f64,
    /// In words.
    pub text: String,
}

/// What to say of the bearings of a run with (contact) step `step` \[s\]; `structure` must fit the machine.
#[must_use]
pub fn bearings_beyond(machine: &Machine, structure: &Structure, step: f64) -> Vec<BearingNote> {
    let note = |beyond, bearing: &str, far, text| BearingNote { beyond, bearing: bearing.to_owned(), far, text };
    let (stiff, held) = (structure.left_out_at_bearings(), structure.left_out_behind_dampers());
    let fast = match machine.run.engine {
        Engine::Exponential => structure.fast_at_bearings(1.0 / step),
        Engine::Reduced | Engine::Full => Vec::new(),
    };
    let mut notes = Vec::new();
    for (place, bearing) in machine.rotor.bearings.iter().enumerate() {
        let name = bearing.name.as_str();
        if stiff[place] > WITHOUT {
            notes.push(note(Beyond::Stiff, name, stiff[place], left_out(structure, name, stiff[place])));
        } else if held[place] > HELD {
            notes.push(note(Beyond::Held, name, held[place], behind_its_damper(name, held[place])));
        }
        if let Some(&(share, highest)) = fast.get(place).filter(|(share, _)| *share > WITHOUT) {
            notes.push(note(Beyond::Fast, name, highest * step, faster(name, share, highest)));
        }
    }
    let damped = unresolved_damping(machine, structure, step);
    notes.extend(damped.into_iter().map(|found| note(Beyond::Damped, &found.bearing, found.ratio, ringing(&found))));
    notes
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// `docs/theory/05-reduction.md`.
fn left_out(structure: &Structure, name: &str, share: f64) -> String {
    let share = percent(share);
    if structure.lateral_residual.is_none() {
        return format!(
            "{share} of the flexibility at bearing {name} is in modes left out, and nothing stands for them (`run.static_residual = \"off\"`, or bearings of \
             indefinite stiffness): its load lacks it; more `run.rotor_modes`, or `run.engine = \"full\"`, has it"
        );
    }
    format!(
        "{share} of the flexibility at bearing {name} is in modes left out: its load follows a force at once, without swinging beyond it after a sudden one \
         (up to twice that); more `run.rotor_modes`, or `run.engine = \"full\"`, has the swing"
    )
}

/// `docs/theory/05-reduction.md`.
fn behind_its_damper(name: &str, share: f64) -> String {
    format!(
        "bearing {name} is damped so strongly that its damper holds the shaft in an impact, and {} of what the shaft yields there is in modes left out: \
         its loads in rubs may be wrong several times over; more `run.rotor_modes`, or `run.engine = \"full\"`, has them",
        percent(share)
    )
}

/// `docs/theory/08-exponential-engine.md`.
fn faster(name: &str, share: f64, highest: f64) -> String {
    let frequency = highest / (2.0 * std::f64::consts::PI);
    format!(
        "{} of the flexibility at bearing {name} is in motions of up to {}, which the contact step does not resolve: peaks of its load may be missed by \
         tens of per cent; `run.contact_step` below {}, or `run.engine = \"reduced\"`, has them",
        percent(share),
        format_digits(frequency, "Hz", 3),
        format_digits(0.5 / highest, "s", 2)
    )
}

/// `docs/theory/04-time-integration.md`: the peaks of its load may be those of the step.
fn ringing(found: &UnresolvedDamping) -> String {
    // in three digits, and never rounded to one that is too long
    let step = 0.99 * found.step;
    let resolved = if step > LEAST_STEP {
        format!("`run.step` below {}, or `run.engine = \"exponential\"`, resolves it", format_digits(step, "s", 3))
    } else {
        "no `run.step` that is allowed resolves it, `run.engine = \"exponential\"` does".to_owned()
    };
    format!(
        "the step does not resolve the damping of bearing {}: c dt/(2 m) = {:.1} at its node, above 1; what excites it may \
         ring from step to step, peak bearing loads up to twice too high; {resolved}",
        found.bearing, found.ratio
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::engine::StepPlan;
    use bladeoff_model::machine::{MachineDef, ParamValue};

    /// Kinds and bearings that are said of a machine with these changes.
    fn said(file: &str, engine: Engine, changes: &[(&str, f64)]) -> Vec<(Beyond, String, String)> {
        let mut machine = MachineDef::parse("m.toml", file).expect("valid");
        machine.settle(engine);
        for (path, value) in changes {
            let path = machine.resolve(path).expect("a path");
            machine.set(&path, &ParamValue::Number(*value)).expect("allowed");
        }
        let machine = machine.build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let plan = StepPlan::new(&machine, &structure).expect("planned");
        let notes = bearings_beyond(&machine, &structure, plan.step);
        notes.into_iter().map(|note| (note.beyond, note.bearing, note.text)).collect()
    }

    const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");
    const TURBINE: &str = include_str!("../../../studies/machines/lp_turbine.toml");

    #[test]
    fn of_the_shipped_machines_nothing_is_said() {
        for engine in [Engine::Exponential, Engine::Reduced, Engine::Full] {
            assert_eq!((said(RIG, engine, &[]), said(TURBINE, engine, &[])), (vec![], vec![]));
        }
    }

    #[test]
    fn bearings_that_yield_in_modes_left_out_are_said() {
        let notes = said(TURBINE, Engine::Reduced, &[("rotor.bearings.rear.stiffness", 1e12)]);
        let [(Beyond::Stiff, name, text)] = &notes[..] else { panic!("{notes:?}") };
        assert!(name == "rear" && text.starts_with("9") && text.contains("at bearing rear"), "{text}");
        assert_eq!(
            said(TURBINE, Engine::Reduced, &[("rotor.bearings.rear.stiffness", 1e10)]),
            [],
            "more modes are kept"
        );
        assert_eq!(said(TURBINE, Engine::Full, &[("rotor.bearings.rear.stiffness", 1e12)]), [], "all modes");
    }

    #[test]
    fn without_a_residual_loads_that_lack_it_are_said() {
        let off = TURBINE.replacen("end_time = ", "static_residual = \"off\"\nend_time = ", 1);
        let notes = said(&off, Engine::Reduced, &[("rotor.bearings.rear.stiffness", 1e12)]);
        assert!(notes.len() == 1 && notes[0].2.contains("its load lacks it"), "{notes:?}");
    }

    #[test]
    fn dampers_that_hold_the_shaft_are_said_and_more_modes_end_it() {
        for engine in [Engine::Exponential, Engine::Reduced] {
            let damped = [("rotor.bearings.left.damping", 1e5)];
            let kinds: Vec<_> = said(RIG, engine, &damped).into_iter().map(|note| (note.0, note.1)).collect();
            assert!(kinds.contains(&(Beyond::Held, "left".to_owned())), "{kinds:?}");
            let more = said(RIG, engine, &[damped[0], ("run.rotor_modes", 36.0)]);
            assert!(!more.iter().any(|note| note.0 == Beyond::Held), "{more:?}");
        }
    }

    #[test]
    fn every_bearing_that_the_step_does_not_resolve_is_said() {
        let damped = [("rotor.bearings.left.damping", 1e7), ("rotor.bearings.right.damping", 1e6)];
        let notes = said(RIG, Engine::Full, &damped);
        let names: Vec<&str> = notes.iter().filter(|note| note.0 == Beyond::Damped).map(|note| &*note.1).collect();
        assert_eq!(names, ["left", "right"]);
        assert!(!said(RIG, Engine::Exponential, &damped).iter().any(|note| note.0 == Beyond::Damped));
        let beyond_any = said(RIG, Engine::Full, &[("rotor.bearings.left.damping", 1e11)]);
        assert!(beyond_any[0].2.contains("no `run.step` that is allowed"), "{beyond_any:?}");
        let note = ringing(&UnresolvedDamping { bearing: "rear".into(), ratio: 5.418, step: 1.144e-7 });
        assert!(note.contains("bearing rear") && note.contains("= 5.4") && note.contains("below 0.113 us"), "{note}");
    }

    #[test]
    fn motions_faster_than_the_contact_step_are_said_with_one_that_has_them() {
        let stiff = [("rotor.bearings.right.stiffness", 1e11), ("run.rotor_modes", 36.0)];
        let notes = said(RIG, Engine::Exponential, &stiff);
        let [(Beyond::Fast, name, text)] = &notes[..] else { panic!("{notes:?}") };
        assert!(name == "right" && text.contains("2.32e5 Hz") && text.contains("below 0.34 us"), "{text}");
        let resolved = [stiff[0], stiff[1], ("run.contact_step", 3.3e-7)];
        assert_eq!(said(RIG, Engine::Exponential, &resolved), []);
        assert_eq!(said(RIG, Engine::Reduced, &stiff), [], "its step follows from them");
    }
}
