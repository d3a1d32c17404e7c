//! The orbit of the rotor centre inside the clearance of the deformed ring, at chosen instants.
//!
//! Drawn in the plane of the rotor centre: the clearance is `gap + v(alpha)`, the gap plus the ring's radial displacement, and
//! the rotor touches where its centre reaches it. Both on one scale: the radii themselves would hide millimetres in metres.

use super::contacts::Contact;
use super::style::{GREY, Scale, fixed, to_scale};
use super::{COLOURS, Figure, HEAD};
use crate::drawing::{Anchor, Axis, Frame, Ruling, Svg, TEXT, number_within};
use crate::history::History;
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
#[must_use]
pub fn orbits(history: &History, name: &str, contact: &Contact, instants: &[f64]) -> Option<Figure> {
    let (x, y) = (&contact.channel(history, "rotor_x_m")?.values, &contact.channel(history, "rotor_y_m")?.values);
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
    let ring = ring_of(history, contact);
    let shown = match ring {
        Ring::Deformed => "rotor centre inside the clearance of the deformed ring",
        Ring::AtRest => "rotor centre and the gap at rest",
        Ring::Unknown => "rotor centre",
    };
    let size = (columns * side, 72 + rows * (side - 19));
    Some(Figure::draw(size, &format!("{name}: {shown}{}", contact.of()), |svg| {
        legend(svg, ring, columns * side);
        for (number_of, &instant) in (0..).zip(instants) {
            let turn = last_turn(history, instant);
            let orbit = turn.clone().map(|k| (x[k] * scale.factor, y[k] * scale.factor));
            let at = turn.end.saturating_sub(1);
            let radial: Vec<f64> = contact.radial(history).iter().map(|node| node.values[at]).collect();
            let ring = gap.and_then(|gap| clearance(&radial, gap)).map(|line| scaled(&line, scale.factor));
            let smallest = contact.channel(history, "gap_m").map(|gap| gap.values[at]).filter(|gap| gap.is_finite());
            let smallest = smallest.map_or(String::new(), |gap| {
                format!(", clearance {} {}", fixed(gap * scale.factor, decimals), scale.unit)
            });
            let caption = format!("t = {} s{smallest}", number_within(instant, span));
            let place = (f64::from(number_of % columns * side), f64::from(number_of / columns * (side - 19)));
            let shown = Orbit {
                caption,
                line: orbit.collect(),
                ring,
                gap: gap.map(|gap| gap * scale.factor),
                reach: reach * scale.factor,
                scale: &scale,
            };
            draw(svg, (place.0, HEAD + 24.0 + place.1), f64::from(side), &shown);
        }
    }))
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

/// The picture of an instant, in shown units.
struct Orbit<'a> {
    caption: String,
    line: Vec<(f64, f64)>,
    ring: Option<Vec<(f64, f64)>>,
    gap: Option<f64>,
    reach: f64,
    scale: &'a Scale,
}

fn draw(svg: &mut Svg, (left, top): (f64, f64), side: f64, orbit: &Orbit<'_>) {
    svg.text("font-size=\"11\"", (left + side / 2.0, top + 16.0), Anchor::Middle, &orbit.caption);
    let corners = [left + 66.0, top + 26.0, left + side - 8.0, top + side - 66.0];
    let (half_x, half_y) = to_scale((corners[2] - corners[0], corners[3] - corners[1]), (orbit.reach, orbit.reach));
    let x = Axis::between(orbit.scale.label("x"), (-half_x, half_x));
    let y = Axis::between(orbit.scale.label("y"), (-half_y, half_y));
    let frame = Frame::new(&x, &y, corners);
    frame.axes(svg, Ruling::Grid, 50.0);
    if let Some(gap) = orbit.gap {
        let circle = (0..=180).map(|k| 2.0 * PI * f64::from(k) / 180.0).map(|a| (gap * a.cos(), gap * a.sin()));
        frame.line(svg, GREY.stroke(1.0), circle);
    }
    if let Some(ring) = &orbit.ring {
        frame.line(svg, COLOURS[1].stroke(2.0), ring.iter().copied());
    }
    let places: Vec<(f64, f64)> = frame.places(orbit.line.iter().copied()).collect();
    if let Some(&last) = places.last() {
        svg.circle(COLOURS[0].fill(), last, 4.0);
    }
    svg.line(COLOURS[0].stroke(2.0), places);
}

/// What the lines are, once for all pictures, in a strip above them: inside, it would hide an orbit.
fn legend(svg: &mut Svg, ring: Ring, width: u32) {
    let mut entries = vec![("orbit of the last turn", COLOURS[0])];
    if ring != Ring::Unknown {
        entries.push(("gap at rest", GREY));
    }
    if ring == Ring::Deformed {
        entries.push(("clearance at t", COLOURS[1]));
    }
    let pitch = (width / 3).min(200);
    for (at, (name, colour)) in (0..).zip(entries) {
        let (x, y) = (f64::from(60 + pitch * at), HEAD + 8.0);
        svg.line(colour.stroke(3.0), [(x, y), (x + 16.0, y)]);
        svg.text("", (x + 21.0, y + TEXT), Anchor::Start, name);
    }
}
