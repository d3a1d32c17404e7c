//! Assumptions of a machine with their consequences, one line each, for `check` and the report.
//!
//! Source: the equations of docs/theory/01-shaft-line.md to 03-contact.md, and the deviations in 06-deviations.md. Verified by
//! `every_line_follows_the_machine`.

use super::def::MachineDef;
use super::layout::Scalar;
use super::model::{
    Bearing, ContactPoints, ContactSurface, DiaphragmKind, Engine, FrictionLaw, Machine, Presence, Release, RotorKind,
    ShaftElement, Torque, Unbalance, UnbalanceKind,
};
use bladeoff_text::document::units::{format_digits, format_quantity};
use std::f64::consts::PI;

/// The key whose absence changes the text.
const TORSIONAL: &str = "rotor.damping.torsional";

/// One assumption.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumption {
    /// Part of the model: the same word for every machine.
    pub topic: &'static str,
    /// The assumption and its consequence, one line.
    pub text: String,
}

impl MachineDef {
    /// The assumptions of the machine with its present values; `machine` is built from them.
    #[must_use]
    pub fn assumptions(&self, machine: &Machine) -> Vec<Assumption> {
        let is_own = self
            .layout
            .find(TORSIONAL)
            .is_some_and(|index| !matches!(self.states[index].scalar, Scalar::Absent | Scalar::Bad));
        let rotor = &machine.rotor;
        let is_shaft = matches!(rotor.kind, RotorKind::Shaft(_));
        let mut lines = vec![
            ("gravity", gravity(machine)),
            ("bearings", bearings(&rotor.bearings)),
            ("release", release(&rotor.unbalances)),
            ("spin", spin(machine)),
            ("rotor", rotor_line(&rotor.kind)),
        ];
        if is_shaft {
            lines.push(("torsional damping", torsional(is_own, rotor.torsional_damping)));
        }
        if !machine.diaphragms.is_empty() {
            lines.push(("diaphragm", diaphragms(machine)));
            lines.push(("friction", friction(machine)));
            lines.push(("contact", contact(machine)));
        }
        lines.push(("engine", engine(machine)));
        lines.into_iter().map(|(topic, text)| Assumption { topic, text }).collect()
    }
}

fn gravity(machine: &Machine) -> String {
    let [x, y] = machine.rotor.gravity;
    if [x, y] == [0.0; 2] {
        return "off: no static sag, and bearing loads do not include the weight of the rotor".to_owned();
    }
    format!("on, {} along X and {} along Y; the run starts from the static sag", metres(x), metres(y))
}

fn metres(acceleration: f64) -> String {
    format_digits(acceleration, "m/s2", 3)
}

fn bearings(bearings: &[Bearing]) -> String {
    let on_pedestals = bearings.iter().filter(|one| one.pedestal.is_some()).count();
    let ground = match on_pedestals {
        0 => String::new(),
        all if all == bearings.len() => ", on pedestals with mass, spring and damper".to_owned(),
        some => format!(
            ", {some} of {} on pedestals with mass, spring and damper, the others on rigid ground",
            bearings.len()
        ),
    };
    let tables = bearings.iter().filter(|one| one.table.is_some()).count();
    let over_speed = match tables {
        0 => String::new(),
        all if all == bearings.len() => {
            " from tables over the speed, tangents at the static point of each speed,".to_owned()
        }
        some => format!(
            " ({some} of {} from tables over the speed, tangents at the static point of each speed)",
            bearings.len()
        ),
    };
    let linear = format!(
        "linear stiffness and damping{over_speed} without clearance{ground}; the journal moves as far as the load takes it"
    );
    let given: Vec<String> = bearings
        .iter()
        .filter_map(|one| Some(format!("{} {}", one.name, format_digits(one.clearance?, "m", 3))))
        .collect();
    match given.is_empty() {
        true => format!("{linear}, and no clearance is given to compare it with"),
        false => format!(
            "{linear}, and is compared with the given clearance ({}), which does not change the motion",
            given.join(", ")
        ),
    }
}

