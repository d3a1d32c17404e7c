//! Plausibility checks of a machine's numbers: a value outside the range of metal machines is usually in another unit than intended.
//!
//! A warning changes no result and no exit code. The ranges are wide: they include rubber and ceramics, watches and hydro turbines.

#[path = "plausible_torques.rs"]
mod torques;

use bladeoff_core::modal::{expected_releases, under_weight};
use bladeoff_model::machine::{DiaphragmKind, Engine, Machine, Release, RotorKind, ShaftElement, Unbalance};
use bladeoff_study::{Chosen, Samples};
use bladeoff_text::document::units::{format_digits, format_quantity};
use std::f64::consts::PI;

/// One quantity and its plausible range in the SI unit, both ends included.
#[derive(Debug)]
struct Rule {
    quantity: &'static str,
    range: [f64; 2],
    unit: &'static str,
    /// Likely cause of a value outside the range.
    hint: &'static str,
}

const fn rule(quantity: &'static str, range: [f64; 2], unit: &'static str, hint: &'static str) -> Rule {
    Rule { quantity, range, unit, hint }
}

const UNIT: &str = "is its unit right?";
static MODULUS: Rule = rule("Young's modulus", [1e9, 1e12], "Pa", UNIT);
static DENSITY: Rule = rule("density", [500.0, 25_000.0], "kg/m3", UNIT);
static SHAFT_DIAMETER: Rule = rule("outer diameter", [1e-3, 5.0], "m", UNIT);
static SHAFT_LENGTH: Rule = rule("length of the shaft", [0.01, 100.0], "m", UNIT);
static INERTIA: Rule = rule(
    "polar over transverse inertia",
    [0.0, 2.0 * (1.0 + 1e-6)],
    "",
    "a thin disc has 2, every other body less: are the two inertias interchanged?",
);
static STIFFNESS: Rule = rule("stiffness", [0.0, 1e12], "N/m", UNIT);
static YIELD: Rule = rule("yield strength", [1e7, 5e9], "Pa", UNIT);
static BEARING_DAMPING: Rule = rule("damping", [0.0, 1e9], "N s/m", UNIT);
static FRICTION: Rule = rule("friction coefficient", [0.0, 1.5], "", "dry steel has 0.1 to 0.8");
static RADIUS: Rule = rule("radius of the unbalance", [1e-5, 5.0], "m", UNIT);
static GAP: Rule = rule("gap", [5e-6, 0.1], "m", UNIT);
static GYRATION: Rule = rule(
    "radius of gyration over the length of the shaft",
    [0.0, 1.0],
    "",
    "are its mass and its inertias in SI units?",
);
static CLEARANCE: Rule = rule("radial clearance", [1e-6, 5e-3], "m", UNIT);
static CRITICAL_DAMPING: Rule = rule(
    "damping ratio of the first bending mode by the shaft's stiffness-proportional damping",
    [0.0, 0.2],
    "",
    "steel has 0.001 to 0.01: is stiffness_proportional in seconds?",
);
static SLENDER: Rule = rule(
    "polar over transverse inertia",
    [0.05, f64::INFINITY],
    "",
    "a drum ten times as long as its radius has 0.06: are both in the same unit?",
);
static SAG: Rule =
    rule("sag under its weight", [0.0, 0.02], "m", "are the stiffness of its bearings and Young's modulus right?");
static FREQUENCY: Rule = rule(
    "first bending frequency over running speed",
    [0.01, f64::INFINITY],
    "",
    "are the stiffness of its bearings and Young's modulus right?",
);
static SURFACE: Rule =
    rule("surface speed", [0.0, 1000.0], "m/s", "are speed (a number alone is in rad/s) and rotor_radius right?");
static RING_RADIUS: Rule = rule("mean radius", [1e-3, 10.0], "m", UNIT);
static RING_WIDTH: Rule =
    rule("width over mean radius", [1e-3, 2.0], "", "are width and mean_radius in the same unit?");
static RING_THICKNESS: Rule =
    rule("thickness over mean radius", [1e-4, 0.5], "", "are thickness and mean_radius in the same unit?");
