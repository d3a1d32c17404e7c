//! Plausibility of torques on the shaft: grid frequency, stress, speed, and torsional modes near the frequencies of a short circuit.
//!
//! ```text
//! tau = 16 T D / (pi (D^4 - d^4))      T: static torque of an element, or |A1| + |A2| and the steps at a node; D, d: its diameters     (1)
//! dW  = (|A1|/w + |A2|/(2 w)) / J      amplitude of the speed of a rigid rotor in a short circuit                                     (2)
//! |f - n f0| <= 0.1 n f0               f: torsional frequency of the free shaft line, f0: grid, n = 1, 2                             (3)
//! ```
//! Source: (1) torsion of a circular tube; (2) J W' = T; (3) the usual margin of 10 % of torsional modes from grid frequency and its double. Verified
//! by `torques_in_another_unit_and_near_a_torsional_mode_are_named`, `torques_are_judged_by_their_sum`.

use super::{Finding, Rule, alone, rule};
use bladeoff_core::modal::{expected_course, polar_inertia, torsional_frequencies};
use bladeoff_model::machine::{Machine, RotorKind, ShaftElement, ShortCircuit, Torque};
use bladeoff_text::document::units::{format_digits, format_quantity};
use std::f64::consts::PI;

static GRID: Rule = rule(
    "frequency of its short circuit",
    [10.0, 1000.0],
    "Hz",
    "grids have 50 or 60 Hz; a number alone is in rad/s, \"3000 rpm\" and \"50 rev/s\" are 50 Hz",
);
static SHEAR: Rule = rule("shear stress of the shaft by its changes", [0.0, 1e9], "Pa", "is its unit right?");
static STATIC_SHEAR: Rule =
    rule("largest static shear stress of the shaft", [0.0, 1e9], "Pa", "are the units of the torques right?");
static OSCILLATION: Rule =
    rule("oscillation of the speed in its short circuit, over the initial speed", [0.0, 0.5], "", "is its unit right?");
static OVERSPEED: Rule = rule(
    "highest speed without contact over the initial speed",
    [0.0, 1.5],
    "",
    "machines are tested at 1.2: are the units and signs of the torques right?",
);
/// Relative margin of a torsional mode.
const MARGIN: f64 = 0.1;

/// Warnings about the torques of a machine.
pub(super) fn findings(machine: &Machine) -> Vec<Finding> {
    if machine.torques.is_empty() {
        return Vec::new();
    }
    let mut found = Vec::new();
    let inertia = polar_inertia(machine);
    let initial = machine.rotor.initial_speed;
    for torque in &machine.torques {
        let subject = format!("torques.{}", torque.name);
        let changes = changes(torque);
        if let Some(modulus) = modulus_at(machine, torque.node) {
            found.extend(SHEAR.judge(&subject, changes / modulus, &format!(" ({})", format_quantity(changes, "N m"))));
        }
        let Some(one) = torque.short_circuit.filter(ShortCircuit::acts) else { continue };
        found.extend(GRID.judge(&subject, one.frequency / (2.0 * PI), ""));
        let [first, second] = one.amplitudes.map(f64::abs);
        let amplitude = (first + 0.5 * second) / (one.frequency * inertia);
        if initial > 0.0 {
            found.extend(OSCILLATION.judge(&subject, amplitude / initial, ""));
        }
    }
    found.extend(STATIC_SHEAR.judge("torques", static_stress(machine), ""));
    if initial > 0.0 && machine.rotor.speed_law.is_none() {
        let [_, highest] = course(machine);
        let beside = format!(" ({})", format_digits(highest, "rad/s", 4));
        found.extend(OVERSPEED.judge("torques", highest / initial, &beside));
    }
    found.extend(resonances(machine).into_iter().map(alone));
    found
}

/// Expected last time \[s\] and highest speed \[rad/s\] without contact.
fn course(machine: &Machine) -> [f64; 2] {
    let course = expected_course(machine);
    let last = course.last().map_or(0.0, |[time, _]| *time);
    [last, course.iter().map(|[_, speed]| *speed).fold(machine.rotor.initial_speed, f64::max)]
}

