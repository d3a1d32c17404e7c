//! Speed transients of the Jeffcott rotor.

use super::case::{Case, Check};
use super::machine::{stepping, vertex, watch};
use bladeoff_model::machine::Engine;

pub(super) fn add(checks: &mut Vec<Check>) {
    for engine in [Engine::Reduced, Engine::Exponential] {
        ramps(checks, engine);
    }
    free_spin(checks, Engine::Reduced);
    free_spin(checks, Engine::Exponential);
}

fn ramps(checks: &mut Vec<Check>, engine: Engine) {
    let published = [(0.0, 1e-3, [47.155, 45.656]), (0.02, 5e-3, [14.000, 12.735]), (0.05, 1e-2, [7.781, 6.754])];
    for (zeta, rate, peaks) in published {
        for (acceleration, reference) in [(rate, peaks[0]), (-rate, peaks[1])] {
            let from = if acceleration > 0.0 { 0.2 } else { 1.8 };
            let tail = format!("initial_speed = {from}\n[rotor.speed_law]\nacceleration = {acceleration:e}\n");
            let ours = passage(engine, zeta, 1.0, 0.005, 1.6 / rate, &tail).map(|found| found.peak);
            let case = Case {
                name: "Jeffcott ramp",
                engine: engine.word(),
                unit: "e",
                source: "integration of q'' + 2 zeta q' + q = (W^2 - i W') exp(i phi)",
                // half a unit of the last digit
                tolerance: 0.51e-3 / reference,
            };
            case.check(checks, format!("max |q|, zeta {zeta}, a {acceleration}"), ours, reference);
        }
    }
}

fn free_spin(checks: &mut Vec<Check>, engine: Engine) {
    // time of W = 1, max |q|/e, its time, W(160)
    let published = [(0.01, [97.7611, 12.214_19, 120.468, 0.672_157]), (0.05, [71.8622, 8.344_580, 84.852, 0.424_216])];
    for (e, reference) in published {
        let tail = "initial_speed = 1.5\n[braking]\nconstant = 0.005\n";
        let found = passage(engine, 0.02, e, 0.001, 160.002, tail);
        let ours = |pick: fn(&Passage) -> Option<f64>| found.as_ref().and_then(pick);
        let source = "integration to 1e-11 with the spin unknown";
        // half a unit of the last digit, and the same for the step
        let case = |unit, k: usize, digit: f64| Case {
            name: "Jeffcott, spin unknown",
            engine: engine.word(),
            unit,
            source,
            tolerance: digit / reference[k],
        };
        case("s", 0, 1e-4).check(checks, format!("time of W = 1, e {e}"), ours(|p| p.crossing), reference[0]);
        case("e", 1, 1e-5).check(checks, format!("max |q|, e {e}"), ours(|p| Some(p.peak)), reference[1]);
        case("s", 2, 1e-3).check(checks, format!("its time, e {e}"), ours(|p| Some(p.time)), reference[2]);
        case("", 3, 1e-6).check(checks, format!("W at 160 s, e {e}"), ours(|p| p.late), reference[3]);
    }
}

struct Passage {
    /// Largest displacement |q|/e.
    peak: f64,
    /// Time of the largest displacement \[s\].
    time: f64,
    /// Time at which the speed falls through 1 \[s\].
    crossing: Option<f64>,
    /// Speed at 160 s \[rad/s\].
    late: Option<f64>,
}

/// Passage of the critical speed, starting from the steady state. All mass, 1, is at eccentricity e, on stiffness k = 1. A parabola refines the
/// largest |q|/e and its time.
fn passage(engine: Engine, zeta: f64, e: f64, step: f64, end: f64, tail: &str) -> Option<Passage> {
    let text = format!(
        "schema = 1\nname = \"jeffcott\"\n[run]\nend_time = {end:?}\n{}\
         [rotor.bearings.spring]\nstiffness = 1\ndamping = {:?}\n\
         [rotor.unbalances.mass]\nmass = 1\nradius = {e:?}\npresent = \"before\"\n\
         [rotor]\nkind = \"point-mass\"\nmass = 0\npolar_inertia = 1\n{tail}",
        stepping(engine, step),
        2.0 * zeta
    );
    let mut found = Passage { peak: 0.0, time: 0.0, crossing: None, late: None };
    let (mut sizes, mut speed) = ([0.0; 2], 2.0);
    watch(&text, |frame| {
        let size = libm::hypot(frame.displacement[0], frame.displacement[1]) / e;
        if sizes[1] >= sizes[0] && sizes[1] > size && sizes[1] > found.peak {
            let (offset, peak) = vertex(sizes[0], sizes[1], size);
            (found.peak, found.time) = (peak, frame.time + (offset - 1.0) * step);
        }
        if found.crossing.is_none() && speed > 1.0 && frame.speed <= 1.0 && frame.time > 0.0 {
            found.crossing = Some(frame.time - step * (1.0 - frame.speed) / (speed - frame.speed));
        }
        if (frame.time - 160.0).abs() < 0.5 * step {
            found.late = Some(frame.speed);
        }
        sizes = [sizes[1], size];
        speed = frame.speed;
    })?;
    Some(found)
}