static UNBALANCE: Rule = rule("mass over the rotor's mass", [0.0, 0.5], "", UNIT);
static BLADE_LENGTH: Rule =
    rule("blade length over mean radius", [1e-2, 10.0], "", "are blades.length and mean_radius in the same unit?");
static BLADE_WIDTH: Rule =
    rule("blade width over ring width", [1e-2, 10.0], "", "are blades.width and ring.width in the same unit?");
static BLADE_THICKNESS: Rule =
    rule("blade thickness over length", [1e-3, 1.0], "", "are thickness and length of the blades in the same unit?");

impl Rule {
    /// The warning about a value of `subject` if it is implausible; `beside`: additional information for the reader's judgement.
    fn judge(&'static self, subject: &str, value: f64, beside: &str) -> Option<Finding> {
        let [least, most] = self.range;
        if (least..=most).contains(&value) {
            return None;
        }
        let text = self.text(subject, &format!("{}{beside}", self.shown(value)));
        Some(Finding { text, of: Some((subject.to_owned(), self, value)) })
    }

    fn shown(&self, value: f64) -> String {
        format_digits(value, self.unit, 3)
    }

    fn text(&self, subject: &str, found: &str) -> String {
        let [least, most] = self.range;
        let usual = match (least > 0.0, most.is_finite()) {
            (true, true) => format!("{} to {}", self.shown(least), self.shown(most)),
            (true, false) => format!("at least {}", self.shown(least)),
            _ => format!("at most {}", self.shown(most)),
        };
        let Self { quantity, hint, .. } = self;
        format!("{subject}: {quantity} {found}, plausible is {usual}; {hint}")
    }
}

