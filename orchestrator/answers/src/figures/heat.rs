//! Maps: a value over two axes as colour, with its scale beside it.

use super::style::{rimmed, viridis};
use super::{Figure, HEAD};
use crate::drawing::{Anchor, Axis, BLACK, Frame, Ruling, WHITE};

/// Colours are drawn in so many steps, so that neighbours of one step become one rectangle.
const LEVELS: f64 = 40.0;

/// A map over evenly spaced columns and rows.
pub(super) struct Map<'a> {
    pub title: &'a str,
    /// A line below the title; "" for none.
    pub note: &'a str,
    pub x_label: &'a str,
    pub y_label: &'a str,
    pub z_label: &'a str,
    pub x_range: (f64, f64),
    pub y_range: (f64, f64),
    /// Numbers along y, about.
    pub y_labels: u32,
    /// Values by column, then row; NaN stays white.
    pub columns: &'a [Vec<f64>],
    pub z_range: (f64, f64),
    /// Lines over the map: a name at its end, points.
    pub lines: &'a [(String, Vec<(f64, f64)>)],
}

pub(super) fn map(map: &Map<'_>) -> Figure {
    Figure::draw((900, 470), map.title, |svg| {
        svg.text("", (450.0, HEAD + 8.0), Anchor::Middle, map.note);
        let top = HEAD + if map.note.is_empty() { 8.0 } else { 26.0 };
        let (x, y) = (map.x_range, map.y_range);
        let across = Axis::between(map.x_label, x).most(10);
        let up = Axis::between(map.y_label, y).most(map.y_labels);
        let frame = Frame::new(&across, &up, [74.0, top, 782.0, 418.0]);
        let step = (x.1 - x.0) / map.columns.len().max(1) as f64;
        let level = |value: f64| {
            let share = (value - map.z_range.0) / (map.z_range.1 - map.z_range.0);
            (share.clamp(0.0, 1.0) * LEVELS).round() / LEVELS
        };
        for (at, column) in map.columns.iter().enumerate() {
            // a little over the next cell, which is drawn later: edges that only touch show as hairlines
            let (from, to) = (x.0 + at as f64 * step, (x.0 + (at as f64 + 1.5) * step).min(x.1));
            let height = (y.1 - y.0) / column.len().max(1) as f64;
            let mut row = 0;
            for run in column.chunk_by(|a, b| level(*a) == level(*b)) {
                let (low, high) =
                    (y.0 + row as f64 * height, (y.0 + ((row + run.len()) as f64 + 0.5) * height).min(y.1));
                if !run[0].is_nan() {
                    frame.rect(svg, viridis(level(run[0])).fill(), [(from, low), (to, high)]);
                }
                row += run.len();
            }
        }
        for (name, points) in map.lines {
            // dark below, so that line and name show on bright ground too
            for (colour, width) in [(BLACK, 3.0), (WHITE, 1.0)] {
                frame.line(svg, colour.stroke(width), points.iter().copied());
            }
            if let Some(&last) = points.iter().rev().find(|point| point.1 < y.1) {
                // above the line, at its beginning
                let place = (x.0 + 0.012 * (x.1 - x.0), points[0].1.max(last.1) + 0.02 * (y.1 - y.0));
                if let Some(place) = frame.place(place) {
                    rimmed(svg, place, Anchor::Start, [BLACK, WHITE], name);
                }
            }
        }
        frame.axes(svg, Ruling::Ticks, 56.0);
        let bar_x = Axis { has_numbers: false, ..Axis::between("", (0.0, 1.0)) };
        let bar_y = Axis::between(map.z_label, map.z_range);
        let bar = Frame::new(&bar_x, &bar_y, [856.0, top, 876.0, 418.0]);
        let height = (map.z_range.1 - map.z_range.0) / LEVELS;
        for k in 0..LEVELS as usize {
            let low = map.z_range.0 + k as f64 * height;
            let high = (low + 1.2 * height).min(map.z_range.1);
            bar.rect(svg, viridis(k as f64 / LEVELS).fill(), [(0.0, low), (1.0, high)]);
        }
        bar.axes(svg, Ruling::Ticks, 50.0);
    })
}
