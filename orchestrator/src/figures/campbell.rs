//! Campbell diagram: whirl frequencies over speed, the lines of synchronous excitation, critical speeds.

use super::panels::{Line, Mark, Panel, tall};
use super::style::GREY;
use super::{COLOURS, Figure, FigureError};
use bladeoff_core::machine::Machine;
use bladeoff_core::modal::{Whirl, report, whirl_modes};
use std::f64::consts::PI;

/// Speeds of a diagram.
const SPEEDS: usize = 97;
/// Modes drawn.
const MODES: usize = 8;

/// Draws the diagram up to `top` [rad/s].
///
/// # Errors
/// An eigenvalue problem or the plotting library failed.
pub fn campbell(machine: &Machine, top: f64) -> Result<Figure, FigureError> {
    let speeds: Vec<f64> = (0..SPEEDS).map(|k| top * k as f64 / (SPEEDS - 1) as f64).collect();
    let modes = whirl_modes(machine, &speeds)?;
    let rpm = |speed: f64| speed * 30.0 / PI;
    let hertz = |frequency: f64| frequency / (2.0 * PI);
    let mut lines = Vec::new();
    for (whirl, label, colour) in [
        (Whirl::Forward, "forward whirl", COLOURS[0]),
        (Whirl::Backward, "backward whirl", COLOURS[1]),
        (Whirl::Planar, "planar (at rest)", COLOURS[6]),
    ] {
        let points: Vec<(f64, f64)> = modes
            .iter()
            .flat_map(|(speed, modes)| modes.iter().take(MODES).map(move |mode| (*speed, mode)))
            .filter(|(_, mode)| mode.whirl == whirl)
            .map(|(speed, mode)| (rpm(speed), hertz(mode.frequency)))
            .collect();
        if !points.is_empty() {
            lines.push(Line::marked(label, points, Mark::Dots(2), colour));
        }
    }
    let highest = lines.iter().flat_map(|line| &line.points).map(|point| point.1).fold(0.0, f64::max) * 1.05;
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
            .filter(|critical| critical.whirl == whirl && critical.speed <= top)
            .map(|critical| (rpm(critical.speed), hertz(critical.speed)))
            .collect();
        if !points.is_empty() {
            lines.push(Line::marked(label, points, mark, COLOURS[2]));
        }
    }
    let panel = Panel { y_label: "frequency [Hz]".to_owned(), lines, y_range: Some((0.0, highest)), thin: false };
    tall(&format!("Campbell diagram of {}", machine.name), "spin speed [rpm]", &panel, (0.0, rpm(top)))
}
