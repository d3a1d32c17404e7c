//! Contact of the Jeffcott rotor (m = k = 1, clearance 1) with a massless radial spring.

use super::case::{Case, Check};
use super::machine::{stepping, watch};
use bladeoff_model::machine::Engine;

pub(super) fn add(checks: &mut Vec<Check>) {
    for engine in [Engine::Reduced, Engine::Exponential] {
        rubs(checks, engine);
    }
}

fn rubs(checks: &mut Vec<Check>, engine: Engine) {
    let case = Case {
        name: "full annular rub",
        engine: engine.word(),
        unit: "gap",
        source: "closed form, [(1-W^2)r + b(r-1)]^2 + [2zWr + mu b(r-1)]^2 = (eW^2)^2",
        // half a unit of the last digit
        tolerance: 0.5e-6 / 1.131_25,
    };
    for (speed, reference) in [(0.9, 1.131_250), (1.0, 1.400_000), (1.1, 1.797_607), (1.2, 2.377_023)] {
        let rotor = Rotor { zeta: 0.1, beta: 1.0, mu: 0.05, e: 0.5, radius: 1.0, start: None, speed, end: 200.0 };
        // second order in the step (tests/contact/rub.rs), so the values are extrapolated
        let [coarse, fine] = [0.005, 0.0025].map(|step| rotor.run(engine, step));
        let ours = coarse.zip(fine).map(|(c, f)| f.radius + (f.radius - c.radius) / 3.0);
        case.check(checks, format!("radius at W = {speed}"), ours, reference);
    }
    let case = Case {
        name: "dry-friction backward whirl",
        engine: engine.word(),
        unit: "gap",
        source: "closed form, b/(b+1-w^2), w = z/mu + sqrt(1+(z/mu)^2)",
        tolerance: 1e-5,
    };
    case.check(checks, "threshold radius", threshold(engine), 1.190_614);
    let speed = Case { unit: "rad/s", tolerance: 2e-5, ..case };
    let whip = Rotor { start: Some(1.190_614), end: 5.0, ..WHIP };
    let whirl = whip.run(engine, 0.001).map(|orbit| -orbit.turned / orbit.time);
    speed.check(checks, "whirl speed, slipping", whirl, 1.280_776);
    let case = Case {
        name: "backward rolling",
        engine: engine.word(),
        unit: "gap",
        source: "closed form, r^2 (1 + b(r-1)/r) = (R W)^2",
        tolerance: 1e-5,
    };
    let rolling = Rotor { start: Some(1.22), speed: 0.3, end: 400.0, ..WHIP };
    case.check(checks, "radius at R W = 3, b = 4", rolling.run(engine, 0.002).map(|orbit| orbit.radius), 1.8);
}

/// Jeffcott rotor of mass 1 and stiffness 1 with clearance 1.
#[derive(Debug, Clone, Copy)]
struct Rotor {
    /// Damping ratio zeta.
    zeta: f64,
    /// Stiffness of the radial spring, relative to that of the rotor.
    beta: f64,
    /// Coulomb friction coefficient.
    mu: f64,
    /// Eccentricity of the unbalance in clearances.
    e: f64,
    /// Radius R of the rotor section in clearances.
    radius: f64,
    /// Initial radius of a backward whirl in clearances; `None` for a start at rest.
    start: Option<f64>,
    /// Constant spin W, relative to the natural frequency.
    speed: f64,
    /// Duration of the run \[s\].
    end: f64,
}

const WHIP: Rotor = Rotor { zeta: 0.05, beta: 4.0, mu: 0.2, e: 0.0, radius: 10.0, start: None, speed: 1.0, end: 250.0 };

/// Orbit of a run.
#[derive(Debug, Clone, Copy, Default)]
struct Orbit {
    /// Radius at the end, in clearances.
    radius: f64,
    /// Whirl angle about the stator's centre \[rad\], negative for backward whirl, and time at the end \[s\].
    turned: f64,
    time: f64,
    /// Whether contact occurred.
    touched: bool,
    /// First radius outside 2/3 to 3/2 of the initial one, relative to the initial one.
    left: Option<f64>,
}

impl Rotor {
    fn run(&self, engine: Engine, step: f64) -> Option<Orbit> {
        let whirl = self.zeta / self.mu + (1.0 + (self.zeta / self.mu) * (self.zeta / self.mu)).sqrt();
        let start = self.start.map_or(String::new(), |r| {
            format!("[rotor.initial]\ndisplacement = [{r:?}, 0.0]\nvelocity = [0.0, {:?}]\n", -whirl * r)
        });
        let text = format!(
            "schema = 1\nname = \"rub\"\n[run]\nend_time = {:?}\n{}\
             [rotor.bearings.spring]\nstiffness = 1\ndamping = {:?}\n[rotor.unbalances.mass]\nmass = 1\nradius = {:?}\n\
             [diaphragms.ring]\nkind = \"radial-spring\"\nstiffness = {:?}\n[diaphragms.ring.contact]\n\
             rotor_radius = {:?}\ngap = 1\nfriction = {:?}\n[rotor]\nkind = \"point-mass\"\nmass = 0\n\
             polar_inertia = 1\ninitial_speed = {:?}\n[rotor.speed_law]\nacceleration = 0\n{start}",
            self.end,
            stepping(engine, step),
            2.0 * self.zeta,
            self.e,
            self.beta,
            self.radius,
            self.mu,
            self.speed,
        );
        let mut orbit = Orbit::default();
        let mut last: Option<f64> = None;
        let reference = self.start.unwrap_or(1.0);
        watch(&text, |frame| {
            let [x, y] = [frame.displacement[0], frame.displacement[1]];
            orbit.radius = libm::hypot(x, y);
            let angle = libm::atan2(y, x);
            if let Some(last) = last {
                let turn = 2.0 * std::f64::consts::PI;
                orbit.turned += angle - last - turn * ((angle - last) / turn).round();
            }
            last = Some(angle);
            orbit.time = frame.time;
            orbit.touched |= frame.contacts.iter().any(|contact| contact.normal_force > 0.0);
            let share = orbit.radius / reference;
            if orbit.left.is_none() && !(2.0 / 3.0..=1.5).contains(&share) {
                orbit.left = Some(share);
            }
        })?;
        orbit.touched.then_some(orbit)
    }
}

/// Radius between decay and growth of the slipping backward whirl in clearances, by bisection.
fn threshold(engine: Engine) -> Option<f64> {
    let (mut low, mut high) = (1.17, 1.22);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        let orbit = Rotor { start: Some(middle), ..WHIP }.run(engine, 0.005)?;
        if orbit.left? > 1.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(0.5 * (low + high))
}