/// One warning about a machine.
#[derive(Debug, Clone)]
struct Finding {
    text: String,
    /// Subject, rule and value of a quantity outside its range.
    of: Option<(String, &'static Rule, f64)>,
}

impl Finding {
    /// Whether both warnings concern the same quantity of the same part; their values may differ.
    fn is_like(&self, other: &Self) -> bool {
        match (&self.of, &other.of) {
            (Some((subject, rule, _)), Some((others, of_other, _))) => {
                subject == others && rule.quantity == of_other.quantity && rule.hint == of_other.hint
            }
            _ => self.text == other.text,
        }
    }
}

/// Warnings about a machine, in the order of its file; empty if all values are plausible.
#[must_use]
pub fn implausible(machine: &Machine) -> Vec<String> {
    findings(machine).into_iter().map(|finding| finding.text).collect()
}

fn findings(machine: &Machine) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut see = |rule, subject: &str, value, beside: &str| add(&mut found, rule, subject, value, beside);
    let rotor = &machine.rotor;
    if let RotorKind::Shaft(shaft) = &rotor.kind {
        let quantities: [(&'static Rule, fn(&ShaftElement) -> f64); 3] =
            [(&MODULUS, |one| one.young_modulus), (&DENSITY, |one| one.density), (&SHAFT_DIAMETER, |one| one.diameter)];
        for element in &shaft.elements {
            if let Some(strength) = element.yield_strength {
                see(&YIELD, &format!("rotor.shaft[{}]", element.section), strength, "");
            }
        }
        for (rule, of) in quantities {
            let mut seen = Vec::new();
            for element in &shaft.elements {
                let value = of(element);
                // sections of the same material would give the same warning
                if !seen.contains(&value.to_bits()) {
                    see(rule, &format!("rotor.shaft[{}]", element.section), value, "");
                    seen.push(value.to_bits());
                }
            }
        }
        see(&SHAFT_LENGTH, "rotor", shaft.nodes.last().unwrap_or(&1.0) - shaft.nodes.first().unwrap_or(&0.0), "");
        for disc in shaft.discs.iter().filter(|disc| disc.polar_inertia > 0.0) {
            let ratio = disc.polar_inertia / disc.transverse_inertia;
            let [polar, transverse] =
                [disc.polar_inertia, disc.transverse_inertia].map(|inertia| format_digits(inertia, "kg m2", 3));
            let gyration = (disc.transverse_inertia.max(disc.polar_inertia) / disc.mass).sqrt();
            let length = shaft.nodes.last().unwrap_or(&1.0) - shaft.nodes.first().unwrap_or(&0.0);
            let beside = format!(" ({} of {})", format_digits(gyration, "m", 3), format_digits(length, "m", 3));
            see(&GYRATION, &format!("rotor.discs.{}", disc.name), gyration / length, &beside);
            for rule in [&INERTIA, &SLENDER] {
                see(rule, &format!("rotor.discs.{}", disc.name), ratio, &format!(" ({polar} over {transverse})"));
            }
        }
    }
    for bearing in &rotor.bearings {
        let largest = bearing.stiffness.iter().flatten().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
        see(&STIFFNESS, &format!("rotor.bearings.{}", bearing.name), largest, "");
        let largest = bearing.damping.iter().flatten().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
        see(&BEARING_DAMPING, &format!("rotor.bearings.{}", bearing.name), largest, "");
        if let Some(clearance) = bearing.clearance {
            see(&CLEARANCE, &format!("rotor.bearings.{}", bearing.name), clearance, "");
        }
    }
    let is_shaft = matches!(rotor.kind, RotorKind::Shaft(_));
    let is_truncated = is_shaft && machine.run.engine != Engine::Full && !machine.run.static_residual;
    if let Some(raised) = rotor.bearings.iter().find(|one| one.elevation != [0.0; 2]).filter(|_| is_truncated) {
        found.push(alone(format!(
            "rotor.bearings.{}: with an elevation and run.static_residual = \"off\" the bending stresses of the shaft lack the static response of the \
             truncated modes (5 % for 0.1 mm on the test rig)",
            raised.name
        )));
    }
    let mut see = |rule, subject: &str, value, beside: &str| add(&mut found, rule, subject, value, beside);
    if let Some(weight) = under_weight(machine) {
        see(&SAG, "rotor", weight.sag, "");
        if rotor.initial_speed > 0.0 {
            let [hertz, rpm] = [weight.frequency / (2.0 * PI), rotor.initial_speed * 30.0 / PI]
                .map(|value| format_digits(value, "", 3));
            let beside = format!(" ({hertz} Hz at {rpm} rpm)");
            see(&FREQUENCY, "rotor", weight.frequency / rotor.initial_speed, &beside);
            // zeta = b w/2 for damping proportional to stiffness
            see(&CRITICAL_DAMPING, "rotor.damping", 0.5 * rotor.damping.stiffness_proportional * weight.frequency, "");
        }
        for unbalance in &rotor.unbalances {
            let [mass, rotor] = [unbalance.mass, weight.mass].map(|mass| format_digits(mass, "kg", 3));
            let subject = format!("rotor.unbalances.{}", unbalance.name);
            see(&UNBALANCE, &subject, unbalance.mass / weight.mass, &format!(" ({mass} of {rotor})"));
        }
    }
    for unbalance in rotor.unbalances.iter().filter(|unbalance| unbalance.mass > 0.0 && unbalance.radius > 0.0) {
        see(&RADIUS, &format!("rotor.unbalances.{}", unbalance.name), unbalance.radius, "");
    }
    for diaphragm in &machine.diaphragms {
        let subject = format!("diaphragms.{}", diaphragm.name);
        see(&FRICTION, &subject, diaphragm.contact.friction, "");
        see(&GAP, &subject, diaphragm.contact.gap, "");
        see(&SURFACE, &subject, rotor.initial_speed * diaphragm.contact.rotor_radius, " of the rotor at the contact");
        if let DiaphragmKind::Flexible(stator) = &diaphragm.kind {
            let ring = &stator.ring;
            see(&MODULUS, &subject, stator.young_modulus, "");
            see(&DENSITY, &subject, stator.density, "");
            if let Some(strength) = stator.yield_strength {
                see(&YIELD, &subject, strength, "");
            }
            see(&RING_RADIUS, &subject, ring.mean_radius, "");
            let mut compare = |rule: &'static Rule, size: f64, reference: f64| {
                let [shown, of] = [size, reference].map(|size| format_digits(size, "m", 3));
                see(rule, &subject, size / reference, &format!(" ({shown} of {of})"));
            };
            compare(&RING_WIDTH, ring.width, ring.mean_radius);
            compare(&RING_THICKNESS, ring.thickness, ring.mean_radius);
            if let Some(blades) = &stator.blades {
                compare(&BLADE_LENGTH, blades.length, ring.mean_radius);
                compare(&BLADE_WIDTH, blades.width, ring.width);
                compare(&BLADE_THICKNESS, blades.thickness, blades.length);
            }
        }
    }
    found.extend(torques::findings(machine));
    found
}

/// Notes on releases and torques that are not expected to act during a run: they do not make the machine invalid.
#[must_use]
pub fn unreleased(machine: &Machine) -> Vec<String> {
    releases(machine).into_iter().chain(torques::notes(machine)).collect()
}

fn releases(machine: &Machine) -> Vec<String> {
    let unbalances = machine.rotor.unbalances.iter().zip(expected_releases(machine));
    let note = |(unbalance, at): (&Unbalance, Option<[f64; 2]>)| {
        let (key, value) = match unbalance.release.filter(|_| at.is_none())? {
            Release::Time(time) => ("release_time", format_quantity(time, "s")),
            Release::Speed(speed) => ("release_speed", format_quantity(speed, "rad/s")),
        };
        Some(format!(
            "rotor.unbalances.{}: {key} = {value} is not expected within the run, so this mass is never released (friction of a contact is not in this estimate)",
            unbalance.name
        ))
    };
    unbalances.filter_map(note).collect()
}

/// Notes of [`unreleased`] on a study's machine: on releases if no release varies; on torques also for samples at corners of its axes.
#[must_use]
pub fn unreleased_of(samples: &Samples) -> Vec<String> {
    let Some(machine) = samples.study().machine().and_then(|subject| subject.def.build().ok()) else {
        return Vec::new();
    };
    if samples.parameters().is_empty() {
        return unreleased(&machine);
    }
    let varies = samples.parameters().iter().any(|varied| varied.info.path.contains(".release_"));
    let mut found = if varies { Vec::new() } else { releases(&machine) };
    let chosen = Chosen::new(samples, MOST_SAMPLES);
    let machines: Vec<Machine> = (0..chosen.count())
        .rev()
        .take(MOST_SAMPLES as usize)
        .filter_map(|at| chosen.machine(at).build().ok())
        .collect();
    let mut notes: Vec<(String, u64)> = Vec::new();
    for note in machines.iter().flat_map(torques::notes) {
        let subject = |note: &str| note.split(':').next().map(str::to_owned);
        match notes.iter_mut().find(|(other, _)| subject(other) == subject(&note)) {
            Some((_, count)) => *count += 1,
            None => notes.push((note, 1)),
        }
    }
    let all = machines.len() as u64;
    let shown = |(note, count): (String, u64)| {
        if count < all { format!("{note} (in {count} of {all} samples that were checked)") } else { note }
    };
    found.extend(notes.into_iter().map(shown));
    found
}

/// Adds the warning about a value, unless the list already contains it.
fn add(found: &mut Vec<Finding>, rule: &'static Rule, subject: &str, value: f64, beside: &str) {
    let finding = rule.judge(subject, value, beside);
    found.extend(finding.filter(|finding| !found.iter().any(|other| other.text == finding.text)));
}

/// A warning that belongs to no range.
fn alone(text: String) -> Finding {
    Finding { text, of: None }
}

/// Largest number of samples at corners of the varied parameters that are checked.
const MOST_SAMPLES: u64 = 32;

/// Warnings about a study's machine and about samples at corners of its axes: one for each quantity, with its range over the samples.
#[must_use]
pub fn implausible_of(samples: &Samples) -> Vec<String> {
    let Some(subject) = samples.study().machine() else { return Vec::new() };
    let of_machine = subject.def.build().map(|machine| findings(&machine)).unwrap_or_default();
    let text = |finding: &Finding| finding.text.clone();
    if samples.parameters().is_empty() {
        return of_machine.iter().map(text).collect();
    }
    let chosen = Chosen::new(samples, MOST_SAMPLES);
    let mut groups: Vec<Group> = Vec::new();
    let mut looked_at: Vec<String> = Vec::new();
    // the samples at corners come last
    for at in (0..chosen.count()).rev().take(MOST_SAMPLES as usize) {
        let Ok(machine) = chosen.machine(at).build() else { continue };
        let described = chosen.describe(at);
        // a small study has fewer samples than corners, so that a sample can occur twice
        if looked_at.contains(&described) {
            continue;
        }
        looked_at.push(described);
        let is_new = |finding: &Finding| !of_machine.iter().any(|of_machine| of_machine.text == finding.text);
        for finding in findings(&machine).into_iter().filter(is_new) {
            match groups.iter_mut().find(|group| group.worst.is_like(&finding)) {
                Some(group) => group.add(finding, at),
                None => groups.push(Group::of(finding, at)),
            }
        }
    }
    // a warning about the samples includes the machine's own value
    let is_alone = |finding: &&Finding| !groups.iter().any(|group| group.worst.is_like(finding));
    let mut found: Vec<String> = of_machine.iter().filter(is_alone).map(text).collect();
    found.extend(groups.iter().map(|group| group.text(looked_at.len(), &chosen.describe(group.at))));
    found
}

/// Warnings of several samples about the same quantity.
struct Group {
    /// The warning with the value furthest outside the plausible range, and its sample.
    worst: Finding,
    at: u64,
    samples: u64,
    range: [f64; 2],
}

impl Group {
    fn of(finding: Finding, at: u64) -> Self {
        let value = finding.of.as_ref().map_or(0.0, |(.., value)| *value);
        Self { worst: finding, at, samples: 1, range: [value; 2] }
    }