fn release(unbalances: &[Unbalance]) -> String {
    let released: Vec<&Unbalance> = unbalances.iter().filter(|one| one.presence == Presence::AtRelease).collect();
    if released.is_empty() {
        return "none, because every unbalance is present from the start".to_owned();
    }
    let lost = released.iter().any(|one| one.kind == UnbalanceKind::Lost);
    let what = if lost { "the mass is lost at once" } else { "the unbalance appears at once, as an added mass" };
    let events: Vec<String> =
        released.iter().filter_map(|one| Some(format!("{} {}", one.name, event(one.release?)))).collect();
    let rest = if events.len() == released.len() { "" } else { " at t = 0" };
    let when = if events.is_empty() { " at t = 0".to_owned() } else { format!("{rest} ({})", events.join(", ")) };
    format!("{what}{when}; blade debris and neighbouring blades carry no load")
}

fn event(release: Release) -> String {
    match release {
        Release::Time(time) => format!("at {}", format_quantity(time, "s")),
        Release::Speed(speed) => format!("at {}", format_quantity(speed, "rad/s")),
    }
}

fn spin(machine: &Machine) -> String {
    let names: Vec<String> = machine.torques.iter().map(torque).collect();
    let torques = match names.is_empty() {
        true => String::new(),
        false => {
            let torsion = match machine.rotor.kind {
                RotorKind::Shaft(_) => "; the run starts with their static torsion",
                RotorKind::PointMass(_) => "",
            };
            format!("; torques over time ({}), whatever the speed{torsion}", names.join("; "))
        }
    };
    let whole = match (machine.rotor.speed_law.is_some(), names.is_empty()) {
        (true, _) => "prescribed; friction and braking do not slow the rotor",
        (false, true) => "free; the machine is disconnected, friction and the braking torque slow the rotor",
        (false, false) => "free; torques change it, friction and the braking torque slow the rotor",
    };
    format!("{whole}{torques}")
}

/// Name and amounts of a torque: "steam 1.2 MN m to 0 N m", "generator -1.2 MN m, short circuit of 50 Hz from 0.5 s with up to 9 MN m".
fn torque(torque: &Torque) -> String {
    let (before, last) = (torque.before(), torque.values.last().copied().unwrap_or(0.0));
    let shown = |torque: f64| format_quantity(torque, "N m");
    let mut line = format!("{} {}", torque.name, shown(before));
    if last != before {
        line += &format!(" to {}", shown(last));
    }
    if let Some(one) = torque.short_circuit {
        let hertz = format_digits(one.frequency / (2.0 * PI), "Hz", 4);
        let most = shown(one.amplitudes[0].abs() + one.amplitudes[1].abs());
        line += &format!(", short circuit of {hertz} from {} with up to {most}", format_quantity(one.start, "s"));
    }
    line
}

/// Text about yielding. A yield strength does not change the motion: it ends the run, or without a given strength stresses are not compared.
fn judged_by_yield(is_given: bool) -> &'static str {
    if is_given { "elastic at any stress; stresses are compared with the yield strength" } else { "without yield" }
}

fn rotor_line(kind: &RotorKind) -> String {
    let what = match kind {
        RotorKind::Shaft(shaft) => {
            let is_given = shaft.elements.iter().any(|element| element.yield_strength.is_some());
            let tapers = if shaft.elements.iter().any(ShaftElement::is_tapered) {
                "; stresses of a tapered section are upper bounds (its largest moments over its smallest modulus), so divide a long cone into several sections"
            } else {
                ""
            };
            let layers = if shaft.layers.is_empty() {
                ""
            } else {
                "; stresses are those of the sections below the layers: a layer that carries most of the load has larger ones, which are not reported"
            };
            format!("linear elastic shaft, {}{tapers}{layers}", judged_by_yield(is_given))
        }
        RotorKind::PointMass(_) => "rigid point mass without tilting".to_owned(),
    };
    format!("{what}; the section that touches is rigid and round, and its own flexibility does not soften an impact")
}

