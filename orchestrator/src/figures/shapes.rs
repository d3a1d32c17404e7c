//! Mode shapes: of the shaft line at rest and without damping, and of the rings.

use super::style::{FINE, GREY, SMALL, TEXT, TITLE};
use super::{COLOURS, Figure, FigureError, Line, Panel, panels};
use bladeoff_core::linalg::column_of;
use bladeoff_core::machine::{DiaphragmKind, Machine, RotorKind};
use bladeoff_core::structure::Structure;
use plotters::prelude::{ChartBuilder, Color, IntoFont, LineSeries};
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
    let normed = |values: Vec<f64>| {
        let largest = values.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
        let sign = values.iter().find(|value| value.abs() > 0.5 * largest).map_or(1.0, |value| value.signum());
        shaft.nodes.iter().copied().zip(values.into_iter().map(|value| sign * value / largest)).collect::<Vec<_>>()
    };
    let mut lateral = Vec::new();
    for (mode, square) in basis.lateral.omega_squared.iter().enumerate() {
        let shape = column_of(&basis.lateral.shapes, mode);
        let [x, y]: [Vec<f64>; 2] =
            [0, 1].map(|axis| (0..rotor.nodes).map(|node| shape[rotor.plane_places(node)[axis]]).collect());
        let size = |values: &[f64]| values.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
        // modes of an isotropic support come twice, one in each plane
        if size(&x) >= size(&y) && lateral.len() < LATERAL {
            lateral.push(Line::new(&format!("{:.1} Hz", hertz(*square)), normed(x)));
        }
    }
    let twist = basis.twist.omega_squared.iter().enumerate().skip(1).take(TWIST).map(|(mode, square)| {
        let shape = column_of(&basis.twist.shapes, mode).to_vec();
        Line::new(&format!("{:.1} Hz", hertz(*square)), normed(shape))
    });
    let marks = |height: f64| Line {
        label: "bearings".to_owned(),
        colour: Some(GREY),
        points: machine.rotor.bearings.iter().map(|bearing| (shaft.nodes[bearing.node], height)).collect(),
        dots: 4,
    };
    let mut lines = lateral;
    lines.push(marks(0.0));
    let panel =
        |label: &str, lines| Panel { y_label: label.to_owned(), lines, y_range: Some((-1.15, 1.15)), thin: false };
    let both = [panel("lateral, X [−]", lines), panel("twist [−]", twist.collect())];
    let title = format!("Mode shapes of {} at rest, largest displacement 1", machine.name);
    panels(&title, "position [m]", &both).map(Some)
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
    let columns = 3;
    let rows = set.omega_squared.len().min(RING).div_ceil(columns);
    let size = (900, 40 + 300 * rows as u32);
    let figure = Figure::draw(size, |root| {
        let root = root.titled(&format!("Modes of diaphragm {} (displacements enlarged)", diaphragm.name), TITLE)?;
        for (mode, area) in root.split_evenly((rows, columns)).iter().enumerate().take(set.omega_squared.len()) {
            let shape = column_of(&set.shapes, mode);
            let largest =
                (0..ring.matrices.nodes).map(|node| shape[4 * node].hypot(shape[4 * node + 2])).fold(0.0, f64::max);
            let scale = 0.22 / largest.max(f64::MIN_POSITIVE);
            let radius = stator.ring.mean_radius;
            let reach = 1.4;
            let mut chart = ChartBuilder::on(area)
                .margin(6 * FINE)
                .caption(
                    format!("mode {}: {:.1} Hz", mode + 1, set.omega_squared[mode].max(0.0).sqrt() / (2.0 * PI)),
                    TEXT,
                )
                .build_cartesian_2d(-reach..reach, -reach * 0.95..reach * 0.95)?;
            let circle = (0..=120).map(|k| (2.0 * PI * f64::from(k) / 120.0).sin_cos()).map(|(s, c)| (c, s));
            chart.draw_series(LineSeries::new(circle, GREY.stroke_width(FINE)))?;
            let surface = ring.matrices.surface(radius, false);
            let around = (0..=360).map(|k| {
                let angle = 2.0 * PI * f64::from(k) / 360.0;
                let (element, xi) = surface.locate(angle);
                let point = surface.point(&shape[..4 * ring.matrices.nodes], element, xi);
                let (r, t) = (1.0 + (point.radial - radius) * scale, point.tangential * scale);
                let (sin, cos) = angle.sin_cos();
                (r * cos - t * sin, r * sin + t * cos)
            });
            chart.draw_series(LineSeries::new(around, COLOURS[0].stroke_width(2 * FINE)))?;
            if mode == 0 {
                chart.draw_series([plotters::element::Text::new(
                    "grey: at rest",
                    (-reach * 0.96, -reach * 0.84),
                    SMALL.into_font(),
                )])?;
            }
        }
        Ok(())
    })?;
    Ok(Some(figure))
}