    fn add(&mut self, finding: Finding, at: u64) {
        self.samples += 1;
        let Some((_, rule, value)) = finding.of else { return };
        self.range = [self.range[0].min(value), self.range[1].max(value)];
        let is_worse = match &self.worst.of {
            Some((.., worst)) if value < rule.range[0] => value < *worst,
            Some((.., worst)) => value > *worst,
            None => false,
        };
        if is_worse {
            (self.worst, self.at) = (finding, at);
        }
    }

    /// The warning in words; `described`: the values of the worst sample.
    fn text(&self, looked_at: usize, described: &str) -> String {
        let of = format!("{} of {looked_at} samples that were checked", self.samples);
        match &self.worst.of {
            Some((subject, rule, _)) if self.range[0] < self.range[1] => {
                let [least, most] = self.range.map(|value| rule.shown(value));
                format!("{} (in {of}; worst with {described})", rule.text(subject, &format!("{least} to {most}")))
            }
            _ if self.samples > 1 => format!("{} (in {of}, one with {described})", self.worst.text),
            _ => format!("with {described}: {}", self.worst.text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    const RIG: &str = include_str!("../../studies/machines/lab_rig.toml");

    fn of(text: &str) -> Vec<String> {
        let machine = MachineDef::parse("m.toml", text).and_then(|def| def.build());
        implausible(&machine.unwrap_or_else(|problems| panic!("{problems}")))
    }

    #[test]
    fn shipped_machines_are_plausible() {
        for text in [
            RIG,
            include_str!("../../studies/machines/lp_turbine_paper.toml"),
            include_str!("../../studies/machines/gas_turbine.toml"),
        ] {
            assert_eq!(of(text), [] as [String; 0]);
        }
    }

    /// Unit errors, each with the beginning of its warning, which gives the value in the usual engineering unit.
    #[test]
    fn a_unit_slip_is_reported_with_its_value() {
        for (from, to, expected) in [
            (
                "young_modulus = \"210 GPa\"",
                "young_modulus = 210",
                "rotor.shaft[0]: Young's modulus 210 Pa, plausible is 1 GPa to 1000 GPa",
            ),
            ("young_modulus = \"200 GPa\"", "young_modulus = 200", "diaphragms.seal: Young's modulus 200 Pa"),
            ("young_modulus = \"200 GPa\"", "young_modulus = \"200 MPa\"", "diaphragms.seal: Young's modulus 200 MPa"),
            (
                "density = \"7850 kg/m3\"",
                "density = 7.85",
                "rotor.shaft[0]: density 7.85 kg/m3, plausible is 500 kg/m3 to 25000 kg/m3",
            ),
            (
                "polar_inertia = \"1.25e-3 kg m2\"",
                "polar_inertia = \"1.4e-3 kg m2\"",
                "rotor.discs.left: polar over transverse inertia 2.15 (0.0014 kg m2 over 6.5e-4 kg m2), plausible is at most 2",
            ),
            (
                "polar_inertia = \"1.25e-3 kg m2\"",
                "polar_inertia = \"2e-5 kg m2\"",
                "rotor.discs.left: polar over transverse inertia 0.0308 (2e-5 kg m2 over 6.5e-4 kg m2), plausible is at least 0.05",
            ),
            (
                "stiffness = \"2e6 N/m\"\n",
                "stiffness = \"2e6 N/m\"\nclearance = 0.3\n",
                "rotor.bearings.left: radial clearance 300 mm, plausible is 1 um to 5 mm",
            ),
            (
                "stiffness_proportional = \"2e-5 s\"",
                "stiffness_proportional = 0.02",
                "rotor.damping: damping ratio of the first bending mode by the shaft's stiffness-proportional damping ",
            ),
            ("friction = 0.15", "friction = 15", "diaphragms.seal: friction coefficient 15, plausible is at most 1.5"),
            ("radius = \"40 mm\"", "radius = 40", "rotor.unbalances.blade_off: radius of the unbalance 40 m"),
            ("gap = \"0.5 mm\"", "gap = 0.4e-6", "diaphragms.seal: gap "),
            ("damping = \"600 N s/m\"", "damping = 6e9", "rotor.bearings.left: damping 6e9 N s/m"),
            (
                "shear_coefficient = 0.9\n",
                "shear_coefficient = 0.9\nyield_strength = 250\n",
                "rotor.shaft[0]: yield strength 250 Pa",
            ),
            (
                "transverse_inertia = \"6.5e-4 kg m2\"",
                "transverse_inertia = 650",
                "rotor.discs.left: radius of gyration over the length of the shaft 25.5 (25.5 m of 1 m)",
            ),
            ("stiffness = \"2e6 N/m\"", "stiffness = 4", "rotor: sag under its weight "),
            ("stiffness = \"2e6 N/m\"", "stiffness = 4", "rotor: first bending frequency over running speed "),
            (
                "stiffness = \"2e6 N/m\"",
                "stiffness = \"2e10 N/mm\"",
                "rotor.bearings.left: stiffness 2e13 N/m, plausible is at most 1e12 N/m",
            ),
            (
                "width = \"10 mm\"\nelements = 16",
                "width = 1e6\nelements = 16",
                "diaphragms.seal: width over mean radius 1.92e7 (1e6 m of 52 mm)",
            ),
            ("initial_speed = \"3000 rpm\"", "initial_speed = \"3e5 rpm\"", "diaphragms.seal: surface speed 1570 m/s"),
            ("mass = \"10 g\"", "mass = 10", "rotor.unbalances.blade_off: mass over the rotor's mass "),
            (
                "width = \"10 mm\"\nelements = 1\n",
                "width = 5\nelements = 1\n",
                "diaphragms.seal: blade width over ring width 500 (5 m of 10 mm)",
            ),
        ] {
            assert!(RIG.contains(from), "{from}");
            let found = of(&RIG.replace(from, to));
            assert!(found.iter().any(|text| text.starts_with(expected)), "{to}: {found:?}");
        }
    }

    #[test]
    fn the_limits_themselves_are_plausible() {
        for ratio in ["1.3e-3 kg m2", "0 kg m2"] {
            assert_eq!(of(&RIG.replace("1.25e-3 kg m2", ratio)), [] as [String; 0], "{ratio}");
        }
        let quiet = MODULUS.judge("x", 1e9, "").or(MODULUS.judge("x", 1e12, ""));
        assert!(quiet.is_none(), "{quiet:?}");
        assert!(MODULUS.judge("x", 0.999e9, "").is_some() && MODULUS.judge("x", f64::NAN, "").is_some());
    }
}