/// Upper bound of the change of a torque from its value at the start \[N m\].
fn changes(torque: &Torque) -> f64 {
    let steps = torque.values.iter().map(|value| (value - torque.before()).abs()).fold(0.0, f64::max);
    steps + torque.short_circuit.map_or(0.0, |one| one.amplitudes[0].abs() + one.amplitudes[1].abs())
}

/// Torsional section modulus \[m3\] for the diameters at one position.
fn modulus([outer, inner]: [f64; 2]) -> f64 {
    PI * (outer.powi(4) - inner.powi(4)) / (16.0 * outer)
}

fn elements(machine: &Machine) -> &[ShaftElement] {
    match &machine.rotor.kind {
        RotorKind::Shaft(shaft) => &shaft.elements,
        RotorKind::PointMass(_) => &[],
    }
}

/// Larger torsional section modulus of the elements at a node; `None` for a point mass.
fn modulus_at(machine: &Machine, node: usize) -> Option<f64> {
    let elements = elements(machine);
    let left = node.checked_sub(1).and_then(|at| elements.get(at));
    let at_left = left.map(|one| [one.end_diameter, one.end_inner_diameter]);
    let at_right = elements.get(node).map(|one| [one.diameter, one.inner_diameter]);
    at_left.into_iter().chain(at_right).map(modulus).reduce(f64::max)
}

/// Largest shear stress of the torques at t = 0 \[Pa\]: each element carries the sum of the torques to its left.
fn static_stress(machine: &Machine) -> f64 {
    let stress = |(at, one): (usize, &ShaftElement)| {
        let carried: f64 = machine.torques.iter().filter(|torque| torque.node <= at).map(Torque::before).sum();
        let ends = [[one.diameter, one.inner_diameter], [one.end_diameter, one.end_inner_diameter]];
        carried.abs() / ends.map(modulus).into_iter().fold(f64::INFINITY, f64::min)
    };
    elements(machine).iter().enumerate().map(stress).fold(0.0, f64::max)
}

/// Torsional modes within the margin (3) of a short circuit that begins during the run and lasts for at least a period.
fn resonances(machine: &Machine) -> Vec<String> {
    let rings = |torque: &Torque| {
        let one = torque.short_circuit.filter(ShortCircuit::acts)?;
        (one.start < machine.run.end_time).then_some((torque.name.clone(), one))
    };
    let ringing: Vec<(String, ShortCircuit)> = machine.torques.iter().filter_map(rings).collect();
    if ringing.is_empty() {
        return Vec::new();
    }
    // a machine without these modes is reported where its run is prepared
    let Ok(modes) = torsional_frequencies(machine) else { return Vec::new() };
    let mut found = Vec::new();
    for (name, one) in &ringing {
        let parts = [(1.0, "the grid frequency"), (2.0, "twice the grid frequency")];
        for ((times, what), (amplitude, decay)) in parts.into_iter().zip(one.amplitudes.into_iter().zip(one.decays)) {
            let forced = times * one.frequency;
            let lasts = amplitude != 0.0 && decay * forced >= 2.0 * PI;
            found.extend(modes.iter().filter(|mode| lasts && (**mode - forced).abs() <= MARGIN * forced).map(|mode| {
                let [mode, forced] = [*mode, forced].map(|value| format_digits(value / (2.0 * PI), "Hz", 4));
                format!(
                    "torques.{name}: a torsional mode at {mode} is within 10 % of {what} of its short circuit ({forced}): torsional moments grow in every \
                     period and depend strongly on stiffness and inertia of the shaft line"
                )
            }));
        }
    }
    found
}