fn torsional(is_own: bool, value: f64) -> String {
    let value_text = format_digits(value, "s", 3);
    match (is_own, value > 0.0) {
        (_, false) => "none: torsional vibration does not decay and accumulates over many impacts".to_owned(),
        (true, true) => format!("{TORSIONAL} = {value_text}, as given"),
        (false, true) => format!(
            "taken from the lateral value, {value_text}, as {TORSIONAL} is not set; peak torsional moments of the shipped turbine are 40 to 77 % \
             below those without torsional damping"
        ),
    }
}

fn diaphragms(machine: &Machine) -> String {
    let kinds = machine.diaphragms.iter().map(|diaphragm| match diaphragm.kind {
        DiaphragmKind::Flexible(_) => 0,
        DiaphragmKind::RadialSpring { .. } => 1,
        DiaphragmKind::Rigid => 2,
    });
    match kinds.min() {
        Some(0) => {
            let is_given = machine.diaphragms.iter().any(|diaphragm| {
                matches!(&diaphragm.kind, DiaphragmKind::Flexible(stator) if stator.yield_strength.is_some())
            });
            format!(
                "planar linear ring, no axial motion and no tilt, small displacements, {}, and blades clamped at a casing that \
                 does not move",
                judged_by_yield(is_given)
            )
        }
        Some(1) => "radial spring without mass: impacts lack the inertia of a ring".to_owned(),
        _ => "rigid circle: contact lacks the flexibility of a ring; its raw contact force and torsional moment are \
              not converged with truncated rotor modes"
            .to_owned(),
    }
}

fn friction(machine: &Machine) -> String {
    let mut values: Vec<f64> = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.friction).collect();
    values.sort_by(f64::total_cmp);
    let show = |value: Option<&f64>| value.map_or_else(String::new, |value| format_digits(*value, "", 3));
    let (low, high) = (show(values.first()), show(values.last()));
    let range = if low == high { low } else { format!("{low} to {high}") };
    let slips = machine.diaphragms.iter().any(|diaphragm| diaphragm.contact.friction_law == FrictionLaw::Slip);
    let law = if slips { "sliding only" } else { "stick and slip" };
    format!(
        "Coulomb, constant coefficient {range}, {law}; no heat, wear or thermal bow, so a rub neither opens the gap nor bends the shaft"
    )
}

fn contact(machine: &Machine) -> String {
    let is_mean = machine.diaphragms.iter().any(|one| one.contact.surface == ContactSurface::MeanLine);
    let is_one = machine.diaphragms.iter().any(|one| one.contact.points == ContactPoints::One);
    let surface = if is_mean {
        "on the mean line, so that the friction couple on the ring is a few per cent too large"
    } else {
        "on the inner face"
    };
    let points = if is_one { "one point" } else { "points" };
    format!("{points} {surface}, unilateral and without a contact stiffness of its own")
}

