//! Shapes of a ring beside one another, each over the ring at rest.

use super::style::{FINE, GREY, SMALL, TEXT, TITLE, to_scale};
use super::{Area, COLOURS, Figure, FigureError};
use plotters::prelude::{BLACK, ChartBuilder, Circle, Color, IntoFont, LineSeries, PathElement};
use plotters::style::text_anchor::{HPos, Pos, VPos};
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

/// Draws shapes in rows of three, with a note above them.
///
/// # Errors
/// The plotting library failed.
pub fn rings(title: &str, note: &str, shapes: &[RingShape]) -> Result<Figure, FigureError> {
    let rows = shapes.len().div_ceil(COLUMNS);
    Figure::draw((900, 66 + 300 * rows as u32), |root| {
        let root = root.titled(title, TITLE)?;
        let (strip, root) = root.split_vertically(26 * FINE);
        let style = SMALL.into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Top));
        strip.draw(&plotters::element::Text::new(note, (450 * FINE as i32, 2 * FINE as i32), style))?;
        for (area, shape) in root.split_evenly((rows, COLUMNS)).iter().zip(shapes) {
            draw(area, shape)?;
        }
        Ok(())
    })
}

fn draw(area: &Area<'_>, shape: &RingShape) -> Result<(), FigureError> {
    let reach = 1.33;
    let area = area.margin(6 * FINE, 6 * FINE, 6 * FINE, 6 * FINE).titled(&shape.caption, TEXT)?;
    let (half_x, half_y) = to_scale(area.dim_in_pixel(), (reach, reach));
    let mut chart = ChartBuilder::on(&area).build_cartesian_2d(-half_x..half_x, -half_y..half_y)?;
    let circle = (0..=120).map(|k| (2.0 * PI * f64::from(k) / 120.0).sin_cos()).map(|(s, c)| (c, s));
    chart.draw_series(LineSeries::new(circle, GREY.stroke_width(FINE)))?;
    chart.draw_series(LineSeries::new(shape.line.iter().copied(), COLOURS[0].stroke_width(2 * FINE)))?;
    for &[from, to] in &shape.marks {
        chart.draw_series([PathElement::new([from, to], COLOURS[1].stroke_width(FINE))])?;
        chart.draw_series([Circle::new(to, 3 * FINE as i32, COLOURS[1].filled())])?;
    }
    Ok(())
}
