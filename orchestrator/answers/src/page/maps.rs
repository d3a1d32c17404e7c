//! A map in a page: the picture as it is drawn everywhere, and the same cells for the chart library, with the numbers of each.

use super::escape::plain;
use super::figure::{Figure, Plot, short};
use crate::figures::{self, FigureError, Scale, of_in_words, plain_name};
use crate::map::{Axis, Cell, Map, Shows};
use bladeoff_model::document::cut;
use serde_json::{Value, json};

/// Characters of a name from outside, at most.
const NAME: usize = 60;
/// Colour of cells that have no one number.
const GREY: &str = "rgb(150,150,150)";

/// A panel as a figure of a page; `name`: of the question.
///
/// # Errors
/// The plotting library failed.
pub fn map_figure(name: &str, map: &Map) -> Result<Figure, FigureError> {
    let group: Vec<String> = map.group.0.iter().map(|(path, label)| format!("{path} = {label}")).collect();
    let mut caption = format!("{}: {} over {} and {}", cut(name, NAME), cut(&map.of, NAME), map.x.column, map.y.column);
    if !group.is_empty() {
        caption += &format!(", {}", group.join(", "));
    }
    if let Some((column, [a, b])) = &map.difference {
        caption += &format!(", {column} = {a} less {b}");
    }
    // the caption says what it is
    let drawing = figures::maps("", std::slice::from_ref(map))?.svg().to_owned();
    Ok(Figure { caption, drawing, plot: Some(plot(map)), table: None })
}

/// What is shown of a cell.
type Pick = fn(&Cell) -> Option<f64>;

fn plot(map: &Map) -> Plot {
    let half: Pick = |cell| Some(0.5 * (cell.high? - cell.low?));
    let middle: Pick = |cell| cell.estimate;
    let upper: Pick = |cell| cell.upper;
    let shown: Vec<(&str, Pick)> = match map.shows {
        Shows::Value => vec![("", middle)],
        Shows::Probability => vec![("", middle)],
        Shows::Median => vec![("median", middle), ("95 % value", upper)],
        Shows::SmoothedMean | Shows::SmoothedProbability => {
            vec![("smoothed", middle), ("half width of its limits", half)]
        }
    };
    let count = shown.len() as f64;
    let (mut traces, mut layout) = (Vec::new(), json!({ "height": 480, "annotations": [] }));
    for (at, (what, pick)) in shown.into_iter().enumerate() {
        let number = if at == 0 { String::new() } else { (at + 1).to_string() };
        let (from, to) = (at as f64 / count, (at as f64 + 0.8) / count);
        traces.extend(cells(map, what, pick, &number, to));
        let (x, y) = (axis(&map.x), axis(&map.y));
        layout[format!("xaxis{number}")] = json!({
            "title": { "text": plain(&x.1) }, "domain": [from, to], "anchor": format!("y{number}"), "zeroline": false,
        });
        layout[format!("yaxis{number}")] = json!({
            "title": { "text": plain(&y.1) }, "anchor": format!("x{number}"), "zeroline": false,
        });
        if at > 0 {
            layout[format!("xaxis{number}")]["matches"] = json!("x");
            layout[format!("yaxis{number}")]["matches"] = json!("y");
        }
    }
    Plot::Traces(Value::Array(traces), layout)
}

/// Factor and label of an axis.
fn axis(axis: &Axis) -> (f64, String) {
    let largest = axis.at.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let scale = Scale::of(&axis.unit, largest);
    let label = scale.label(&cut(&plain_name(&axis.column, &axis.unit), NAME));
    (scale.factor, label)
}

/// Whether bad runs leave the figure of a cell open.
fn is_open(cell: &Cell) -> bool {
    cell.estimate != cell.estimate_if_bad_harmful || cell.upper != cell.upper_if_bad_harmful
}

