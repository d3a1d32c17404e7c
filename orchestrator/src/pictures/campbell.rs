//! Campbell diagram: whirl frequencies over speed, the lines of synchronous excitation, critical speeds.

use bladeoff_answers::figures::{COLOURS, Figure, FigureError, GREY, Line, Mark, Panel, tall_panel};
use bladeoff_core::modal::{CriticalSpeed, SpeedModes, Whirl};
use bladeoff_model::machine::Machine;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Speeds of a diagram.
const SPEEDS: usize = 97;
/// Whirl modes drawn that are the lowest somewhere in the diagram.
const MODES: usize = 8;
/// The highest frequency drawn is so many times the highest spin at most, but for the lowest modes.
const ORDERS: f64 = 4.0;

/// Speeds \[rad/s\] whose modes make a diagram up to `top` \[rad/s\].
#[must_use]
pub fn campbell_speeds(top: f64) -> Vec<f64> {
    (0..SPEEDS).map(|k| top * k as f64 / (SPEEDS - 1) as f64).collect()
}

/// Draws the diagram up to `top` \[rad/s\] from the modes at [`campbell_speeds`]: each a line, followed by its shape; overdamped
/// motions are not among them.
///
/// # Errors
/// The plotting library failed.
pub fn campbell(
    machine: &Machine,
    found: &[SpeedModes],
    critical: &[CriticalSpeed],
    top: f64,
) -> Result<Figure, FigureError> {
    let rpm = |speed: f64| speed * 30.0 / PI;
    let hertz = |frequency: f64| frequency / (2.0 * PI);
    let highest = highest(found, top);
    let mut lines = Vec::new();
    let numbers: BTreeSet<usize> =
        found.iter().flat_map(|speed| speed.whirl.iter().map(|(number, _)| *number)).collect();
    // where lines coincide, the dashes of those that are drawn later leave the ones below to be seen
    for (whirl, label, mark, colour) in [
        (Whirl::Forward, "forward whirl", Mark::Line, COLOURS[0]),
        (Whirl::Planar, "planar whirl", Mark::Line, COLOURS[6]),
        (Whirl::Mixed, "mixed whirl", Mark::Line, COLOURS[4]),
        (Whirl::Backward, "backward whirl", Mark::Dashed, COLOURS[1]),
    ] {
        let pieces = numbers.iter().flat_map(|number| pieces(found, *number, whirl)).map(|piece| {
            piece.into_iter().map(|(speed, frequency)| (rpm(speed), hertz(frequency))).collect::<Vec<_>>()
        });
        let mut label = label;
        for piece in pieces {
            for within in piece.split(|point| point.1 > highest).filter(|within| within.len() > 1) {
                let label = std::mem::take(&mut label);
                lines.push(Line { width: 2, ..Line::marked(label, within.to_vec(), mark, colour) });
            }
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
    // of two at one place both are seen
    for (whirl, label, mark, colour) in [
        (Whirl::Forward, "critical, forward", Mark::Dots(5), COLOURS[2]),
        (Whirl::Backward, "critical, backward", Mark::Rings(8), COLOURS[2]),
        (Whirl::Planar, "critical, planar", Mark::Dots(3), COLOURS[5]),
        (Whirl::Mixed, "critical, mixed", Mark::Rings(6), COLOURS[5]),
    ] {
        let points: Vec<(f64, f64)> = critical
            .iter()
            .filter(|critical| critical.whirl == whirl && critical.speed <= top && hertz(critical.speed) <= highest)
            .map(|critical| (rpm(critical.speed), hertz(critical.speed)))
            .collect();
        if !points.is_empty() {
            lines.push(Line::marked(label, points, mark, colour));
        }
    }
    let spin = machine.rotor.initial_speed;
    let near: Vec<(f64, f64)> = critical
        .iter()
        .filter(|critical| critical.is_too_near(spin) && critical.speed <= top && hertz(critical.speed) <= highest)
        .map(|critical| (rpm(critical.speed), hertz(critical.speed)))
        .collect();
    if !near.is_empty() {
        lines.push(Line::marked("separation margin too small", near, Mark::Rings(11), COLOURS[3]));
    }
    let panel = Panel { y_label: "frequency [Hz]".to_owned(), lines, y_range: Some((0.0, highest)), thin: false };
    let overdamped = found.iter().map(|speed| speed.overdamped.len()).max().unwrap_or(0);
    let left_out =
        if overdamped > 0 { format!(" ({overdamped} overdamped motions are not drawn)") } else { String::new() };
    tall_panel(&format!("Campbell diagram of {}{left_out}", machine.name), "spin speed [rpm]", &panel, (0.0, rpm(top)))
}

/// The speeds and frequencies at which the mode of a number whirls so, as far as they follow one another. From speed to speed a mode has
/// the sense that it has at the second: at rest it has none.
fn pieces(found: &[SpeedModes], number: usize, whirl: Whirl) -> Vec<Vec<(f64, f64)>> {
    let at = |speed: &SpeedModes| speed.whirl.iter().find(|(other, _)| *other == number).map(|(_, mode)| *mode);
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut goes_on = false;
    for pair in found.windows(2) {
        let (from, to) = (at(&pair[0]), at(&pair[1]).filter(|to| to.whirl == whirl));
        let (Some(from), Some(to)) = (from, to) else {
            goes_on = false;
            continue;
        };
        let reached = (pair[1].speed, to.frequency);
        match pieces.last_mut().filter(|_| goes_on) {
            Some(piece) => piece.push(reached),
            None => pieces.push(vec![(pair[0].speed, from.frequency), reached]),
        }
        goes_on = true;
    }
    pieces
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

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::modal::report;
    use bladeoff_model::machine::MachineDef;

    /// A point mass on springs that are the same all round: its modes are one frequency at all speeds.
    #[test]
    fn of_lines_and_marks_at_one_place_both_are_seen() {
        let text = "schema = 1\nname = \"jeffcott\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\n\
                    polar_inertia = 1\ninitial_speed = 100\n[rotor.bearings.s]\nstiffness = 1e4\n";
        let machine = MachineDef::parse("m.toml", text).expect("valid").build().expect("valid");
        let report = report(&machine, &campbell_speeds(200.0)).expect("solvable");
        let figure = campbell(&machine, &report.speeds, &report.critical_speeds, 200.0).expect("drawn");
        let strokes = |at: usize| {
            let colour = COLOURS[at];
            let stroke = format!("stroke=\"#{:02X}{:02X}{:02X}\"", colour.0, colour.1, colour.2);
            figure.svg().split("<polyline").filter(|tag| tag.contains(&stroke)).count()
        };
        let (forward, backward) = (strokes(0), strokes(1));
        assert!(forward > 0 && backward > 20 * forward, "one is in dashes over the other: {forward} {backward}");
        let discs: BTreeSet<&str> = figure
            .svg()
            .split("<circle")
            .skip(1)
            .filter_map(|tag| tag.split(" r=\"").nth(1)?.split('"').next())
            .collect();
        assert!(discs.len() > 1, "a ring around a dot: {discs:?}");
    }
}
