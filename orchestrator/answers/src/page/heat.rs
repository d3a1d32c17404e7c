//! Maps in a page: the picture of all panels, and a heat map of each where scripts run.

use super::escape::plain;
use super::figure::{Figure, Plot, short};
use crate::figures::{FigureError, Scale, plain_name};
use crate::map::{Axis, Map};
use serde_json::{Map as Object, Value, json};

/// Panels side by side, and pixels of one.
const ACROSS: usize = 2;
const HEIGHT: usize = 340;

/// The maps of one question.
///
/// # Errors
/// The plotting library failed.
pub fn maps(name: &str, maps: &[Map]) -> Result<Figure, FigureError> {
    let drawing = crate::figures::maps(name, maps)?.svg().to_owned();
    let of = maps.first().map_or(String::new(), |map| format!("{} over {} and {}", map.of, map.x.column, map.y.column));
    let caption =
        format!("{name}: {of}. Where no sample is, nothing is drawn; with scripts the value with bad runs harmless.");
    Ok(Figure { caption, drawing, plot: Some(plot(maps)), table: None })
}

fn plot(maps: &[Map]) -> Plot {
    let across = maps.len().clamp(1, ACROSS);
    let rows = maps.len().div_ceil(across).max(1);
    let mut layout = Object::new();
    let (mut traces, mut titles) = (Vec::new(), Vec::new());
    for (at, map) in maps.iter().enumerate() {
        let number = if at == 0 { String::new() } else { (at + 1).to_string() };
        let (column, row) = (at % across, at / across);
        let (width, height) = (0.88 / across as f64, 1.0 / rows as f64);
        let x = [column as f64 * width, (column as f64 + 0.82) * width];
        let y = [1.0 - (row as f64 + 0.78) * height, 1.0 - (row as f64 + 0.08) * height];
        let (along, up) = (scale_of(&map.x), scale_of(&map.y));
        let label = |axis: &Axis, scale: &Scale| plain(&scale.label(&plain_name(&axis.column, &axis.unit)));
        layout.insert(
            format!("xaxis{number}"),
            json!({ "domain": x, "anchor": format!("y{number}"), "title": { "text": label(&map.x, &along) } }),
        );
        layout.insert(
            format!("yaxis{number}"),
            json!({ "domain": y, "anchor": format!("x{number}"), "title": { "text": label(&map.y, &up) } }),
        );
        let said: Vec<String> = map.group.0.iter().map(|(_, label)| label.to_string()).collect();
        let less = map.difference.as_ref().map_or(String::new(), |(_, [a, b])| format!(" {a} less {b}"));
        let title = plain(&format!("{}{less}", said.join(", ")));
        titles.push(json!({
            "text": title, "showarrow": false, "xref": "paper", "yref": "paper", "x": x[0], "y": y[1], "xanchor": "left", "yanchor": "bottom",
        }));
        let largest = maps.iter().filter(|other| other.difference.is_some() == map.difference.is_some());
        let largest = largest
            .flat_map(|other| &other.cells)
            .filter_map(|cell| cell.estimate)
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        let value =
            if map.is_share() { Scale { factor: 100.0, unit: "%".to_owned() } } else { Scale::of(&map.unit, largest) };
        let table = map.table();
        let cells: Vec<Vec<Option<f64>>> = (0..map.y.at.len())
            .map(|row| {
                table
                    .iter()
                    .map(|column| {
                        column[row].and_then(|cell| cell.estimate).map(|estimate| short(estimate * value.factor))
                    })
                    .collect()
            })
            .collect();
        let shared = if map.difference.is_some() { "coloraxis2" } else { "coloraxis" };
        let bar = |x: f64| json!({ "title": { "text": plain(&value.unit) }, "thickness": 14, "x": x, "outlinewidth": 0, "len": 0.9 });
        layout.entry(shared).or_insert_with(|| match map.difference {
            None => json!({ "colorscale": "Viridis", "colorbar": bar(0.88) }),
            Some(_) => json!({ "colorscale": "RdBu", "cmid": 0, "colorbar": bar(0.95) }),
        });
        let places = |axis: &Axis, scale: &Scale| axis.at.iter().map(|at| short(at * scale.factor)).collect::<Vec<_>>();
        traces.push(json!({
            "type": "heatmap", "x": places(&map.x, &along), "y": places(&map.y, &up), "z": cells, "coloraxis": shared,
            "xaxis": format!("x{number}"), "yaxis": format!("y{number}"), "hoverongaps": false, "name": title,
        }));
    }
    layout.insert("annotations".to_owned(), Value::Array(titles));
    layout.insert("height".to_owned(), json!(HEIGHT * rows + 40));
    Plot::Traces(Value::Array(traces), Value::Object(layout))
}

fn scale_of(axis: &Axis) -> Scale {
    Scale::of(&axis.unit, axis.at.iter().fold(0.0_f64, |most, at| most.max(at.abs())))
}