fn engine(machine: &Machine) -> String {
    match machine.run.engine {
        Engine::Exponential => {
            "exponential, kept modes are propagated exactly and contact acts by impulses, so that single force peaks depend on the \
             contact step"
                .to_owned()
        }
        Engine::Reduced => "reduced, kept modes only; those above follow statically at the contact".to_owned(),
        Engine::Full => "full, all degrees of freedom of the finite elements, no modes truncated".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAFT: &str = "schema = 1\nname = \"m\"\n[run]\nend_time = 1.0\n[rotor]\ninitial_speed = 100.0\n\
        [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\nshear_coefficient = 0.9\n\
        [[rotor.shaft]]\nlength = 0.5\nelements = 2\ndiameter = 0.1\n[rotor.damping]\nstiffness_proportional = 2e-5\n\
        [rotor.bearings.a]\nposition = 0.0\nstiffness = 1e8\ndamping = 1e3\naxial_stiffness = 1e6\n\
        [rotor.bearings.b]\nposition = 0.5\nstiffness = 1e8\ndamping = 1e3\n\
        [rotor.unbalances.blade]\nposition = 0.25\nmass = 0.01\nradius = 0.05\n\
        [diaphragms.ring]\nkind = \"rigid\"\n[diaphragms.ring.contact]\nposition = 0.25\nrotor_radius = 0.06\ngap = 0.001\nfriction = 0.2\n";

    fn lines(text: &str) -> Vec<Assumption> {
        let def = MachineDef::parse("m.toml", text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        def.assumptions(&def.build().expect("valid"))
    }

    fn line(text: &str, topic: &str) -> String {
        let found = lines(text).into_iter().find(|one| one.topic == topic);
        found.unwrap_or_else(|| panic!("{topic} of {:?}", lines(text))).text
    }

    /// Each change of the machine changes the line of its topic and no other line.
    #[test]
    fn every_line_follows_the_machine() {
        let spring = "kind = \"radial-spring\"\nstiffness = 1e7\n";
        let changes = [
            ("gravity", "initial_speed = 100.0\n", "initial_speed = 100.0\ngravity = [0.0, -9.81]\n"),
            ("bearings", "damping = 1e3\n", "damping = 1e3\nclearance = \"0.3 mm\"\n"),
            ("release", "radius = 0.05\n", "radius = 0.05\npresent = \"before\"\n"),
            ("spin", "[rotor.material]", "[rotor.speed_law]\nacceleration = -1.0\n[rotor.material]"),
            ("torsional damping", "[rotor.damping]\n", "[rotor.damping]\ntorsional = 1e-6\n"),
            ("torsional damping", "stiffness_proportional = 2e-5\n", "stiffness_proportional = 0.0\n"),
            ("diaphragm", "kind = \"rigid\"\n", spring),
            ("friction", "friction = 0.2\n", "friction = 0.3\n"),
            ("friction", "friction = 0.2\n", "friction = 0.2\nfriction_law = \"slip\"\n"),
            ("contact", "friction = 0.2\n", "friction = 0.2\nsurface = \"mean-line\"\n"),
            ("contact", "friction = 0.2\n", "friction = 0.2\npoints = \"one\"\n"),
            ("engine", "end_time = 1.0\n", "end_time = 1.0\nengine = \"full\"\n"),
        ];
        let whole = lines(SHAFT);
        for (topic, from, to) in changes {
            assert!(SHAFT.contains(from), "{from}");
            let other = lines(&SHAFT.replacen(from, to, 1));
            let changed: Vec<&str> =
                whole.iter().zip(&other).filter(|(a, b)| a != b).map(|(one, _)| one.topic).collect();
            assert_eq!(changed, [topic], "{to}");
        }
        // `auto` computes torques with another engine
        let torque = "[torques.fan]\nposition = 0.25\nbalance = true\n[diaphragms.ring]\n";
        let other = lines(&SHAFT.replacen("[diaphragms.ring]\n", torque, 1));
        let changed: Vec<&str> = whole.iter().zip(&other).filter(|(a, b)| a != b).map(|(one, _)| one.topic).collect();
        assert_eq!(changed, ["spin", "engine"]);
        let clearance =
            line(&SHAFT.replacen("damping = 1e3\n", "damping = 1e3\nclearance = \"0.3 mm\"\n", 1), "bearings");
        assert!(clearance.contains("the given clearance (a 0.3 mm)"), "{clearance}");
        assert!(line(SHAFT, "torsional damping").contains("40 to 77 %"));
        assert!(
            line(&SHAFT.replacen("initial_speed", "gravity = [0, -9.81]\ninitial_speed", 1), "gravity")
                .contains("-9.81 m/s2")
        );
    }

    #[test]
    fn a_machine_without_a_diaphragm_or_a_shaft_has_no_line_about_it() {
        let (alone, _) = SHAFT.split_once("[diaphragms.ring]").expect("a diaphragm");
        let topics: Vec<&str> = lines(alone).iter().map(|one| one.topic).collect();
        assert_eq!(topics, ["gravity", "bearings", "release", "spin", "rotor", "torsional damping", "engine"]);
        let point = "schema = 1\nname = \"p\"\n[run]\nend_time = 1.0\n[rotor]\nkind = \"point-mass\"\nmass = 1.0\n\
            polar_inertia = 1.0\ninitial_speed = 1.0\n[rotor.bearings.a]\nstiffness = 4.0\ndamping = 0.1\n";
        assert!(lines(point).iter().all(|one| one.topic != "torsional damping"));
        assert!(line(point, "rotor").starts_with("rigid point mass"));
        assert!(line(point, "release").starts_with("none"));
    }
}
