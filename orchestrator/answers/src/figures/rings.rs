//! Shapes of a ring beside one another, each over the ring at rest.

use super::style::{GREY, to_scale};
use super::{COLOURS, Figure, HEAD};
use crate::drawing::{Anchor, Axis, Frame, Svg};
use std::f64::consts::PI;

/// Pictures beside one another.
const COLUMNS: usize = 3;

/// One shape; places in radii of the ring at rest, from its centre.
#[derive(Debug, Clone, PartialEq)]
pub struct RingShape {
    /// Above the picture.
    pub caption: String,
    /// The displaced ring, around once.
    pub line: Vec<(f64, f64)>,
    /// Points of the ring that are marked: where they are at rest, and displaced.
    pub marks: Vec<[(f64, f64); 2]>,
}

/// Side of a picture \[px\].
const SIDE: f64 = 300.0;

/// Draws shapes in rows of three, with a note above them.
#[must_use]
pub fn rings(title: &str, note: &str, shapes: &[RingShape]) -> Figure {
    let rows = shapes.len().div_ceil(COLUMNS);
    Figure::draw((900, 66 + 300 * rows as u32), title, |svg| {
        svg.text("", (450.0, HEAD + 12.0), Anchor::Middle, note);
        for (at, shape) in shapes.iter().enumerate() {
            draw(svg, (SIDE * (at % COLUMNS) as f64, HEAD + 26.0 + SIDE * (at / COLUMNS) as f64), shape);
        }
    })
}

fn draw(svg: &mut Svg, (left, top): (f64, f64), shape: &RingShape) {
    svg.text("font-size=\"11\"", (left + SIDE / 2.0, top + 18.0), Anchor::Middle, &shape.caption);
    let corners = [left + 6.0, top + 28.0, left + SIDE - 6.0, top + SIDE - 6.0];
    let (half_x, half_y) = to_scale((corners[2] - corners[0], corners[3] - corners[1]), (1.33, 1.33));
    let (x, y) = (Axis::between("", (-half_x, half_x)), Axis::between("", (-half_y, half_y)));
    let frame = Frame::new(&x, &y, corners);
    let circle = (0..=120).map(|k| (2.0 * PI * f64::from(k) / 120.0).sin_cos()).map(|(s, c)| (c, s));
    frame.line(svg, GREY.stroke(1.0), circle);
    frame.line(svg, COLOURS[0].stroke(2.0), shape.line.iter().copied());
    for ends in &shape.marks {
        frame.line(svg, COLOURS[1].stroke(1.0), *ends);
        frame.circle(svg, COLOURS[1].fill(), ends[1], 3.0);
    }
}
