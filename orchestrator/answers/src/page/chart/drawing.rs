//! A chart as SVG.

use super::labels::{Corner, placed};
use super::{Chart, Series, Shape, Symbol};
use crate::drawing::{Anchor, Frame, LETTER, LINE, MOST_LETTERS, Ruling, Svg, TEXT};
use bladeoff_text::document::cut;

/// Units of a drawing: it is stretched to the page's width.
pub(super) const WIDTH: f64 = 900.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 10.0;

fn corners(frame: &Frame<'_>, there: &[((f64, f64), String)]) -> Vec<Corner> {
    let points: Vec<(f64, f64)> = there.iter().map(|(point, _)| *point).collect();
    let letters: Vec<usize> = there.iter().map(|(_, text)| text.chars().count()).collect();
    placed(&points, &letters, [frame.left, frame.top, frame.left + frame.width, frame.top + frame.height])
}

impl Chart {
    fn frame(&self) -> Frame<'_> {
        let longest = self.y.ticks().iter().map(|(_, text)| text.chars().count().min(MOST_LETTERS)).max().unwrap_or(0);
        let left = 14.0 + LETTER * longest as f64 + if self.y.label.is_empty() { 4.0 } else { 24.0 };
        Frame::new(&self.x, &self.y, [left, TOP, WIDTH - RIGHT, TOP + f64::from(self.height)])
    }

    /// Where the drawing has the names of points.
    pub(super) fn corners(&self, labels: &[(f64, f64, String)]) -> Vec<Corner> {
        let frame = self.frame();
        let place = |(x, y, text): &(f64, f64, String)| {
            (frame.place((*x, *y)).unwrap_or((-WIDTH, -WIDTH)), cut(text, MOST_LETTERS))
        };
        corners(&frame, &labels.iter().map(place).collect::<Vec<_>>())
    }

    /// The drawing.
    pub(super) fn svg(&self) -> String {
        let frame = self.frame();
        let (left, width, height) = (frame.left, frame.width, frame.height);
        let mut svg = Svg::default();
        frame.axes(&mut svg, Ruling::Grid, left - 14.0);
        svg.put(format_args!(
            "<svg x=\"{left:.1}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height}\" viewBox=\"{left:.1} {TOP} {width:.1} {height}\">"
        ));
        self.series.iter().for_each(|series| draw(&mut svg, &frame, series));
        svg.0 += "</svg>\n";
        let below = if self.x.label.is_empty() { 2.0 * LINE } else { 3.0 * LINE };
        let bottom = legend(&mut svg, &self.series, TOP + height + below, left);
        whole(&svg, bottom)
    }
}

/// The drawing of these elements.
pub(super) fn whole(svg: &Svg, height: f64) -> String {
    let Svg(elements) = svg;
    format!(
        "<svg class=\"chart\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\">\n{elements}</svg>\n"
    )
}

fn draw(svg: &mut Svg, frame: &Frame<'_>, series: &Series) {
    let class = format!("class=\"{} {}\"", series.shape.class(), series.colour);
    match &series.shape {
        Shape::Line(points, _) => frame.line(svg, class, points.iter().copied()),
        Shape::Band(points) => {
            let back = points.iter().rev().map(|(x, _, high)| (*x, *high));
            frame.area(svg, class, points.iter().map(|(x, low, _)| (*x, *low)).chain(back));
        }
        Shape::Dots(points, _, symbol) => {
            svg.path(class, frame.places(points.iter().copied()).map(|place| dot(place, *symbol)).collect::<String>());
        }
        Shape::Bars(bars, thick) => {
            for (y, value) in bars {
                frame.rect(svg, &class, [(0.0, y - thick / 2.0), (*value, y + thick / 2.0)]);
            }
        }
        Shape::Labels(labels) => {
            let there: Vec<((f64, f64), String)> = labels
                .iter()
                .filter_map(|(x, y, text)| Some((frame.place((*x, *y))?, cut(text, MOST_LETTERS))))
                .collect();
            for ((point, text), corner) in there.iter().zip(corners(frame, &there)) {
                let anchor = if corner.left { Anchor::End } else { Anchor::Start };
                svg.text("class=\"name\"", corner.place(*point), anchor, text);
            }
        }
        Shape::Across(intervals) => {
            let (first, last) = frame.x.ends();
            for (y, low, high) in intervals {
                let ends = (frame.across(low.unwrap_or(first)), frame.across(high.unwrap_or(last)), frame.up(*y));
                let (Some(from), Some(to), Some(y)) = ends else { continue };
                let cap = |at: f64, is: bool| if is { format!("M{at:.1},{:.1}v10", y - 5.0) } else { String::new() };
                let caps = cap(from, low.is_some()) + &cap(to, high.is_some());
                svg.path(whisker(series, low, high), format_args!("M{from:.1},{y:.1}H{to:.1}{caps}"));
            }
        }
        Shape::Upright(intervals) => {
            let (first, last) = frame.y.ends();
            for (x, low, high) in intervals {
                let ends = (frame.up(low.unwrap_or(first)), frame.up(high.unwrap_or(last)), frame.across(*x));
                let (Some(from), Some(to), Some(x)) = ends else { continue };
                let cap = |at: f64, is: bool| if is { format!("M{:.1},{at:.1}h8", x - 4.0) } else { String::new() };
                let caps = cap(from, low.is_some()) + &cap(to, high.is_some());
                svg.path(whisker(series, low, high), format_args!("M{x:.1},{from:.1}V{to:.1}{caps}"));
            }
        }
    }
}