/// Notes on torques that do not change within the run, and on bearing tables above which torques are expected to drive the rotor.
pub(super) fn notes(machine: &Machine) -> Vec<String> {
    if machine.torques.is_empty() {
        return Vec::new();
    }
    let [last, highest] = course(machine);
    let end = machine.run.end_time;
    let after = |time: f64| {
        let [time, last, end] = [time, last, end].map(|time| format_digits(time, "s", 4));
        match last == end {
            true => format!("at {time}, not before run.end_time = {end}"),
            false => {
                format!("at {time}, when the run is expected to have ended (at {last}, at rest or at run.end_speed)")
            }
        }
    };
    let mut notes = Vec::new();
    for torque in &machine.torques {
        let first = torque.first_change().filter(|first| *first >= last);
        let start = torque.short_circuit.filter(ShortCircuit::acts).map(|one| one.start).filter(|start| *start >= last);
        notes.extend(match (first, start) {
            (Some(first), _) => Some(format!("torques.{}: it first changes {}", torque.name, after(first))),
            (None, Some(start)) => Some(format!("torques.{}: its short circuit begins {}", torque.name, after(start))),
            (None, None) => None,
        });
    }
    let tables = machine.rotor.bearings.iter().filter_map(|one| Some((&one.name, one.table.as_ref()?.range()[1])));
    let above = |(name, high): (&String, f64)| {
        let [reached, high] = [highest, high].map(|speed| format_digits(speed, "rad/s", 5));
        format!(
            "rotor.bearings.{name}: torques are expected to drive the rotor to {reached}, above its table (to {high}); there the run ends beyond the \
             model with cause table_range"
        )
    };
    notes.extend(tables.filter(|(_, high)| highest > *high).map(above));
    notes
}

#[cfg(test)]
mod tests {
    use super::super::{implausible, unreleased};
    use bladeoff_core::modal::torsional_frequencies;
    use bladeoff_model::machine::{Machine, MachineDef};
    use bladeoff_text::document::units::format_digits;
    use std::f64::consts::PI;

    const RIG: &str = include_str!("../../studies/machines/lab_rig.toml");

    fn with(short_circuit: &str) -> Machine {
        let torque = format!(
            "[torques.motor]\nposition = 0.5\nbalance = true\nshort_circuit = {{ decay = \"0.1 s\", {short_circuit} }}\n"
        );
        let text = RIG.replacen("[diaphragms.", &format!("{torque}\n[diaphragms."), 1);
        MachineDef::parse("m.toml", &text)
            .and_then(|def| def.build())
            .unwrap_or_else(|problems| panic!("{problems}\n{text}"))
    }

    #[test]
    fn torques_in_another_unit_and_near_a_torsional_mode_are_named() {
        let usual = "start = \"0.1 s\", frequency = \"3000 rpm\", amplitude = \"9 N m\"";
        assert_eq!(implausible(&with(usual)), [] as [String; 0]);
        for (from, to, expected) in [
            (
                "\"3000 rpm\"",
                "50",
                "torques.motor: frequency of its short circuit 7.96 Hz, plausible is 10 Hz to 1000 Hz; grids have",
            ),
            ("\"9 N m\"", "\"9 MN m\"", "torques.motor: shear stress of the shaft by its changes "),
        ] {
            let found = implausible(&with(&usual.replace(from, to)));
            assert!(found.iter().any(|text| text.starts_with(expected)), "{to}: {found:?}");
        }
        let mode = torsional_frequencies(&with(usual)).expect("solvable")[0];
        for (ratio, double, expected) in
            [(0.95, "", "of the grid frequency"), (0.52, ", double_amplitude = \"9 N m\"", "of twice the grid")]
        {
            let frequency = format!("\"{} rad/s\"", mode * ratio);
            let found = implausible(&with(&(usual.replace("\"3000 rpm\"", &frequency) + double)));
            let named =
                format!("a torsional mode at {} is within 10 % {expected}", format_digits(mode / (2.0 * PI), "Hz", 4));
            assert!(found.iter().any(|text| text.contains(&named)), "{named}: {found:?}");
        }
    }

