//! The frame of a drawing: places within it, its axes.

use super::{Anchor, Axis, INK, Rgb, Svg};
use bladeoff_text::document::cut;
use std::fmt::Display;

/// Width of a letter.
pub const LETTER: f64 = 7.0;
/// Height of a line of text.
pub const LINE: f64 = 18.0;
/// From the middle of a line of text to its base line.
pub const TEXT: f64 = 4.5;
/// Letters of a name at an axis.
pub const MOST_LETTERS: usize = 44;

/// Lines across a frame.
const GRID: Rgb = Rgb(222, 222, 222);

/// How an axis shows where its ticks are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ruling {
    /// By lines across the frame.
    Grid,
    /// By short lines outside of it.
    Ticks,
}

/// A frame with its axes.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    pub x: &'a Axis,
    pub y: &'a Axis,
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl<'a> Frame<'a> {
    /// From corner to corner.
    pub fn new(x: &'a Axis, y: &'a Axis, [left, top, right, bottom]: [f64; 4]) -> Self {
        Self { x, y, left, top, width: right - left, height: bottom - top }
    }

    /// Far outside is outside, and a number that every reader of SVG takes.
    pub fn across(&self, value: f64) -> Option<f64> {
        Some(self.left + self.width * self.x.share(value)?.clamp(-3.0, 4.0))
    }

    pub fn up(&self, value: f64) -> Option<f64> {
        Some(self.top + self.height * (1.0 - self.y.share(value)?.clamp(-3.0, 4.0)))
    }

    pub fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        Some((self.across(x)?, self.up(y)?))
    }

    /// Places of those that have one.
    pub fn places(&self, points: impl IntoIterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
        points.into_iter().filter_map(|point| self.place(point))
    }

    /// Draws a line through those that have a place, if there are any.
    pub fn line(&self, svg: &mut Svg, paint: impl Display, points: impl IntoIterator<Item = (f64, f64)>) {
        let mut places = self.places(points).peekable();
        if places.peek().is_some() {
            svg.line(paint, places);
        }
    }

    /// Draws an area.
    pub fn area(&self, svg: &mut Svg, paint: impl Display, points: impl IntoIterator<Item = (f64, f64)>) {
        svg.area(paint, self.places(points));
    }

    /// Draws a rectangle between two corners.
    pub fn rect(&self, svg: &mut Svg, paint: impl Display, [from, to]: [(f64, f64); 2]) {
        if let Some((from, to)) = self.place(from).zip(self.place(to)) {
            svg.rect(paint, from, to);
        }
    }

    /// Draws a circle of this radius \[px\].
    pub fn circle(&self, svg: &mut Svg, paint: impl Display, point: (f64, f64), radius: f64) {
        if let Some(place) = self.place(point) {
            svg.circle(paint, place, radius);
        }
    }

    /// Draws both axes, their ticks, numbers and names; the name of the upright one `beside` to the left of the frame.
    pub fn axes(&self, svg: &mut Svg, ruling: Ruling, beside: f64) {
        let (left, top, right, bottom) = (self.left, self.top, self.left + self.width, self.top + self.height);
        let mut rules = String::new();
        let mut free = f64::NEG_INFINITY;
        for (value, text) in self.x.ticks() {
            let Some(x) = self.across(value) else { continue };
            rules += &match ruling {
                Ruling::Grid => format!("M{x:.1},{top}V{bottom}"),
                Ruling::Ticks if self.x.has_numbers => format!("M{x:.1},{bottom}v4"),
                Ruling::Ticks => String::new(),
            };
            let half = LETTER * text.chars().count() as f64 / 2.0;
            if self.x.has_numbers && x - half > free {
                svg.text("", (x, bottom + LINE), Anchor::Middle, &text);
                free = x + half + LETTER;
            }
        }
        for (value, text) in self.y.ticks() {
            let Some(y) = self.up(value) else { continue };
            rules += &match ruling {
                Ruling::Grid => format!("M{left:.1},{y:.1}H{right:.1}"),
                Ruling::Ticks => format!("M{left:.1},{y:.1}h-4"),
            };
            svg.text("", (left - 8.0, y + TEXT), Anchor::End, &cut(&text, MOST_LETTERS));
        }
        let mut frame = format!("M{left:.1},{top}V{bottom}H{right:.1}");
        match ruling {
            Ruling::Grid => svg.path(format_args!("class=\"grid\" {}", GRID.stroke(1.0)), rules),
            Ruling::Ticks => frame += &rules,
        }
        svg.path(format_args!("class=\"frame\" {INK}"), frame);
        if self.x.has_numbers {
            svg.text("", (left + self.width / 2.0, bottom + 2.2 * LINE), Anchor::Middle, &self.x.label);
        }
        let label = cut(&self.y.label, ((self.height + LINE) / 6.2).max(8.0) as usize);
        svg.turned((left - beside, top + self.height / 2.0), &label);
    }
}
