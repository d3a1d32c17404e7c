//! Notes on bearings whose peak loads are those of the discretisation, not of the machine, from machine, modes and step before a run.

use bladeoff_core::engine::{LEAST_STEP, unresolved_damping};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_text::document::units::format_digits;

/// Share of a bearing's flexibility in truncated modes, or in motions faster than the step, above which its load under a sudden force is inaccurate by as much.
const WITHOUT: f64 = 0.05;
/// Limit of the same share for the flexibility of the shaft at a damper: up to here loads of rubs are off by 2 % (`docs/theory/05-reduction.md`).
const HELD: f64 = 0.1;

/// Kind of inaccuracy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Beyond {
    /// Most of the flexibility at a stiff bearing is in truncated modes.
    Stiff,
    /// The damper holds the bearing, and the flexibility of the shaft beside it is in truncated modes.
    Held,
    /// The step does not resolve the strong damping.
    Damped,
    /// The bearing is so stiff that motions contained in the modes are faster than the contact step.
    Fast,
}

/// Note on a bearing.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingNote {
    /// Kind of inaccuracy.
    pub beyond: Beyond,
    /// Name of the bearing.
    pub bearing: String,
    /// Severity, comparable within a kind: share of the flexibility, c dt/(2 m), or w dt.
    pub far: f64,
    /// Share of the bearing's flexibility that is affected, 0 to 1.
    pub share: f64,
    /// Step that resolves the motion \[s\]; infinite if no step does.
    pub step: f64,
    /// Whether truncated modes follow forces statically (residual flexibility).
    pub follows: bool,
}

/// Notes for the result of a run with (contact) step `step` \[s\], one line each.
#[must_use]
pub fn bearing_remarks(machine: &Machine, structure: &Structure, step: f64) -> Vec<String> {
    bearings_beyond(machine, structure, step).into_iter().map(|note| format!("note: {}", note.text())).collect()
}

/// Notes on the bearings of a run with (contact) step `step` \[s\]; `structure` must belong to the machine.
#[must_use]
pub fn bearings_beyond(machine: &Machine, structure: &Structure, step: f64) -> Vec<BearingNote> {
    let follows = structure.lateral_residual.is_some();
    let note = |beyond, bearing: &str, far, share, step| {
        let bearing = bearing.to_owned();
        BearingNote { beyond, bearing, far, share, step, follows }
    };
    let (stiff, held) = (structure.left_out_at_bearings(), structure.left_out_behind_dampers());
    let fast = match machine.run.engine {
        Engine::Exponential => structure.fast_at_bearings(1.0 / step),
        Engine::Reduced | Engine::Full => Vec::new(),
    };
    let may_rub = !machine.diaphragms.is_empty();
    let mut notes = Vec::new();
    for (place, bearing) in machine.rotor.bearings.iter().enumerate() {
        let name = bearing.name.as_str();
        if stiff[place] > WITHOUT {
            notes.push(note(Beyond::Stiff, name, stiff[place], stiff[place], f64::INFINITY));
        } else if held[place] > HELD && may_rub {
            notes.push(note(Beyond::Held, name, held[place], held[place], f64::INFINITY));
        }
        if let Some(&(share, highest)) = fast.get(place).filter(|(share, _)| *share > WITHOUT) {
            notes.push(note(Beyond::Fast, name, highest * step, share, 0.5 / highest));
        }
    }
    let damped = unresolved_damping(machine, structure, step);
    // rounded down, so that three digits never give too large a step
    notes.extend(damped.iter().map(|found| note(Beyond::Damped, &found.bearing, found.ratio, 1.0, 0.99 * found.step)));
    notes
}

impl BearingNote {
    /// Text of the note. Measurements: stiff and held bearings `docs/theory/05-reduction.md`, damping `04-time-integration.md`, fast motions
    /// `08-exponential-engine.md`.
    #[must_use]
    pub fn text(&self) -> String {
        let (name, share) = (&self.bearing, format!("{:.0} %", 100.0 * self.share));
        match self.beyond {
            Beyond::Stiff if !self.follows => format!(
                "{share} of the flexibility at bearing {name} is in truncated modes, and nothing replaces them (`run.static_residual = \"off\"`, or \
                 bearings of indefinite stiffness): its load lacks the part that they carry; use more \
                 `run.rotor_modes`, or `run.engine = \"full\"`"
            ),
            Beyond::Stiff => format!(
                "{share} of the flexibility at bearing {name} is in truncated modes: its load follows a force at \
                 once, without the overshoot after a sudden force (up to twice the force); more `run.rotor_modes`, or \
                 `run.engine = \"full\"`, include the overshoot"
            ),
            Beyond::Held => format!(
                "bearing {name} is damped so strongly that its damper holds the shaft during an impact, and {share} \
                 of the shaft's flexibility there is in truncated modes. Peaks of its load in rubs may be wrong, in \
                 heavy rubs several times too high. Use more `run.rotor_modes`, or `run.engine = \"full\"`, and compare"
            ),
            Beyond::Damped => format!(
                "the step does not resolve the damping of bearing {name}: c dt/(2 m) = {:.1} at its node, above 1; \
                 its response may oscillate from step to step, with peak bearing loads up to twice too high; {}",
                self.far,
                if self.step > LEAST_STEP {
                    format!("`run.step` below {} resolves it", format_digits(self.step, "s", 3))
                } else {
                    "no allowed `run.step` resolves it".to_owned()
                }
            ),
            Beyond::Fast => format!(
                "{share} of the flexibility at bearing {name} is in motions of up to {}, which the contact step does not resolve: peaks of its load may be \
                 missed by tens of per cent; use `run.contact_step` below {}, or `run.engine = \"reduced\"`",
                format_digits(0.25 / (std::f64::consts::PI * self.step), "Hz", 3),
                format_digits(self.step, "s", 2)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::engine::TimeStep;
    use bladeoff_model::machine::{MachineDef, ParamValue};

    /// Kinds and bearings of the notes on a machine with these changes.
    fn said(file: &str, engine: Engine, changes: &[(&str, f64)]) -> Vec<(Beyond, String, String)> {
        let mut machine = MachineDef::parse("m.toml", file).expect("valid");
        machine.settle(engine);
        for (path, value) in changes {
            let path = machine.resolve(path).expect("a path");
            machine.set(&path, &ParamValue::Number(*value)).expect("allowed");
        }
        let machine = machine.build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let time_step = TimeStep::new(&machine, &structure).expect("planned");
        let notes = bearings_beyond(&machine, &structure, time_step.step);
        notes.into_iter().map(|note| (note.beyond, note.bearing.clone(), note.text())).collect()
    }

    const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");
    const TURBINE: &str = include_str!("../../../studies/machines/lp_turbine_paper.toml");

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
        assert!(notes.len() == 1 && notes[0].2.contains("its load lacks the part"), "{notes:?}");
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
        assert!(beyond_any[0].2.contains("no allowed `run.step`"), "{beyond_any:?}");
        let notes = said(RIG, Engine::Full, &damped[1..]);
        let told = notes[0].2.split("below ").nth(1).and_then(|rest| rest.split(" us").next()).expect("a step");
        let step = 1e-6 * told.parse::<f64>().expect("a number");
        assert_eq!(said(RIG, Engine::Full, &[damped[1], ("run.step", step)]), []);
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
