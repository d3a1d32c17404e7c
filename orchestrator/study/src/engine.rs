//! Engine of a study: `run.engine = "auto"` is resolved once for all samples, even if only a part of them is computed. Each limit of the
//! exponential engine's coverage depends on one value, so every value of every axis is checked, but not every combination.

use super::axis::Axis;
use super::file::SampledTables;
use super::parameter::{Origin, Parameter};
use bladeoff_model::machine::{
    CONTACT_STEP, ENGINE, Engine, EngineChoice, EngineReason, MachineDef, ParamValue, PathInfo, STEP, decides_engine,
};
use bladeoff_text::document::Collector;

/// The engine of all samples, which is set in `machine`; `None`: `run.engine` varies, so each sample has its own.
pub(super) fn settle(machine: &mut MachineDef, axes: &[Axis], sampled: &SampledTables) -> Option<EngineChoice> {
    if sampled.parameters.iter().any(|parameter| parameter.info.path == ENGINE) {
        return None;
    }
    let choice = choose(machine, axes, sampled)?;
    if choice.is_auto() {
        machine.settle(choice.engine);
    }
    Some(choice)
}

fn choose(machine: &MachineDef, axes: &[Axis], sampled: &SampledTables) -> Option<EngineChoice> {
    let first = machine.engine()?;
    if !first.is_auto() {
        return Some(first);
    }
    let varies = |path: &str| sampled.parameters.iter().any(|parameter| parameter.info.path == path);
    if varies(CONTACT_STEP) {
        return Some(EngineChoice { engine: Engine::Exponential, reason: EngineReason::ContactStep });
    }
    if varies(STEP) {
        return Some(EngineChoice { engine: Engine::Reduced, reason: EngineReason::Step });
    }
    let lists: Vec<Vec<Along<'_>>> =
        axes.iter().map(along).chain(sampled.parameters.iter().map(|one| of_law(one, sampled))).collect();
    // a value of the file that varies occurs in no sample
    let mut begun = machine.clone();
    lists.iter().filter_map(|list| list.first()).for_each(|values| set(&mut begun, values));
    let mut choices =
        std::iter::once(begun.clone()).chain(lists.iter().flat_map(|list| list.iter().skip(1)).map(|values| {
            let mut one = begun.clone();
            set(&mut one, values);
            one
        }));
    choices.find_map(|one| one.engine().filter(|choice| choice.engine == Engine::Reduced)).or_else(|| begun.engine())
}

/// Values that occur together in samples.
type Along<'a> = Vec<(&'a PathInfo, ParamValue)>;

/// Values of an axis that may affect the choice, without repetitions.
fn along(axis: &Axis) -> Vec<Along<'_>> {
    let deciding: Vec<_> = axis.varied.iter().filter(|varied| decides_engine(&varied.info.path)).collect();
    if deciding.is_empty() {
        return Vec::new();
    }
    let mut all: Vec<Along<'_>> = Vec::new();
    for position in 0..axis.length {
        let values: Along<'_> = deciding.iter().map(|varied| (&varied.info, varied.values.at(position))).collect();
        // in a file of millions of points, most repeat the previous value
        if all.last() != Some(&values) {
            all.push(values);
        }
    }
    all
}

/// All words of a distribution, or its ends: the coverage has limits on numbers.
fn of_law<'a>(parameter: &'a Parameter, sampled: &SampledTables) -> Vec<Along<'a>> {
    let Origin::Uncertain(law) = parameter.origin else { return Vec::new() };
    let Some(law) = sampled.values.laws().get(law).filter(|_| decides_engine(&parameter.info.path)) else {
        return Vec::new();
    };
    let values: Vec<ParamValue> = match law.words() {
        Some(words) => words.iter().cloned().map(ParamValue::Choice).collect(),
        None => law.ends().into_iter().map(ParamValue::Number).collect(),
    };
    values.into_iter().map(|value| vec![(&parameter.info, value)]).collect()
}

/// Values that the machine rejects are reported elsewhere.
fn set(machine: &mut MachineDef, values: &Along<'_>) {
    for (info, value) in values {
        let _ = machine.set(info, value);
    }
}

/// Rejects `auto` among values of `run.engine`: it selects one engine for all samples.
pub(super) fn refuse_auto(axes: &[Axis], sampled: &SampledTables, problems: &mut Collector<'_>) {
    let is_auto = |value: &ParamValue| *value == ParamValue::Choice(Engine::AUTO.to_owned());
    for parameter in sampled.parameters.iter().filter(|parameter| parameter.info.path == ENGINE) {
        let has = match parameter.origin {
            Origin::Varied(axis, member) => {
                let (length, values) = (axes[axis].length, &axes[axis].varied[member].values);
                (0..length).any(|position| is_auto(&values.at(position)))
            }
            Origin::Uncertain(law) => {
                sampled.values.laws()[law].words().is_some_and(|words| words.iter().any(|word| word == Engine::AUTO))
            }
            Origin::Derived(_) => false,
        };
        if has {
            let message = "\"auto\" selects one engine for the whole study and cannot be one of several values";
            problems.add(parameter.place.clone(), parameter.key(), message).allowed = Some(Engine::WORDS.join(", "));
        }
    }
}
