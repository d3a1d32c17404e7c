//! `[design]`: placement of the points of the uncertain parameters.

use super::super::correlation::Copula;
use super::super::parameter::Parameter;
use super::super::sampling::layout::{
    Base, LayoutDef, LayoutError, LayoutKind, MOST_LEVELS, MOST_POINTS, MOST_REPLICATES, SamplingLayout,
};
use super::super::table::{Keys, wrong_type};
use super::super::uncertain::{Uncertain, Values};
use bladeoff_model::machine::ParamValue;
use bladeoff_text::document::{Collector, Entry, Node, Value, cut};

/// Rejects tables that require another one which is missing.
pub(crate) fn needs(keys: &Keys<'_>, problems: &mut Collector<'_>) {
    let mut pair = |has: &str, needs: &str, allowed: &str| {
        if let (Some(entry), None) = (keys.get(has), keys.get(needs)) {
            problems.add(entry.name_span.clone(), has, format!("is given without [{needs}]")).allowed =
                Some(allowed.to_owned());
        }
    };
    pair("uncertain", "design", "[design] with kind = \"monte-carlo\" and samples = 1000, or the like");
    pair("design", "uncertain", "one table [[uncertain]] for each uncertain parameter");
    pair("correlation", "uncertain", "one table [[uncertain]] for each uncertain parameter");
    if let (Some(design), Some(_)) = (keys.get("design"), keys.get("points")) {
        problems.add(design.name_span.clone(), "design", "is given together with [points]").allowed =
            Some("either [design], which draws the points, or [points], which reads them".to_owned());
    }
}

/// The layout. `drawn`: given if all distributions are valid. `Some(None)`: the study has no design. `None`: problems were added.
#[allow(clippy::option_option)]
pub(super) fn read(
    keys: &Keys<'_>,
    parameters: &[Parameter],
    drawn: Option<(&[Uncertain], &Copula)>,
    seed: u64,
    problems: &mut Collector<'_>,
) -> Option<Option<SamplingLayout>> {
    let Some(entry) = keys.get("design") else { return Some(None) };
    let keys = Keys::of(entry, "design", problems)?;
    keys.refuse_unknown(&crate::keys::names("[design]"), problems);
    let def = def(&keys, parameters, drawn.map(|(laws, _)| laws), problems);
    let (def, (laws, copula)) = (def?, drawn?);
    if laws.is_empty() {
        // reported by `needs`
        return None;
    }
    let names: Vec<String> = parameters.iter().map(|parameter| parameter.shown().to_owned()).collect();
    match SamplingLayout::new(&def, seed, &names, laws, copula) {
        Ok(layout) => Some(Some(layout)),
        Err(errors) => {
            for error in errors {
                let key = error.key();
                let span = match (keys.get(key), &error) {
                    (
                        Some(Entry { node: Node { value: Value::Array(items), .. }, .. }),
                        LayoutError::Element { position, .. },
                    ) => items[*position].span.clone(),
                    (Some(entry), _) => entry.node.span.clone(),
                    (None, _) => keys.span(),
                };
                problems.add(span, keys.key(key), error.to_string());
            }
            None
        }
    }
}

fn def(
    keys: &Keys<'_>,
    parameters: &[Parameter],
    laws: Option<&[Uncertain]>,
    problems: &mut Collector<'_>,
) -> Option<LayoutDef> {
    let kind = kind(keys, problems);
    let mut sound = true;
    let mut whole = |name: &str, most: u64, problems: &mut Collector<'_>| {
        let entry = keys.get(name)?;
        let number = keys.whole(entry, 1, most, problems);
        sound &= number.is_some();
        number
    };
    let samples = whole("samples", MOST_POINTS, problems);
    let replicates = whole("replicates", MOST_REPLICATES, problems);
    let trajectories = whole("trajectories", MOST_POINTS, problems);
    let levels = whole("levels", MOST_LEVELS, problems);
    let mut truth = |name: &str, problems: &mut Collector<'_>| {
        let entry = keys.get(name)?;
        let Value::Bool(truth) = entry.node.value else {
            wrong_type(&entry.node, &keys.key(name), "true or false", problems);
            sound = false;
            return None;
        };
        Some(truth)
    };
    let scramble = truth("scramble", problems);
    let second_order = truth("second_order", problems);
    let quantiles = keys.get("quantiles").and_then(|entry| {
        let Value::Array(items) = &entry.node.value else {
            wrong_type(&entry.node, &keys.key("quantiles"), "an array of numbers", problems);
            sound = false;
            return None;
        };
        let numbers: Option<Vec<f64>> = items.iter().map(|item| item.value.as_number()).collect();
        if numbers.is_none() {
            wrong_type(&entry.node, &keys.key("quantiles"), "an array of numbers", problems);
            sound = false;
        }
        numbers
    });
    let base = keys.get("base").and_then(|entry| {
        let base = base(entry, keys, parameters, laws, problems);
        sound &= base.is_some();
        base
    });
    let def =
        LayoutDef { kind: kind?, samples, replicates, scramble, base, quantiles, trajectories, levels, second_order };
    sound.then_some(def)
}

fn kind(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<LayoutKind> {
    let entry = keys.require("kind", "kind = \"monte-carlo\"", problems)?;
    let word = keys.text(entry, problems)?;
    let found = LayoutKind::from_word(word);
    if found.is_none() {
        let words = || LayoutKind::ALL.iter().map(|(word, _)| *word);
        let nearest = problems.nearest(word, words());
        let problem = problems.add(entry.node.span.clone(), keys.key("kind"), "not an allowed word");
        problem.value = Some(format!("{:?}", cut(word, 80)));
        problem.allowed = Some(words().collect::<Vec<_>>().join(", "));
        problem.nearest = nearest;
    }
    found
}

/// Base point: present values of the machine; for words, their positions in the list of the distribution.
fn base(
    entry: &Entry,
    keys: &Keys<'_>,
    parameters: &[Parameter],
    laws: Option<&[Uncertain]>,
    problems: &mut Collector<'_>,
) -> Option<Base> {
    match keys.text(entry, problems)? {
        "median" => Some(Base::Median),
        "nominal" => {
            let present = |(parameter, law): (&Parameter, &Uncertain)| match (&parameter.info.value, law) {
                (Some(ParamValue::Choice(word)), Uncertain::Discrete(law)) => match law.values().0 {
                    Values::Words(words) => words.iter().position(|known| known == word).map(|place| place as f64),
                    Values::Numbers(_) => None,
                },
                (Some(ParamValue::Number(number)), law) if law.words().is_none() => Some(*number),
                _ => None,
            };
            // without valid distributions there is no layout
            Some(Base::Nominal(parameters.iter().zip(laws.unwrap_or_default()).map(present).collect()))
        }
        word => {
            let problem = problems.add(entry.node.span.clone(), keys.key("base"), "not an allowed word");
            problem.value = Some(format!("{:?}", cut(word, 80)));
            problem.allowed = Some("median, nominal".to_owned());
            None
        }
    }
}
