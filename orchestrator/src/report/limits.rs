//! Where a run leaves what the model covers: said beside its result, since it may be consistent and still be that of another machine.

use super::OutcomeView;
use super::bearings::bearings_beyond;
use bladeoff_core::record::pushed;
use bladeoff_core::structure::Structure;
use bladeoff_model::document::units::format_quantity;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine};
use bladeoff_model::outcome::Cause;

/// Displacement of a ring, as a share of its radius, from which on its small-displacement equations are out of their range.
pub const BEYOND_SMALL: f64 = 0.05;

/// What to say of a run with time step `step` \[s\].
#[must_use]
pub fn beyond_the_model(machine: &Machine, structure: &Structure, step: f64, view: OutcomeView<'_>) -> Vec<String> {
    let inside = !view.outcome.causes.contains(Cause::OutsideRing);
    let pushed = if inside { pushed_too_far(machine, &view.outcome.values) } else { Vec::new() };
    let bearings = bearings_beyond(machine, structure, step).into_iter().map(|note| format!("note: {}", note.text()));
    pushed.into_iter().chain(bearings).collect()
}

/// What to say of rings that a rotor which is inside them pushed too far, by the values of an outcome.
#[must_use]
pub fn pushed_too_far(machine: &Machine, values: &[Option<f64>]) -> Vec<String> {
    pushed_share(machine, values).into_iter().flatten().filter_map(|(way, share)| ring_pushed(way, share)).collect()
}

/// How far each flexible ring that was touched was pushed out \[m\], and which share of its radius that is, by the values of an outcome.
#[must_use]
pub fn pushed_share(machine: &Machine, values: &[Option<f64>]) -> Vec<Option<(f64, f64)>> {
    let share = |(diaphragm, way): (&Diaphragm, Option<f64>)| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => way.map(|way| (way, way / stator.ring.mean_radius)),
        _ => None,
    };
    machine.diaphragms.iter().zip(pushed(machine, values)).map(share).collect()
}

/// The rotor pushed a flexible ring further than its equations hold (`docs/theory/03-contact.md`). Only a ring that was touched was
/// pushed, and only by a rotor that is inside it. `way` \[m\].
fn ring_pushed(way: f64, share: f64) -> Option<String> {
    (share > BEYOND_SMALL).then(|| {
        format!(
            "note: the rotor pushed the ring {} out, {:.0} % of the ring's radius: beyond the small displacements that its equations hold for",
            format_quantity(way, "m"),
            100.0 * share
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::{Engine, MachineDef};
    use bladeoff_model::outcome::{CauseSet, EndCause, Outcome, Status};

    fn turbine() -> (Machine, Structure) {
        let text = include_str!("../../../studies/machines/lp_turbine.toml");
        let mut machine = MachineDef::parse("lp_turbine.toml", text).expect("valid");
        machine.settle(Engine::Reduced);
        let machine = machine.build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        (machine, structure)
    }

    #[test]
    fn a_ring_pushed_too_far_is_said() {
        let (machine, structure) = turbine();
        let columns = bladeoff_core::record::columns(&machine);
        let at = |name: &str| columns.iter().position(|column| column.name == name).expect("a column");
        let noted = |eccentricity: f64, touched: Option<f64>, cause: Option<Cause>| {
            let mut causes = CauseSet::default();
            cause.into_iter().for_each(|cause| causes.insert(cause));
            let mut values = vec![None; columns.len()];
            (values[at("max_eccentricity_m")], values[at("first_contact_s")]) = (Some(eccentricity), touched);
            let outcome = Outcome {
                status: if cause.is_some() { Status::Failed } else { Status::Ok },
                cause,
                causes,
                notes: CauseSet::default(),
                end_cause: EndCause::EndTime,
                values,
            };
            beyond_the_model(&machine, &structure, 1e-5, OutcomeView { columns: &columns, outcome: &outcome })
        };
        assert!(noted(9e-3, Some(3.0), None).is_empty());
        // nothing was pushed by a rotor that never touched, or that is not in the ring any more
        assert!(noted(94e-3, None, None).is_empty());
        assert!(noted(94e-3, Some(3.0), Some(Cause::OutsideRing)).is_empty());
        let notes = noted(94e-3, Some(3.0), None);
        assert!(notes.len() == 1 && notes[0].contains("86 mm") && notes[0].contains("radius"), "{notes:?}");
    }
}
