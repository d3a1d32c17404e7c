//! Charts of a page: one description, drawn as SVG and given to the chart library, so that both show the same.
//!
//! Colours are classes of the page's style, so that a drawing is light, dark and printed as the page is. An interval that has no limit on a side
//! goes to the edge of the frame there, dashed.

mod drawing;
mod labels;
mod parallel;
mod traces;

pub use crate::drawing::{Axis, shown};
pub use parallel::{Coordinate, parallel};

use super::figure::{Figure, Plot};
use super::table::Table;

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Across.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// In the order they are drawn.
    pub series: Vec<Series>,
    /// Pixels of its frame.
    pub height: u32,
}

/// Something in a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; empty: not there.
    pub name: String,
    /// `c0` to `c6`, `ink`, `quiet`, `bad`.
    pub colour: &'static str,
    /// What it is.
    pub shape: Shape,
}

/// How numbers are shown.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A line through points; dashed or not.
    Line(Vec<(f64, f64)>, bool),
    /// Between two lines: x, lower, upper.
    Band(Vec<(f64, f64, f64)>),
    /// Points, each with words of its own (none: its numbers).
    Dots(Vec<(f64, f64)>, Vec<String>, Symbol),
    /// Bars from zero along x, at these places of y; how thick they are.
    Bars(Vec<(f64, f64)>, f64),
    /// Words at places, above and to the right.
    Labels(Vec<(f64, f64, String)>),
    /// Intervals along x: y, lower, upper; `None`: no limit.
    Across(Vec<(f64, Option<f64>, Option<f64>)>),
    /// Intervals along y: x, lower, upper.
    Upright(Vec<(f64, Option<f64>, Option<f64>)>),
}

/// Shape of a dot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    /// Small and light: one of many.
    Speck,
    /// One that is looked at.
    Disc,
    /// A cross: something went wrong.
    Cross,
    /// Open: the other end of what is left open.
    Ring,
}

/// Colours by number.
pub const COLOURS: [&str; 7] = ["c0", "c1", "c2", "c3", "c5", "c4", "c6"];

impl Chart {
    /// With its caption.
    #[must_use]
    pub fn figure(&self, caption: impl Into<String>, table: Option<Table>) -> Figure {
        let (traces, layout) = self.traces();
        Figure { caption: caption.into(), drawing: self.svg(), plot: Some(Plot::Traces(traces, layout)), table }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> Chart {
        let names = vec!["a <b>".to_owned(), "c".to_owned()];
        Chart {
            x: Axis::numbers("load [kN]", [0.0, 2.5].into_iter()),
            y: Axis::words(names),
            series: vec![
                Series {
                    name: "bars & all".into(),
                    colour: "c0",
                    shape: Shape::Bars(vec![(0.0, 1.0), (1.0, 2.0)], 0.6),
                },
                Series { name: String::new(), colour: "ink", shape: Shape::Across(vec![(0.0, Some(0.5), None)]) },
                Series {
                    name: "dots".into(),
                    colour: "bad",
                    shape: Shape::Dots(vec![(f64::NAN, 0.0), (1.0, 1.0)], Vec::new(), Symbol::Cross),
                },
            ],
            height: 200,
        }
    }

    #[test]
    fn a_drawing_has_what_is_described_and_no_markup_from_outside() {
        let figure = chart().figure("About <i>it</i>", None);
        assert_eq!(figure.drawing.matches("class=\"bar").count(), 3, "with the legend's: {}", figure.drawing);
        assert!(
            figure.drawing.contains("a &lt;b&gt;") && figure.drawing.contains("bars &amp; all"),
            "{}",
            figure.drawing
        );
        assert!(figure.drawing.contains("dashed"), "no upper limit: {}", figure.drawing);
        assert!(!figure.drawing.contains("NaN") && !figure.drawing.contains("inf"), "{}", figure.drawing);
        let Some(Plot::Traces(traces, layout)) = figure.plot else { panic!("a plot") };
        assert_eq!(
            traces.as_array().map(Vec::len),
            Some(3),
            "bars, an interval without an upper limit, dots: {traces}"
        );
        assert_eq!(traces[0]["name"], "bars &amp; all");
        assert_eq!(layout["yaxis"]["ticktext"][0], "a &lt;b&gt;");
    }

    #[test]
    fn extreme_numbers_are_numbers_in_a_drawing() {
        for extreme in [[f64::MIN, f64::MAX], [1e308, -1e308], [5e-324, 0.0], [1e20, 1e20], [f64::NAN, f64::INFINITY]] {
            let points: Vec<(f64, f64)> = extreme.iter().map(|value| (*value, *value)).collect();
            for is_log in [false, true] {
                let axis = |name: &str| {
                    if is_log { Axis::log(name, extreme.into_iter()) } else { Axis::numbers(name, extreme.into_iter()) }
                };
                let shapes = [
                    Shape::Line(points.clone(), false),
                    Shape::Dots(points.clone(), Vec::new(), Symbol::Ring),
                    Shape::Band(points.iter().map(|(x, y)| (*x, *y, -*y)).collect()),
                    Shape::Bars(points.clone(), 0.5),
                    Shape::Across(vec![(extreme[0], Some(extreme[0]), Some(extreme[1]))]),
                    Shape::Upright(vec![(extreme[0], Some(extreme[1]), None)]),
                    Shape::Labels(vec![(extreme[0], extreme[1], "here".into())]),
                ];
                let series = |shape| Series { name: "a".into(), colour: "c0", shape };
                let chart =
                    Chart { x: axis("x"), y: axis("y"), series: shapes.into_iter().map(series).collect(), height: 200 };
                let figure = chart.figure("extreme", None);
                assert!(!figure.drawing.contains("NaN") && !figure.drawing.contains("inf"), "{}", figure.drawing);
            }
        }
        // the ends of all numbers that there are, both within the frame
        let axis = Axis::numbers("", [f64::MIN, f64::MAX].into_iter());
        assert_eq!([f64::MIN, 0.0, f64::MAX].map(|value| axis.share(value)), [Some(0.0), Some(0.5), Some(1.0)]);
    }

    #[test]
    fn a_chart_of_nothing_is_drawn() {
        let chart = Chart {
            x: Axis::numbers("x", [].into_iter()),
            y: Axis::log("y", [].into_iter()),
            series: Vec::new(),
            height: 200,
        };
        let figure = chart.figure("nothing", None);
        assert!(figure.drawing.starts_with("<svg ") && !figure.drawing.contains("NaN"), "{}", figure.drawing);
    }
}
