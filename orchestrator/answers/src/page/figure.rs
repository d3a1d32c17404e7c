//! A picture in a page: a static SVG, and data for the chart library where scripts run.

use super::table::Table;
use serde_json::{Value, json};

/// A picture with its caption.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Caption.
    pub caption: String,
    /// SVG made by this program, shown in print and where scripts do not run. Texts in it are escaped.
    pub drawing: String,
    /// Interactive chart (zoom, hover) for the chart library; `None`: only the drawing.
    pub plot: Option<Plot>,
    /// Numbers of the picture, if they are few.
    pub table: Option<Table>,
}

/// Input of the chart library.
#[derive(Debug, Clone, PartialEq)]
pub enum Plot {
    /// Traces and layout of Plotly. Names and titles in them are escaped by [`super::plain`]. A colour may be one of the page's names, which
    /// fit its light and dark style: `"@c0"` to `"@c6"`, `"@ink"`, `"@quiet"`, `"@grid"`, `"@bad"`, with an opacity `"@c0/0.2"`.
    Traces(Value, Value),
    /// Points whose axes the reader chooses.
    Explorer(Explorer),
}

/// Points with many coordinates, two of which are plotted at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Explorer {
    /// Label and values of each coordinate.
    pub columns: Vec<(String, Vec<Option<f64>>)>,
    /// Words of the values 0, 1, ... of a coordinate; empty for numbers.
    pub words: Vec<Vec<String>>,
    /// Number of the sample of each point.
    pub samples: Vec<u64>,
    /// Index in `kinds` of each point.
    pub kind: Vec<usize>,
    /// Names of the kinds: "ok", then causes.
    pub kinds: Vec<String>,
    /// Coordinates plotted first.
    pub first: (usize, usize),
}

impl Plot {
    /// JSON for the script of the page.
    pub(super) fn json(&self) -> Value {
        match self {
            Self::Traces(traces, layout) => json!({ "traces": traces, "layout": layout }),
            Self::Explorer(explorer) => {
                let columns = explorer.columns.iter();
                json!({ "explorer": {
                    "labels": columns.clone().map(|(label, _)| label).collect::<Vec<_>>(),
                    "columns": columns.map(|(_, values)| values.iter().map(|value| value.map(short)).collect::<Vec<_>>()).collect::<Vec<_>>(),
                    "words": explorer.words,
                    "samples": explorer.samples,
                    "kind": explorer.kind,
                    "kinds": explorer.kinds,
                    "first": [explorer.first.0, explorer.first.1],
                } })
            }
        }
    }
}

/// Rounds to six significant digits: more are not visible in a picture and would double the size of the page.
#[must_use]
pub(super) fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
