//! Elements of an SVG.

use bladeoff_text::document::pictured_lines;
use std::fmt::{self, Display, Write};

/// A colour: red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rgb(pub u8, pub u8, pub u8);

/// Colour of rims and backgrounds.
pub const WHITE: Rgb = Rgb(255, 255, 255);
/// Colour of lines and text.
pub const BLACK: Rgb = Rgb(0, 0, 0);

/// Attributes of a line in the colour of text: dark on light, and light on dark.
pub const INK: &str = "fill=\"none\" stroke=\"currentColor\"";

impl Display for Rgb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02X}{:02X}{:02X}", self.0, self.1, self.2)
    }
}

impl Rgb {
    /// Attributes of an area.
    pub fn fill(self) -> String {
        format!("fill=\"{self}\"")
    }

    /// Attributes of an area that shows what is below.
    pub fn mixed(self, opacity: f64) -> String {
        format!("fill=\"{self}\" fill-opacity=\"{opacity}\"")
    }

    /// Attributes of an area with an edge.
    pub fn bordered(self, edge: Self) -> String {
        format!("fill=\"{self}\" stroke=\"{edge}\"")
    }

    /// Attributes of a line of this width.
    pub fn stroke(self, width: f64) -> String {
        format!("fill=\"none\" stroke=\"{self}\" stroke-width=\"{width}\"")
    }

    /// Attributes of a line in dashes and gaps of these lengths.
    pub fn dashed(self, width: f64, dashes: [u32; 2]) -> String {
        format!("{} stroke-dasharray=\"{} {}\"", self.stroke(width), dashes[0], dashes[1])
    }
}

/// Which end of a text is at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The beginning.
    Start,
    /// The middle.
    Middle,
    /// The end.
    End,
}

/// Elements one after the other. Attributes of an element are its first argument.
#[derive(Debug, Default)]
pub struct Svg(pub String);

impl Svg {
    /// Writes text as it is, with the end of a line.
    pub fn put(&mut self, text: fmt::Arguments<'_>) {
        writeln!(self.0, "{text}").expect("writing to a String cannot fail");
    }

    /// A line through points.
    pub fn line(&mut self, paint: impl Display, points: impl IntoIterator<Item = (f64, f64)>) {
        self.put(format_args!("<polyline {paint} points=\"{}\"/>", list(points)));
    }

    /// An area within points.
    pub fn area(&mut self, paint: impl Display, points: impl IntoIterator<Item = (f64, f64)>) {
        self.put(format_args!("<polygon {paint} points=\"{}\"/>", list(points)));
    }

    /// A rectangle between two corners.
    pub fn rect(&mut self, paint: impl Display, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) {
        let (x, y, width, height) = (x0.min(x1), y0.min(y1), (x1 - x0).abs(), (y1 - y0).abs());
        self.put(format_args!("<rect {paint} x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"));
    }

    /// A circle.
    pub fn circle(&mut self, paint: impl Display, (x, y): (f64, f64), radius: f64) {
        self.put(format_args!("<circle {paint} cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>"));
    }

    /// A path.
    pub fn path(&mut self, paint: impl Display, path: impl Display) {
        self.put(format_args!("<path {paint} d=\"{path}\"/>"));
    }

    /// Text on a base line; `paint` may be empty.
    pub fn text(&mut self, paint: impl Display, (x, y): (f64, f64), anchor: Anchor, text: &str) {
        let place = format!("x=\"{x:.1}\" y=\"{y:.1}\"");
        self.text_at(paint, &place, anchor, text);
    }

    /// Text upwards, its base line to the right.
    pub fn turned(&mut self, (x, y): (f64, f64), text: &str) {
        self.text_at("", &format!("transform=\"translate({x:.1} {y:.1}) rotate(-90)\""), Anchor::Middle, text);
    }

    fn text_at(&mut self, paint: impl Display, place: &str, anchor: Anchor, text: &str) {
        if text.is_empty() {
            return;
        }
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        self.put(format_args!("<text {paint} {place}{anchor}>{}</text>", html(text)));
    }
}

fn list(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut list = String::new();
    for (x, y) in points {
        write!(list, "{x:.1},{y:.1} ").expect("writing to a String cannot fail");
    }
    list
}

/// Text of an HTML or XML element or quoted attribute, hidden characters as [`pictured_lines`] shows them.
#[must_use]
pub fn html(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    for c in pictured_lines(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML cannot hold them
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
