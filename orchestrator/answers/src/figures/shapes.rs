//! Mode shapes: of the shaft line at rest and without damping, and of the rings.

use super::style::{FINE, GREY, SMALL, TEXT, TITLE, to_scale};
use super::{Area, COLOURS, Figure, FigureError, Line, Mark, Panel, panels};
use bladeoff_core::linalg::column_of;
use bladeoff_core::modal::report;
use bladeoff_core::rotor::deflection;
use bladeoff_model::machine::{DiaphragmKind, FlexibleStator, Machine, RotorKind, Shaft};

use bladeoff_core::structure::{RingPart, Structure};
use plotters::prelude::{BLACK, ChartBuilder, Circle, Color, IntoFont, LineSeries, PathElement};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::f64::consts::PI;

/// Lateral shapes drawn, twist shapes, ring shapes.
const LATERAL: usize = 4;
const TWIST: usize = 3;
const RING: usize = 6;

/// Lateral shapes in the XZ plane and twist shapes; `None` for a point mass.
///
/// # Errors
/// The plotting library failed.
pub fn rotor_shapes(machine: &Machine, structure: &Structure) -> Result<Option<Figure>, FigureError> {
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { return Ok(None) };
    let rotor = &structure.rotor;
    let basis = structure.basis();
    let hertz = |square: f64| square.max(0.0).sqrt() / (2.0 * PI);
    let normed = |points: Vec<(f64, f64)>| {
        let largest = points.iter().fold(0.0_f64, |max, point| max.max(point.1.abs()));
        let sign = points.iter().find(|point| point.1.abs() > 0.5 * largest).map_or(1.0, |point| point.1.signum());
        points.into_iter().map(|(z, value)| (z, sign * value / largest)).collect::<Vec<_>>()
    };
    let mut lateral = Vec::new();
    for (mode, square) in basis.lateral.omega_squared.iter().enumerate() {
        let shape = column_of(&basis.lateral.shapes, mode);
        let (x, y) = (&shape[..2 * rotor.nodes], &shape[2 * rotor.nodes..]);
        let size = |values: &[f64]| values.iter().step_by(2).fold(0.0_f64, |max, value| max.max(value.abs()));
        // modes of an isotropic support come twice, one in each plane
        if size(x) >= size(y) && lateral.len() < LATERAL {
            lateral.push(Line::new(&format!("{:.1} Hz", hertz(*square)), normed(bent(shaft, x))));
        }
    }
    let twist = basis.twist.omega_squared.iter().enumerate().skip(1).take(TWIST).map(|(mode, square)| {
        let shape = column_of(&basis.twist.shapes, mode).to_vec();
        Line::new(&format!("{:.1} Hz", hertz(*square)), normed(shaft.nodes.iter().copied().zip(shape).collect()))
    });
    let bearings = machine.rotor.bearings.iter().map(|bearing| (shaft.nodes[bearing.node], 0.0)).collect();
    let mut lines = lateral;
    lines.push(Line::marked("bearings", bearings, Mark::Dots(4), GREY));
    let panel =
        |label: &str, lines| Panel { y_label: label.to_owned(), lines, y_range: Some((-1.15, 1.15)), thin: false };
    let both = [panel("lateral, X [−]", lines), panel("twist [−]", twist.collect())];
    let title = format!("Undamped mode shapes of {} at rest, largest displacement 1", machine.name);
    panels(&title, "position [m]", &both).map(Some)
}

/// The deflection between the nodes of one plane, `[u, theta_v]` of each, as the elements have it.
fn bent(shaft: &Shaft, plane: &[f64]) -> Vec<(f64, f64)> {
    const PARTS: usize = 12;
    let mut points = Vec::new();
    for (element, (ends, from)) in shaft.elements.iter().zip(plane.windows(4).step_by(2).zip(&shaft.nodes)) {
        let ends = [ends[0], ends[1], ends[2], ends[3]];
        points.extend((0..=PARTS).map(|part| {
            let xi = part as f64 / PARTS as f64;
            (from + xi * element.length, deflection(element, ends, xi))
        }));
    }
    points
}

