//! A chart as SVG.

use super::{Axis, Chart, Series, Shape, Symbol};
use crate::page::escape::html;
use std::fmt::Write;

/// Units of a drawing: it is stretched to the page's width.
pub(super) const WIDTH: f64 = 900.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 10.0;
/// Of a letter.
const LETTER: f64 = 7.0;
const LINE: f64 = 18.0;
/// Letters of a name at an axis.
const MOST_LETTERS: usize = 44;

/// Where the frame is.
struct Frame<'a> {
    x: &'a Axis,
    y: &'a Axis,
    left: f64,
    width: f64,
    height: f64,
}

impl Frame<'_> {
    fn across(&self, value: f64) -> Option<f64> {
        // far outside is outside, and a number that every reader of SVG takes
        Some(self.left + self.width * self.x.share(value)?.clamp(-3.0, 4.0))
    }

    fn up(&self, value: f64) -> Option<f64> {
        Some(TOP + self.height * (1.0 - self.y.share(value)?.clamp(-3.0, 4.0)))
    }

    fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        Some((self.across(x)?, self.up(y)?))
    }

    fn path(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        points.filter_map(|point| self.place(point)).map(|(x, y)| format!("{x:.1},{y:.1} ")).collect()
    }
}

impl Chart {
    /// The drawing.
    pub(super) fn svg(&self) -> String {
        let height = f64::from(self.height);
        let longest = self.y.ticks().iter().map(|(_, text)| text.chars().count().min(MOST_LETTERS)).max().unwrap_or(0);
        let left = 14.0 + LETTER * longest as f64 + if self.y.label.is_empty() { 4.0 } else { 24.0 };
        let frame = Frame { x: &self.x, y: &self.y, left, width: WIDTH - left - RIGHT, height };
        let mut out = String::new();
        axes(&mut out, &frame);
        out.push_str(&format!(
            "<svg x=\"{left:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{height}\" viewBox=\"{left:.1} {TOP} {:.1} {height}\">\n",
            frame.width, frame.width
        ));
        self.series.iter().for_each(|series| draw(&mut out, &frame, series));
        out.push_str("</svg>\n");
        let bottom = legend(
            &mut out,
            &self.series,
            TOP + height + 2.0 * LINE + if self.x.label.is_empty() { 0.0 } else { LINE },
            left,
        );
        format!(
            "<svg class=\"chart\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {bottom:.0}\">\n{out}</svg>\n"
        )
    }
}

fn axes(out: &mut String, frame: &Frame<'_>) {
    let (left, bottom) = (frame.left, TOP + frame.height);
    let mut put = |text: std::fmt::Arguments<'_>| out.write_fmt(text).expect("writing to a String cannot fail");
    let mut free = f64::NEG_INFINITY;
    for (value, text) in frame.x.ticks() {
        let Some(x) = frame.across(value) else { continue };
        put(format_args!("<path class=\"grid\" d=\"M{x:.1},{TOP}V{bottom}\"/>\n"));
        let half = LETTER * text.chars().count() as f64 / 2.0;
        if x - half > free {
            put(format_args!(
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
                bottom + LINE,
                html(&text)
            ));
            free = x + half + LETTER;
        }
    }
    for (value, text) in frame.y.ticks() {
        let Some(y) = frame.up(value) else { continue };
        put(format_args!("<path class=\"grid\" d=\"M{left:.1},{y:.1}H{:.1}\"/>\n", left + frame.width));
        let text = html(&cut(&text, MOST_LETTERS));
        put(format_args!("<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>\n", left - 8.0, y + 4.5));
    }
    put(format_args!("<path class=\"frame\" d=\"M{left:.1},{TOP}V{bottom}H{:.1}\"/>\n", left + frame.width));
    let middle = left + frame.width / 2.0;
    put(format_args!(
        "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
        bottom + 2.2 * LINE,
        html(&frame.x.label)
    ));
    let y = TOP + frame.height / 2.0;
    put(format_args!(
        "<text transform=\"translate(14 {y:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        html(&cut(&frame.y.label, (frame.height / LETTER).max(8.0) as usize))
    ));
}

