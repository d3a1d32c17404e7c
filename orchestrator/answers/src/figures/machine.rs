//! The machine drawn to scale: the shaft line from the side, the diaphragm from the front.

use super::style::{FINE, GREY, SMALL, TEXT, TITLE, tick, to_scale};
use super::{Area, COLOURS, Figure, FigureError};
use bladeoff_model::machine::{DiaphragmKind, Disc, Machine, RotorKind, Shaft, ShaftElement};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{BLACK, ChartBuilder, Color, IntoFont, RGBAColor, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::f64::consts::PI;

/// Steel: discs carry mass and inertia only, so that their drawn size is that of a steel disc with both.
const DENSITY: f64 = 7850.0;
const SHAFT: RGBColor = RGBColor(190, 200, 210);

/// Draws the machine; `None` for a point mass, which has no shape.
///
/// # Errors
/// The plotting library failed.
pub fn machine(machine: &Machine) -> Result<Option<Figure>, FigureError> {
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { return Ok(None) };
    let front = machine.diaphragms.iter().any(|diaphragm| matches!(diaphragm.kind, DiaphragmKind::Flexible(_)));
    let width = if front { 1240 } else { 860 };
    let figure = Figure::draw((width, 430), |root| {
        let root = root.titled(
            &format!("{}, drawn to scale (discs as steel discs of their mass and inertia)", machine.name),
            TITLE,
        )?;
        let (side, rest) = root.split_horizontally(850 * FINE);
        draw_side(&side, machine, shaft)?;
        if front {
            draw_front(&rest, machine)?;
        }
        Ok(())
    })?;
    Ok(Some(figure))
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

fn draw_side(area: &Area<'_>, machine: &Machine, shaft: &Shaft) -> Result<(), FigureError> {
    let length = shaft.nodes.last().copied().unwrap_or(1.0);
    let radius = outer(machine, shaft);
    let middle = 0.5 * length;
    let mut builder = ChartBuilder::on(area);
    builder.margin(8 * FINE).x_label_area_size(40 * FINE).y_label_area_size(56 * FINE);
    let plot = builder.build_cartesian_2d(0.0..1.0, 0.0..1.0)?.plotting_area().dim_in_pixel();
    // one scale for both axes, whichever direction needs the room
    let (half_z, half_r) = to_scale(plot, (0.56 * length, 1.55 * radius));
    let mut chart = builder.build_cartesian_2d(middle - half_z..middle + half_z, -half_r..half_r)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .set_all_tick_mark_size(4 * FINE)
        .axis_style(BLACK.stroke_width(FINE))
        .x_labels(9)
        .y_labels(7)
        .x_label_formatter(&|value| tick(*value))
        .y_label_formatter(&|value| tick(*value))
        .label_style(SMALL.into_font())
        .axis_desc_style(TEXT.into_font())
        .x_desc("Z [m]")
        .y_desc("radius [m]")
        .draw()?;
    let mut from = 0.0;
    for layer in &shaft.layers {
        for (element, from) in layer.elements.iter().zip(&shaft.nodes[layer.first..]) {
            draw_taper(&mut chart, element, *from, COLOURS[0].mix(0.2))?;
        }
    }
    for element in &shaft.elements {
        let to = from + element.length;
        if element.is_tapered() {
            draw_taper(&mut chart, element, from, SHAFT.to_rgba())?;
            from = to;
            continue;
        }
        let (r, bore) = (0.5 * element.diameter, 0.5 * element.inner_diameter);
        for (low, high) in if bore > 0.0 { vec![(-r, -bore), (bore, r)] } else { vec![(-r, r)] } {
            chart.draw_series([
                Rectangle::new([(from, low), (to, high)], SHAFT.filled()),
                Rectangle::new([(from, low), (to, high)], GREY.stroke_width(FINE)),
            ])?;
        }
        from = to;
    }
    for disc in &shaft.discs {
        let (r, thickness) = disc_size(disc);
        let z = shaft.nodes[disc.node];
        let corners = [(z - 0.5 * thickness, -r), (z + 0.5 * thickness, r)];
        chart.draw_series([
            Rectangle::new(corners, COLOURS[0].mix(0.45).filled()),
            Rectangle::new(corners, COLOURS[0].stroke_width(FINE)),
        ])?;
    }
    for diaphragm in &machine.diaphragms {
        let z = shaft.nodes[diaphragm.contact.node];
        let contact = &diaphragm.contact;
        // the rotor's surface at the contact
        let rim = [(z - 0.012 * length, contact.rotor_radius), (z + 0.012 * length, contact.rotor_radius)];
        for sign in [1.0, -1.0] {
            chart.draw_series([PathElement::new(rim.map(|(z, r)| (z, sign * r)), BLACK.stroke_width(2 * FINE))])?;
            if let DiaphragmKind::Flexible(stator) = &diaphragm.kind {
                let (w, t) = (0.5 * stator.ring.width, 0.5 * stator.ring.thickness);
                let (inner, outer) = (stator.ring.mean_radius - t, stator.ring.mean_radius + t);
                chart.draw_series([Rectangle::new(
                    [(z - w, sign * inner), (z + w, sign * outer)],
                    COLOURS[1].filled(),
                )])?;
                if let Some(blades) = stator.blades {
                    let (half, end) = (0.5 * blades.width, stator.ring.mean_radius + blades.length);
                    chart.draw_series([Rectangle::new(
                        [(z - half, sign * outer), (z + half, sign * end)],
                        COLOURS[1].mix(0.4).filled(),
                    )])?;
                }
            } else {
                let r = contact.rotor_radius + contact.gap;
                chart.draw_series([Rectangle::new(
                    [(z - 0.01 * length, sign * r), (z + 0.01 * length, sign * 1.08 * r)],
                    COLOURS[1].filled(),
                )])?;
            }
        }
    }
    for bearing in &machine.rotor.bearings {
        let z = shaft.nodes[bearing.node];
        let node = bearing.node.min(shaft.elements.len() - 1);
        let r = 0.5 * shaft.elements[node].diameter;
        let (w, h) = (0.018 * length, 0.16 * half_r);
        for sign in [1.0, -1.0] {
            let triangle = vec![(z, sign * r), (z - w, sign * (r + h)), (z + w, sign * (r + h))];
            chart.draw_series([Polygon::new(triangle, COLOURS[2].filled())])?;
        }
    }
    for unbalance in &machine.rotor.unbalances {
        let place = (shaft.nodes[unbalance.node], unbalance.radius);
        chart.draw_series([Circle::new(place, 5 * FINE as i32, COLOURS[3].filled())])?;
        let style = SMALL.into_font().color(&COLOURS[3]).pos(Pos::new(HPos::Left, VPos::Center));
        let beside = (place.0 + 0.02 * length, place.1);
        chart.draw_series([Text::new(unbalance.name.replace('_', " "), beside, style)])?;
    }
    label(&mut chart, machine, shaft, (radius, half_r))
}

/// The walls of an element with different ends, above and below the axis.
fn draw_taper(
    chart: &mut Chart<'_, '_>,
    element: &ShaftElement,
    from: f64,
    fill: RGBAColor,
) -> Result<(), FigureError> {
    let to = from + element.length;
    let radii = [0.0, 1.0].map(|xi| element.diameters_at(xi).map(|diameter| 0.5 * diameter));
    for sign in [1.0, -1.0] {
        let [[outer, inner], [end_outer, end_inner]] = radii.map(|ends| ends.map(|r| sign * r));
        let corners = vec![(from, inner), (from, outer), (to, end_outer), (to, end_inner)];
        let outline: Vec<(f64, f64)> = corners.iter().chain(corners.first()).copied().collect();
        chart.draw_series([Polygon::new(corners, fill.filled())])?;
        chart.draw_series([PathElement::new(outline, GREY.stroke_width(FINE))])?;
    }
    Ok(())
}

type Chart<'a, 'b> = plotters::chart::ChartContext<
    'a,
    plotters::prelude::SVGBackend<'b>,
    plotters::prelude::Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Names above and below, in two rows each where neighbours are close.
fn label(
    chart: &mut Chart<'_, '_>,
    machine: &Machine,
    shaft: &Shaft,
    (radius, half_r): (f64, f64),
) -> Result<(), FigureError> {
    let mut above: Vec<(f64, String, RGBColor)> =
        shaft.discs.iter().map(|disc| (shaft.nodes[disc.node], disc.name.replace('_', " "), COLOURS[0])).collect();
    above.extend(
        machine.diaphragms.iter().map(|d| (shaft.nodes[d.contact.node], format!("diaphragm {}", d.name), COLOURS[1])),
    );
    let below: Vec<(f64, String, RGBColor)> = machine
        .rotor
        .bearings
        .iter()
        .map(|bearing| (shaft.nodes[bearing.node], format!("bearing {}", bearing.name.replace('_', " ")), COLOURS[2]))
        .collect();
    for (mut list, sign) in [(above, 1.0), (below, -1.0)] {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (at, (z, name, colour)) in list.iter().enumerate() {
            let row = (at % 3) as f64;
            let height = sign * (radius + (0.08 + 0.085 * row) * half_r);
            let anchor = Pos::new(HPos::Center, VPos::Center);
            let style = SMALL.into_font().color(colour).pos(anchor);
            chart.draw_series([PathElement::new(
                [(*z, sign * radius * 0.2), (*z, height - sign * 0.03 * half_r)],
                colour.mix(0.35).stroke_width(FINE),
            )])?;
            chart.draw_series([Text::new(name.clone(), (*z, height), style)])?;
        }
    }
    Ok(())
}

fn draw_front(area: &Area<'_>, machine: &Machine) -> Result<(), FigureError> {
    let Some((diaphragm, stator)) = machine.diaphragms.iter().find_map(|diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => Some((diaphragm, stator)),
        _ => None,
    }) else {
        return Ok(());
    };
    let (ring, contact) = (&stator.ring, &diaphragm.contact);
    let reach = 1.08 * (ring.mean_radius + ring.thickness + stator.blades.map_or(0.0, |blades| blades.length));
    let caption = format!("diaphragm {} along Z: gap {} mm", diaphragm.name, tick(1e3 * contact.gap));
    let area = area.margin(8 * FINE, 8 * FINE, 8 * FINE, 8 * FINE).titled(&caption, TEXT)?;
    let (half_x, half_y) = to_scale(area.dim_in_pixel(), (reach, reach));
    let mut chart = ChartBuilder::on(&area).build_cartesian_2d(-half_x..half_x, -half_y..half_y)?;
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
            let turned: Vec<(f64, f64)> = corners.iter().map(|(r, t)| (r * cos - t * sin, r * sin + t * cos)).collect();
            chart.draw_series([Polygon::new(turned, COLOURS[1].mix(0.4).filled())])?;
        }
        let end = ring.mean_radius + blades.length;
        chart.draw_series([PathElement::new(circle(end).collect::<Vec<_>>(), GREY.stroke_width(2 * FINE))])?;
    }
    // ring and rotor surfaces: rings are drawn as discs, the larger first
    let half = 0.5 * ring.thickness;
    let disc = |radius: f64, colour: RGBColor| Polygon::new(circle(radius).collect::<Vec<_>>(), colour.filled());
    chart.draw_series([
        disc(ring.mean_radius + half, COLOURS[1]),
        disc((ring.mean_radius - half).max(contact.rotor_radius + contact.gap), WHITE),
        disc(contact.rotor_radius, SHAFT),
    ])?;
    chart
        .draw_series([PathElement::new(circle(contact.rotor_radius).collect::<Vec<_>>(), BLACK.stroke_width(FINE))])?;
    Ok(())
}
