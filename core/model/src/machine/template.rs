//! The commented machine file that `bladeoff new machine` writes: example values from here, everything else from the table of keys, so that the
//! template always matches the format.

use std::fmt::Write;

use super::schema::{Key, Kind, Need, When, keys};
use bladeoff_text::document::units::format_digits;

const HEAD: &str = "\
# Machine file of bladeoff. Every number is SI, or a string with its unit (\"8 mm\", \"1500 rpm\", \"210 GPa\", \"kg m2\").
# Lines that begin with \"# key =\" show defaults or examples of what may be left out. Names of discs, bearings,
# unbalances and diaphragms are yours. Positions run along the shaft from its left end; what is
# between two nodes makes a node there. X and Y lie across it, spin is positive about +Z.
";

/// A table of the template: header, pattern in the table of keys, whether all its keys are explained, values.
type Table = (&'static str, &'static str, bool, &'static [(&'static str, &'static str)]);

#[rustfmt::skip]
const TABLES: &[Table] = &[
    ("", "", true, &[("schema", "1"), ("name", "\"my_turbine\"")]),
    ("[run]", "run", true, &[("end_time", "\"6 s\"")]),
    ("[run.guard]", "run.guard", true, &[]),
    ("[run.limit.ring_displacement]", "run.limit.ring_displacement", true, &[]),
    ("[run.limit.ring_yield]", "run.limit.ring_yield", true, &[]),
    ("[run.limit.blade_yield]", "run.limit.blade_yield", true, &[]),
    ("[run.limit.shaft_yield]", "run.limit.shaft_yield", true, &[]),
    ("[run.limit.journal_clearance]", "run.limit.journal_clearance", true, &[]),
    ("[run.limit.unstable_rotor]", "run.limit.unstable_rotor", true, &[]),
    ("[rotor]", "rotor", true, &[("initial_speed", "\"1500 rpm\""), ("gravity", "[0.0, -9.81]")]),
    ("[rotor.material]", "rotor.material", true,
        &[("young_modulus", "\"210 GPa\""), ("poisson_ratio", "0.3"), ("density", "\"7850 kg/m3\""), ("shear_coefficient", "0.9")]),
    ("[[rotor.shaft]]", "rotor.shaft[i]", true, &[("length", "\"2.55 m\""), ("elements", "6"), ("diameter", "\"0.45 m\"")]),
    ("[rotor.shaft.material]", "rotor.shaft[i].material", true, &[]),
    ("[[rotor.shaft]]", "rotor.shaft[i]", false, &[("length", "\"2 m\""), ("elements", "4"), ("diameter", "\"0.64 m\"")]),
    ("[[rotor.shaft]]", "rotor.shaft[i]", false, &[("length", "\"2.55 m\""), ("elements", "6"), ("diameter", "\"0.45 m\"")]),
    ("[rotor.layers.sleeve]", "rotor.layers.NAME", true, &[]),
    ("[rotor.layers.sleeve.material]", "rotor.layers.NAME.material", true, &[]),
    ("[rotor.discs.front]", "rotor.discs.NAME", true,
        &[("position", "\"2.55 m\""), ("mass", "\"3000 kg\""), ("transverse_inertia", "\"800 kg m2\""), ("polar_inertia", "\"1500 kg m2\"")]),
    ("[rotor.discs.rear]", "rotor.discs.NAME", false,
        &[("position", "\"4.55 m\""), ("mass", "\"3000 kg\""), ("transverse_inertia", "\"800 kg m2\""), ("polar_inertia", "\"1500 kg m2\"")]),
    ("[rotor.bearings.front]", "rotor.bearings.NAME", true,
        &[("position", "\"0.425 m\""), ("stiffness", "\"6e8 N/m\""), ("damping", "\"6e5 N s/m\""), ("axial_stiffness", "\"1e8 N/m\"")]),
    ("[rotor.bearings.front.coefficients]", "rotor.bearings.NAME.coefficients", true, &[]),
    ("[rotor.bearings.front.pedestal]", "rotor.bearings.NAME.pedestal", true, &[]),
    ("[rotor.bearings.rear]", "rotor.bearings.NAME", false,
        &[("position", "\"6.675 m\""), ("stiffness", "\"6e8 N/m\""), ("damping", "\"6e5 N s/m\"")]),
    ("[rotor.unbalances.blade_off]", "rotor.unbalances.NAME", true,
        &[("position", "\"4.55 m\""), ("mass", "\"12 kg\""), ("radius", "\"1.5 m\"")]),
    ("[rotor.damping]", "rotor.damping", true, &[("stiffness_proportional", "\"2e-5 s\"")]),
    ("[rotor.speed_law]", "rotor.speed_law", true, &[]),
    ("[rotor.initial]", "rotor.initial", true, &[]),
    ("[braking]", "braking", true, &[("linear", "\"30 N m s\""), ("quadratic", "\"0.66 N m s2\"")]),
    ("[torques.generator]", "torques.NAME", true, &[]),
    ("[torques.generator.short_circuit]", "torques.NAME.short_circuit", true, &[]),
    ("[diaphragms.mid]", "diaphragms.NAME", true, &[("kind", "\"flexible\"")]),
    ("[diaphragms.mid.material]", "diaphragms.NAME.material", true,
        &[("young_modulus", "\"200 GPa\""), ("poisson_ratio", "0.3"), ("density", "\"7850 kg/m3\"")]),
    ("[diaphragms.mid.ring]", "diaphragms.NAME.ring", true,
        &[("mean_radius", "\"353 mm\""), ("thickness", "\"50 mm\""), ("width", "\"100 mm\""), ("elements", "48")]),
    ("[diaphragms.mid.blades]", "diaphragms.NAME.blades", true,
        &[("count", "12"), ("length", "\"250 mm\""), ("thickness", "\"20 mm\""), ("width", "\"60 mm\""), ("elements", "2")]),
    ("[diaphragms.mid.damping]", "diaphragms.NAME.damping", true,
        &[("mass_proportional", "\"20 1/s\""), ("stiffness_proportional", "\"1e-5 s\"")]),
    ("[diaphragms.mid.contact]", "diaphragms.NAME.contact", true,
        &[("position", "\"3.55 m\""), ("rotor_radius", "\"320 mm\""), ("gap", "\"8 mm\""), ("friction", "0.2"), ("detection", "\"hyp2\"")]),
];

/// Examples of keys that have neither a value above nor a default.
const EXAMPLES: &[(&str, &str)] = &[
    ("run.step", "\"5 us\""),
    ("run.contact_step", "\"5 us\""),
    ("run.rotor_modes", "16"),
    ("run.torsional_modes", "4"),
    ("run.ring_modes", "36"),
    ("run.step_limit", "5000000"),
    ("run.guard.energy_balance", "1e-6"),
    ("run.guard.impact_steps", "64"),
    ("rotor.bearings.NAME.clearance", "\"0.3 mm\""),
    ("rotor.bearings.NAME.table", "\"front_bearing.csv\""),
    ("rotor.bearings.NAME.coefficients.speeds", "[\"100 rpm\", \"1600 rpm\"]"),
    ("rotor.bearings.NAME.coefficients.kxx", "[9e8, 5e8]"),
    ("rotor.bearings.NAME.coefficients.kxy", "[3e8, 1e8]"),
    ("rotor.bearings.NAME.coefficients.kyx", "[-6e8, -4e8]"),
    ("rotor.bearings.NAME.coefficients.kyy", "[5e8, 7e8]"),
    ("rotor.bearings.NAME.coefficients.cxx", "[6e6, 1e6]"),
    ("rotor.bearings.NAME.coefficients.cxy", "[-5e5, -1e5]"),
    ("rotor.bearings.NAME.coefficients.cyx", "[-5e5, -1e5]"),
    ("rotor.bearings.NAME.coefficients.cyy", "[4e6, 1e6]"),
    ("rotor.bearings.NAME.pedestal.mass", "[\"8 t\", \"10 t\"]"),
    ("rotor.bearings.NAME.pedestal.stiffness", "[\"1e9 N/m\", \"3e9 N/m\"]"),
    ("rotor.bearings.NAME.pedestal.damping", "\"1e5 N s/m\""),
    ("rotor.mass", "\"17 t\""),
    ("rotor.polar_inertia", "\"3000 kg m2\""),
    ("rotor.shaft[i].element_lengths", "[\"0.4 m\", \"0.5 m\"]"),
    ("rotor.shaft[i].shear_coefficient", "\"cowper\""),
    ("rotor.shaft[i].end_diameter", "\"0.5 m\""),
    ("rotor.shaft[i].end_inner_diameter", "\"0.1 m\""),
    ("rotor.layers.NAME.position", "\"2.55 m\""),
    ("rotor.layers.NAME.length", "\"0.5 m\""),
    ("rotor.layers.NAME.diameter", "\"0.74 m\""),
    ("rotor.layers.NAME.inner_diameter", "\"0.64 m\""),
    ("rotor.layers.NAME.end_diameter", "\"0.7 m\""),
    ("rotor.layers.NAME.end_inner_diameter", "\"0.64 m\""),
    ("rotor.layers.NAME.shear_coefficient", "\"cowper\""),
    ("rotor.layers.NAME.material.young_modulus", "\"1 MPa\""),
    ("rotor.layers.NAME.material.poisson_ratio", "0.3"),
    ("rotor.layers.NAME.material.density", "\"7850 kg/m3\""),
    ("rotor.shaft[i].material.young_modulus", "\"205 GPa\""),
    ("rotor.shaft[i].material.poisson_ratio", "0.3"),
    ("rotor.shaft[i].material.density", "\"7850 kg/m3\""),
    ("rotor.shaft[i].material.shear_coefficient", "\"none\""),
    ("rotor.material.yield_strength", "\"600 MPa\""),
    ("rotor.shaft[i].material.yield_strength", "\"550 MPa\""),
    ("diaphragms.NAME.material.yield_strength", "\"400 MPa\""),
    ("rotor.unbalances.NAME.disc", "\"rear\""),
    ("rotor.unbalances.NAME.release_time", "\"0.5 s\""),
    ("rotor.unbalances.NAME.release_speed", "\"1650 rpm\""),
    ("rotor.damping.torsional", "\"2e-5 s\""),
    ("rotor.speed_law.acceleration", "\"-50 rpm/s\""),
    ("rotor.speed_law.times", "[\"0 s\", \"6 s\"]"),
    ("rotor.speed_law.speeds", "[\"1500 rpm\", \"1200 rpm\"]"),
    ("braking.speeds", "[\"0 rpm\", \"1500 rpm\"]"),
    ("braking.torques", "[\"200 N m\", \"2 kN m\"]"),
    ("torques.NAME.position", "\"6.9 m\""),
    ("torques.NAME.times", "[\"0 s\", \"0.1 s\"]"),
    ("torques.NAME.values", "[\"-2 MN m\", \"0 N m\"]"),
    ("torques.NAME.factors", "[1.0, 0.0]"),
    ("torques.NAME.short_circuit.start", "\"0 s\""),
    ("torques.NAME.short_circuit.frequency", "\"3000 rpm\""),
    ("torques.NAME.short_circuit.amplitude", "\"-9 MN m\""),
    ("torques.NAME.short_circuit.decay", "\"0.2 s\""),
    ("torques.NAME.short_circuit.double_amplitude", "\"4 MN m\""),
    ("torques.NAME.short_circuit.double_decay", "\"0.1 s\""),
    ("diaphragms.NAME.stiffness", "\"1e8 N/m\""),
];

/// A valid machine file with every key, its default or an example, its allowed values and meaning.
#[must_use]
pub fn machine_template() -> String {
    let mut out = HEAD.to_owned();
    for &(header, pattern, explained, values) in TABLES {
        if !header.is_empty() {
            // A table without any set value would be empty.
            let off = if values.is_empty() { "# " } else { "" };
            writeln!(out, "\n{off}{header}").expect("writing to a string cannot fail");
        }
        for key in keys().iter().filter(|key| key.path.rsplit_once('.').map_or("", |(above, _)| above) == pattern) {
            let value = values.iter().find(|(name, _)| *name == key.name());
            match value {
                Some((name, value)) if explained => line(&mut out, &format!("{name} = {value}"), key),
                Some((name, value)) => writeln!(out, "{name} = {value}").expect("writing to a string cannot fail"),
                None if explained => line(&mut out, &format!("# {} = {}", key.name(), example(key)), key),
                None => {}
            }
        }
    }
    out
}

/// Writes one key with its comment, aligned.
fn line(out: &mut String, assignment: &str, key: &Key) {
    let mut comment = key.meaning.to_owned();
    match key.kind {
        Kind::Choice(words) if words.len() > 1 => write!(comment, " ({})", words.join(" | ")),
        Kind::Schema | Kind::Text | Kind::Choice(_) => Ok(()),
        _ => write!(comment, " ({})", key.range.words(key.unit())),
    }
    .expect("writing to a string cannot fail");
    match key.need {
        Need::Optional(without) if key.when == When::Always => {
            write!(comment, "; without: {without}").expect("writing to a string cannot fail");
        }
        _ => {}
    }
    if matches!(key.when, When::PointMass | When::RadialSpring | When::TableBearing) {
        write!(comment, "; only with {}", key.when.words()).expect("writing to a string cannot fail");
    }
    writeln!(out, "{assignment:<38} # {comment}").expect("writing to a string cannot fail");
}

/// The default as written in a file, or an example.
fn example(key: &Key) -> String {
    let quantity = |number: f64| {
        let shown = format_digits(number, key.unit(), 10);
        if key.unit().is_empty() { shown } else { format!("\"{shown}\"") }
    };
    match (key.need, key.kind) {
        (Need::Number(number), Kind::Vector(_)) => format!("[{0}, {0}]", quantity(number)),
        (Need::Number(number), _) => quantity(number),
        (Need::Word(word), _) => format!("\"{word}\""),
        (Need::Required | Need::Optional(_), _) => {
            EXAMPLES.iter().find(|(path, _)| *path == key.path).map_or_else(String::new, |(_, text)| (*text).to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::MachineDef;

    #[test]
    fn the_template_loads_and_names_every_key() {
        let text = machine_template();
        let def = MachineDef::parse("template", &text).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let machine = def.build().unwrap();
        assert_eq!((machine.rotor.bearings.len(), machine.rotor.gravity), (2, [0.0, -9.81]));
        for key in keys() {
            let written =
                text.lines().any(|line| line.trim_start_matches("# ").starts_with(&format!("{} = ", key.name())));
            assert!(written, "{}", key.path);
            let has_value = TABLES.iter().any(|(_, _, _, values)| values.iter().any(|(name, _)| *name == key.name()));
            let shown = has_value || !example(key).is_empty();
            assert!(shown, "{} has no example", key.path);
        }
    }

    #[test]
    fn every_line_that_is_commented_out_is_valid_toml() {
        for line in machine_template().lines().filter(|line| line.starts_with("# ") && line.contains(" = ")) {
            assert!(line[2..].parse::<toml::Table>().is_ok(), "{line}");
        }
    }
}
