//! Unbalance response: displacements with their phases, and bearing loads, over speed. Amplitudes are zero-to-peak, on logarithmic axes. The peak
//! without damping is infinite and is cut off.

use bladeoff_answers::figures::{Figure, GREY, Line, Mark, Panel, Scale, panels_marked, style};
use bladeoff_core::modal::{CriticalSpeed, UnbalanceResponse, unbalance_response as responses};
use bladeoff_model::machine::{Machine, RotorKind};
use bladeoff_text::document::units::format_digits;
use std::f64::consts::PI;

/// Number of evenly spaced speeds of a curve; further speeds lie around each critical speed.
const SPEEDS: usize = 400;
const NEAR: i32 = 30;

/// Draws the steady response to all unbalances of the machine up to `top` [rad/s]; `None` without an unbalance.
#[must_use]
pub fn unbalance_response(machine: &Machine, critical: &[CriticalSpeed], top: f64) -> Option<Figure> {
    if machine.rotor.unbalances.iter().all(|unbalance| unbalance.mass * unbalance.radius == 0.0) {
        return None;
    }
    let speeds = speeds(critical, top);
    let found = responses(machine, &speeds);
    let places = places(machine);
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
    let bearing = |name: &str| format!("bearing {name}");
    let on_pedestals = machine.rotor.bearings.iter().filter(|bearing| bearing.pedestal.is_some());
    let loads: Vec<Line> = machine
        .rotor
        .bearings
        .iter()
        .enumerate()
        .map(|(i, of)| {
            Line::new(&bearing(&of.name), found.iter().map(|r| (rpm(r.speed), r.bearings[i] * load.factor)).collect())
        })
        .chain(on_pedestals.enumerate().map(|(i, of)| {
            let points = found.iter().map(|r| (rpm(r.speed), r.pedestals[i] * load.factor)).collect();
            Line::new(&format!("pedestal of {}", of.name.replace('_', " ")), points)
        }))
        .collect();
    let mut displacement_top = length.factor * largest_displacement(&seen, &places);
    for diaphragm in &machine.diaphragms {
        let gap = diaphragm.contact.gap * length.factor;
        let points = vec![(rpm(speeds[0]), gap), (rpm(top), gap)];
        displacement_top = displacement_top.max(gap);
        displacement.push(Line::marked(
            &format!("gap of {}", diaphragm.name.replace('_', " ")),
            points,
            Mark::Dashed,
            GREY,
        ));
    }
    let running = rpm(machine.rotor.initial_speed);
    let load_top = load.factor * largest(&|r| r.bearings.iter().chain(&r.pedestals).copied().fold(0.0, f64::max));
    let panel = |y_label: String, mut lines: Vec<Line>, top: f64, floor: f64, is_log: bool| {
        let top = if top > 0.0 { 1.05 * top } else { 1.0 };
        let floor = if is_log { floor.clamp(top / DECADES, top / 10.0) } else { 0.0 };
        for line in &mut lines {
            // values below the range of a logarithmic axis are not drawn, and an undamped peak is cut off
            line.points.retain(|point| !is_log || point.1 >= floor);
            line.points.iter_mut().for_each(|point| point.1 = point.1.min(top));
        }
        if running > 0.0 {
            lines.push(Line::marked("running speed", vec![(running, floor), (running, top)], Mark::Line, GREY));
        }
        Panel { y_label, lines, y_range: Some((floor, top)), thin: false, is_log }
    };
    let least = |lines: &[Line]| {
        let values = lines.iter().flat_map(|line| &line.points).map(|point| point.1).filter(|value| *value > 0.0);
        values.fold(f64::INFINITY, f64::min).min(f64::MAX)
    };
    let title = format!("Steady response of {} to its unbalances, without contact{cut}", machine.name);
    let floors = [least(&displacement), least(&loads)];
    let all = [
        panel(length.label("amplitude, 0 to peak"), displacement, displacement_top, floors[0], true),
        panel("phase lag along X [°]".to_owned(), lags(machine, &found, &places), 360.0 / 1.05, 0.0, false),
        panel(load.label("bearing load, 0 to peak"), loads, load_top, floors[1], true),
    ];
    let excited = critical.iter().filter(|critical| critical.is_excited_by_unbalance() && critical.speed <= top);
    let marks: Vec<(f64, String)> = excited
        .take(MARKS)
        .map(|critical| (rpm(critical.speed), format!("critical {} rpm", format_digits(rpm(critical.speed), "", 4))))
        .collect();
    Some(panels_marked(&title, "spin speed [rpm]", &all, &marks))
}

