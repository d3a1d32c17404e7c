//! The machine drawn to scale: the shaft line from the side, the diaphragm from the front.

use super::style::{GREY, to_scale};
use super::{COLOURS, Figure, HEAD};
use crate::drawing::{Anchor, Axis, BLACK, Frame, INK, Rgb, Ruling, Svg, TEXT, WHITE, shown};
use bladeoff_model::machine::{
    Diaphragm, DiaphragmKind, Disc, FlexibleStator, Machine, RotorKind, Shaft, ShaftElement,
};
use std::f64::consts::PI;

/// Steel: discs carry mass and inertia only, so that their drawn size is that of a steel disc with both.
const DENSITY: f64 = 7850.0;
/// Width of a character of a name \[px\].
const CHARACTER: f64 = 6.5;
const SHAFT: Rgb = Rgb(190, 200, 210);

/// Draws the machine; `None` for a point mass, which has no shape.
#[must_use]
pub fn machine(machine: &Machine) -> Option<Figure> {
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { return None };
    let front = machine.diaphragms.iter().find_map(|diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => Some((diaphragm, stator)),
        _ => None,
    });
    let title = format!("{}, drawn to scale (discs as steel discs of their mass and inertia)", machine.name);
    Some(Figure::draw((if front.is_some() { 1240 } else { 860 }, 430), &title, |svg| {
        draw_side(svg, machine, shaft);
        if let Some((diaphragm, stator)) = front {
            draw_front(svg, diaphragm, stator);
        }
    }))
}

/// Radius and thickness of a steel disc with this mass and polar inertia.
fn disc_size(disc: &Disc) -> (f64, f64) {
    if disc.mass <= 0.0 {
        return (0.0, 0.0);
    }
    let radius = (2.0 * disc.polar_inertia / disc.mass).sqrt();
    (radius, disc.mass / (DENSITY * PI * radius * radius).max(f64::MIN_POSITIVE))
}

/// Largest radius of what is drawn from the side.
fn outer(machine: &Machine, shaft: &Shaft) -> f64 {
    let layers = shaft.layers.iter().flat_map(|layer| &layer.elements);
    let shafts = shaft.elements.iter().chain(layers).map(|element| 0.5 * element.diameter.max(element.end_diameter));
    let discs = shaft.discs.iter().map(|disc| disc_size(disc).0);
    let unbalances = machine.rotor.unbalances.iter().map(|unbalance| unbalance.radius);
    let stators = machine.diaphragms.iter().map(|diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => {
            stator.ring.mean_radius + 0.5 * stator.ring.thickness + stator.blades.map_or(0.0, |blades| blades.length)
        }
        _ => diaphragm.contact.rotor_radius + diaphragm.contact.gap,
    });
    shafts.chain(discs).chain(unbalances).chain(stators).fold(0.0, f64::max)
}

