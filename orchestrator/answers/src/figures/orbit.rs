//! The orbit of the rotor centre inside the clearance of the deformed ring, at chosen instants.
//!
//! Drawn in the plane of the rotor centre: the clearance is `gap + v(alpha)`, the gap plus the ring's radial displacement, and
//! the rotor touches where its centre reaches it. Both on one scale: the radii themselves would hide millimetres in metres.

use super::contacts::Contact;
use super::style::{FINE, GREY, GRID, SMALL, Scale, TEXT, TITLE, fixed, tick_within, to_scale};
use super::{Area, COLOURS, Figure, FigureError};
use crate::history::History;
use plotters::prelude::{BLACK, ChartBuilder, Circle, Color, IntoFont, LineSeries, PathElement, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::f64::consts::PI;

/// Side of the picture of an instant \[px\], and of a single one.
const SIZE: u32 = 330;
const ALONE: u32 = 600;

/// What a history knows of the ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ring {
    /// Gap and displacements: the clearance of every instant.
    Deformed,
    /// The gap alone: its ring channels were not recorded.
    AtRest,
    /// Nothing: a CSV carries no geometry.
    Unknown,
}

/// Ring channels and geometry of a contact in a history.
#[must_use]
pub fn ring_of(history: &History, contact: &Contact) -> Ring {
    match (contact.gap(history), contact.radial(history).is_empty()) {
        (None, _) => Ring::Unknown,
        (Some(_), true) => Ring::AtRest,
        (Some(_), false) => Ring::Deformed,
    }
}

/// Draws the orbit of the last whole turn before each instant \[s\], in what [`ring_of`] knows of the ring. `None` if the
/// history has no rotor place at the contact.
///
/// # Errors
/// The plotting library failed.
pub fn orbits(
    history: &History,
    name: &str,
    contact: &Contact,
    instants: &[f64],
) -> Result<Option<Figure>, FigureError> {
    let places = ["rotor_x_m", "rotor_y_m"].map(|field| contact.channel(history, field));
    let [Some(x), Some(y)] = places else { return Ok(None) };
    let (x, y) = (&x.values, &y.values);
    let end = |of: fn(f64, f64) -> f64| instants.iter().copied().reduce(of).unwrap_or_default();
    let span = (end(f64::min), end(f64::max));
    let columns = instants.len().clamp(1, 3) as u32;
    let rows = (instants.len().max(1) as u32).div_ceil(columns);
    let gap = contact.gap(history);
    let reach = reach_of(history, contact, x.iter().zip(y).map(|(x, y)| x.hypot(*y)));
    let scale = Scale::of("m", reach);
    // four digits of the picture's size
    let decimals = (3 - libm::floor(libm::log10(reach * scale.factor)) as i32).clamp(0, 9) as usize;
    let side = if columns == 1 { ALONE } else { SIZE };
    let size = (columns * side, 72 + rows * (side - 19));
    let figure = Figure::draw(size, |root| {
        let shown = match ring_of(history, contact) {
            Ring::Deformed => "rotor centre inside the clearance of the deformed ring",
            Ring::AtRest => "rotor centre and the gap at rest",
            Ring::Unknown => "rotor centre",
        };
        let root = root.titled(&format!("{name}: {shown}{}", contact.of()), TITLE)?;
        let (strip, root) = root.split_vertically(24 * FINE);
        legend(&strip, ring_of(history, contact), columns * side)?;
        for (area, &instant) in root.split_evenly((rows as usize, columns as usize)).iter().zip(instants) {
            let turn = last_turn(history, instant);
            let orbit: Vec<(f64, f64)> = turn.clone().map(|k| (x[k] * scale.factor, y[k] * scale.factor)).collect();
            let is_place = |place: &(f64, f64)| place.0.is_finite() && place.1.is_finite();
            let orbit: Vec<(f64, f64)> = orbit.into_iter().filter(is_place).collect();
            let at = turn.end.saturating_sub(1);
            let radial: Vec<f64> = contact.radial(history).iter().map(|node| node.values[at]).collect();
            let ring = gap.and_then(|gap| clearance(&radial, gap)).map(|line| scaled(&line, scale.factor));
            let smallest = contact.channel(history, "gap_m").map(|gap| gap.values[at]).filter(|gap| gap.is_finite());
            let smallest = smallest.map_or(String::new(), |gap| {
                format!(", clearance {} {}", fixed(gap * scale.factor, decimals), scale.unit)
            });
            draw(
                area,
                &format!("t = {} s{smallest}", tick_within(instant, span)),
                &orbit,
                ring.as_deref(),
                gap.map(|gap| gap * scale.factor),
                reach * scale.factor,
                &scale,
            )?;
        }
        Ok(())
    })?;
    Ok(Some(figure))
}

/// Half the extent of a picture of these distances from the middle \[m\], with the gap at rest. Where all are zero and the file has no gap,
/// that of the largest clearance.
pub(crate) fn reach_of(history: &History, contact: &Contact, distances: impl Iterator<Item = f64>) -> f64 {
    let reach = distances.filter(|reach| reach.is_finite()).fold(contact.gap(history).unwrap_or(0.0), f64::max);
    let clearances =
        || contact.channel(history, "gap_m").into_iter().flat_map(|gap| gap.values.iter().map(|gap| gap.abs()));
    let reach = if reach > 0.0 { reach } else { clearances().filter(|gap| gap.is_finite()).fold(0.0, f64::max) };
    if reach > 0.0 { 1.12 * reach } else { 1.0 }
}

