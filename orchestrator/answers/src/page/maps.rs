//! Maps in a page: the static picture, and its layers for the chart library with the numbers of each cell.

use super::escape::plain;
use super::figure::{Figure, Plot, short};
use crate::drawing::Rgb;
use crate::figures::{
    COLOURS, Colours, Layers, MapScales, Picture, STEPS, Scale, UNKNOWN, maps_on, marks, pictures_of, stepped,
};
use crate::map::{Axis, Cell, Map};
use bladeoff_text::document::cut;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Largest number of characters of a name from a file.
const NAME: usize = 60;

/// Largest number of cell places of all maps of a page: about 300 bytes each, in a page of about five megabytes.
const MOST_PLACES: usize = 8000;

/// A figure for each panel and difference of a question of this name; `of`: number of maps of the whole page. Large grids are thinned
/// evenly, as the caption reports. All figures use the colour scales of the picture with all panels.
#[must_use]
pub fn map_figures(name: &str, maps: &[Map], of: usize) -> Vec<Figure> {
    let scales = MapScales::of(maps);
    maps.iter().map(|map| map_figure(name, map, of, &scales)).collect()
}

fn map_figure(name: &str, map: &Map, of: usize, scales: &MapScales) -> Figure {
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
    for mark in marks(std::slice::from_ref(map)) {
        caption += &format!("; {mark}");
    }
    if every > 1 {
        caption += &format!("; one of {every} values along each axis is drawn, `bladeoff map --out F.png` draws all");
    }
    // the caption has the title
    let drawing = maps_on("", std::slice::from_ref(map), scales).svg().to_owned();
    let plot = (!map.cells.is_empty()).then(|| plot(map, scales));
    Figure { caption, drawing, plot, table: None }
}

/// Number of places of a map if one of `every` values is drawn along each axis.
fn places(map: &Map, every: usize) -> usize {
    let along = |axis: &Axis| axis.at.len().div_ceil(every).max(1);
    // a single place cannot be thinned further
    if along(&map.x) == 1 && along(&map.y) == 1 { 0 } else { along(&map.x) * along(&map.y) }
}

/// Map with one of `every` values along each axis.
fn thinned(map: &Map, every: usize) -> Map {
    let axis = |axis: &Axis| Axis { at: axis.at.iter().copied().step_by(every).collect(), ..axis.clone() };
    let is_kept = |cell: &&Cell| cell.at.0.is_multiple_of(every) && cell.at.1.is_multiple_of(every);
    let cell = |cell: &Cell| Cell { at: (cell.at.0 / every, cell.at.1 / every), ..cell.clone() };
    let cells = map.cells.iter().filter(is_kept).map(cell).collect();
    Map { x: axis(&map.x), y: axis(&map.y), cells, ..map.clone() }
}