/// Shapes of the first flexible ring; `None` without one.
///
/// # Errors
/// The plotting library failed.
pub fn ring_shapes(machine: &Machine, structure: &Structure) -> Result<Option<Figure>, FigureError> {
    let Some((diaphragm, ring)) =
        machine.diaphragms.iter().zip(&structure.rings).find_map(|(d, ring)| Some((d, ring.as_ref()?)))
    else {
        return Ok(None);
    };
    let DiaphragmKind::Flexible(stator) = &diaphragm.kind else { return Ok(None) };
    let Some(set) = structure.basis().rings.first() else { return Ok(None) };
    let diameters: Vec<usize> = report(machine, &[])?
        .rings
        .iter()
        .find(|(name, _)| *name == diaphragm.name)
        .map_or_else(Vec::new, |(_, modes)| modes.iter().map(|mode| mode.nodal_diameters).collect());
    let columns = 3;
    let shown = set.omega_squared.len().min(RING);
    let rows = shown.div_ceil(columns);
    let figure = Figure::draw((900, 66 + 300 * rows as u32), |root| {
        let root = root.titled(&format!("Modes of diaphragm {} (displacements enlarged)", diaphragm.name), TITLE)?;
        let (legend, root) = root.split_vertically(26 * FINE);
        let text =
            "grey: at rest; dots: blade feet, from their places at rest; n: nodal diameters of the largest harmonic";
        let middle = Pos::new(HPos::Center, VPos::Top);
        let style = SMALL.into_font().color(&BLACK).pos(middle);
        legend.draw(&plotters::element::Text::new(text, (450 * FINE as i32, 2 * FINE as i32), style))?;
        for (mode, area) in root.split_evenly((rows, columns)).iter().enumerate().take(shown) {
            let hertz = set.omega_squared[mode].max(0.0).sqrt() / (2.0 * PI);
            let n = diameters.get(mode).map_or_else(String::new, |n| format!(", n = {n}"));
            let caption = format!("mode {}: {hertz:.1} Hz{n}", mode + 1);
            draw_ring(area, &caption, stator, ring, column_of(&set.shapes, mode))?;
        }
        Ok(())
    })?;
    Ok(Some(figure))
}

fn draw_ring(
    area: &Area<'_>,
    caption: &str,
    stator: &FlexibleStator,
    ring: &RingPart,
    shape: &[f64],
) -> Result<(), FigureError> {
    let nodes = ring.matrices.nodes;
    let largest = (0..nodes).map(|node| shape[4 * node].hypot(shape[4 * node + 2])).fold(0.0, f64::max);
    let scale = 0.22 / largest.max(f64::MIN_POSITIVE);
    let radius = stator.ring.mean_radius;
    let reach = 1.33;
    let area = area.margin(6 * FINE, 6 * FINE, 6 * FINE, 6 * FINE).titled(caption, TEXT)?;
    let (half_x, half_y) = to_scale(area.dim_in_pixel(), (reach, reach));
    let mut chart = ChartBuilder::on(&area).build_cartesian_2d(-half_x..half_x, -half_y..half_y)?;
    let circle = (0..=120).map(|k| (2.0 * PI * f64::from(k) / 120.0).sin_cos()).map(|(s, c)| (c, s));
    chart.draw_series(LineSeries::new(circle, GREY.stroke_width(FINE)))?;
    let surface = ring.matrices.surface(radius, false);
    let displaced = |angle: f64| {
        let (element, xi) = surface.locate(angle);
        let point = surface.point(&shape[..4 * nodes], element, xi);
        let (r, t) = (1.0 + (point.radial - radius) * scale, point.tangential * scale);
        let (sin, cos) = angle.sin_cos();
        (r * cos - t * sin, r * sin + t * cos)
    };
    let around = (0..=360).map(|k| displaced(2.0 * PI * f64::from(k) / 360.0));
    chart.draw_series(LineSeries::new(around, COLOURS[0].stroke_width(2 * FINE)))?;
    for foot in 0..stator.blades.map_or(0, |blades| blades.count) {
        let angle = 2.0 * PI * foot as f64 / stator.blades.map_or(1, |blades| blades.count) as f64;
        let (sin, cos) = angle.sin_cos();
        let to = displaced(angle);
        chart.draw_series([PathElement::new([(cos, sin), to], COLOURS[1].stroke_width(FINE))])?;
        chart.draw_series([Circle::new(to, 3 * FINE as i32, COLOURS[1].filled())])?;
    }
    Ok(())
}