/// Names and nodes of the displacements that are drawn, each node once: discs, unbalances, diaphragms, bearings and monitors.
fn places(machine: &Machine) -> Vec<(String, usize)> {
    let rotor = &machine.rotor;
    let discs = match &rotor.kind {
        RotorKind::Shaft(shaft) => shaft.discs.iter().map(|disc| (disc.name.clone(), disc.node)).collect(),
        RotorKind::PointMass(_) => Vec::new(),
    };
    let unbalances = rotor.unbalances.iter().map(|unbalance| (unbalance.name.clone(), unbalance.node));
    let diaphragms = machine.diaphragms.iter();
    let diaphragms = diaphragms.map(|diaphragm| (format!("diaphragm {}", diaphragm.name), diaphragm.contact.node));
    let bearings = rotor.bearings.iter().map(|bearing| (format!("bearing {}", bearing.name), bearing.node));
    let monitors = machine.monitors.iter().map(|monitor| (format!("monitor {}", monitor.name), monitor.node));
    let mut seen = Vec::new();
    let mut all: Vec<_> =
        discs.into_iter().chain(unbalances).chain(diaphragms).chain(bearings).chain(monitors).collect();
    all.retain(|(_, node)| {
        let is_new = !seen.contains(node);
        seen.push(*node);
        is_new
    });
    all
}

/// Largest number of critical speeds that are marked.
const MARKS: usize = 6;
/// Largest ratio of two values on a logarithmic axis.
const DECADES: f64 = 1e4;

/// Phase lags of the displacements relative to the first unbalance, in degrees from 0 to 360; a line is interrupted where the lag passes from one
/// end of the range to the other.
fn lags(machine: &Machine, found: &[UnbalanceResponse], places: &[(String, usize)]) -> Vec<Line> {
    let unbalances = &machine.rotor.unbalances;
    let mark =
        unbalances.iter().find(|unbalance| unbalance.mass * unbalance.radius != 0.0).map_or(0.0, |first| first.phase);
    let mut lines = Vec::new();
    for (at, (name, node)) in places.iter().enumerate() {
        let lag = |response: &UnbalanceResponse| {
            let lag = (mark - response.phases[*node]).to_degrees().rem_euclid(360.0);
            // a lag just below 360 degrees by rounding is 0
            (response.speed * 30.0 / PI, if lag > 359.999 { 0.0 } else { lag })
        };
        let points: Vec<(f64, f64)> = found.iter().map(lag).collect();
        let pieces = points.chunk_by(|from, to| (to.1 - from.1).abs() < 180.0);
        for (piece, points) in pieces.enumerate() {
            let label = if piece == 0 { name.replace('_', " ") } else { String::new() };
            let (colour, mark) = style(at, Mark::Line);
            lines.push(Line::marked(&label, points.to_vec(), mark, colour));
        }
    }
    lines
}

/// Damping ratio below which the peak at a critical speed is cut off, because it is a thousand times the response away from resonance, or
/// infinite.
const UNDAMPED: f64 = 5e-4;
/// Relative distance from a critical speed within which its peak is cut off: at this distance the response is at most 25 times that at rest.
const BESIDE: f64 = 0.02;

/// Whether a speed lies within an undamped peak.
fn is_cut(critical: &CriticalSpeed, speed: f64) -> bool {
    critical.damping_ratio.abs() < UNDAMPED && (speed / critical.speed - 1.0).abs() < BESIDE
}

fn largest_displacement(found: &[&UnbalanceResponse], places: &[(String, usize)]) -> f64 {
    found.iter().flat_map(|response| places.iter().map(|(_, node)| response.nodes[*node])).fold(0.0, f64::max)
}

/// Evenly spaced speeds, and additional speeds near a lightly damped critical speed, whose peak is narrow.
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