fn plot(map: &Map, scales: &MapScales) -> Plot {
    let pictures: Vec<(Picture<'_>, &Colours)> =
        pictures_of(map).into_iter().filter_map(|picture| scales.get(picture.kind).map(|of| (picture, of))).collect();
    let count = pictures.len();
    let mut traces = Vec::new();
    let mut layout = json!({ "height": 480, "margin": { "l": 64, "r": 64, "t": 70, "b": 48 }, "annotations": [], "shapes": [], "showlegend": false });
    // two pictures side by side do not fit on a telephone
    let mut narrow = json!({ "height": 70 + 410 * count, "margin": { "l": 56, "r": 56, "t": 70, "b": 48 }, "annotations": [], "shapes": [] });
    for (at, (picture, colours)) in pictures.iter().enumerate() {
        let number = if at == 0 { String::new() } else { (at + 1).to_string() };
        let layers = Layers::new(picture, colours);
        traces.extend(drawn(picture, &layers, colours, &number));
        let wide = match (at, count) {
            (_, 1) => (0.0, 0.94),
            (0, _) => (0.0, 0.4),
            _ => (0.57, 0.97),
        };
        // leave room for title and labels between the pictures
        let stacked = match (at, count) {
            (_, 1) => (0.0, 1.0),
            (0, _) => (0.59, 1.0),
            _ => (0.0, 0.41),
        };
        for (layout, across, up) in [(&mut layout, wide, (0.0, 1.0)), (&mut narrow, (0.0, 0.94), stacked)] {
            for (axis, of, domain, anchor) in [("x", &layers.x, across, "y"), ("y", &layers.y, up, "x")] {
                let ends = of.ends();
                let mut drawn = json!({
                    "title": { "text": plain(&of.label) }, "domain": [domain.0, domain.1], "anchor": format!("{anchor}{number}"),
                    "range": [short(ends.0), short(ends.1)], "showgrid": false, "zeroline": false,
                });
                if at > 0 {
                    drawn["matches"] = json!(axis);
                }
                layout[format!("{axis}axis{number}")] = drawn;
            }
            let bar = json!({
                "x": across.1 + 0.01, "xanchor": "left", "xpad": 0, "y": 0.5 * (up.0 + up.1), "yanchor": "middle", "ypad": 0,
                "len": up.1 - up.0, "thickness": 12, "outlinewidth": 0, "ticks": "outside",
                "tickvals": colours.levels.iter().map(|level| short(colours.share(*level))).collect::<Vec<_>>(),
                "ticktext": colours.levels.iter().map(|level| colours.mark(*level)).collect::<Vec<_>>(),
            });
            layout[format!("coloraxis{number}")] =
                json!({ "colorscale": scale_of(colours), "cmin": 0, "cmax": 1, "colorbar": bar });
            let title = json!({
                "text": format!("{}<br>{}", plain(&cut(&picture.what, NAME)), plain(&colours.label(&picture.name))), "xref": "paper",
                "yref": "paper", "x": across.0, "xanchor": "left", "y": up.1, "yanchor": "bottom", "yshift": 4, "showarrow": false,
                "align": "left",
            });
            let names = layers.names.iter().map(|(name, place)| {
                json!({
                    "text": plain(name), "x": short(place.0), "y": short(place.1), "xref": format!("x{number}"), "yref": format!("y{number}"),
                    "showarrow": false, "bgcolor": "rgba(255,255,255,0.75)", "font": { "color": "rgb(0,0,0)" },
                })
            });
            if !layers.hatching.is_empty() {
                let path: String = layers
                    .hatching
                    .iter()
                    .map(|[a, b]| format!("M{},{}L{},{}", short(a.0), short(a.1), short(b.0), short(b.1)))
                    .collect();
                layout["shapes"].as_array_mut().expect("made as one").push(json!({
                    "type": "path", "path": path, "layer": "below", "xref": format!("x{number}"), "yref": format!("y{number}"),
                    "line": { "color": "@line", "width": 1 },
                }));
            }
            layout["annotations"].as_array_mut().expect("made as one").extend(std::iter::once(title).chain(names));
        }
    }
    layout["narrow"] = narrow;
    Plot::Traces(Value::Array(traces), layout)
}

/// Steps of the colour scale for the chart library.
fn scale_of(colours: &Colours) -> Vec<Value> {
    let step = |at: usize| at as f64 / STEPS as f64;
    (0..=STEPS).map(|at| json!([step(at), css(colours.at(step(at)))])).collect()
}

fn css(Rgb(red, green, blue): Rgb) -> String {
    format!("rgb({red},{green},{blue})")
}

/// Traces of a picture, in drawing order.
fn drawn(picture: &Picture<'_>, layers: &Layers, colours: &Colours, number: &str) -> Vec<Value> {
    let map = picture.map;
    let place = |mut trace: Value| {
        trace["xaxis"] = json!(format!("x{number}"));
        trace["yaxis"] = json!(format!("y{number}"));
        trace
    };
    let lines = |lines: &[&[(f64, f64)]], colour: &str, width: f64| {
        let (x, y) = joined(lines);
        place(json!({
            "type": "scatter", "mode": "lines", "x": x, "y": y, "hoverinfo": "skip", "line": { "color": colour, "width": width },
        }))
    };
    let mut traces = Vec::new();
    // [row of y][column of x]
    let mut table: Vec<Vec<Option<usize>>> = vec![vec![None; map.x.at.len()]; map.y.at.len()];
    for (at, cell) in map.cells.iter().enumerate() {
        table[cell.at.1][cell.at.0] = Some(at);
    }
    let by_rows = |of: &dyn Fn(usize) -> Value| -> Vec<Vec<Value>> {
        table.iter().map(|row| row.iter().map(|at| at.map_or(Value::Null, of)).collect()).collect()
    };
    let value = |at: usize| json!(layers.tiles[at].harmless.map(|share| short(stepped(share))));
    let grey = |at: usize| json!(layers.tiles[at].harmless.is_none().then_some(0));
    let said = |at: usize| json!(plain(&words(&map.cells[at], colours.scale(), map.difference.is_some())));
    let edges = |edges: &[f64]| edges.iter().map(|edge| short(*edge)).collect::<Vec<_>>();
    let heat = |z: Vec<Vec<Value>>| {
        place(json!({
            "type": "heatmap", "x": edges(&layers.x.edges), "y": edges(&layers.y.edges), "z": z, "text": by_rows(&said),
            "hoverinfo": "x+y+text", "name": plain(&picture.what),
        }))
    };
    let mut coloured = heat(by_rows(&value));
    coloured["coloraxis"] = json!(format!("coloraxis{number}"));
    traces.push(coloured);
    if layers.tiles.iter().any(|tile| tile.harmless.is_none()) {
        let mut grey = heat(by_rows(&grey));
        grey["showscale"] = json!(false);
        grey["colorscale"] = json!([[0, css(UNKNOWN)], [1, css(UNKNOWN)]]);
        traces.push(grey);
    }
    // triangles of one colour form one trace
    let mut halves: BTreeMap<String, Vec<[(f64, f64); 3]>> = BTreeMap::new();
    for tile in &layers.tiles {
        if let Some(harmful) = tile.harmful {
            let colour = css(harmful.map_or(UNKNOWN, |share| colours.at(share)));
            halves.entry(colour).or_default().push(tile.upper_half(tile.to));
        }
    }
    for (colour, halves) in &halves {
        let (x, y) = joined(&slices(halves));
        traces.push(place(json!({
            "type": "scatter", "mode": "none", "x": x, "y": y, "hoverinfo": "skip", "fill": "toself", "fillcolor": colour,
        })));
    }
    for (pieces, ink, width) in
        [(slices(&layers.contours), "rgb(0,0,0)", 1.0), (slices(&layers.boundaries), &css(COLOURS[1]), 3.0)]
    {
        if !pieces.is_empty() {
            traces.push(lines(&pieces, "rgb(255,255,255)", width + 1.5));
            traces.push(lines(&pieces, ink, width));
        }
    }
    for (places, symbol) in [(&layers.diamonds, "diamond-open"), (&layers.crosses, "x-thin-open")] {
        // black on white, as in the picture: a white line alone is invisible on yellow and grey
        for (colour, width) in [("rgb(255,255,255)", 5), ("rgb(0,0,0)", 2)] {
            if !places.is_empty() {
                traces.push(place(json!({
                    "type": "scatter", "mode": "markers", "hoverinfo": "skip",
                    "x": places.iter().map(|place| short(place.0)).collect::<Vec<_>>(),
                    "y": places.iter().map(|place| short(place.1)).collect::<Vec<_>>(),
                    "marker": { "symbol": symbol, "size": 9, "color": colour, "line": { "width": width } },
                })));
            }
        }
    }
    traces
}

fn slices<L: AsRef<[(f64, f64)]>>(lines: &[L]) -> Vec<&[(f64, f64)]> {
    lines.iter().map(AsRef::as_ref).collect()
}

/// Coordinates of several lines, separated by gaps.
fn joined(lines: &[&[(f64, f64)]]) -> (Vec<Value>, Vec<Value>) {
    let along = |of: fn(&(f64, f64)) -> f64| {
        lines.iter().flat_map(|line| line.iter().map(|point| json!(short(of(point)))).chain([Value::Null])).collect()
    };
    (along(|point| point.0), along(|point| point.1))
}

/// Numbers of a cell as text.
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
