//! Plausibility of torques on the shaft: grid frequency, stress, and torsional modes near the frequencies of a short circuit.
//!
//! ```text
//! tau = 16 T D / (pi (D^4 - d^4))      T: largest |L| + |A1| + |A2| of the torque, D, d: outer and inner diameter at its node       (1)
//! |f - n f0| <= 0.1 n f0               f: torsional frequency of the free shaft line, f0: grid, n = 1, 2                             (2)
//! ```
//! Source: (1) torsion of a circular tube; (2) the usual margin of 10 % of torsional modes from grid frequency and its double. Verified by
//! `torques_in_another_unit_and_near_a_torsional_mode_are_named`.

use super::{Finding, Rule, alone, rule};
use bladeoff_core::modal::{highest_speed, torsional_frequencies};
use bladeoff_model::machine::{Machine, RotorKind, ShaftElement, Torque};
use bladeoff_text::document::units::{format_digits, format_quantity};
use std::f64::consts::PI;

static GRID: Rule = rule(
    "frequency of its short circuit",
    [10.0, 1000.0],
    "Hz",
    "grids have 50 or 60 Hz; a number alone is in rad/s, \"3000 rpm\" and \"50 rev/s\" are 50 Hz",
);
static SHEAR: Rule = rule("shear stress of the shaft by its largest value", [0.0, 1e9], "Pa", "is its unit right?");
/// Margin of a torsional mode.
const MARGIN: f64 = 0.1;

/// Warnings about the torques of a machine.
pub(super) fn findings(machine: &Machine) -> Vec<Finding> {
    let mut found = Vec::new();
    for torque in &machine.torques {
        let subject = format!("torques.{}", torque.name);
        if let Some(short_circuit) = torque.short_circuit {
            found.extend(GRID.judge(&subject, short_circuit.frequency / (2.0 * PI), ""));
        }
        if let Some(stress) = stress(machine, torque) {
            let beside = format!(" ({})", format_quantity(torque.largest(), "N m"));
            found.extend(SHEAR.judge(&subject, stress, &beside));
        }
    }
    found.extend(resonances(machine).into_iter().map(alone));
    found
}

/// Stress (1) in the stouter of the elements at the node.
fn stress(machine: &Machine, torque: &Torque) -> Option<f64> {
    let RotorKind::Shaft(shaft) = &machine.rotor.kind else { return None };
    let left = torque.node.checked_sub(1).and_then(|at| shaft.elements.get(at));
    let at_left = left.map(|one| [one.end_diameter, one.end_inner_diameter]);
    let at_right = shaft.elements.get(torque.node).map(|one: &ShaftElement| [one.diameter, one.inner_diameter]);
    let modulus = |[outer, inner]: [f64; 2]| PI * (outer.powi(4) - inner.powi(4)) / (16.0 * outer);
    let largest = at_left.into_iter().chain(at_right).map(modulus).fold(0.0, f64::max);
    (largest > 0.0).then(|| torque.largest() / largest)
}

/// Torsional modes within the margin (2).
fn resonances(machine: &Machine) -> Vec<String> {
    if machine.torques.iter().all(|torque| torque.short_circuit.is_none()) {
        return Vec::new();
    }
    // a machine without these modes is reported where its run is prepared
    let Ok(modes) = torsional_frequencies(machine) else { return Vec::new() };
    let mut found = Vec::new();
    for torque in &machine.torques {
        let Some(short_circuit) = torque.short_circuit else { continue };
        for (times, what, amplitude) in [
            (1.0, "the grid frequency", short_circuit.amplitudes[0]),
            (2.0, "twice the grid frequency", short_circuit.amplitudes[1]),
        ] {
            let forced = times * short_circuit.frequency;
            let near = |mode: &&f64| (**mode - forced).abs() <= MARGIN * forced && amplitude != 0.0;
            found.extend(modes.iter().filter(near).map(|mode| {
                let [mode, forced] = [*mode, forced].map(|value| format_digits(value / (2.0 * PI), "Hz", 4));
                format!(
                    "torques.{}: a torsional mode at {mode} is within 10 % of {what} of its short circuit ({forced}): torsional moments grow in every \
                     period and depend strongly on stiffness and inertia of the shaft line",
                    torque.name
                )
            }));
        }
    }
    found
}

/// Notes on bearing tables above which torques are expected to drive the rotor.
pub(super) fn overspeeds(machine: &Machine) -> Vec<String> {
    if machine.torques.is_empty() {
        return Vec::new();
    }
    let highest = highest_speed(machine);
    let tables = machine.rotor.bearings.iter().filter_map(|one| Some((&one.name, one.table.as_ref()?.range()[1])));
    let note = |(name, high): (&String, f64)| {
        let [reached, high] = [highest, high].map(|speed| format_quantity(speed, "rad/s"));
        format!(
            "rotor.bearings.{name}: torques are expected to drive the rotor to {reached}, above its table (to {high}); there the run ends beyond the \
             model with cause table_range"
        )
    };
    tables.filter(|(_, high)| highest > *high).map(note).collect()
}

/// Notes on torques that do not change within the run.
pub(super) fn unchanged(machine: &Machine) -> Vec<String> {
    let end = machine.run.end_time;
    let after =
        |time: f64| format!("at {}, after run.end_time = {}", format_quantity(time, "s"), format_quantity(end, "s"));
    let mut notes = Vec::new();
    for torque in &machine.torques {
        let first = torque.first_change().filter(|first| *first > end);
        let start = torque.short_circuit.map(|short_circuit| short_circuit.start).filter(|start| *start > end);
        notes.extend(match (first, start) {
            (Some(first), _) => Some(format!("torques.{}: it first changes {}", torque.name, after(first))),
            (None, Some(start)) => Some(format!("torques.{}: its short circuit begins {}", torque.name, after(start))),
            (None, None) => None,
        });
    }
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
            ("\"9 N m\"", "\"9 MN m\"", "torques.motor: shear stress of the shaft by its largest value "),
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
            notes.len() == 1 && notes[0].starts_with("torques.motor: it first changes at 90 s, after run.end_time ="),
            "{notes:?}"
        );
    }
}
