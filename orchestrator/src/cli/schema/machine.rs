//! The schema of machine files.

use super::{document, extend, table, with_unit};
use bladeoff_model::machine::{Key, Kind, Need, Range, When, keys};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// The format as a JSON Schema.
pub(super) fn schema() -> Value {
    let keys: Vec<(&Key, &str)> = keys().iter().map(|key| (key, key.path)).collect();
    document("bladeoff machine file", "A shaft line with its diaphragms, version 1 of the format", below(&keys))
}

/// A table, from its keys with the rest of their paths.
fn below(keys: &[(&Key, &str)]) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    let mut steps = BTreeSet::new();
    for (key, rest) in keys {
        let Some((step, _)) = rest.split_once('.') else {
            properties.insert((*rest).to_owned(), value(key));
            if key.need == Need::Required && key.when == When::Always {
                required.push((*rest).to_owned());
            }
            continue;
        };
        if !steps.insert(step) {
            continue;
        }
        let inner: Vec<(&Key, &str)> = keys
            .iter()
            .filter_map(|(key, rest)| {
                rest.split_once('.').filter(|(other, _)| *other == step).map(|(_, rest)| (*key, rest))
            })
            .collect();
        let inner = below(&inner);
        if step == "NAME" {
            return json!({ "type": "object", "additionalProperties": inner });
        }
        match step.strip_suffix("[i]") {
            Some(name) => properties.insert(name.to_owned(), json!({ "type": "array", "items": inner })),
            None => {
                if inner.get("required").is_some() {
                    required.push(step.to_owned());
                }
                properties.insert(step.to_owned(), inner)
            }
        };
    }
    table(properties, &required)
}

/// A value of a key.
fn value(key: &Key) -> Value {
    let scalar = |unit| quantity(unit, key.range);
    let mut value = match key.kind {
        Kind::Schema => json!({ "const": 1 }),
        Kind::Text => json!({ "type": "string" }),
        Kind::Number(unit) => scalar(unit),
        Kind::NumberOr(unit, words) => json!({ "anyOf": [{ "enum": words }, scalar(unit)] }),
        Kind::Count => number("integer", key.range),
        // written as a boolean or as a word
        Kind::Choice(words) if words[..] == ["false", "true"] => json!({ "enum": [false, true, "false", "true"] }),
        Kind::Choice(words) => json!({ "enum": words }),
        Kind::Vector(unit) => pair(&scalar(unit)),
        // The components of a matrix have other bounds than the scalar.
        Kind::Matrix(unit) => {
            let row = pair(&quantity(unit, Range::ANY));
            json!({ "anyOf": [scalar(unit), pair(&row)] })
        }
        Kind::Diagonal(unit) => json!({ "anyOf": [scalar(unit), pair(&scalar(unit))] }),
        Kind::List(unit) => json!({ "type": "array", "items": scalar(unit) }),
    };
    extend(&mut value, json!({ "description": description(key) }));
    match (key.need, key.kind) {
        (Need::Number(number), Kind::Vector(_)) => value["default"] = json!([number, number]),
        (Need::Number(number), _) => value["default"] = json!(number),
        (Need::Word(word), _) => value["default"] = json!(word),
        (Need::Required | Need::Optional(_), _) => {}
    }
    value
}

/// Meaning, allowed numbers with their unit, default, condition.
fn description(key: &Key) -> String {
    let mut text = key.meaning.to_owned();
    if !matches!(key.kind, Kind::Schema | Kind::Text | Kind::Choice(_)) {
        text += &format!("; {}", key.range.words(key.unit()));
    }
    if let Need::Optional(without) = key.need {
        text += &format!("; without it: {without}");
    }
    match key.when.words() {
        "" => text,
        when => format!("{text}; only with {when}"),
    }
}

fn pair(item: &Value) -> Value {
    json!({ "type": "array", "items": item, "minItems": 2, "maxItems": 2 })
}

/// A number in SI, or a string with its unit.
fn quantity(unit: &str, range: Range) -> Value {
    json!({ "anyOf": [number("number", range), with_unit(unit)] })
}

/// A number within a range.
fn number(kind: &str, range: Range) -> Value {
    let mut number = json!({ "type": kind });
    let ends = [("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")];
    for (end, (allowed, excluded)) in range.ends().into_iter().zip(ends) {
        if end.is_finite() {
            number[if range.contains(end) { allowed } else { excluded }] = json!(end);
        }
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The schema of a path: `additionalProperties` for a name, `items` for an array.
    fn at<'s>(schema: &'s Value, path: &str) -> &'s Value {
        path.split('.').fold(schema, |schema, step| match (step, step.strip_suffix("[i]")) {
            ("NAME", _) => &schema["additionalProperties"],
            (_, Some(array)) => &schema["properties"][array]["items"],
            _ => &schema["properties"][step],
        })
    }

    #[test]
    fn every_key_is_at_its_place_and_no_table_takes_others() {
        let schema = schema();
        for key in keys() {
            let found = at(&schema, key.path);
            let description = found["description"].as_str().unwrap_or_default();
            assert!(description.starts_with(key.meaning), "{}: {found}", key.path);
        }
        for closed in ["run", "run.guard", "rotor", "rotor.shaft[i]", "rotor.bearings.NAME", "diaphragms.NAME.contact"]
        {
            assert_eq!(at(&schema, closed)["additionalProperties"], false, "{closed}");
        }
        assert_eq!(schema["required"], json!(["schema", "name", "run", "rotor"]));
    }

    #[test]
    fn ranges_words_and_units_are_those_of_the_table() {
        let schema = schema();
        let gap = at(&schema, "diaphragms.NAME.contact.gap");
        assert_eq!(gap["anyOf"][0], json!({ "type": "number", "minimum": 1e-9, "maximum": 1e6 }));
        assert_eq!(gap["anyOf"][1]["type"], "string");
        let poisson = at(&schema, "rotor.material.poisson_ratio");
        assert_eq!(poisson["anyOf"][0]["exclusiveMaximum"], 0.5);
        assert_eq!(at(&schema, "rotor.kind")["enum"], json!(["shaft", "point-mass"]));
        assert_eq!(at(&schema, "run.rotor_modes")["type"], "integer");
    }
}
