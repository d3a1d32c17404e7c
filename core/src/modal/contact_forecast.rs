//! Forecast of contact: the eccentricity of the linear rotor at each diaphragm, assuming no contact.
//!
//! ```text
//! reach(W) = |s - o| + a(W)            steady state: a major half axis of the synchronous orbit, s sag under gravity, o offset of the ring's centre
//! reach    = max |s + x(t) - o|        release: M x'' + (C + W0 G) x' + K x = f(W, t), starting from the motion before the release
//! W0 .. W1                             speeds of the run: from W0 at the start to W1, reached by braking and torques alone within run.end_time, at least run.end_speed
//! ```
//! Source: the equations of motion of docs/theory/01-shaft-line.md, with the spin under braking and torques alone and `G` at the initial speed.
//! They are integrated by Newmark's average acceleration (N. M. Newmark, ASCE J. Eng. Mech. 85, 1959), which neither adds nor dissipates
//! energy. Limits: only the first [`TURNS`] revolutions after the release are computed; a rotor that passes a critical speed quickly stays
//! below its steady-state response. Verified by `a_sudden_unbalance_has_the_closed_form_of_a_jeffcott_rotor` and, against complete runs of
//! the shipped machines, by `tests/contact/contact_forecast.rs`.

use super::releases::{expected_releases, turned};
use super::unbalance::LinearRotor;
use bladeoff_model::machine::{InitialState, Machine, Presence};
use bladeoff_numerics::linalg::{Matrix, Vector, mul_vec, solve};
use std::f64::consts::TAU;

/// Number of equidistant speeds in the search for the largest response, of refined maxima, and of golden-section steps per refinement.
const SPEEDS: usize = 96;
const REFINED: usize = 3;
const GOLDEN: usize = 24;
/// Number of computed revolutions after the release, and of time steps per revolution.
const TURNS: usize = 40;
const STEPS: usize = 64;
/// Number of time steps of the course of the speed.
const BRAKING: usize = 2000;

/// Forecast eccentricity of the rotor at a diaphragm, assuming no contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactForecast {
    /// Index of the diaphragm in the machine.
    pub diaphragm: usize,
    /// Radial gap \[m\].
    pub gap: f64,
    /// Static distance of the rotor's centre from the ring's centre, with sag and offset \[m\].
    pub at_rest: f64,
    /// Lowest and highest speed of the run without contact \[rad/s\].
    pub speeds: [f64; 2],
    /// Largest synchronous response within these speeds \[m\]: the major half axis of the orbit.
    pub response: f64,
    /// Speed of the largest response \[rad/s\].
    pub speed: f64,
    /// Largest eccentricity in the first revolutions after the release \[m\].
    pub release: f64,
}

impl ContactForecast {
    /// Largest steady-state eccentricity over the gap \[-\]; contact is expected from 1 on.
    #[must_use]
    pub fn steady_share(&self) -> f64 {
        (self.at_rest + self.response) / self.gap
    }

    /// Largest eccentricity after the release over the gap \[-\].
    #[must_use]
    pub fn release_share(&self) -> f64 {
        self.release / self.gap
    }

    /// Larger of the steady-state share and the release share of the gap \[-\].
    #[must_use]
    pub fn share(&self) -> f64 {
        self.steady_share().max(self.release_share())
    }
}