/// Cells, and crosses where bad runs are.
fn cells(map: &Map, what: &str, pick: Pick, number: &str, end: f64) -> Vec<Value> {
    let table = map.table();
    let (x, y) = (axis(&map.x), axis(&map.y));
    let scale = if map.is_share() {
        Scale { factor: 100.0, unit: "%".to_owned() }
    } else {
        let largest = map.cells.iter().filter_map(pick).fold(0.0_f64, |most, value| most.max(value.abs()));
        Scale::of(&map.unit, largest)
    };
    let columns = 0..map.x.at.len();
    let by_rows = |of: &dyn Fn(Option<&Cell>) -> Value| -> Vec<Vec<Value>> {
        (0..map.y.at.len()).map(|j| columns.clone().map(|i| of(table[i][j])).collect()).collect()
    };
    // one colour cannot say two things: what bad runs leave open is grey, as is what has no number
    let shown = |cell: &Cell| if is_open(cell) { None } else { pick(cell) };
    let value = |cell: Option<&Cell>| json!(cell.and_then(shown).map(|value| short(value * scale.factor)));
    let grey = |cell: Option<&Cell>| json!(cell.filter(|cell| shown(cell).is_none()).map(|_| 0));
    let told = |cell: Option<&Cell>| json!(cell.map_or(String::new(), |cell| plain(&words(cell, &scale))));
    let along = |axis: &Axis, factor: f64| axis.at.iter().map(|value| short(value * factor)).collect::<Vec<_>>();
    let name = if what.is_empty() { of_in_words(map) } else { what.to_owned() };
    let mut heat = json!({
        "type": "heatmap", "x": along(&map.x, x.0), "y": along(&map.y, y.0), "z": by_rows(&value), "text": by_rows(&told),
        "hoverinfo": "x+y+text", "xaxis": format!("x{number}"), "yaxis": format!("y{number}"), "name": plain(&name),
        "colorbar": { "title": { "text": plain(&scale.label(&cut(&name, NAME))), "side": "right" }, "x": end + 0.005, "thickness": 12 },
    });
    if map.difference.is_some() && what != "half width of its limits" {
        heat["colorscale"] = json!([[0, "rgb(0,114,178)"], [0.5, "rgb(247,247,247)"], [1, "rgb(213,94,0)"]]);
        heat["zmid"] = json!(0);
    } else {
        heat["colorscale"] = json!("Viridis");
    }
    let bad: Vec<&Cell> = map.cells.iter().filter(|cell| cell.bad > 0).collect();
    let grey = json!({
        "type": "heatmap", "x": heat["x"], "y": heat["y"], "z": by_rows(&grey), "text": heat["text"], "hoverinfo": "x+y+text",
        "xaxis": heat["xaxis"], "yaxis": heat["yaxis"], "showscale": false, "colorscale": [[0, GREY], [1, GREY]],
    });
    let mut traces = vec![heat, grey];
    if !bad.is_empty() {
        traces.push(json!({
            "type": "scatter", "mode": "markers", "name": "bad runs", "showlegend": number.is_empty(), "hoverinfo": "skip",
            "x": bad.iter().map(|cell| short(cell.x * x.0)).collect::<Vec<_>>(),
            "y": bad.iter().map(|cell| short(cell.y * y.0)).collect::<Vec<_>>(),
            "xaxis": format!("x{number}"), "yaxis": format!("y{number}"),
            "marker": { "symbol": "x", "size": 8, "color": "rgb(255,255,255)", "line": { "width": 1, "color": "rgb(0,0,0)" } },
        }));
    }
    traces
}

/// The numbers of a cell.
fn words(cell: &Cell, scale: &Scale) -> String {
    let unit = if scale.unit.is_empty() { String::new() } else { format!(" {}", scale.unit) };
    let show = |value: Option<f64>| {
        value.map_or("no number".to_owned(), |value| format!("{}{unit}", short(value * scale.factor)))
    };
    let mut text = show(cell.estimate);
    if cell.estimate != cell.estimate_if_bad_harmful {
        text += &format!(" to {}", show(cell.estimate_if_bad_harmful));
    }
    if cell.upper.is_some() {
        text += &format!("; 95 % value {}", show(cell.upper));
    }
    if cell.low.is_some() || cell.high.is_some() {
        text += &format!("; limits {} and {}", show(cell.low), show(cell.high));
    }
    text += &format!("; {} runs, {} bad", cell.n, cell.bad);
    if let Some(regime) = &cell.regime {
        text += &format!("; {regime}");
    }
    text
}