fn draw_side(svg: &mut Svg, machine: &Machine, shaft: &Shaft) {
    let length = shaft.nodes.last().copied().unwrap_or(1.0);
    let radius = outer(machine, shaft);
    let middle = 0.5 * length;
    let corners = [72.0, HEAD + 8.0, 842.0, 382.0];
    // one scale for both axes, whichever direction needs the room
    let (half_z, half_r) = to_scale((corners[2] - corners[0], corners[3] - corners[1]), (0.56 * length, 1.55 * radius));
    let x = Axis::between("Z [m]", (middle - half_z, middle + half_z)).most(9);
    let y = Axis::between("radius [m]", (-half_r, half_r));
    let frame = Frame::new(&x, &y, corners);
    frame.axes(svg, Ruling::Ticks, 52.0);
    let mut from = 0.0;
    for layer in &shaft.layers {
        for (element, from) in layer.elements.iter().zip(&shaft.nodes[layer.first..]) {
            draw_taper(svg, &frame, element, *from, &COLOURS[0].mixed(0.2));
        }
    }
    for element in &shaft.elements {
        let to = from + element.length;
        if element.is_tapered() {
            draw_taper(svg, &frame, element, from, &SHAFT.fill());
            from = to;
            continue;
        }
        let (r, bore) = (0.5 * element.diameter, 0.5 * element.inner_diameter);
        for (low, high) in if bore > 0.0 { vec![(-r, -bore), (bore, r)] } else { vec![(-r, r)] } {
            frame.rect(svg, SHAFT.bordered(GREY), [(from, low), (to, high)]);
        }
        from = to;
    }
    for disc in &shaft.discs {
        let (r, thickness) = disc_size(disc);
        let z = shaft.nodes[disc.node];
        let corners = [(z - 0.5 * thickness, -r), (z + 0.5 * thickness, r)];
        frame.rect(svg, COLOURS[0].mixed(0.45), corners);
        frame.rect(svg, COLOURS[0].stroke(1.0), corners);
    }
    for diaphragm in &machine.diaphragms {
        let z = shaft.nodes[diaphragm.contact.node];
        let contact = &diaphragm.contact;
        // the rotor's surface at the contact
        let rim = [(z - 0.012 * length, contact.rotor_radius), (z + 0.012 * length, contact.rotor_radius)];
        for sign in [1.0, -1.0] {
            frame.line(svg, format!("{INK} stroke-width=\"2\""), rim.map(|(z, r)| (z, sign * r)));
            if let DiaphragmKind::Flexible(stator) = &diaphragm.kind {
                let (w, t) = (0.5 * stator.ring.width, 0.5 * stator.ring.thickness);
                let (inner, outer) = (stator.ring.mean_radius - t, stator.ring.mean_radius + t);
                frame.rect(svg, COLOURS[1].fill(), [(z - w, sign * inner), (z + w, sign * outer)]);
                if let Some(blades) = stator.blades {
                    let (half, end) = (0.5 * blades.width, stator.ring.mean_radius + blades.length);
                    frame.rect(svg, COLOURS[1].mixed(0.4), [(z - half, sign * outer), (z + half, sign * end)]);
                }
            } else {
                let r = contact.rotor_radius + contact.gap;
                let casing = [(z - 0.01 * length, sign * r), (z + 0.01 * length, sign * 1.08 * r)];
                frame.rect(svg, COLOURS[1].fill(), casing);
            }
        }
    }
    for bearing in &machine.rotor.bearings {
        let z = shaft.nodes[bearing.node];
        let node = bearing.node.min(shaft.elements.len() - 1);
        let r = 0.5 * shaft.elements[node].diameter;
        let (w, h) = (0.018 * length, 0.16 * half_r);
        for sign in [1.0, -1.0] {
            let triangle = [(z, sign * r), (z - w, sign * (r + h)), (z + w, sign * (r + h))];
            frame.area(svg, COLOURS[2].fill(), triangle);
        }
    }
    for unbalance in &machine.rotor.unbalances {
        let place = (shaft.nodes[unbalance.node], unbalance.radius);
        frame.circle(svg, COLOURS[3].fill(), place, 5.0);
    }
    label(svg, &frame, machine, shaft, (radius, half_r));
}

/// The walls of an element with different ends, above and below the axis.
fn draw_taper(svg: &mut Svg, frame: &Frame<'_>, element: &ShaftElement, from: f64, fill: &str) {
    let to = from + element.length;
    let radii = [0.0, 1.0].map(|xi| element.diameters_at(xi).map(|diameter| 0.5 * diameter));
    for sign in [1.0, -1.0] {
        let [[outer, inner], [end_outer, end_inner]] = radii.map(|ends| ends.map(|r| sign * r));
        let corners = [(from, inner), (from, outer), (to, end_outer), (to, end_inner)];
        frame.area(svg, fill, corners);
        frame.line(svg, GREY.stroke(1.0), corners.into_iter().chain([corners[0]]));
    }
}