fn draw(out: &mut String, frame: &Frame<'_>, series: &Series) {
    let colour = series.colour;
    let mut put = |text: std::fmt::Arguments<'_>| out.write_fmt(text).expect("writing to a String cannot fail");
    match &series.shape {
        Shape::Line(points, dashed) => {
            let class = if *dashed { "line dashed" } else { "line" };
            put(format_args!(
                "<polyline class=\"{class} {colour}\" points=\"{}\"/>\n",
                frame.path(points.iter().copied())
            ));
        }
        Shape::Band(points) => {
            let edge =
                points.iter().map(|(x, low, _)| (*x, *low)).chain(points.iter().rev().map(|(x, _, high)| (*x, *high)));
            put(format_args!("<polygon class=\"band {colour}\" points=\"{}\"/>\n", frame.path(edge)));
        }
        Shape::Dots(points, _, symbol) => {
            let path: String =
                points.iter().filter_map(|point| frame.place(*point)).map(|place| dot(place, *symbol)).collect();
            let class = match symbol {
                Symbol::Speck => "speck",
                Symbol::Disc => "disc",
                Symbol::Cross => "cross",
                Symbol::Ring => "ring",
            };
            put(format_args!("<path class=\"{class} {colour}\" d=\"{path}\"/>\n"));
        }
        Shape::Bars(bars, thick) => {
            for (y, value) in bars {
                let (Some(zero), Some(end), Some(up), Some(down)) =
                    (frame.across(0.0), frame.across(*value), frame.up(y - thick / 2.0), frame.up(y + thick / 2.0))
                else {
                    continue;
                };
                let (x, width) = (zero.min(end), (zero - end).abs());
                let height = down - up;
                put(format_args!(
                    "<rect class=\"bar {colour}\" x=\"{x:.1}\" y=\"{up:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>\n"
                ));
            }
        }
        Shape::Labels(labels) => {
            for (x, y, text) in labels {
                let Some((x, y)) = frame.place((*x, *y)) else { continue };
                // what stands at the right edge goes to the left
                let (x, anchor) =
                    if x > frame.left + 0.75 * frame.width { (x - 8.0, "end") } else { (x + 8.0, "start") };
                let text = html(&cut(text, MOST_LETTERS));
                put(format_args!("<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{text}</text>\n", y - 7.0));
            }
        }
        Shape::Across(intervals) => {
            let (first, last) = frame.x.ends();
            for (y, low, high) in intervals {
                let ends = (frame.across(low.unwrap_or(first)), frame.across(high.unwrap_or(last)), frame.up(*y));
                let (Some(from), Some(to), Some(y)) = ends else { continue };
                let cap = |at: f64, is: bool| if is { format!("M{at:.1},{:.1}v10", y - 5.0) } else { String::new() };
                let caps = cap(from, low.is_some()) + &cap(to, high.is_some());
                let class = if low.is_none() || high.is_none() { "whisker dashed" } else { "whisker" };
                put(format_args!("<path class=\"{class} {colour}\" d=\"M{from:.1},{y:.1}H{to:.1}{caps}\"/>\n"));
            }
        }
        Shape::Upright(intervals) => {
            let (first, last) = frame.y.ends();
            for (x, low, high) in intervals {
                let ends = (frame.up(low.unwrap_or(first)), frame.up(high.unwrap_or(last)), frame.across(*x));
                let (Some(from), Some(to), Some(x)) = ends else { continue };
                let cap = |at: f64, is: bool| if is { format!("M{:.1},{at:.1}h8", x - 4.0) } else { String::new() };
                let caps = cap(from, low.is_some()) + &cap(to, high.is_some());
                let class = if low.is_none() || high.is_none() { "whisker dashed" } else { "whisker" };
                put(format_args!("<path class=\"{class} {colour}\" d=\"M{x:.1},{from:.1}V{to:.1}{caps}\"/>\n"));
            }
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
pub(super) fn legend(out: &mut String, series: &[Series], top: f64, left: f64) -> f64 {
    let (mut x, mut y) = (left, top + 4.0);
    let mut any = false;
    for series in series.iter().filter(|series| !series.name.is_empty()) {
        let name = cut(&series.name, 80);
        let width = 30.0 + LETTER * name.chars().count() as f64;
        if any && x + width > WIDTH - RIGHT {
            (x, y) = (left, y + LINE);
        }
        any = true;
        let sign = match &series.shape {
            Shape::Line(_, false) => format!("<path class=\"line {}\" d=\"M{x:.1},{y:.1}h20\"/>", series.colour),
            Shape::Line(_, true) => format!("<path class=\"line dashed {}\" d=\"M{x:.1},{y:.1}h20\"/>", series.colour),
            Shape::Across(_) | Shape::Upright(_) => {
                format!("<path class=\"whisker {}\" d=\"M{x:.1},{y:.1}h20\"/>", series.colour)
            }
            Shape::Labels(_) => continue,
            Shape::Band(_) | Shape::Bars(..) => {
                let class = if matches!(series.shape, Shape::Band(_)) { "band" } else { "bar" };
                format!(
                    "<rect class=\"{class} {}\" x=\"{x:.1}\" y=\"{:.1}\" width=\"20\" height=\"10\"/>",
                    series.colour,
                    y - 5.0
                )
            }
            Shape::Dots(_, _, symbol) => {
                let class = match symbol {
                    Symbol::Speck => "speck",
                    Symbol::Disc => "disc",
                    Symbol::Cross => "cross",
                    Symbol::Ring => "ring",
                };
                format!("<path class=\"{class} {}\" d=\"{}\"/>", series.colour, dot((x + 10.0, y), *symbol))
            }
        };
        writeln!(out, "{sign}<text x=\"{:.1}\" y=\"{:.1}\">{}</text>", x + 26.0, y + 4.5, html(&name))
            .expect("writing to a String cannot fail");
        x += width + 14.0;
    }
    if any { y + 12.0 } else { top - 8.0 }
}

/// Text of so many letters at most.
pub(super) fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        text.to_owned()
    } else {
        text.chars().take(most - 1).chain(['\u{2026}']).collect()
    }
}