/// Returns one forecast per diaphragm. The list is empty if a system matrix of the rotor is singular.
#[must_use]
pub fn contact_forecasts(machine: &Machine) -> Vec<ContactForecast> {
    let expected = expected_releases(machine);
    let mut machine = machine.clone();
    let mut is_expected = expected.iter().map(Option::is_some);
    machine.rotor.unbalances.retain(|_| is_expected.next() == Some(true));
    let (machine, expected) = (&machine, expected.into_iter().flatten().collect::<Vec<[f64; 2]>>());
    let rotor = LinearRotor::new(machine);
    let Some(sag) = sag(machine, &rotor) else { return Vec::new() };
    let speeds = speeds(machine, &rotor);
    let places: Vec<(usize, [f64; 2])> = machine
        .diaphragms
        .iter()
        .map(|diaphragm| {
            let (node, offset) = (diaphragm.contact.node, diaphragm.contact.offset);
            let [u, v] = rotor.matrices.plane_places(node);
            (node, [sag[u] - offset[0], sag[v] - offset[1]])
        })
        .collect();
    let mut release = vec![0.0_f64; places.len()];
    for stage in stages(machine, &expected) {
        let Some(largest) = self::release(machine, &rotor, &places, &stage) else { return Vec::new() };
        release.iter_mut().zip(largest).for_each(|(most, here)| *most = most.max(here));
    }
    let found = machine.diaphragms.iter().enumerate().zip(places.iter().zip(release));
    found
        .map(|((place, diaphragm), ((node, rest), release))| {
            let (speed, response) = largest_response(&rotor, *node, speeds);
            let at_rest = rest[0].hypot(rest[1]);
            ContactForecast { diaphragm: place, gap: diaphragm.contact.gap, at_rest, speeds, response, speed, release }
        })
        .collect()
}

/// Static deflection \[m, rad\] under gravity and by bearing seats off the bearing line.
fn sag(machine: &Machine, rotor: &LinearRotor) -> Option<Vec<f64>> {
    let weight = rotor.matrices.constant_force(&machine.rotor, &rotor.sites);
    if weight.iter().all(|force| *force == 0.0) {
        return Some(weight);
    }
    solve(&rotor.stiffness, &Vector::from_vec(weight)).map(|sag| sag.as_slice().to_vec())
}

/// Lowest and highest speed of a run without contact \[rad/s\].
fn speeds(machine: &Machine, rotor: &LinearRotor) -> [f64; 2] {
    let first = machine.rotor.initial_speed;
    if let Some(law) = &machine.rotor.speed_law {
        let all = law.speeds.iter().copied().chain([first]);
        return all.fold([f64::INFINITY, 0.0], |[low, high], speed| [low.min(speed), high.max(speed)]);
    }
    let h = machine.run.end_time / BRAKING as f64;
    let (mut speed, mut low, mut high) = (first, first, first);
    for step in 0..BRAKING {
        speed = turned(machine, rotor, [step as f64 * h, h], speed);
        if speed <= machine.run.end_speed {
            return [machine.run.end_speed, high];
        }
        (low, high) = (low.min(speed), high.max(speed));
    }
    [low, high]
}

/// Speed \[rad/s\] and amplitude \[m\] of the largest response of a node. The search also finds a critical speed between two of its speeds,
/// because the response rises towards it from both sides.
fn largest_response(rotor: &LinearRotor, node: usize, [low, high]: [f64; 2]) -> (f64, f64) {
    let at = |speed: f64| rotor.response(speed).map_or(f64::INFINITY, |found| found.nodes[node]);
    if high <= low {
        return (high, at(high));
    }
    let speed = |k: usize| low + (high - low) * k as f64 / SPEEDS as f64;
    let found: Vec<f64> = (0..=SPEEDS).map(|k| at(speed(k))).collect();
    let mut maxima: Vec<usize> = (0..=SPEEDS)
        .filter(|&k| (k == 0 || found[k] >= found[k - 1]) && (k == SPEEDS || found[k] >= found[k + 1]))
        .collect();
    maxima.sort_by(|a, b| found[*b].total_cmp(&found[*a]).then(a.cmp(b)));
    let best = |best: (f64, f64), one: (f64, f64)| if one.1 > best.1 { one } else { best };
    let refined = maxima.iter().take(REFINED).map(|&k| {
        let ends = [speed(k.saturating_sub(1)), speed((k + 1).min(SPEEDS))];
        best((speed(k), found[k]), golden(&at, ends))
    });
    refined.fold((high, found[SPEEDS]), best)
}

