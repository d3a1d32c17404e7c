//! Mode shapes: of the shaft line at rest and without damping, and of the rings.

use bladeoff_answers::figures::{Figure, GREY, Line, Mark, Panel, RingShape, panels, rings};
use bladeoff_core::modal::{ModeSet, ModesReport};
use bladeoff_core::rotor::deflection;
use bladeoff_core::structure::{RingPart, Structure};
use bladeoff_model::machine::{DiaphragmKind, FlexibleStator, Machine, RotorKind, Shaft};
use bladeoff_numerics::linalg::column_of;
use std::f64::consts::PI;

/// Lateral shapes drawn, torsional shapes, ring shapes.
const LATERAL: usize = 4;
const TWIST: usize = 3;
const RING: usize = 6;

/// Lateral shapes in the XZ plane and torsional shapes; `None` for a point mass.
#[must_use]
pub fn rotor_shapes(machine: &Machine, structure: &Structure) -> Option<Figure> {
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { return None };
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
    let torsion = basis.torsion.omega_squared.iter().enumerate().skip(1).take(TWIST).map(|(mode, square)| {
        let shape = column_of(&basis.torsion.shapes, mode).to_vec();
        Line::new(&format!("{:.1} Hz", hertz(*square)), normed(shaft.nodes.iter().copied().zip(shape).collect()))
    });
    let bearings = machine.rotor.bearings.iter().map(|bearing| (shaft.nodes[bearing.node], 0.0)).collect();
    let mut lines = lateral;
    lines.push(Line::marked("bearings", bearings, Mark::Dots(4), GREY));
    let panel = |label: &str, lines| Panel {
        y_label: label.to_owned(),
        lines,
        y_range: Some((-1.15, 1.15)),
        ..Panel::default()
    };
    let both = [panel("lateral, X [−]", lines), panel("torsion [−]", torsion.collect())];
    let title = format!("Undamped mode shapes of {} at rest, largest displacement 1", machine.name);
    Some(panels(&title, "position [m]", &both))
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

/// Shapes of each flexible ring, with the nodal diameters that the report counts, and the name of its diaphragm.
#[must_use]
pub fn ring_shapes(machine: &Machine, structure: &Structure, report: &ModesReport) -> Vec<(String, Figure)> {
    let flexible = machine.diaphragms.iter().zip(&structure.rings).filter_map(|(diaphragm, ring)| {
        let DiaphragmKind::Flexible(stator) = &diaphragm.kind else { return None };
        Some((&*diaphragm.name, stator, ring.as_ref()?))
    });
    // the basis has the modes of the flexible ones alone
    let drawn = flexible
        .zip(&structure.basis().rings)
        .map(|((name, stator, ring), set)| (name.to_owned(), ring_figure(name, stator, ring, set, report)));
    drawn.collect()
}

fn ring_figure(name: &str, stator: &FlexibleStator, ring: &RingPart, set: &ModeSet, report: &ModesReport) -> Figure {
    let diameters: Vec<usize> = report
        .rings
        .iter()
        .find(|(of, _)| of == name)
        .map_or_else(Vec::new, |(_, modes)| modes.iter().map(|mode| mode.nodal_diameters).collect());
    let shown = set.omega_squared.iter().take(RING).enumerate().map(|(mode, square)| {
        let hertz = square.max(0.0).sqrt() / (2.0 * PI);
        let n = diameters.get(mode).map_or_else(String::new, |n| format!(", n = {n}"));
        displaced(format!("mode {}: {hertz:.1} Hz{n}", mode + 1), stator, ring, column_of(&set.shapes, mode))
    });
    let title = format!("Modes of diaphragm {name} (displacements enlarged)");
    let note = "grey: at rest; dots: blade feet, from their places at rest; n: nodal diameters of the largest harmonic";
    rings(&title, note, &shown.collect::<Vec<_>>())
}

/// A ring and its blade feet in one of its shapes.
fn displaced(caption: String, stator: &FlexibleStator, ring: &RingPart, shape: &[f64]) -> RingShape {
    let nodes = ring.matrices.nodes;
    let largest = (0..nodes).map(|node| shape[4 * node].hypot(shape[4 * node + 2])).fold(0.0, f64::max);
    let scale = 0.22 / largest.max(f64::MIN_POSITIVE);
    let radius = stator.ring.mean_radius;
    let surface = ring.matrices.surface(radius, false);
    let place = |angle: f64| {
        let (element, xi) = surface.locate(angle);
        let point = surface.point(&shape[..4 * nodes], element, xi);
        let (r, t) = (1.0 + (point.radial - radius) * scale, point.tangential * scale);
        let (sin, cos) = angle.sin_cos();
        (r * cos - t * sin, r * sin + t * cos)
    };
    let feet = stator.blades.map_or(0, |blades| blades.count);
    let foot = |foot: usize| {
        let angle = 2.0 * PI * foot as f64 / feet as f64;
        let (sin, cos) = angle.sin_cos();
        [(cos, sin), place(angle)]
    };
    RingShape {
        caption,
        line: (0..=360).map(|k| place(2.0 * PI * f64::from(k) / 360.0)).collect(),
        marks: (0..feet).map(foot).collect(),
    }
}
