//! Lines over a common axis: one panel below the other, each with its own scale.

use super::style::{FINE, GRID, SMALL, TEXT, TITLE, roomy, tick};
use super::{Area, COLOURS, Figure, FigureError};
use plotters::element::Circle;
use plotters::prelude::{
    BLACK, ChartBuilder, Color, IntoFont, LineSeries, PathElement, RGBColor, SeriesLabelPosition, WHITE,
};

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// In the legend; "" for none.
    pub label: String,
    /// Colour; `None`: the next of the palette.
    pub colour: Option<RGBColor>,
    /// Points, in the panel's shown units.
    pub points: Vec<(f64, f64)>,
    /// Dots of this radius \[px\] instead of a line; 0: a line.
    pub dots: u32,
}

impl Line {
    /// A line in the next colour.
    #[must_use]
    pub fn new(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.to_owned(), colour: None, points, dots: 0 }
    }
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Vertical axis with its unit.
    pub y_label: String,
    /// Lines.
    pub lines: Vec<Line>,
    /// Range; `None`: that of the values with some room.
    pub y_range: Option<(f64, f64)>,
    /// Draw the smallest and largest value of each column of pixels only.
    pub thin: bool,
}

/// Width of a figure \[px\].
const WIDTH: u32 = 900;
/// Height of a panel without axis texts \[px\].
const HEIGHT: u32 = 190;

/// Draws panels below one another.
///
/// # Errors
/// The plotting library failed.
pub fn panels(title: &str, x_label: &str, panels: &[Panel]) -> Result<Figure, FigureError> {
    let below = 44;
    let height = 48 + below + HEIGHT * panels.len().max(1) as u32;
    let all = panels.iter().flat_map(|panel| &panel.lines).flat_map(|line| &line.points);
    let x_range = roomy(all.map(|point| point.0), 0.0);
    Figure::draw((WIDTH, height), |root| {
        let root = root.titled(title, TITLE)?;
        let mut rest = root;
        for (at, panel) in panels.iter().enumerate() {
            let last = at + 1 == panels.len();
            let (area, next) = rest.split_vertically((HEIGHT + if last { below } else { 0 }) * FINE);
            draw(&area, panel, x_range, last.then_some(x_label))?;
            rest = next;
        }
        Ok(())
    })
}

/// Draws one tall panel.
///
/// # Errors
/// The plotting library failed.
pub(super) fn tall(title: &str, x_label: &str, panel: &Panel, x_range: (f64, f64)) -> Result<Figure, FigureError> {
    Figure::draw((WIDTH, 560), |root| {
        let root = root.titled(title, TITLE)?;
        draw(&root, panel, x_range, Some(x_label))
    })
}

fn draw(area: &Area<'_>, panel: &Panel, x_range: (f64, f64), x_label: Option<&str>) -> Result<(), FigureError> {
    let values = panel.lines.iter().flat_map(|line| &line.points).map(|point| point.1);
    let (low, high) = panel.y_range.unwrap_or_else(|| roomy(values, 0.06));
    let mut chart = ChartBuilder::on(area)
        .margin_right(22 * FINE)
        .margin_top(8 * FINE)
        .margin_left(6 * FINE)
        .x_label_area_size(if x_label.is_some() { 44 * FINE } else { 10 * FINE })
        .y_label_area_size(74 * FINE)
        .build_cartesian_2d(x_range.0..x_range.1, low..high)?;
    let x_text = |value: &f64| if x_label.is_some() { tick(*value) } else { String::new() };
    let y_text = |value: &f64| tick(*value);
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE)
        .set_all_tick_mark_size(4 * FINE)
        .axis_style(BLACK.stroke_width(FINE))
        .bold_line_style(GRID.stroke_width(FINE))
        .x_labels(10)
        .y_labels(6)
        .x_label_formatter(&x_text)
        .y_label_formatter(&y_text)
        .label_style(SMALL.into_font())
        .axis_desc_style(TEXT.into_font())
        .y_desc(&panel.y_label);
    if let Some(label) = x_label {
        mesh.x_desc(label);
    }
    mesh.draw()?;
    let mut named = false;
    for (at, line) in panel.lines.iter().enumerate() {
        let colour = line.colour.unwrap_or(COLOURS[at % COLOURS.len()]);
        let points =
            if panel.thin { thinned(&line.points, x_range, (WIDTH - 100) as usize) } else { line.points.clone() };
        let drawn = if line.dots > 0 {
            chart.draw_series(
                points.into_iter().map(|point| Circle::new(point, (line.dots * FINE) as i32, colour.filled())),
            )?
        } else {
            chart.draw_series(LineSeries::new(points, colour.stroke_width(FINE)))?
        };
        if !line.label.is_empty() {
            named = true;
            drawn.label(line.label.as_str()).legend(move |(x, y)| {
                PathElement::new([(x, y), (x + 18 * FINE as i32, y)], colour.stroke_width(3 * FINE))
            });
        }
    }
    if named {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.2).stroke_width(FINE))
            .label_font(SMALL.into_font())
            .legend_area_size(26 * FINE)
            .margin(6 * FINE)
            .draw()?;
    }
    Ok(())
}

/// First, smallest, largest and last point of every column of pixels: the picture of all points.
fn thinned(points: &[(f64, f64)], (from, to): (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    if points.len() <= 4 * columns {
        return points.to_vec();
    }
    let column = |x: f64| ((x - from) / (to - from) * columns as f64) as usize;
    let mut thin = Vec::with_capacity(4 * columns);
    for run in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let by_value = |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
        let low = run.iter().enumerate().min_by(by_value).map_or(0, |found| found.0);
        let high = run.iter().enumerate().max_by(by_value).map_or(0, |found| found.0);
        let mut kept = vec![0, low, high, run.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        thin.extend(kept.into_iter().map(|at| run[at]));
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_peaks_and_ends() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), f64::from(k % 7))).collect();
        points[54_321].1 = 99.0;
        let thin = thinned(&points, (0.0, 99_999.0), 800);
        assert!(thin.len() <= 4 * 801);
        assert!(thin.contains(&(54_321.0, 99.0)));
        assert_eq!((thin[0], thin[thin.len() - 1]), (points[0], points[99_999]));
    }
}
