//! `bladeoff check --json`: a study or a machine as JSON.

use super::answer::understood;
use super::error::CliError;
use super::estimate::Estimate;
use super::json::pretty;
use crate::html_report::{assumed, assumed_of_machine, bearings_of, reservations_of, unstable_of};
use crate::plausible::{implausible_of, unreleased_of};
use bladeoff_answers::ask::in_words;
use bladeoff_core::modal::equilibrium;
use bladeoff_model::machine::{Machine, MachineDef};
use bladeoff_study::{Origin, Parameter, Samples, fixed_angle, idle_levels, show};
use bladeoff_system::shown;
use serde_json::{Value, json};

/// The output of `check` for a study as JSON, without the contact forecast. A study of formulas has no estimate of its duration.
pub(super) fn of_study(samples: &Samples) -> Result<String, CliError> {
    let study = samples.study();
    let asked = understood(samples, &study.file, &study.text, &study.asked)?;
    let fixed = study.machine().map(|machine| machine.fixed.as_slice()).unwrap_or_default();
    let fixed: Vec<Value> = fixed
        .iter()
        .map(|fixed| json!({ "path": fixed.info.path, "value": show(&fixed.info, &fixed.value) }))
        .collect();
    let formulas = study.function().map(|model| {
        model.outputs.iter().map(|output| json!({ "name": output.name, "formula": output.text })).collect::<Vec<_>>()
    });
    let design = samples.layout().map(
        |layout| json!({ "kind": layout.kind().word(), "points": samples.points(), "replicates": layout.replicates() }),
    );
    let parameters = study.parameters().iter().enumerate().map(|at| parameter(samples, at)).collect::<Vec<_>>();
    let mut notes = idle_levels(samples);
    notes.extend(fixed_angle(samples).map(|found| found.text()));
    notes.extend(bearings_of(samples));
    notes.extend(unreleased_of(samples));
    notes.extend(reservations_of(samples).into_iter().map(|one| one.text));
    let warnings = [implausible_of(samples), unstable_of(samples)].concat();
    let estimate = if study.function().is_some() { Value::Null } else { Estimate::of(samples)?.json() };
    Ok(pretty(&json!({
        "study": study.name,
        "samples": samples.count(),
        "machine": study.machine().map(|_| shown(study.subject_name())),
        "formulas": formulas,
        "engine": study.engine().map(|choice| choice.engine.word()),
        "design": design,
        "combinations": samples.groups().len(),
        "parameters": parameters,
        "correlations": study.sampled.correlated,
        "fixed": fixed,
        "questions": asked.questions.iter().map(in_words).collect::<Vec<_>>(),
        "gates": asked.gates.iter().map(|gate| json!({ "require": gate.text, "confidence": gate.confidence })).collect::<Vec<_>>(),
        "assumptions": assumed(samples),
        "notes": notes,
        "warnings": warnings,
        "estimate": estimate,
    })))
}

/// A parameter that differs between samples.
fn parameter(samples: &Samples, (number, parameter): (usize, &Parameter)) -> Value {
    let study = samples.study();
    let (origin, content) = match parameter.origin {
        Origin::Uncertain(_) => ("uncertain", json!(study.sampled.distributions[number])),
        Origin::Derived(formula) => ("derived", json!(study.sampled.formulas[formula])),
        Origin::Varied(axis, member) => {
            let axis = &study.axes[axis];
            let varied = &axis.varied[member];
            let shown = |position| show(&varied.info, &varied.values.at(position));
            // A long axis is represented by its ends.
            let places: Vec<u64> =
                if axis.length <= 100 { (0..axis.length).collect() } else { vec![0, axis.length - 1] };
            ("varied", json!({ "count": axis.length, "values": places.into_iter().map(shown).collect::<Vec<_>>() }))
        }
    };
    json!({
        "path": parameter.info.path,
        "column": parameter.column().name,
        "unit": parameter.info.unit,
        "origin": origin,
        "content": content,
    })
}

/// The output of `check` for a machine as JSON, without the contact forecast.
pub(super) fn of_machine(definition: &MachineDef, machine: &Machine, notes: &[String], warnings: &[String]) -> String {
    let rest = equilibrium(machine).map(|found| {
        let bearings = machine.rotor.bearings.iter().zip(&found.bearings);
        let bearings: Vec<Value> =
            bearings.map(|(bearing, force)| json!({ "name": bearing.name, "force_N": force })).collect();
        json!({ "largest_displacement_m": found.sag, "position_m": found.position, "bearings": bearings })
    });
    pretty(&json!({
        "machine": definition.name(),
        "engine": machine.run.engine.word(),
        "static_equilibrium": rest,
        "assumptions": assumed_of_machine(definition, machine),
        "notes": notes,
        "warnings": warnings,
    }))
}