/// Argument and value of a maximum between two ends, by golden section.
fn golden(at: &impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> (f64, f64) {
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut inner = [high - share * (high - low), low + share * (high - low)];
    let mut values = inner.map(at);
    for _ in 0..GOLDEN {
        if values[0] > values[1] {
            high = inner[1];
            inner = [high - share * (high - low), inner[0]];
            values = [at(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + share * (high - low)];
            values = [values[1], at(inner[1])];
        }
    }
    if values[0] > values[1] { (inner[0], values[0]) } else { (inner[1], values[1]) }
}

/// A stage: releases at the same instant.
struct Stage {
    /// Time \[s\] and speed \[rad/s\] of the releases.
    time: f64,
    speed: f64,
    /// Whether each unbalance is present before the releases.
    before: Vec<bool>,
    /// Whether each unbalance is present after the releases.
    after: Vec<bool>,
}

/// Returns the stage at t = 0 and all later stages in order. A later stage starts from the steady motion with the unbalances released
/// before.
fn stages(machine: &Machine, expected: &[[f64; 2]]) -> Vec<Stage> {
    let mut times: Vec<[f64; 2]> = expected.to_vec();
    times.push([0.0, machine.rotor.initial_speed]);
    times.sort_by(|one, other| one[0].total_cmp(&other[0]));
    times.dedup_by_key(|[time, _]| *time);
    let is_before = |place: usize| machine.rotor.unbalances[place].presence == Presence::Before;
    let stage = |[time, speed]: [f64; 2]| {
        let there = |by: &dyn Fn(f64) -> bool| {
            expected.iter().enumerate().map(|(place, [at, _])| is_before(place) || by(*at)).collect()
        };
        Stage { time, speed, before: there(&|at| at < time), after: there(&|at| at <= time) }
    };
    times.into_iter().map(stage).collect()
}

/// Returns the largest eccentricity at each diaphragm in the first revolutions after the releases of a stage \[m\]; `None`: a matrix is
/// singular. `places`: node, and its static position relative to the ring's centre \[m\].
fn release(machine: &Machine, rotor: &LinearRotor, places: &[(usize, [f64; 2])], stage: &Stage) -> Option<Vec<f64>> {
    let speed = stage.speed;
    let before = rotor.amplitudes(speed, |place| stage.before[place])?;
    let size = rotor.matrices.lateral_size();
    // an initial disturbance has decayed before a later release
    let initial = if stage.time == 0.0 { machine.rotor.initial } else { InitialState::default() };
    let shift = rotor.matrices.uniform(initial.displacement);
    let drift = rotor.matrices.uniform(initial.velocity);
    let (mut x, mut v): (Vec<f64>, Vec<f64>) =
        (0..size).map(|dof| (before[dof] + shift[dof], drift[dof] - speed * before[size + dof])).unzip();
    let reach = |x: &[f64], (node, rest): &(usize, [f64; 2])| {
        let [u, v] = rotor.matrices.at(*node, x);
        (u + rest[0]).hypot(v + rest[1])
    };
    let mut largest: Vec<f64> = places.iter().map(|place| reach(&x, place)).collect();
    if speed <= 0.0 || !machine.run.end_time.is_finite() {
        return Some(largest);
    }
    let h = TAU / speed / STEPS as f64;
    let steps = (((machine.run.end_time - stage.time) / h).ceil() as usize).min(TURNS * STEPS);
    let (mut damping, mut stiffness) = (&rotor.matrices.damping + &rotor.gyroscopic * speed, rotor.stiffness.clone());
    if let Some([k, c]) = rotor.matrices.change_at(speed) {
        stiffness += k;
        damping += c;
    }
    let system: Matrix = &rotor.mass + &damping * (0.5 * h) + &stiffness * (0.25 * h * h);
    let force = |angle: f64, speed: f64| {
        let mut force = vec![0.0; size];
        for (site, _) in rotor.sites.iter().zip(&stage.after).filter(|(_, is_there)| **is_there) {
            let (sin, cos) = libm::sincos(site.phase + angle);
            let amplitude = site.mass * site.radius * speed * speed;
            rotor.matrices.add_at(site.node, [amplitude * cos, amplitude * sin], &mut force);
        }
        force
    };
    let mut product = vec![0.0; size];
    let mut rest = |force: Vec<f64>, x: &[f64], v: &[f64]| {
        let mut rest = force;
        for (matrix, of) in [(&stiffness, x), (&damping, v)] {
            mul_vec(matrix, of, &mut product);
            rest.iter_mut().zip(&product).for_each(|(rest, product)| *rest -= product);
        }
        Vector::from_vec(rest)
    };
    let mut a = solve(&rotor.mass, &rest(force(0.0, speed), &x, &v))?;
    let factors = nalgebra::LU::new(system);
    let (mut angle, mut now) = (0.0, speed);
    for step in 0..steps {
        let next = turned(machine, rotor, [stage.time + step as f64 * h, h], now);
        angle += 0.5 * h * (now + next);
        now = next;
        for dof in 0..size {
            x[dof] += h * (v[dof] + 0.25 * h * a[dof]);
            v[dof] += 0.5 * h * a[dof];
        }
        a = factors.solve(&rest(force(angle, now), &x, &v))?;
        for dof in 0..size {
            x[dof] += 0.25 * h * h * a[dof];
            v[dof] += 0.5 * h * a[dof];
        }
        largest.iter_mut().zip(places).for_each(|(most, place)| *most = most.max(reach(&x, place)));
        // a prescribed speed does not end a run
        if machine.rotor.speed_law.is_none() && now <= machine.run.end_speed {
            break;
        }
    }
    Some(largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    fn jeffcott(speed: f64, tail: &str) -> Machine {
        let text = format!(
            "schema = 1\nname = \"jeffcott\"\n[rotor]\nkind = \"point-mass\"\nmass = 0.9\npolar_inertia = 1.0\n\
             initial_speed = {speed}\n{tail}\n[rotor.bearings.support]\nstiffness = 4.0\ndamping = 0.0\n\
             [rotor.unbalances.blade]\nmass = 0.1\nradius = 0.3\nphase = 0.7\n[run]\nend_time = 500.0\n\
             [diaphragms.ring]\nkind = \"rigid\"\n[diaphragms.ring.contact]\nrotor_radius = 1.0\ngap = 0.5\nfriction = 0.1\n"
        );
        MachineDef::parse("test.toml", &text)
            .unwrap_or_else(|e| panic!("{e}"))
            .build()
            .unwrap_or_else(|e| panic!("{e}"))
    }

    /// Undamped rotor of natural frequency w = 2: X e^{iWt} - A e^{iwt} - B e^{-iwt} with A, B = X (1 +- W/w)/2. At some time the three
    /// amplitudes add: |X| (1 + max(1, W/w)).
    #[test]
    fn a_sudden_unbalance_has_the_closed_form_of_a_jeffcott_rotor() {
        for speed in [0.7, 1.3, 5.1] {
            let machine = jeffcott(speed, "");
            let found = &contact_forecasts(&machine)[0];
            let steady = 0.03 * speed * speed / (4.0 - speed * speed).abs();
            let expected = steady * (1.0 + (speed / 2.0_f64).max(1.0));
            assert!((found.release / expected - 1.0).abs() < 0.01, "{speed}: {} not {expected}", found.release);
            assert!((found.speeds[0] - speed).abs() < 1e-12, "nothing brakes: {:?}", found.speeds);
            assert!((found.response / steady - 1.0).abs() < 1e-9, "{speed}: {}", found.response);
        }
    }

    #[test]
    fn braking_widens_the_speeds_down_to_the_resonance_and_gravity_and_offset_take_from_the_gap() {
        let free = jeffcott(3.0, "");
        let braked = jeffcott(3.0, "[braking]\nconstant = 0.1");
        let (free, braked) = (&contact_forecasts(&free)[0], &contact_forecasts(&braked)[0]);
        assert_eq!(braked.speeds[0], 0.0);
        assert!(braked.response > 1e3 * free.response && (braked.speed - 2.0).abs() < 1e-3, "{braked:?}");
        let heavy = contact_forecasts(&jeffcott(3.0, "gravity = [0.0, -0.4]")).remove(0);
        assert!((heavy.at_rest - 0.1).abs() < 1e-12, "m g/k: {heavy:?}");
        assert!((heavy.steady_share() - (heavy.response + 0.1) / 0.5).abs() < 1e-12);
        assert!(heavy.release > free.release && heavy.release <= free.release + 0.1 + 1e-9, "{heavy:?}");
    }
}