/// Names above (discs, diaphragms, unbalances) and below (bearings), in as many rows as they need without overlaps.
fn label(svg: &mut Svg, frame: &Frame<'_>, machine: &Machine, shaft: &Shaft, (radius, half_r): (f64, f64)) {
    let plain = |name: &str| name.replace('_', " ");
    let discs = shaft.discs.iter().map(|disc| (disc.node, plain(&disc.name), COLOURS[0]));
    let unbalances = machine.rotor.unbalances.iter().map(|one| (one.node, plain(&one.name), COLOURS[3]));
    let diaphragms =
        machine.diaphragms.iter().map(|one| (one.contact.node, format!("diaphragm {}", plain(&one.name)), COLOURS[1]));
    let above = discs.chain(unbalances).chain(diaphragms).map(|(node, name, colour)| (shaft.nodes[node], name, colour));
    let above: Vec<(f64, String, Rgb)> = above.collect();
    let below: Vec<(f64, String, Rgb)> = machine
        .rotor
        .bearings
        .iter()
        .map(|bearing| (shaft.nodes[bearing.node], format!("bearing {}", bearing.name.replace('_', " ")), COLOURS[2]))
        .collect();
    for (mut list, sign) in [(above, 1.0), (below, -1.0)] {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        // right end of the last name of each row
        let mut ends: Vec<f64> = Vec::new();
        for (z, name, colour) in &list {
            let Some((x, _)) = frame.place((*z, 0.0)) else { continue };
            let half = 0.5 * CHARACTER * (name.chars().count() as f64 + 1.0);
            let row = ends.iter().position(|end| *end <= x - half).unwrap_or(ends.len());
            match ends.get_mut(row) {
                Some(end) => *end = x + half,
                None => ends.push(x + half),
            }
            let height = sign * (radius + (0.08 + 0.085 * row as f64) * half_r);
            let from = (*z, sign * radius * 0.2);
            let line = format!("{} opacity=\"0.35\"", colour.stroke(1.0));
            frame.line(svg, line, [from, (*z, height - sign * 0.03 * half_r)]);
            if let Some((x, y)) = frame.place((*z, height)) {
                svg.text("", (x, y + TEXT), Anchor::Middle, name);
            }
        }
    }
}

fn draw_front(svg: &mut Svg, diaphragm: &Diaphragm, stator: &FlexibleStator) {
    let (ring, contact) = (&stator.ring, &diaphragm.contact);
    let reach = 1.08 * (ring.mean_radius + ring.thickness + stator.blades.map_or(0.0, |blades| blades.length));
    let caption = format!("diaphragm {} along Z: gap {} mm", diaphragm.name, shown(1e3 * contact.gap));
    svg.text("font-size=\"11\"", (1045.0, HEAD + 24.0), Anchor::Middle, &caption);
    let corners = [858.0, HEAD + 36.0, 1232.0, 422.0];
    let (half_x, half_y) = to_scale((corners[2] - corners[0], corners[3] - corners[1]), (reach, reach));
    let (x, y) = (Axis::between("", (-half_x, half_x)), Axis::between("", (-half_y, half_y)));
    let frame = Frame::new(&x, &y, corners);
    let circle = |radius: f64| {
        (0..=240).map(move |k| {
            let (sin, cos) = (2.0 * PI * f64::from(k) / 240.0).sin_cos();
            (radius * cos, radius * sin)
        })
    };
    if let Some(blades) = stator.blades {
        for blade in 0..blades.count {
            let (sin, cos) = (diaphragm.angle + 2.0 * PI * blade as f64 / blades.count as f64).sin_cos();
            let (half, from, to) = (0.5 * blades.thickness, ring.mean_radius, ring.mean_radius + blades.length);
            let corners = [(from, -half), (to, -half), (to, half), (from, half)];
            frame.area(svg, COLOURS[1].mixed(0.4), corners.map(|(r, t)| (r * cos - t * sin, r * sin + t * cos)));
        }
        let end = ring.mean_radius + blades.length;
        frame.line(svg, GREY.stroke(2.0), circle(end));
    }
    // ring and rotor surfaces: rings are drawn as discs, the larger first
    let half = 0.5 * ring.thickness;
    for (radius, paint) in [
        (ring.mean_radius + half, COLOURS[1].fill()),
        ((ring.mean_radius - half).max(contact.rotor_radius + contact.gap), WHITE.fill()),
        (contact.rotor_radius, SHAFT.bordered(BLACK)),
    ] {
        frame.area(svg, paint, circle(radius));
    }
}
