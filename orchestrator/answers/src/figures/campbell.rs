//! Campbell diagram: whirl frequencies over speed, the lines of synchronous excitation, critical speeds.

use super::panels::{Line, Mark, Panel, tall};
use super::style::GREY;
use super::{COLOURS, Figure, FigureError};
use bladeoff_core::modal::{SpeedModes, Whirl, followed_modes, report};
use bladeoff_model::machine::Machine;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Speeds of a diagram.
const SPEEDS: usize = 97;
/// Whirl modes drawn that are the lowest somewhere in the diagram.
const MODES: usize = 8;
/// The highest frequency drawn is so many times the highest spin at most, but for the lowest modes.
const ORDERS: f64 = 4.0;

/// Draws the diagram up to `top` [rad/s]: each mode a line, followed by its shape; overdamped motions are not among them.
///
/// # Errors
/// An eigenvalue problem or the plotting library failed.
pub fn campbell(machine: &Machine, top: f64) -> Result<Figure, FigureError> {
    let speeds: Vec<f64> = (0..SPEEDS).map(|k| top * k as f64 / (SPEEDS - 1) as f64).collect();
    let found = followed_modes(machine, &speeds)?;
    let rpm = |speed: f64| speed * 30.0 / PI;
    let hertz = |frequency: f64| frequency / (2.0 * PI);
    let highest = highest(&found, top);
    let mut lines = Vec::new();
    let numbers: BTreeSet<usize> =
        found.iter().flat_map(|speed| speed.whirl.iter().map(|(number, _)| *number)).collect();
    let senses = [
        (Whirl::Forward, "forward whirl", COLOURS[0]),
        (Whirl::Backward, "backward whirl", COLOURS[1]),
        (Whirl::Planar, "planar", COLOURS[6]),
    ];
    let mut named = [false; 3];
    for number in numbers {
        let at = |speed: &SpeedModes| speed.whirl.iter().find(|(other, _)| *other == number).map(|(_, mode)| *mode);
        // from speed to speed in the colour of its sense at the second: at rest it has none
        for pair in found.windows(2) {
            let (Some(from), Some(to)) = (at(&pair[0]), at(&pair[1])) else { continue };
            let points = [(&pair[0], from), (&pair[1], to)].map(|(at, mode)| (rpm(at.speed), hertz(mode.frequency)));
            if points.iter().any(|point| point.1 > highest) {
                continue;
            }
            let sense = senses.iter().position(|(whirl, ..)| *whirl == to.whirl).unwrap_or(2);
            let (_, label, colour) = senses[sense];
            let label = if std::mem::replace(&mut named[sense], true) { "" } else { label };
            lines.push(Line { width: 2, ..Line::marked(label, points.to_vec(), Mark::Line, colour) });
        }
    }
    for (order, mark) in [(1.0, Mark::Line), (2.0, Mark::Dashed)] {
        let end = rpm(top).min(highest * 60.0 / order);
        lines.push(Line::marked(&format!("{order}× spin"), vec![(0.0, 0.0), (end, end * order / 60.0)], mark, GREY));
    }
    let running = rpm(machine.rotor.initial_speed);
    if running > 0.0 {
        let points = vec![(running, 0.0), (running, highest)];
        lines.push(Line::marked("running speed", points, Mark::Dashed, COLOURS[3]));
    }
    let critical = report(machine, &[])?.critical_speeds;
    for (whirl, label, mark) in [
        (Whirl::Forward, "critical, forward", Mark::Dots(5)),
        (Whirl::Backward, "critical, backward", Mark::Rings(5)),
        (Whirl::Planar, "critical, planar", Mark::Dots(3)),
    ] {
        let points: Vec<(f64, f64)> = critical
            .iter()
            .filter(|critical| critical.whirl == whirl && critical.speed <= top && hertz(critical.speed) <= highest)
            .map(|critical| (rpm(critical.speed), hertz(critical.speed)))
            .collect();
        if !points.is_empty() {
            lines.push(Line::marked(label, points, mark, COLOURS[2]));
        }
    }
    let panel = Panel { y_label: "frequency [Hz]".to_owned(), lines, y_range: Some((0.0, highest)), thin: false };
    let overdamped = found.iter().map(|speed| speed.overdamped.len()).max().unwrap_or(0);
    let left_out =
        if overdamped > 0 { format!(" ({overdamped} overdamped motions are not drawn)") } else { String::new() };
    tall(&format!("Campbell diagram of {}{left_out}", machine.name), "spin speed [rpm]", &panel, (0.0, rpm(top)))
}

/// Highest frequency drawn \[Hz\]: that of the lowest modes, as far as it is within some orders of the highest spin; at least the
/// lowest two, and the highest spin.
fn highest(found: &[SpeedModes], top: f64) -> f64 {
    let lowest = |count: usize, most: f64| {
        let modes = found.iter().flat_map(|speed| speed.whirl.iter().take(count));
        modes.map(|(_, mode)| mode.frequency).filter(|frequency| *frequency <= most).fold(0.0, f64::max)
    };
    let frequency = lowest(MODES, ORDERS * top).max(lowest(2, f64::INFINITY)).max(top);
    1.1 * frequency / (2.0 * PI)
}
