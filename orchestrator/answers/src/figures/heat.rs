//! Maps: a value over two axes as colour, with its scale beside it.

use super::rimmed::rimmed;
use super::style::{FINE, SMALL, TEXT, TITLE, tick_within, viridis};
use super::{Figure, FigureError};
use plotters::prelude::{BLACK, ChartBuilder, Color, EmptyElement, IntoFont, LineSeries, Rectangle, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};

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
    /// Most numbers along y.
    pub y_labels: usize,
    /// Values by column, then row; NaN stays white.
    pub columns: &'a [Vec<f64>],
    pub z_range: (f64, f64),
    /// Lines over the map: a name at its end, points.
    pub lines: &'a [(String, Vec<(f64, f64)>)],
}

pub(super) fn map(map: &Map<'_>) -> Result<Figure, FigureError> {
    Figure::draw((900, 470), |root| {
        let root = root.titled(map.title, TITLE)?;
        let root = if map.note.is_empty() { root } else { root.titled(map.note, SMALL)? };
        let (left, right) = root.split_horizontally(790 * FINE);
        let (x, y) = (map.x_range, map.y_range);
        let mut chart = ChartBuilder::on(&left)
            .margin(8 * FINE)
            .x_label_area_size(44 * FINE)
            .y_label_area_size(66 * FINE)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        let step = (x.1 - x.0) / map.columns.len().max(1) as f64;
        let level = |value: f64| {
            let share = (value - map.z_range.0) / (map.z_range.1 - map.z_range.0);
            (share.clamp(0.0, 1.0) * LEVELS).round() / LEVELS
        };
        let mut cells = Vec::new();
        for (at, column) in map.columns.iter().enumerate() {
            // a little over the next cell, which is drawn later: edges that only touch show as hairlines
            let (from, to) = (x.0 + at as f64 * step, (x.0 + (at as f64 + 1.5) * step).min(x.1));
            let height = (y.1 - y.0) / column.len().max(1) as f64;
            let mut row = 0;
            for run in column.chunk_by(|a, b| level(*a) == level(*b)) {
                let (low, high) =
                    (y.0 + row as f64 * height, (y.0 + ((row + run.len()) as f64 + 0.5) * height).min(y.1));
                if !run[0].is_nan() {
                    cells.push(Rectangle::new([(from, low), (to, high)], viridis(level(run[0])).filled()));
                }
                row += run.len();
            }
        }
        chart.draw_series(cells)?;
        for (name, points) in map.lines {
            // dark below, so that line and name show on bright ground too
            for (colour, width) in [(BLACK, 3 * FINE), (WHITE, FINE)] {
                chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(width)))?;
            }
            if let Some(&last) = points.iter().rev().find(|point| point.1 < y.1) {
                // above the line, at its beginning
                let place = (x.0 + 0.012 * (x.1 - x.0), points[0].1.max(last.1) + 0.01 * (y.1 - y.0));
                let anchor = Pos::new(HPos::Left, VPos::Bottom);
                rimmed(name, (0, 0), anchor, [BLACK, WHITE], |text| {
                    chart.draw_series([EmptyElement::at(place) + text])?;
                    Ok(())
                })?;
            }
        }
        chart
            .configure_mesh()
            .disable_mesh()
            .set_all_tick_mark_size(4 * FINE)
            .axis_style(BLACK.stroke_width(FINE))
            .x_labels(10)
            .y_labels(map.y_labels)
            .x_label_formatter(&|value| tick_within(*value, x))
            .y_label_formatter(&|value| tick_within(*value, y))
            .label_style(SMALL.into_font())
            .axis_desc_style(TEXT.into_font())
            .x_desc(map.x_label)
            .y_desc(map.y_label)
            .draw()?;
        let mut bar = ChartBuilder::on(&right)
            .margin_top(8 * FINE)
            .margin_bottom(52 * FINE)
            .margin_left(10 * FINE)
            .margin_right(24 * FINE)
            .y_label_area_size(56 * FINE)
            .build_cartesian_2d(0.0..1.0, map.z_range.0..map.z_range.1)?;
        let height = (map.z_range.1 - map.z_range.0) / LEVELS;
        let steps = (0..LEVELS as usize).map(|k| {
            let low = map.z_range.0 + k as f64 * height;
            Rectangle::new(
                [(0.0, low), (1.0, (low + 1.2 * height).min(map.z_range.1))],
                viridis(k as f64 / LEVELS).filled(),
            )
        });
        bar.draw_series(steps)?;
        bar.configure_mesh()
            .disable_mesh()
            .set_all_tick_mark_size(4 * FINE)
            .axis_style(BLACK.stroke_width(FINE))
            .disable_x_axis()
            .y_labels(7)
            .y_label_formatter(&|value| tick_within(*value, map.z_range))
            .label_style(SMALL.into_font())
            .axis_desc_style(TEXT.into_font())
            .y_desc(map.z_label)
            .draw()?;
        Ok(())
    })
}
