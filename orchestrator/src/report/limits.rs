//! Where a run leaves what the model covers: said beside its result, since it may be consistent and still be that of another machine.

use super::OutcomeView;
use bladeoff_core::document::units::format_quantity;
use bladeoff_core::machine::{DiaphragmKind, Machine};
use bladeoff_core::structure::Structure;

/// Displacement of a ring, as a share of its radius, from which on its small-displacement equations are out of their range.
const SMALL: f64 = 0.05;
/// Part of a bearing's flexibility in the modes left out from which on its load under a sudden force is off by as much.
const WITHOUT_INERTIA: f64 = 0.05;

/// What to say of a run.
#[must_use]
pub fn beyond_the_model(machine: &Machine, structure: &Structure, view: OutcomeView<'_>) -> Vec<String> {
    ring_pushed(machine, view).into_iter().chain(bearings_without_inertia(machine, structure)).collect()
}

/// The rotor pushed a flexible ring further than its equations hold (`docs/theory/03-contact.md`).
fn ring_pushed(machine: &Machine, view: OutcomeView<'_>) -> Option<String> {
    let diaphragm = machine.diaphragms.first()?;
    let DiaphragmKind::Flexible(stator) = &diaphragm.kind else { return None };
    let pushed = view.value("max_eccentricity_m")? - diaphragm.contact.gap;
    let share = pushed / stator.ring.mean_radius;
    (share > SMALL).then(|| {
        format!(
            "note: the rotor pushed the ring {} out, {:.0} % of the ring's radius: beyond the small displacements that its equations hold for",
            format_quantity(pushed, "m"),
            100.0 * share
        )
    })
}

/// Bearings so stiff that most of what they yield is in modes left out (`docs/theory/05-reduction.md`).
fn bearings_without_inertia(machine: &Machine, structure: &Structure) -> Option<String> {
    let shares = structure.left_out_at_bearings();
    let named: Vec<String> = machine
        .rotor
        .bearings
        .iter()
        .zip(shares)
        .filter(|(_, share)| *share > WITHOUT_INERTIA)
        .map(|(bearing, share)| format!("{} ({:.0} %)", bearing.name, 100.0 * share))
        .collect();
    (!named.is_empty()).then(|| {
        format!(
            "note: modes left out hold that much of the flexibility at bearings {}: their loads follow a force at once, without swinging \
             beyond it after a sudden one; more `run.rotor_modes`, or `run.engine = \"full\"`, has the swing",
            named.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::machine::{MachineDef, ParamValue};
    use bladeoff_core::outcome::{CauseSet, Column, ColumnKind, EndCause, Outcome, Status};

    fn turbine(changes: &[(&str, f64)]) -> (Machine, Structure) {
        let text = include_str!("../../../studies/machines/lp_turbine.toml");
        let mut machine = MachineDef::parse("lp_turbine.toml", text).expect("valid");
        for (path, value) in changes {
            let path = machine.resolve(path).expect("a path");
            machine.set(&path, &ParamValue::Number(*value)).expect("allowed");
        }
        let machine = machine.build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        (machine, structure)
    }

    #[test]
    fn a_ring_pushed_too_far_is_said() {
        let (machine, structure) = turbine(&[]);
        let columns =
            [Column { name: "max_eccentricity_m".into(), unit: "m", kind: ColumnKind::Real, meaning: String::new() }];
        let noted = |eccentricity: f64| {
            let outcome = Outcome {
                status: Status::Ok,
                cause: None,
                causes: CauseSet::default(),
                end_cause: EndCause::EndTime,
                values: vec![Some(eccentricity)],
            };
            beyond_the_model(&machine, &structure, OutcomeView { columns: &columns, outcome: &outcome })
        };
        assert!(noted(9e-3).is_empty());
        let notes = noted(94e-3);
        assert!(notes.len() == 1 && notes[0].contains("86 mm") && notes[0].contains("radius"), "{notes:?}");
    }

    #[test]
    fn bearings_that_yield_in_modes_left_out_are_said() {
        let (machine, structure) = turbine(&[("rotor.bearings.rear.stiffness", 1e12)]);
        let note = bearings_without_inertia(&machine, &structure).expect("a rigid bearing");
        assert!(note.contains("rear (9") && !note.contains("front"), "{note}");
        let (machine, structure) = turbine(&[("rotor.bearings.rear.stiffness", 1e10)]);
        assert_eq!(bearings_without_inertia(&machine, &structure), None, "more modes are kept by default");
    }
}
