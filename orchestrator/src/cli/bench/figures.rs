//! Results of a benchmark, as text table and as JSON.

use bladeoff_answers::summary::{Align, TextTable};
use serde_json::{Value, json};

/// Name, value, unit and goal of a measurement.
pub(super) type Figure = (&'static str, Option<f64>, &'static str, &'static str);

/// The results as a text table.
pub(super) fn text(figures: &[Figure]) -> String {
    let mut table = TextTable::new(&[
        ("measured", Align::Left),
        ("value", Align::Right),
        ("unit", Align::Left),
        ("goal", Align::Left),
    ]);
    for (what, value, unit, goal) in figures {
        let value = value.map_or_else(|| "not measured".to_owned(), |value| format!("{value:.2}"));
        table.row(vec![(*what).to_owned(), value, (*unit).to_owned(), (*goal).to_owned()]);
    }
    table.render("")
}

/// The results as JSON.
pub(super) fn json(figures: &[Figure]) -> Vec<Value> {
    let one = |(what, value, unit, goal): &Figure| json!({ "what": what, "value": value, "unit": unit, "goal": goal });
    figures.iter().map(one).collect()
}
