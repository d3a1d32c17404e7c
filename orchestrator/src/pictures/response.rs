//! Unbalance response: displacements and bearing loads over speed, amplitudes from zero to peak. A peak without damping is infinite, and is cut off.

use bladeoff_answers::figures::{COLOURS, Figure, FigureError, GREY, Line, Mark, Panel, Scale, panels};
use bladeoff_core::modal::{CriticalSpeed, UnbalanceResponse, unbalance_response as responses};
use bladeoff_model::machine::{Machine, RotorKind};
use std::f64::consts::PI;

/// Evenly spaced speeds of a curve, and more of them around each critical speed.
const SPEEDS: usize = 400;
const NEAR: i32 = 30;

/// Draws the steady response to all unbalances of the machine up to `top` [rad/s]; `None` without an unbalance.
///
/// # Errors
/// The plotting library failed.
pub fn unbalance_response(
    machine: &Machine,
    critical: &[CriticalSpeed],
    top: f64,
) -> Result<Option<Figure>, FigureError> {
    if machine.rotor.unbalances.iter().all(|unbalance| unbalance.mass * unbalance.radius == 0.0) {
        return Ok(None);
    }
    let speeds = speeds(critical, top);
    let found = responses(machine, &speeds);
    let mut places: Vec<(String, usize)> = Vec::new();
    if let RotorKind::Shaft(shaft) = &machine.rotor.kind {
        places.extend(shaft.discs.iter().map(|disc| (disc.name.clone(), disc.node)));
    }
    places.extend(
        machine.diaphragms.iter().map(|diaphragm| (format!("diaphragm {}", diaphragm.name), diaphragm.contact.node)),
    );
    let bearing = |name: &str| format!("bearing {name}");
    places.extend(machine.rotor.bearings.iter().map(|found| (bearing(&found.name), found.node)));
    places.extend(machine.rotor.unbalances.iter().map(|unbalance| (unbalance.name.clone(), unbalance.node)));
    let mut seen = Vec::new();
    places.retain(|(_, node)| {
        let new = !seen.contains(node);
        seen.push(*node);
        new
    });
    places.truncate(7);
    let rpm = |speed: f64| speed * 30.0 / PI;
    let is_drawn_whole = |speed: f64| !critical.iter().any(|critical| is_cut(critical, speed));
    let seen: Vec<&UnbalanceResponse> = found.iter().filter(|response| is_drawn_whole(response.speed)).collect();
    let largest = |values: &dyn Fn(&UnbalanceResponse) -> f64| seen.iter().map(|one| values(one)).fold(0.0, f64::max);
    let cut = if seen.len() < found.len() { "; undamped peaks cut off" } else { "" };
    let length = Scale::of("m", largest_displacement(&seen, &places));
    let load = Scale::of("N", largest(&|r| r.bearings.iter().chain(&r.pedestals).copied().fold(0.0, f64::max)));
    let mut displacement: Vec<Line> = places
        .iter()
        .map(|(name, node)| {
            Line::new(
                &name.replace('_', " "),
                found.iter().map(|r| (rpm(r.speed), r.nodes[*node] * length.factor)).collect(),
            )
        })
        .collect();
    let on_pedestals = machine.rotor.bearings.iter().filter(|bearing| bearing.pedestal.is_some());
    let loads = machine
        .rotor
        .bearings
        .iter()
        .enumerate()
        .map(|(i, of)| {
            Line::new(&bearing(&of.name), found.iter().map(|r| (rpm(r.speed), r.bearings[i] * load.factor)).collect())
        })
        .chain(on_pedestals.enumerate().map(|(i, of)| {
            let points = found.iter().map(|r| (rpm(r.speed), r.pedestals[i] * load.factor)).collect();
            Line::new(&format!("pedestal of {}", of.name), points)
        }))
        .collect();
    let mut displacement_top = length.factor * largest_displacement(&seen, &places);
    for diaphragm in &machine.diaphragms {
        let gap = diaphragm.contact.gap * length.factor;
        let points = vec![(rpm(speeds[0]), gap), (rpm(top), gap)];
        displacement_top = displacement_top.max(gap);
        displacement.push(Line::marked(&format!("gap of {}", diaphragm.name), points, Mark::Dashed, GREY));
    }
    let running = rpm(machine.rotor.initial_speed);
    let mut load_lines: Vec<Line> = loads;
    let load_top = load.factor * largest(&|r| r.bearings.iter().chain(&r.pedestals).copied().fold(0.0, f64::max));
    for (lines, high) in [(&mut displacement, displacement_top), (&mut load_lines, load_top)] {
        if running > 0.0 {
            let points = vec![(running, 0.0), (running, 1.05 * high)];
            lines.push(Line::marked("running speed", points, Mark::Dashed, COLOURS[3]));
        }
    }
    let panel = |y_label: String, mut lines: Vec<Line>, top: f64| {
        let top = if top > 0.0 { 1.05 * top } else { 1.0 };
        let points = lines.iter_mut().flat_map(|line| &mut line.points);
        points.for_each(|point| point.1 = point.1.min(top));
        let y_range = Some((0.0, top));
        Panel { y_label, lines, y_range, thin: false }
    };
    let title = format!("Steady response of {} to its unbalances, without contact{cut}", machine.name);
    let both = [
        panel(length.label("amplitude, 0 to peak"), displacement, displacement_top),
        panel(load.label("bearing load, 0 to peak"), load_lines, load_top),
    ];
    panels(&title, "spin speed [rpm]", &both).map(Some)
}

/// Damping ratio below which the peak at a critical speed is cut off: it is a thousand times the response off resonance, or infinite.
const UNDAMPED: f64 = 5e-4;
/// Part of a critical speed on either side of it where its peak is cut off: there the response is at most 25 times the one at rest.
const BESIDE: f64 = 0.02;

/// Whether a speed lies within an undamped peak.
fn is_cut(critical: &CriticalSpeed, speed: f64) -> bool {
    critical.damping_ratio.abs() < UNDAMPED && (speed / critical.speed - 1.0).abs() < BESIDE
}

fn largest_displacement(found: &[&UnbalanceResponse], places: &[(String, usize)]) -> f64 {
    found.iter().flat_map(|response| places.iter().map(|(_, node)| response.nodes[*node])).fold(0.0, f64::max)
}

/// Evenly spaced, and denser where a lightly damped critical speed makes a narrow peak.
fn speeds(critical: &[CriticalSpeed], top: f64) -> Vec<f64> {
    let mut speeds: Vec<f64> = (1..=SPEEDS).map(|k| top * k as f64 / SPEEDS as f64).collect();
    for critical in critical {
        let width = 4.0 * critical.damping_ratio.clamp(1e-4, 0.1) * critical.speed;
        speeds.extend((-NEAR..=NEAR).map(|k| critical.speed + width * f64::from(k) / f64::from(NEAR)));
    }
    speeds.retain(|speed| *speed > 0.0 && *speed <= top);
    speeds.sort_by(f64::total_cmp);
    speeds
}
