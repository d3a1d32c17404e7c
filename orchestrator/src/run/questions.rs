//! Questions and gates of a study in the metadata of its table.

use bladeoff_study::{Asked, AskedGate, AskedQuestion, Placed};
use serde_json::{Map, Value, json};

/// Metadata of the questions and gates. They are not part of the study's identity: another question is another answer, not
/// another study.
pub(super) fn questions(asked: &Asked) -> Vec<(String, String)> {
    if asked.is_empty() {
        return Vec::new();
    }
    let gate = |gate: &AskedGate| {
        let confidence = gate.confidence.as_ref().map(|placed| json!(placed.value));
        object([("require", Some(json!(gate.require.value))), ("confidence", confidence)])
    };
    let all = json!({
        "question": asked.questions.iter().map(question).collect::<Vec<_>>(),
        "gate": asked.gates.iter().map(gate).collect::<Vec<_>>(),
    });
    vec![("questions".to_owned(), all.to_string())]
}

fn question(asked: &AskedQuestion) -> Value {
    let text = |placed: &Option<Placed<String>>| placed.as_ref().map(|placed| json!(placed.value));
    let number = |placed: &Option<Placed<f64>>| placed.as_ref().map(|placed| json!(placed.value));
    object([
        ("name", text(&asked.name)),
        ("probability", text(&asked.probability)),
        ("quantile", number(&asked.quantile)),
        ("of", text(&asked.of)),
        ("mean", text(&asked.mean)),
        ("exceedance", text(&asked.exceedance)),
        ("sensitivity", text(&asked.sensitivity)),
        ("method", text(&asked.method)),
        ("fragility", text(&asked.fragility)),
        ("map", asked.map.as_ref().map(|placed| json!(placed.value))),
        ("difference", asked.difference.as_ref().map(|placed| json!(placed.value))),
        ("vary", text(&asked.vary)),
        ("confidence", number(&asked.confidence)),
    ])
}

fn object<const N: usize>(pairs: [(&str, Option<Value>); N]) -> Value {
    let there = pairs.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
    Value::Object(there.collect::<Map<String, Value>>())
}
