//! Campbell diagram: whirl frequencies over speed with the logarithmic decrement as colour, the lines of synchronous excitation, critical speeds
//! with their separation margins.

use bladeoff_answers::figures::{COLOURS, Figure, GREY, Line, Mark, Panel, Rgb, tall_panel, viridis};
use bladeoff_core::modal::{CriticalSpeed, SpeedModes, Whirl};
use bladeoff_model::machine::Machine;
use bladeoff_text::document::units::format_digits;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Number of speeds in a diagram.
const SPEEDS: usize = 97;
/// Number of lowest whirl modes that the frequency axis covers at each speed, up to [`ORDERS`] times the highest spin speed.
const MODES: usize = 8;
/// Largest number of critical speeds listed beside the diagram.
const LISTED: usize = 12;
/// Ratio to the highest spin speed up to which the frequency axis covers the lowest [`MODES`] modes; it always covers the lowest two.
const ORDERS: f64 = 4.0;

/// Speeds \[rad/s\] at which the modes are computed for a diagram up to `top` \[rad/s\].
#[must_use]
pub fn campbell_speeds(top: f64) -> Vec<f64> {
    (0..SPEEDS).map(|k| top * k as f64 / (SPEEDS - 1) as f64).collect()
}

/// Draws the diagram up to `top` \[rad/s\] from the modes at [`campbell_speeds`]: one line for each mode, which is followed from speed to speed by
/// its mode shape. Overdamped modes are not drawn.
#[must_use]
pub fn campbell(machine: &Machine, found: &[SpeedModes], critical: &[CriticalSpeed], top: f64) -> Figure {
    let rpm = |speed: f64| speed * 30.0 / PI;
    let hertz = |frequency: f64| frequency / (2.0 * PI);
    let highest = highest(found, top);
    let mut lines = Vec::new();
    let numbers: BTreeSet<usize> =
        found.iter().flat_map(|speed| speed.whirl.iter().map(|(number, _)| *number)).collect();
    // where lines coincide, the line below remains visible between the dashes of the line drawn later
    for (whirl, label, mark, width) in [
        (Whirl::Forward, "forward whirl", Mark::Line, 3),
        (Whirl::Planar, "planar whirl", Mark::Line, 1),
        (Whirl::Mixed, "mixed whirl", Mark::Dashed, 1),
        (Whirl::Backward, "backward whirl", Mark::Dashed, 3),
    ] {
        let of_one_colour =
            numbers.iter().flat_map(|number| pieces(found, *number, whirl)).flat_map(|piece| coloured(&piece));
        let mut label = label;
        for (colour, piece) in of_one_colour {
            let points: Vec<(f64, f64)> =
                piece.into_iter().map(|(speed, frequency)| (rpm(speed), hertz(frequency))).collect();
            for within in points.split(|point| point.1 > highest).filter(|within| within.len() > 1) {
                if !label.is_empty() {
                    // the legend entry of a whirl direction has no colour of a decrement
                    lines
                        .push(Line { width, ..Line::marked(std::mem::take(&mut label), Vec::new(), mark, COLOURS[6]) });
                }
                lines.push(Line { width, ..Line::marked("", within.to_vec(), mark, colour) });
            }
        }
    }
    for (at, (_, label)) in DECREMENTS.iter().enumerate() {
        if lines.iter().any(|line| line.colour == Some(colour_of(at))) {
            lines.push(Line::marked(&format!("log decrement {label}"), Vec::new(), Mark::Line, colour_of(at)));
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
    // of two marks at the same place both remain visible
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
    // critical speeds above the highest frequency of the diagram are listed, too
    let listed = critical.iter().take(LISTED);
    lines.extend(listed.map(|critical| Line::marked(&in_words(critical, spin), Vec::new(), Mark::Dots(0), GREY)));
    let panel =
        Panel { y_label: "frequency [Hz]".to_owned(), lines, y_range: Some((0.0, highest)), ..Panel::default() };
    let overdamped = found.iter().map(|speed| speed.overdamped.len()).max().unwrap_or(0);
    let left_out =
        if overdamped > 0 { format!(" ({overdamped} overdamped motions are not drawn)") } else { String::new() };
    tall_panel(&format!("Campbell diagram of {}{left_out}", machine.name), "spin speed [rpm]", &panel, (0.0, rpm(top)))
}

/// Lower limit of the logarithmic decrement for each colour, and its name. Below zero is unstable; 0.1 is what standards ask for.
const DECREMENTS: [(f64, &str); 6] = [
    (f64::NEG_INFINITY, "below 0: unstable"),
    (0.0, "0 to 0.03"),
    (0.03, "0.03 to 0.1"),
    (0.1, "0.1 to 0.3"),
    (0.3, "0.3 to 1"),
    (1.0, "from 1"),
];

/// The colour of a class of decrements: red for unstable, the others from dark to light.
fn colour_of(class: usize) -> Rgb {
    match class {
        0 => Rgb(200, 0, 0),
        _ => viridis(0.88 * (class - 1) as f64 / (DECREMENTS.len() - 2) as f64),
    }
}

/// A speed, the whirl frequency at this speed, and its logarithmic decrement.
type Point = (f64, f64, f64);

/// Parts of a line whose decrements are in one class, with their colours. Each part begins at the last point of the part before it.
fn coloured(piece: &[Point]) -> Vec<(Rgb, Vec<(f64, f64)>)> {
    let class = |point: &Point| DECREMENTS.iter().rposition(|(from, _)| point.2 >= *from).unwrap_or(0);
    let mut parts: Vec<(Rgb, Vec<(f64, f64)>)> = Vec::new();
    for pair in piece.windows(2) {
        let colour = colour_of(class(&pair[1]));
        match parts.last_mut().filter(|(known, _)| *known == colour) {
            Some((_, part)) => part.push((pair[1].0, pair[1].1)),
            None => parts.push((colour, pair.iter().map(|point| (point.0, point.1)).collect())),
        }
    }
    parts
}

/// A critical speed in words: "1242 rpm: log dec. 0.096, margin 17 % (16 % required)".
fn in_words(critical: &CriticalSpeed, spin: f64) -> String {
    let per_cent = |share: f64| format!("{:.0} %", 100.0 * share);
    let margin = match (critical.separation(spin), critical.required_separation(spin)) {
        (Some(margin), Some(required)) => format!(", margin {} ({} required)", per_cent(margin), per_cent(required)),
        (Some(_), None) => ", not excited by unbalance".to_owned(),
        _ => String::new(),
    };
    let (rpm, decrement) =
        (format_digits(critical.speed * 30.0 / PI, "", 4), format_digits(critical.decrement(), "", 2));
    format!("{rpm} rpm: log dec. {decrement}{margin}")
}

/// Uninterrupted series of points (speed, frequency, decrement) at which mode `number` has this whirl direction. Between two speeds a mode has the
/// direction that it has at the higher one, because at rest it has none.
fn pieces(found: &[SpeedModes], number: usize, whirl: Whirl) -> Vec<Vec<Point>> {
    let at = |speed: &SpeedModes| speed.whirl.iter().find(|(other, _)| *other == number).map(|(_, mode)| *mode);
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    let mut goes_on = false;
    for pair in found.windows(2) {
        let (from, to) = (at(&pair[0]), at(&pair[1]).filter(|to| to.whirl == whirl));
        let (Some(from), Some(to)) = (from, to) else {
            goes_on = false;
            continue;
        };
        let reached = (pair[1].speed, to.frequency, to.decrement());
        match pieces.last_mut().filter(|_| goes_on) {
            Some(piece) => piece.push(reached),
            None => pieces.push(vec![(pair[0].speed, from.frequency, from.decrement()), reached]),
        }
        goes_on = true;
    }
    pieces
}

/// Highest frequency drawn \[Hz\]: that of the lowest [`MODES`] modes up to [`ORDERS`] times the highest spin speed; at least that of the lowest
/// two modes and the highest spin frequency.
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

    fn diagram(bearing: &str) -> Figure {
        let text = format!(
            "schema = 1\nname = \"jeffcott\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\n\
             polar_inertia = 1\ninitial_speed = 110\n[rotor.bearings.s]\n{bearing}\n"
        );
        let machine = MachineDef::parse("m.toml", &text).expect("valid").build().expect("valid");
        let report = report(&machine, &campbell_speeds(200.0)).expect("solvable");
        campbell(&machine, &report.speeds, &report.critical_speeds, 200.0)
    }

    fn strokes(figure: &Figure, colour: Rgb) -> usize {
        let stroke = format!("stroke=\"{colour}\"");
        figure.svg().split("<polyline").filter(|tag| tag.contains(&stroke)).count()
    }

    /// A point mass on isotropic springs: its forward and backward frequencies are equal at all speeds.
    #[test]
    fn of_lines_and_marks_at_one_place_both_are_seen() {
        let figure = diagram("stiffness = 1e4");
        // undamped: one solid line, and the dashed line over it
        let stroke = format!("stroke=\"{}\"", colour_of(1));
        let lines = figure.svg().split("<polyline").filter(|tag| tag.contains(&stroke));
        let dashed: Vec<bool> = lines.map(|tag| tag.contains("stroke-dasharray")).collect();
        assert!(!dashed[0] && dashed.contains(&true), "{dashed:?}");
        assert!(figure.svg().contains("forward whirl") && figure.svg().contains("backward whirl"));
        let discs: BTreeSet<&str> = figure
            .svg()
            .split("<circle")
            .skip(1)
            .filter_map(|tag| tag.split(" r=\"").nth(1)?.split('"').next())
            .collect();
        assert!(discs.len() > 1, "a ring around a dot: {discs:?}");
    }

    /// Damping ratio c/(2 sqrt(k m)): the class of colour of its decrement, and the critical speed at 100 rad/s with its separation margin.
    #[test]
    fn the_colour_is_the_decrement_and_the_margin_is_named() {
        for (damping, class) in [(0.0, 1), (2.0, 2), (8.0, 3), (40.0, 5)] {
            let figure = diagram(&format!("stiffness = 1e4\ndamping = {damping}"));
            for other in 0..DECREMENTS.len() {
                assert_eq!(strokes(&figure, colour_of(other)) > 0, other == class, "{damping}: {other}");
            }
            assert!(figure.svg().contains(DECREMENTS[class].1), "{damping}");
        }
        let figure = diagram("stiffness = 1e4\ndamping = 2");
        // critical speed 9.1 % below 110 rad/s; amplification factor 50: required margin 16 %
        let words = "954.9 rpm: log dec. 0.063, margin 9 % (16 % required)";
        assert!(figure.svg().contains(words), "{}", figure.svg());
        assert!(figure.svg().contains("separation margin too small"));
    }
}