    /// Torques that cancel at one position do not load the shaft; two torques of the same sign add up.
    #[test]
    fn torques_are_judged_by_their_sum() {
        let with = |torques: &str| {
            let text = RIG.replacen("[diaphragms.", &format!("{torques}\n[diaphragms."), 1);
            let machine = MachineDef::parse("m.toml", &text).and_then(|def| def.build());
            implausible(&machine.unwrap_or_else(|problems| panic!("{problems}\n{text}")))
        };
        let torque = |name: &str, position: f64, value: &str| {
            format!("[torques.{name}]\nposition = {position}\ntimes = [0]\nvalues = [\"{value}\"]\n")
        };
        let fan = "[torques.fan]\nposition = 0.9\nbalance = true\n";
        let cancelling = torque("a", 0.3, "11 kN m") + &torque("b", 0.3, "-11 kN m") + fan;
        assert_eq!(with(&cancelling), [] as [String; 0]);
        let one = torque("a", 0.3, "2 kN m") + fan;
        assert_eq!(with(&one), [] as [String; 0]);
        let found = with(&(torque("a", 0.3, "2 kN m") + &torque("b", 0.31, "2 kN m") + fan));
        let expected = "torques: largest static shear stress of the shaft ";
        assert!(found.len() == 1 && found[0].starts_with(expected), "{found:?}");
        let drive = format!("[torques.a]\nposition = 0.3\ntimes = [0.01, 0.01]\nvalues = [0, \"100 N m\"]\n{fan}");
        let found = with(&drive);
        assert!(found.len() == 1 && found[0].starts_with("torques: highest speed without contact over"), "{found:?}");
    }

    #[test]
    fn a_mass_point_is_judged_by_its_speed() {
        let point = "schema = 1\nname = \"p\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 0.05\ninitial_speed = 300\n\
            [rotor.bearings.a]\nstiffness = 4e4\ndamping = 10\n[torques.m]\nbalance = true\n\
            short_circuit = { start = 0.1, frequency = \"3000 rpm\", amplitude = \"50 MN m\", decay = 0.1 }\n";
        let machine = MachineDef::parse("p.toml", point)
            .and_then(|def| def.build())
            .unwrap_or_else(|problems| panic!("{problems}"));
        let found = implausible(&machine);
        assert!(
            found.iter().any(|text| text.starts_with("torques.m: oscillation of the speed in its short circuit")),
            "{found:?}"
        );
    }

    #[test]
    fn a_torque_that_drives_the_rotor_out_of_a_bearing_table_is_noted() {
        let table = "kind = \"table\"\ncoefficients = { speeds = [10, 400], kxx = [2e6, 2e6], kyy = [2e6, 2e6], cxx = [600, 600], cyy = [600, 600] }";
        let bearing = "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"";
        assert!(RIG.contains(bearing));
        let of = |torque: &str| {
            let text = RIG.replacen(bearing, table, 1).replacen("[diaphragms.", &format!("{torque}\n[diaphragms."), 1);
            let text = text.replacen("[run]\n", "[run]\nend_speed = \"10 rad/s\"\n", 1);
            let machine = MachineDef::parse("m.toml", &text).and_then(|def| def.build());
            unreleased(&machine.unwrap_or_else(|problems| panic!("{problems}\n{text}")))
        };
        assert_eq!(of(""), [] as [String; 0]);
        let motor = "[torques.motor]\nposition = 0.5\ntimes = [0.01, 0.01]\nvalues = [0, \"100 N m\"]\n[torques.fan]\nposition = 0.4\nbalance = true\n";
        let notes = of(motor);
        assert!(
            notes.len() == 1
                && notes[0].starts_with("rotor.bearings.left: torques are expected to drive the rotor to "),
            "{notes:?}"
        );
    }

    #[test]
    fn a_short_circuit_after_the_end_is_noted() {
        let notes = unreleased(&with("start = \"90 s\", frequency = \"3000 rpm\", amplitude = \"9 N m\""));
        assert!(
            notes.len() == 1
                && notes[0].starts_with("torques.motor: it first changes at 90 s, not before run.end_time ="),
            "{notes:?}"
        );
    }
}
