//! A map in a page: the picture as it is drawn everywhere, and the same cells for the chart library, with the numbers of each.

use super::escape::plain;
use super::figure::{Figure, Plot, short};
use crate::figures::{self, FigureError, Scale, of_in_words, plain_name};
use crate::map::{Axis, Cell, Map, Shows};
use bladeoff_text::document::cut;
use serde_json::{Value, json};

/// Characters of a name from outside, at most.
const NAME: usize = 60;
/// What the second panel of a smoothed map is of.
const HALF_WIDTH: &str = "half width of its limits";
/// Marks of runs that are not ok, at most of each kind.
const MOST_CROSSES: usize = 400;
/// Colour of cells that have no one number.
const GREY: &str = "rgb(150,150,150)";

/// Places of cells that all maps of a page have together, at most: about 300 bytes each, of a page of five megabytes.
const MOST_PLACES: usize = 8000;

/// A panel as a figure of a page that shows `of` maps; `name`: of the question. Of a large grid evenly chosen values are drawn, and the
/// caption says so.
///
/// # Errors
/// The plotting library failed.
pub fn map_figure(name: &str, map: &Map, of: usize) -> Result<Figure, FigureError> {
    let every = (1..).find(|every| places(map, *every) <= MOST_PLACES / of.max(1)).unwrap_or(1);
    let thin = (every > 1).then(|| thinned(map, every));
    let map = thin.as_ref().unwrap_or(map);
    let mut caption = format!("{}: {} over {} and {}", cut(name, NAME), cut(&map.of, NAME), map.x.column, map.y.column);
    for said in [&map.panel, &map.less].into_iter().filter(|said| !said.is_empty()) {
        caption += &format!(", {said}");
    }
    if let Some(width) = map.width {
        caption += &format!("; smoothed over {width:.2} of the range of both axes, a width of this panel's own");
    }
    let is_pair = map.difference.is_some();
    if map.failing() > 0 {
        caption += &format!("; crosses: {}", if is_pair { "pairs with a bad run" } else { "bad runs" });
    }
    if map.beyond > 0 {
        let what = if is_pair { "pairs with a run beyond the model" } else { "runs beyond the model" };
        caption += &format!("; diamonds: {what}");
    }
    if map.lacks_limits() {
        caption += "; grey where there are no limits";
    }
    if map.cells.iter().any(|cell| is_open(cell) || map.is_unsure(cell)) {
        caption += "; grey: left open by them, with both numbers beside the pointer";
    }
    if every > 1 {
        caption += &format!("; one of {every} values along each axis is drawn, `bladeoff map --out F.png` draws all");
    }
    // the caption says what it is
    let drawing = figures::maps("", std::slice::from_ref(map))?.svg().to_owned();
    Ok(Figure { caption, drawing, plot: Some(plot(map)), table: None })
}

/// Places of a map of which one of so many values is drawn along each axis; at least one.
fn places(map: &Map, every: usize) -> usize {
    let along = |axis: &Axis| axis.at.len().div_ceil(every).max(1);
    // one that is left cannot be thinned any more
    if along(&map.x) == 1 && along(&map.y) == 1 { 0 } else { along(&map.x) * along(&map.y) }
}

/// The cells of one of so many values along each axis.
fn thinned(map: &Map, every: usize) -> Map {
    let axis = |axis: &Axis| Axis { at: axis.at.iter().copied().step_by(every).collect(), ..axis.clone() };
    let is_kept = |cell: &&Cell| cell.at.0.is_multiple_of(every) && cell.at.1.is_multiple_of(every);
    let cell = |cell: &Cell| Cell { at: (cell.at.0 / every, cell.at.1 / every), ..cell.clone() };
    let cells = map.cells.iter().filter(is_kept).map(cell).collect();
    Map { x: axis(&map.x), y: axis(&map.y), cells, ..map.clone() }
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
            vec![("smoothed", middle), (HALF_WIDTH, half)]
        }
    };
    let count = shown.len();
    let (x, y) = (axis(&map.x), axis(&map.y));
    let mut traces = Vec::new();
    let mut layout = json!({ "height": 470, "margin": { "l": 64, "r": 64, "t": 60, "b": 48 }, "annotations": [], "showlegend": false });
    // side by side there is no room on a telephone
    let mut narrow =
        json!({ "height": 60 + 410 * count, "margin": { "l": 56, "r": 56, "t": 60, "b": 48 }, "annotations": [] });
    for (at, (what, pick)) in shown.into_iter().enumerate() {
        let number = if at == 0 { String::new() } else { (at + 1).to_string() };
        let (drawn, colours, title) = cells(map, what, pick, &number);
        traces.extend(drawn);
        let wide = match (at, count) {
            (_, 1) => (0.0, 0.94),
            (0, _) => (0.0, 0.4),
            _ => (0.57, 0.97),
        };
        // room for the title and the labels between two
        let stacked = match (at, count) {
            (_, 1) => (0.0, 1.0),
            (0, _) => (0.575, 1.0),
            _ => (0.0, 0.425),
        };
        for (layout, across, up) in [(&mut layout, wide, (0.0, 1.0)), (&mut narrow, (0.0, 0.94), stacked)] {
            layout[format!("xaxis{number}")] = json!({
                "title": { "text": plain(&x.1) }, "domain": [across.0, across.1], "anchor": format!("y{number}"), "zeroline": false,
            });
            layout[format!("yaxis{number}")] = json!({
                "title": { "text": plain(&y.1) }, "domain": [up.0, up.1], "anchor": format!("x{number}"), "zeroline": false,
            });
            if at > 0 {
                layout[format!("xaxis{number}")]["matches"] = json!("x");
                layout[format!("yaxis{number}")]["matches"] = json!("y");
            }
            let mut colours = colours.clone();
            colours["colorbar"] = json!({
                "x": across.1 + 0.01, "xanchor": "left", "xpad": 0, "y": 0.5 * (up.0 + up.1), "yanchor": "middle", "ypad": 0,
                "len": up.1 - up.0, "thickness": 12, "exponentformat": "power", "outlinewidth": 0,
            });
            layout[format!("coloraxis{number}")] = colours;
            let title = json!({
                "text": plain(&title), "xref": "paper", "yref": "paper", "x": across.0, "xanchor": "left", "y": up.1, "yanchor": "bottom",
                "yshift": 4, "showarrow": false, "align": "left",
            });
            layout["annotations"].as_array_mut().expect("made as one").push(title);
        }
    }
    layout["narrow"] = narrow;
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

