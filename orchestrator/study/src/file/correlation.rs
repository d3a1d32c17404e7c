//! `[[correlation]]`: pairs of dependent parameters and the strength of their dependence.

use super::super::correlation::{Copula, CorrelationError, Pair, Strength};
use super::super::derived::{Variable, find, meant};
use super::super::table::{Keys, wrong_type};
use super::super::uncertain::Uncertain;
use super::tables;
use bladeoff_text::document::{Collector, Entry, Value, cut};
use std::ops::Range;

const STRENGTHS: &str =
    "one of `rank` (Spearman), `linear` (Pearson), `normal` (of the normal numbers behind the values)";

/// The copula of the uncertain parameters, and a description of each pair. `laws`: given if all distributions are valid. `None`: problems were added.
pub(super) fn read(
    keys: &Keys<'_>,
    variables: &[Variable],
    laws: Option<&[Uncertain]>,
    problems: &mut Collector<'_>,
) -> Option<(Copula, Vec<String>)> {
    let Some(entry) = keys.get("correlation") else {
        return Some((Copula::independent(variables.len()), Vec::new()));
    };
    let (mut pairs, mut places, mut sound) = (Vec::new(), Vec::new(), true);
    for (number, item) in tables(&entry.node, "correlation", problems).iter().enumerate() {
        let key = format!("correlation[{number}]");
        let Some(keys) = Keys::at(item, &key, problems) else {
            sound = false;
            continue;
        };
        keys.refuse_unknown(&crate::keys::names("[[correlation]]"), problems);
        let between = keys.require("between", "between = [\"gap\", \"friction\"]", problems);
        let between = between.and_then(|entry| pair(entry, &keys, variables, laws.is_some(), problems));
        let strength = strength(&keys, problems);
        // with both names and all distributions, this is checked together with the rest
        if let Some(strength) = strength.filter(|_| between.is_none() || laws.is_none()) {
            refuse_beyond_one(strength, &keys, problems);
        }
        match (between, strength) {
            (Some(between), Some(strength)) => {
                pairs.push(Pair { between, strength });
                places.push((keys.span(), key));
            }
            _ => sound = false,
        }
    }
    let laws = laws?;
    let names: Vec<String> = variables.iter().map(|variable| variable.shown().to_owned()).collect();
    match Copula::new(&names, laws, &pairs) {
        Ok(copula) => {
            let said = pairs.iter().map(|pair| sentence(pair, &names)).collect();
            Some((copula, said)).filter(|_| sound)
        }
        Err(errors) => {
            for error in errors {
                // a table that could not be read may be the reason
                if !sound && matches!(error, CorrelationError::Impossible { .. }) {
                    continue;
                }
                let (span, key): &(Range<usize>, String) = &places[error.pair()];
                let key = match &error {
                    CorrelationError::Itself { .. } | CorrelationError::Repeated { .. } => format!("{key}.between"),
                    CorrelationError::Value { key: which, .. } | CorrelationError::NotContinuous { key: which, .. } => {
                        format!("{key}.{which}")
                    }
                    CorrelationError::Unreachable { .. } | CorrelationError::Unresolved { .. } => {
                        format!("{key}.linear")
                    }
                    CorrelationError::Impossible { .. } => "correlation".to_owned(),
                };
                problems.add(span.clone(), key, error.to_string());
            }
            None
        }
    }
}

fn refuse_beyond_one(strength: Strength, keys: &Keys<'_>, problems: &mut Collector<'_>) {
    let (key, given) = strength.parts();
    if !(given > -1.0 && given < 1.0) {
        let told = CorrelationError::Value { pair: 0, key, given }.to_string();
        problems.add(keys.span(), keys.key(key), told);
    }
}

/// Description of a pair: "cold_gap and growth: rank correlation 0.3".
fn sentence(Pair { between: [a, b], strength }: &Pair, names: &[String]) -> String {
    let (key, number) = strength.parts();
    let of = if key == "normal" { "correlation of the normal numbers behind the values" } else { "correlation" };
    let key = if key == "normal" { String::new() } else { format!("{key} ") };
    format!("{} and {}: {key}{of} {number}", names[*a], names[*b])
}

/// The two parameters. `all`: all variables could be read, so an unknown name is a mistake.
fn pair(
    entry: &Entry,
    keys: &Keys<'_>,
    variables: &[Variable],
    all: bool,
    problems: &mut Collector<'_>,
) -> Option<[usize; 2]> {
    let key = keys.key("between");
    let names: Vec<&str> = match &entry.node.value {
        Value::Array(items) if items.len() == 2 => items
            .iter()
            .filter_map(|item| match &item.value {
                Value::Text(name) => Some(name.as_str()),
                _ => None,
            })
            .collect(),
        _ => Vec::new(),
    };
    let [first, second] = names[..] else {
        wrong_type(&entry.node, &key, "two names: [\"gap\", \"friction\"]", problems);
        return None;
    };
    let mut number = |name: &str| {
        let found = find(variables, name);
        if found.is_none() && all {
            let nearest = meant(variables, name);
            let problem = problems.add(entry.node.span.clone(), &key, "is no uncertain parameter");
            problem.value = Some(format!("{:?}", cut(name, 80)));
            problem.allowed = Some("the paths, endings or names of [[uncertain]]".to_owned());
            problem.nearest = nearest;
        }
        found
    };
    let found = [number(first), number(second)];
    Some([found[0]?, found[1]?])
}

fn strength(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<Strength> {
    let given: Vec<&Entry> = ["rank", "linear", "normal"].iter().filter_map(|name| keys.get(name)).collect();
    let [entry] = given[..] else {
        let message = if given.is_empty() { "has no strength" } else { "has more than one strength" };
        let key = given.last().map_or_else(|| keys.key("rank"), |entry| keys.key(&entry.name));
        problems.add(keys.span(), key, message).allowed = Some(STRENGTHS.to_owned());
        return None;
    };
    let Some(number) = entry.node.value.as_number() else {
        wrong_type(&entry.node, &keys.key(&entry.name), "a number above -1 and below 1", problems);
        return None;
    };
    Some(match entry.name.as_str() {
        "rank" => Strength::Rank(number),
        "linear" => Strength::Linear(number),
        _ => Strength::Normal(number),
    })
}
