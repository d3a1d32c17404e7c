//! A picture in a page: drawn once for all, and by the chart library where scripts run.

use super::table::Table;
use serde_json::{Value, json};

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it shows, in words.
    pub caption: String,
    /// SVG made by this program, shown where scripts do not run and in print. Text in it has been escaped.
    pub drawing: String,
    /// The same for the chart library, which lets zoom and hover; `None`: the drawing alone.
    pub plot: Option<Plot>,
    /// Its numbers, where they are few.
    pub table: Option<Table>,
}

/// What the chart library draws.
#[derive(Debug, Clone, PartialEq)]
pub enum Plot {
    /// Plotly's traces and layout. Names and titles in them went through [`super::plain`]; a colour may be one of the page's, which suit
    /// light and dark: `"@c0"` to `"@c6"`, `"@ink"`, `"@quiet"`, `"@grid"`, `"@bad"`, with an opacity `"@c0/0.2"`.
    Traces(Value, Value),
    /// Points whose axes the reader chooses.
    Explorer(Explorer),
}

/// Points with many coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Explorer {
    /// Label and values of each coordinate.
    pub columns: Vec<(String, Vec<Option<f64>>)>,
    /// Names of 0, 1, ... of a coordinate that has words; none: numbers.
    pub words: Vec<Vec<String>>,
    /// Number of the sample of each point.
    pub samples: Vec<u64>,
    /// Which of `kinds` each point is.
    pub kind: Vec<usize>,
    /// "ok", then causes.
    pub kinds: Vec<String>,
    /// Coordinates that are shown first.
    pub first: (usize, usize),
}

impl Plot {
    /// As the page's script reads it.
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

/// Six significant digits: more nobody sees in a picture, and they are half of a page.
#[must_use]
pub(super) fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