/// Cells, and marks where runs are not ok; their colours; what they are, with the unit of the colours.
fn cells(map: &Map, what: &str, pick: Pick, number: &str) -> (Vec<Value>, Value, String) {
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
    let shown = |cell: &Cell| if is_open(cell) || map.is_unsure(cell) { None } else { pick(cell) };
    let value = |cell: Option<&Cell>| json!(cell.and_then(shown).map(|value| short(value * scale.factor)));
    let grey = |cell: Option<&Cell>| json!(cell.filter(|cell| shown(cell).is_none()).map(|_| 0));
    let told = |cell: Option<&Cell>| {
        json!(cell.map_or(String::new(), |cell| plain(&words(cell, &scale, map.difference.is_some()))))
    };
    let along = |axis: &Axis, factor: f64| axis.at.iter().map(|value| short(value * factor)).collect::<Vec<_>>();
    let name = if what.is_empty() { of_in_words(map) } else { what.to_owned() };
    let heat = json!({
        "type": "heatmap", "x": along(&map.x, x.0), "y": along(&map.y, y.0), "z": by_rows(&value), "text": by_rows(&told),
        "hoverinfo": "x+y+text", "xaxis": format!("x{number}"), "yaxis": format!("y{number}"), "name": plain(&name),
        "coloraxis": format!("coloraxis{number}"),
    });
    let is_width = what == HALF_WIDTH;
    let mut colours = if map.difference.is_some() && !is_width {
        json!({ "colorscale": [[0, "rgb(0,114,178)"], [0.5, "rgb(247,247,247)"], [1, "rgb(213,94,0)"]], "cmid": 0 })
    } else {
        json!({ "colorscale": "Viridis" })
    };
    let largest = map.cells.iter().filter_map(shown).fold(0.0_f64, |most, value| most.max(value.abs()));
    if is_width {
        // nothing is uncertain: one colour
        let high = if largest == 0.0 { 1.0 } else { largest };
        (colours["cmin"], colours["cmax"]) = (json!(0), json!(short(high * scale.factor)));
    }
    let grey = json!({
        "type": "heatmap", "x": heat["x"], "y": heat["y"], "z": by_rows(&grey), "text": heat["text"], "hoverinfo": "x+y+text",
        "xaxis": heat["xaxis"], "yaxis": heat["yaxis"], "showscale": false, "colorscale": [[0, GREY], [1, GREY]],
    });
    let mut traces = vec![heat, grey];
    // where they are, or in which cells
    let marked = |places: &[(f64, f64)], count: fn(&Cell) -> u64| -> Vec<(f64, f64)> {
        if map.is_smoothed() {
            places.iter().copied().step_by(places.len().div_ceil(MOST_CROSSES).max(1)).collect()
        } else {
            map.cells.iter().filter(|cell| count(cell) > 0).map(|cell| (cell.x, cell.y)).collect()
        }
    };
    let failing = (marked(&map.bad_at, |cell| cell.bad - cell.beyond), "x");
    let beyond = (marked(&map.beyond_at, |cell| cell.beyond), "diamond-open");
    for (bad, symbol) in [failing, beyond].into_iter().filter(|(places, _)| !places.is_empty()) {
        traces.push(json!({
            "type": "scatter", "mode": "markers", "hoverinfo": "skip",
            "x": bad.iter().map(|place| short(place.0 * x.0)).collect::<Vec<_>>(),
            "y": bad.iter().map(|place| short(place.1 * y.0)).collect::<Vec<_>>(),
            "xaxis": format!("x{number}"), "yaxis": format!("y{number}"),
            "marker": { "symbol": symbol, "size": 8, "color": "rgb(255,255,255)", "line": { "width": 1, "color": "rgb(0,0,0)" } },
        }));
    }
    // the uncertainty has the name of no quantity
    let title = match what {
        "" | HALF_WIDTH => name,
        what => format!("{}, {what}", of_in_words(map)),
    };
    (traces, colours, scale.label(&cut(&title, NAME)))
}

/// The numbers of a cell.
fn words(cell: &Cell, scale: &Scale, is_difference: bool) -> String {
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
    let s = if cell.n == 1 { "" } else { "s" };
    text += &if is_difference {
        format!("; {} pair{s}, {} with a bad run", cell.n, cell.bad - cell.beyond)
    } else {
        format!("; {} run{s}, {} bad", cell.n, cell.bad - cell.beyond)
    };
    if cell.beyond > 0 {
        text += &format!(", {} {}beyond the model", cell.beyond, if is_difference { "with a run " } else { "" });
    }
    if let Some(regime) = &cell.regime {
        text += &format!("; {regime}");
    }
    text
}
