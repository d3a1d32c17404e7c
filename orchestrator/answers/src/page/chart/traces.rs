//! A chart for the chart library.

use super::labels::Corner;
use super::{Axis, Chart, Series, Shape, Symbol};
use crate::drawing::MOST_LETTERS;
use crate::page::escape::plain;
use crate::page::figure::short;
use bladeoff_text::document::cut;
use serde_json::{Value, json};

/// Room above the frame, where the library has its tools.
const TOOLS: usize = 34;

impl Chart {
    /// Traces and layout.
    pub(super) fn traces(&self) -> (Value, Value) {
        let traces: Vec<Value> = self.series.iter().flat_map(|series| self.series_traces(series)).collect();
        let names: Vec<usize> =
            self.series.iter().map(|series| series.name.chars().count()).filter(|count| *count > 0).collect();
        // the library sets names in columns as wide as the longest
        let columns = (820 / (56 + 7 * names.iter().max().copied().unwrap_or(0))).max(1);
        let bottom = 54 + 20 * names.len().div_ceil(columns);
        let legend = json!({ "orientation": "h", "x": 0, "yref": "container", "y": 0, "yanchor": "bottom" });
        let layout = json!({
            "xaxis": layout(&self.x), "yaxis": layout(&self.y), "barmode": "overlay", "legend": legend,
            "height": self.height as usize + TOOLS + bottom, "margin": { "l": 64, "r": 16, "t": TOOLS, "b": bottom },
        });
        (Value::Array(traces), layout)
    }

    fn series_traces(&self, series: &Series) -> Vec<Value> {
        let colour = format!("@{}", series.colour);
        let light = format!("@{}/0.18", series.colour);
        let name = plain(&series.name);
        let legend = !series.name.is_empty();
        let numbers = |values: &mut dyn Iterator<Item = f64>| values.map(short).collect::<Vec<_>>();
        match &series.shape {
            Shape::Line(points, dashed) => vec![json!({
                "type": "scatter", "mode": "lines", "name": name, "showlegend": legend,
                "x": numbers(&mut points.iter().map(|point| point.0)), "y": numbers(&mut points.iter().map(|point| point.1)),
                "line": { "color": colour, "width": 2, "dash": if *dashed { "dash" } else { "solid" } },
            })],
            Shape::Band(points) => {
                let edge = || {
                    points
                        .iter()
                        .map(|(x, low, _)| (*x, *low))
                        .chain(points.iter().rev().map(|(x, _, high)| (*x, *high)))
                };
                vec![json!({
                    "type": "scatter", "mode": "lines", "name": name, "showlegend": legend, "hoverinfo": "skip",
                    "x": numbers(&mut edge().map(|point| point.0)), "y": numbers(&mut edge().map(|point| point.1)),
                    "fill": "toself", "fillcolor": light, "line": { "width": 0, "color": light },
                })]
            }
            Shape::Dots(points, words, symbol) => {
                let mut marker = match symbol {
                    Symbol::Speck => json!({ "symbol": "circle", "size": 4, "opacity": 0.45 }),
                    Symbol::Disc => json!({ "symbol": "circle", "size": 9 }),
                    Symbol::Cross => json!({ "symbol": "x", "size": 8 }),
                    Symbol::Ring => json!({ "symbol": "circle-open", "size": 9, "line": { "width": 2 } }),
                };
                marker["color"] = json!(colour);
                let mut trace = json!({
                    "type": "scatter", "mode": "markers", "name": name, "showlegend": legend, "marker": marker,
                    "x": numbers(&mut points.iter().map(|point| point.0)), "y": numbers(&mut points.iter().map(|point| point.1)),
                });
                if !words.is_empty() {
                    trace["text"] = words.iter().map(|word| plain(word)).collect();
                    trace["hoverinfo"] = json!("text");
                }
                vec![trace]
            }
            Shape::Bars(bars, thick) => vec![json!({
                "type": "bar", "orientation": "h", "name": name, "showlegend": legend, "width": thick, "marker": { "color": colour },
                "x": numbers(&mut bars.iter().map(|bar| bar.1)), "y": numbers(&mut bars.iter().map(|bar| bar.0)),
            })],
            Shape::Labels(labels) => {
                let position = |corner: Corner| match (corner.below, corner.left) {
                    (false, false) => "top right",
                    (false, true) => "top left",
                    (true, false) => "bottom right",
                    (true, true) => "bottom left",
                };
                vec![json!({
                    // markers that are not seen keep names off the points
                    "type": "scatter", "mode": "markers+text", "showlegend": false, "hoverinfo": "skip", "cliponaxis": false,
                    "marker": { "size": 9, "color": "rgba(0,0,0,0)" },
                    "textposition": self.corners(labels).into_iter().map(position).collect::<Vec<_>>(),
                    "x": numbers(&mut labels.iter().map(|label| label.0)), "y": numbers(&mut labels.iter().map(|label| label.1)),
                    "text": labels.iter().map(|label| plain(&cut(&label.2, MOST_LETTERS))).collect::<Vec<_>>(),
                })]
            }
            Shape::Across(intervals) => {
                let ends = self.x.ends();
                self.intervals(series, intervals, ends, |along, at| (along, at))
            }
            Shape::Upright(intervals) => {
                let ends = self.y.ends();
                self.intervals(series, intervals, ends, |along, at| (at, along))
            }
        }
    }

    /// Lines between two limits, and where there is no limit to the edge, dashed.
    fn intervals(
        &self,
        series: &Series,
        intervals: &[(f64, Option<f64>, Option<f64>)],
        (first, last): (f64, f64),
        place: impl Fn(f64, f64) -> (f64, f64),
    ) -> Vec<Value> {
        let mut traces = Vec::new();
        for open in [false, true] {
            let (mut x, mut y): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
            for (at, low, high) in intervals.iter().filter(|(_, low, high)| (low.is_none() || high.is_none()) == open) {
                for along in [low.unwrap_or(first), high.unwrap_or(last)] {
                    let (across, up) = place(along, *at);
                    x.push(json!(short(across)));
                    y.push(json!(short(up)));
                }
                x.push(Value::Null);
                y.push(Value::Null);
            }
            if x.is_empty() {
                continue;
            }
            let line = json!({ "color": format!("@{}", series.colour), "width": 2, "dash": if open { "dash" } else { "solid" } });
            traces.push(json!({
                "type": "scatter", "mode": "lines", "name": plain(&series.name), "x": x, "y": y, "line": line,
                "showlegend": !series.name.is_empty() && traces.is_empty(),
            }));
        }
        traces
    }
}

fn layout(axis: &Axis) -> Value {
    let mut layout =
        json!({ "title": { "text": plain(&axis.label) }, "range": [short(axis.range.0), short(axis.range.1)] });
    if axis.log {
        layout["type"] = json!("log");
        if axis.range.1 - axis.range.0 >= 2.0 {
            layout["dtick"] = json!(1);
        }
    }
    if !axis.at.is_empty() {
        layout["tickvals"] = json!(axis.at);
        layout["ticktext"] = axis.ticks().into_iter().map(|(_, text)| text).collect();
    }
    if !axis.words.is_empty() {
        layout["tickvals"] = (0..axis.words.len()).collect();
        layout["ticktext"] = axis.words.iter().map(|word| plain(word)).collect();
        layout["zeroline"] = json!(false);
    }
    layout
}