/// An interval without a limit on a side is dashed.
fn whisker(series: &Series, low: &Option<f64>, high: &Option<f64>) -> String {
    let dashed = if low.is_none() || high.is_none() { " dashed" } else { "" };
    format!("class=\"whisker{dashed} {}\"", series.colour)
}

impl Shape {
    /// Its class in the page's style.
    fn class(&self) -> &'static str {
        match self {
            Self::Line(_, false) => "line",
            Self::Line(_, true) => "line dashed",
            Self::Band(_) => "band",
            Self::Bars(..) => "bar",
            Self::Labels(_) => "name",
            Self::Across(_) | Self::Upright(_) => "whisker",
            Self::Dots(_, _, Symbol::Speck) => "speck",
            Self::Dots(_, _, Symbol::Disc) => "disc",
            Self::Dots(_, _, Symbol::Cross) => "cross",
            Self::Dots(_, _, Symbol::Ring) => "ring",
        }
    }
}

fn dot((x, y): (f64, f64), symbol: Symbol) -> String {
    let round = |radius: f64| {
        format!(
            "M{:.1},{y:.1}a{radius},{radius} 0 1 0 {},0a{radius},{radius} 0 1 0 -{},0",
            x - radius,
            2.0 * radius,
            2.0 * radius
        )
    };
    match symbol {
        // a line of no length with a round end is a point, in a tenth of the bytes
        Symbol::Speck => format!("M{x:.1},{y:.1}h0"),
        Symbol::Disc => round(4.0),
        Symbol::Ring => round(4.0),
        Symbol::Cross => format!("M{:.1},{:.1}l7,7m0-7l-7,7", x - 3.5, y - 3.5),
    }
}

/// Draws what colours mean; the bottom of the drawing.
pub(super) fn legend(svg: &mut Svg, series: &[Series], top: f64, left: f64) -> f64 {
    let (mut x, mut y) = (left, top + 4.0);
    let mut any = false;
    for series in series.iter().filter(|series| !series.name.is_empty()) {
        let name = cut(&series.name, 80);
        let width = 30.0 + LETTER * name.chars().count() as f64;
        if any && x + width > WIDTH - RIGHT {
            (x, y) = (left, y + LINE);
        }
        any = true;
        let class = format!("class=\"{} {}\"", series.shape.class(), series.colour);
        match &series.shape {
            Shape::Labels(_) => continue,
            Shape::Line(..) | Shape::Across(_) | Shape::Upright(_) => {
                svg.path(class, format_args!("M{x:.1},{y:.1}h20"));
            }
            Shape::Band(_) | Shape::Bars(..) => svg.rect(class, (x, y - 5.0), (x + 20.0, y + 5.0)),
            Shape::Dots(_, _, symbol) => svg.path(class, dot((x + 10.0, y), *symbol)),
        }
        svg.text("", (x + 26.0, y + TEXT), Anchor::Start, &name);
        x += width + 14.0;
    }
    if any { y + 12.0 } else { top - 8.0 }
}
