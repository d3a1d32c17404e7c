//! `[refine]`: a map of some combinations that is refined where it changes. Like `[stop]`, `[refine]` does not enter the identity of a
//! study: another rule gives another result table of the same samples.

use super::asked::Asked;
use super::table::{Keys, wrong_type};
use bladeoff_text::document::{Collector, Entry, Value};
use std::ops::Range;

/// Settings of `[refine]`.
#[derive(Debug, Clone, PartialEq)]
pub struct RefineDef {
    /// Index of the question with the map.
    pub question: usize,
    /// Most samples of the table.
    pub max_samples: u64,
    /// Number of first values of each axis, evenly spread; `None`: every fourth.
    pub first: Option<[u64; 2]>,
    /// Byte range of the table's header.
    pub span: Range<usize>,
    /// Byte ranges of the values of `max_samples` and `first`; of the header for a missing key.
    pub places: [Range<usize>; 2],
}

impl RefineDef {
    /// Reads `[refine]` of a study; problems are added to `problems`.
    pub(super) fn read(entry: &Entry, asked: &Asked, has_stop: bool, problems: &mut Collector<'_>) -> Option<Self> {
        let keys = Keys::of(entry, "refine", problems)?;
        let before = problems.count();
        keys.refuse_unknown(&crate::keys::names("[refine]"), problems);
        if has_stop {
            let message =
                "[stop] ends a study after a number of points, but [refine] takes all points where a map changes";
            problems.add(entry.name_span.clone(), "refine", message).allowed = Some("one of both".to_owned());
        }
        if !asked.gates.is_empty() {
            let message = "leaves combinations out by their results, and a [[gate]] would not cover them";
            problems.add(entry.name_span.clone(), "refine", message).allowed = Some("one of both".to_owned());
        }
        let allowed = "max_samples = 2000: of the table, at most";
        let most = keys.require("max_samples", allowed, problems);
        let most = most.and_then(|entry| keys.whole(entry, 1, i64::MAX as u64, problems));
        let first = keys.get("first").and_then(|entry| first(entry, problems));
        let question = question(&keys, asked, problems);
        let span = entry.name_span.clone();
        let place = |name| keys.get(name).map_or(span.clone(), |entry| entry.node.span.clone());
        let places = [place("max_samples"), place("first")];
        let def = Self { question: question?, max_samples: most?, first, span: span.clone(), places };
        (problems.count() == before).then_some(def)
    }
}

/// The question with the map: the named one, or the only one.
fn question(keys: &Keys<'_>, asked: &Asked, problems: &mut Collector<'_>) -> Option<usize> {
    let maps: Vec<(usize, &str)> = asked
        .questions
        .iter()
        .enumerate()
        .filter(|(_, question)| question.map.is_some())
        .filter_map(|(at, question)| Some((at, question.name.as_ref()?.value.as_str())))
        .collect();
    let names = maps.iter().map(|(_, name)| format!("of = {name:?}")).collect::<Vec<_>>().join(", ");
    let allowed = if names.is_empty() { "a [[question]] with `map`".to_owned() } else { names };
    let named = match keys.get("of") {
        Some(entry) => Some((entry, keys.text(entry, problems)?)),
        None => None,
    };
    let found = match (named, maps.as_slice()) {
        (None, &[(at, _)]) => return Some(at),
        (Some((_, named)), maps) => maps.iter().find(|(_, name)| *name == named),
        (None, _) => None,
    };
    if let Some((at, _)) = found {
        return Some(*at);
    }
    if asked.questions.iter().any(|question| question.is_partly) {
        // the unreadable question has been reported
        return None;
    }
    match named {
        Some((entry, named)) => {
            let nearest = problems.nearest(named, maps.iter().map(|(_, name)| *name));
            let problem = problems.add(entry.node.span.clone(), "refine.of", "is no question with a map");
            (problem.allowed, problem.nearest) = (Some(allowed), nearest);
        }
        None => {
            let message = if maps.is_empty() {
                "needs a [[question]] with a map, which this study does not have"
            } else {
                "does not say which map"
            };
            problems.add(keys.span(), "refine.of", message).allowed = Some(allowed);
        }
    }
    None
}

/// Two whole numbers, at least 2 each.
fn first(entry: &Entry, problems: &mut Collector<'_>) -> Option<[u64; 2]> {
    let Value::Array(items) = &entry.node.value else {
        wrong_type(&entry.node, "refine.first", "the number of values of each axis that come first: [9, 7]", problems);
        return None;
    };
    let number = |value: &Value| match value {
        Value::Integer(number) => u64::try_from(*number).ok().filter(|number| *number >= 2),
        _ => None,
    };
    let numbers: Vec<u64> = items.iter().filter_map(|item| number(&item.value)).collect();
    match <[u64; 2]>::try_from(numbers) {
        Ok(first) if items.len() == 2 => Some(first),
        _ => {
            let value = problems.excerpt(entry.node.span.clone());
            let problem = problems.add(entry.node.span.clone(), "refine.first", "is not two whole numbers from 2 on");
            problem.value = Some(value);
            problem.allowed = Some("the number of values of each axis that come first: [9, 7]".to_owned());
            None
        }
    }
}