/// Records of the last whole turn of the shaft before an instant; of the last tenth of the history without its angle.
pub(crate) fn last_turn(history: &History, instant: f64) -> std::ops::Range<usize> {
    let end = history.time.partition_point(|time| *time <= instant).max(1).min(history.time.len());
    let start = match history.channel("rotor.angle_rad") {
        Some(angle) => {
            let from = angle.values[end - 1] - 2.0 * PI;
            angle.values[..end].partition_point(|angle| *angle < from)
        }
        None => end.saturating_sub(history.time.len() / 10),
    };
    start..end
}

/// Points of the clearance \[m\], closed, from the radial displacements of the nodes; `None` without any, or where one is no number.
pub(crate) fn clearance(radial: &[f64], gap: f64) -> Option<Vec<(f64, f64)>> {
    if radial.is_empty() || radial.iter().any(|value| !value.is_finite()) {
        return None;
    }
    // smooth between nodes: a Catmull-Rom curve through them
    let count = radial.len();
    let value = |k: usize| radial[k % count];
    let mut points = Vec::new();
    for node in 0..count {
        for part in 0..6 {
            let t = f64::from(part) / 6.0;
            let (a, b, c, d) = (value(node + count - 1), value(node), value(node + 1), value(node + 2));
            let v = b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
            let angle = 2.0 * PI * (node as f64 + t) / count as f64;
            points.push(((gap + v) * angle.cos(), (gap + v) * angle.sin()));
        }
    }
    points.push(points[0]);
    Some(points)
}

fn scaled(line: &[(f64, f64)], factor: f64) -> Vec<(f64, f64)> {
    line.iter().map(|(x, y)| (x * factor, y * factor)).collect()
}

fn draw(
    area: &Area<'_>,
    caption: &str,
    orbit: &[(f64, f64)],
    ring: Option<&[(f64, f64)]>,
    gap: Option<f64>,
    reach: f64,
    scale: &Scale,
) -> Result<(), FigureError> {
    let area = area.margin(8 * FINE, 8 * FINE, 8 * FINE, 8 * FINE).titled(caption, TEXT)?;
    let mut builder = ChartBuilder::on(&area);
    builder.x_label_area_size(38 * FINE).y_label_area_size(46 * FINE);
    let plot = builder.build_cartesian_2d(0.0..1.0, 0.0..1.0)?.plotting_area().dim_in_pixel();
    let (half_x, half_y) = to_scale(plot, (reach, reach));
    let mut chart = builder.build_cartesian_2d(-half_x..half_x, -half_y..half_y)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .set_all_tick_mark_size(4 * FINE)
        .axis_style(BLACK.stroke_width(FINE))
        .bold_line_style(GRID.stroke_width(FINE))
        .x_labels(5)
        .y_labels(5)
        .x_label_formatter(&|value| tick_within(*value, (-half_x, half_x)))
        .y_label_formatter(&|value| tick_within(*value, (-half_y, half_y)))
        .label_style(SMALL.into_font())
        .axis_desc_style(TEXT.into_font())
        .x_desc(scale.label("x"))
        .y_desc(scale.label("y"))
        .draw()?;
    if let Some(gap) = gap {
        let circle = (0..=180).map(|k| 2.0 * PI * f64::from(k) / 180.0).map(|a| (gap * a.cos(), gap * a.sin()));
        chart.draw_series(LineSeries::new(circle, GREY.stroke_width(FINE)))?;
    }
    if let Some(ring) = ring {
        let colour = COLOURS[1];
        chart.draw_series(LineSeries::new(ring.iter().copied(), colour.stroke_width(2 * FINE)))?;
    }
    let colour = COLOURS[0];
    chart.draw_series(LineSeries::new(orbit.iter().copied(), colour.stroke_width(2 * FINE)))?;
    if let Some(&last) = orbit.last() {
        chart.draw_series([Circle::new(last, 4 * FINE as i32, colour.filled())])?;
    }
    Ok(())
}

/// What the lines are, once for all pictures, in a strip above them: inside, it would hide an orbit.
fn legend(strip: &Area<'_>, ring: Ring, width: u32) -> Result<(), FigureError> {
    let mut entries = vec![("orbit of the last turn", COLOURS[0])];
    if ring != Ring::Unknown {
        entries.push(("gap at rest", GREY));
    }
    if ring == Ring::Deformed {
        entries.push(("clearance at t", COLOURS[1]));
    }
    let fine = FINE as i32;
    let pitch = (width as i32 / 3).min(200);
    let style = SMALL.into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    for (at, (name, colour)) in entries.into_iter().enumerate() {
        let x = (60 + pitch * at as i32) * fine;
        let y = 8 * fine;
        strip.draw(&PathElement::new([(x, y), (x + 16 * fine, y)], colour.stroke_width(3 * FINE)))?;
        strip.draw(&plotters::element::Text::new(name, (x + 21 * fine, y), style.clone()))?;
    }
    Ok(())
}
