//! `model` and `[function]` of a study file: formulas instead of a machine.

use super::derived::Variable;
use super::function::{FunctionError, FunctionModel};
use super::table::Keys;
use bladeoff_text::document::{Collector, cut};

/// Keys and tables that a study without a machine does not use.
const OF_MACHINES: [&str; 4] = ["machine", "set", "points", "twin_share"];

/// Reads `model`: whether the study computes formulas instead of a machine. `None`: problems were added.
pub(super) fn is_function(keys: &Keys<'_>, problems: &mut Collector<'_>) -> Option<bool> {
    let is_function = match keys.get("model") {
        None => false,
        Some(entry) => match keys.text(entry, problems)? {
            "machine" => false,
            "function" => true,
            word => {
                let nearest = problems.nearest(word, ["machine", "function"]);
                let problem = problems.add(entry.node.span.clone(), "model", "not an allowed word");
                problem.value = Some(format!("{:?}", cut(word, 80)));
                problem.allowed = Some("machine, function".to_owned());
                problem.nearest = nearest;
                return None;
            }
        },
    };
    if is_function {
        for entry in OF_MACHINES.iter().filter_map(|name| keys.get(name)) {
            let message = "belongs to a machine, and model = \"function\" has none";
            problems.add(entry.name_span.clone(), &entry.name, message);
        }
    } else if let Some(entry) = keys.get("function") {
        let message = "is given without model = \"function\"";
        problems.add(entry.name_span.clone(), "function", message).allowed =
            Some("model = \"function\" and [function], or `machine`".to_owned());
    }
    Some(is_function)
}

/// Reads `[function]`: the outputs as formulas of the variables.
pub(super) fn read_function(
    keys: &Keys<'_>,
    variables: Option<&[Variable]>,
    problems: &mut Collector<'_>,
) -> Option<FunctionModel> {
    let entry = keys.require("function", "[function] with g = \"3 - x\"", problems)?;
    let keys = Keys::of(entry, "function", problems)?;
    let mut outputs = Vec::new();
    for entry in keys.entries() {
        let text = keys.text(entry, problems)?;
        outputs.push((entry.name.clone(), text.to_owned()));
    }
    match FunctionModel::new(&outputs, variables?) {
        Ok(function) => Some(function),
        Err(errors) => {
            // too many variables are reported at the first variable above the limit
            let told = |error: &FunctionError| !matches!(error, FunctionError::TooManyVariables { .. });
            for error in errors.into_iter().filter(told) {
                let entry = error.output().and_then(|output| keys.entries().get(output));
                let (span, key) = match (entry, &error) {
                    (Some(entry), FunctionError::Formula { output, place, .. }) => {
                        let said = &outputs[*output].1;
                        (problems.inside(&entry.node.span, said, place), keys.key(&cut(&entry.name, 80)))
                    }
                    (Some(entry), FunctionError::Words { .. }) => {
                        (entry.node.span.clone(), keys.key(&cut(&entry.name, 80)))
                    }
                    (Some(entry), _) => (entry.name_span.clone(), keys.key(&cut(&entry.name, 80))),
                    (None, _) => (keys.span(), "function".to_owned()),
                };
                problems.add(span, key, error.to_string());
            }
            None
        }
    }
}
