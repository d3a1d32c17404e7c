//! Limits of the physical model before any run: value, origin and reference of each limit, or the key that is missing if it is not judged.
//!
//! ```text
//! value in words = value * reference (value of NAME), where all references are known; "varies" where samples differ
//! ```

use bladeoff_answers::summary::{Align, TextTable, wrapped};
use bladeoff_model::machine::{DiaphragmKind, Machine, MachineDef, ModelLimit, OnExceed, RotorKind};
use bladeoff_model::outcome::Limit;
use bladeoff_study::Samples;
use bladeoff_text::document::units::format_digits;

/// One limit of a machine, or of the machines of a study.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LimitValue {
    /// The limit, as the first sample has it.
    pub limit: ModelLimit,
    /// The value and its reference in words.
    pub value: String,
    /// Origin of the value.
    pub origin: &'static str,
    /// Whether the status of a run above the limit differs between samples.
    pub varies: bool,
    /// Part or key that the machine does not have and without which the limit is not judged.
    pub lacks: Option<&'static str>,
}

impl LimitValue {
    /// Name of the limit.
    pub fn name(&self) -> &'static str {
        self.limit.limit.word()
    }

    /// Whether the limit compares a stress that the machine has with a yield strength that is not given.
    fn lacks_strength(&self) -> bool {
        self.lacks.is_some_and(|needed| needed.contains("yield_strength"))
    }

    /// Status of a run above the limit.
    pub fn exceeded(&self) -> &'static str {
        match self.limit.on_exceed {
            _ if self.varies => "varies",
            OnExceed::Beyond => "beyond",
            OnExceed::Note => "note",
        }
    }
}

/// Words for a limit that is not judged: "not judged: no KEY".
pub(super) fn not_judged(key: &str) -> String {
    format!("not judged: no {}", key.strip_prefix("a ").unwrap_or(key))
}

/// Column of the stress that a limit compares with a yield strength, and the part that has this stress.
pub(super) fn stress(limit: Limit) -> Option<(&'static str, &'static str)> {
    match limit {
        Limit::RingYield => Some(("max_ring_stress_Pa", "ring")),
        Limit::BladeYield => Some(("max_blade_stress_Pa", "blades")),
        Limit::ShaftYield => Some(("max_shaft_von_mises_Pa", "shaft")),
        Limit::RingDisplacement | Limit::JournalClearance | Limit::UnstableRotor => None,
    }
}

/// The warning that stresses of these parts are not compared with a yield strength; `None` if `parts` is empty.
pub(super) fn unjudged_stresses(parts: &[&str]) -> Option<String> {
    let parts = match parts {
        [] => return None,
        [one] => (*one).to_owned(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    };
    Some(format!(
        "stresses of {parts} are not judged, because no yield_strength is given: status ok does not mean that they are elastic"
    ))
}

/// The limits of the first sample of a study; `None` for a study of formulas.
pub(super) fn of_study(samples: &Samples) -> Option<Vec<LimitValue>> {
    let definition = samples.try_machine(0).ok().flatten()?;
    let machine = definition.build().ok()?;
    let varied: Vec<&str> = samples.parameters().iter().map(|varied| varied.info.path.as_str()).collect();
    Some(of_machine(&definition, &machine, &varied))
}

/// The limits of a machine; `varied`: the paths that differ between samples.
fn of_machine(definition: &MachineDef, machine: &Machine, varied: &[&str]) -> Vec<LimitValue> {
    let of = |limit: ModelLimit| {
        let path = format!("run.limit.{}.value", limit.limit.word());
        let reference = reference(machine, limit.limit);
        let is_reference = |path: &&str| reference.as_ref().is_some_and(|of| of.is_at(path));
        let (value, origin) = if varied.contains(&path.as_str()) {
            ("varies".to_owned(), "study")
        } else if varied.iter().any(is_reference) {
            let name = reference.as_ref().map_or("", |of| of.name);
            (format!("varies ({} of {name})", format_digits(limit.value, "", 4)), "study")
        } else {
            let is_default = definition.resolve(&path).is_ok_and(|info| info.default);
            (in_words(limit.value, reference.as_ref()), if is_default { "default" } else { "machine or study file" })
        };
        let varies = varied.contains(&format!("run.limit.{}.on_exceed", limit.limit.word()).as_str());
        LimitValue { limit, value, origin, varies, lacks: machine.lacks(limit.limit) }
    };
    machine.run.limits.into_iter().map(of).collect()
}

/// The quantity by which the value of a limit is multiplied.
struct Reference {
    name: &'static str,
    unit: &'static str,
    /// Beginning and end of the paths of its keys.
    path: (&'static str, &'static str),
    values: Vec<f64>,
    /// Number of the parts that may have a value, and the name of these parts.
    parts: (usize, &'static str),
}

impl Reference {
    fn is_at(&self, path: &str) -> bool {
        path.starts_with(self.path.0) && path.ends_with(self.path.1)
    }
}

/// A limit in words: "40 mm (0.05 of mean radius)"; "600 MPa" for the yield strength itself.
fn in_words(value: f64, reference: Option<&Reference>) -> String {
    let plain = format_digits(value, "", 4);
    let Some(Reference { name, unit, values, parts: (all, parts), .. }) = reference.filter(|of| !of.values.is_empty())
    else {
        return plain;
    };
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let show = |of: f64| format_digits(value * of, unit, 4);
    let range = if least == most { show(least) } else { format!("{} to {}", show(least), show(most)) };
    let words = if value == 1.0 { range } else { format!("{range} ({plain} of {name})") };
    // for parts without a value the limit is not judged
    if values.len() < *all { format!("{words}, for {} of {all} {parts}", values.len()) } else { words }
}

/// The reference of a limit; `None` if the limit is an absolute value.
fn reference(machine: &Machine, limit: Limit) -> Option<Reference> {
    let rings = || {
        machine.diaphragms.iter().filter_map(|diaphragm| match &diaphragm.kind {
            DiaphragmKind::Flexible(stator) => Some(stator),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
        })
    };
    const STRENGTH: (&str, &str) = ("diaphragms.", ".yield_strength");
    let (name, unit, path, values, parts): (_, _, _, Vec<f64>, _) = match limit {
        Limit::RingDisplacement => {
            let path = ("diaphragms.", ".ring.mean_radius");
            let values = rings().map(|stator| stator.ring.mean_radius);
            ("mean radius", "m", path, values.collect(), (rings().count(), "rings"))
        }
        Limit::RingYield => {
            let values = rings().filter_map(|stator| stator.yield_strength);
            ("yield strength", "Pa", STRENGTH, values.collect(), (rings().count(), "rings"))
        }
        Limit::BladeYield => {
            let bladed = || rings().filter(|stator| stator.blades.is_some());
            let values = bladed().filter_map(|stator| stator.yield_strength);
            ("yield strength", "Pa", STRENGTH, values.collect(), (bladed().count(), "bladed rings"))
        }
        Limit::ShaftYield => match &machine.rotor.kind {
            RotorKind::Shaft(shaft) => {
                let values = shaft.elements.iter().filter_map(|element| element.yield_strength);
                let parts = (shaft.elements.len(), "shaft elements");
                ("yield strength", "Pa", ("rotor.", ".yield_strength"), values.collect(), parts)
            }
            RotorKind::PointMass(_) => return None,
        },
        Limit::JournalClearance => {
            let values = machine.rotor.bearings.iter().filter_map(|bearing| bearing.clearance);
            let parts = (machine.rotor.bearings.len(), "bearings");
            ("clearance", "m", ("rotor.bearings.", ".clearance"), values.collect(), parts)
        }
        Limit::UnstableRotor => return None,
    };
    Some(Reference { name, unit, path, values, parts })
}

/// The table of limits of a study before it runs; empty for a study of formulas.
#[must_use]
pub fn limits_of(samples: &Samples, width: Option<usize>) -> String {
    of_study(samples).map_or_else(String::new, |all| table(&all, width))
}

/// The table of limits of a machine.
#[must_use]
pub fn limits_of_machine(definition: &MachineDef, machine: &Machine, width: Option<usize>) -> String {
    table(&of_machine(definition, machine, &[]), width)
}

fn table(all: &[LimitValue], width: Option<usize>) -> String {
    let mut table = TextTable::new(&["limit", "value", "set by", "if exceeded"].map(|head| (head, Align::Left)));
    for of in all.iter().filter(|of| of.lacks.is_none()) {
        table.row(vec![of.name().to_owned(), of.value.clone(), of.origin.to_owned(), of.exceeded().to_owned()]);
    }
    let mut text = format!("\nLimits of the model:\n{}", table.fitting("  ", width));
    let wide = width.unwrap_or(usize::MAX);
    for of in all {
        if let Some(key) = of.lacks {
            text += &wrapped(&format!("{}: {}", of.name(), not_judged(key)), wide, "  ", "    ");
        }
    }
    let parts: Vec<&str> =
        all.iter().filter(|of| of.lacks_strength()).filter_map(|of| Some(stress(of.limit.limit)?.1)).collect();
    if let Some(warning) = unjudged_stresses(&parts) {
        text += &wrapped(&format!("warning: {warning}"), wide, "  ", "    ");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURBINE: &str = include_str!("../../../studies/machines/lp_turbine_paper.toml");

    fn values(text: &str, varied: &[&str]) -> Vec<LimitValue> {
        let definition = MachineDef::parse("m.toml", text).expect("valid");
        let machine = definition.build().expect("valid");
        of_machine(&definition, &machine, varied)
    }

    #[test]
    fn a_value_is_a_stress_or_a_length_and_varies_with_its_reference() {
        let strong = TURBINE.replace("[rotor.material]", "[rotor.material]\nyield_strength = \"600 MPa\"");
        assert_ne!(strong, TURBINE);
        let of = |text: &str, varied: &[&str], limit: Limit| {
            values(text, varied).into_iter().find(|of| of.limit.limit == limit).expect("all are there").value
        };
        assert_eq!(of(&strong, &[], Limit::ShaftYield), "600 MPa");
        let one = TURBINE.replacen("[rotor.bearings.front]", "[rotor.bearings.front]\nclearance = \"0.3 mm\"", 1);
        assert_eq!(of(&one, &[], Limit::JournalClearance), "0.3 mm, for 1 of 2 bearings");
        assert!(of(TURBINE, &[], Limit::RingDisplacement).ends_with("mm (0.05 of mean radius)"));
        let own = ["rotor.material.yield_strength"];
        assert_eq!(of(&strong, &own, Limit::ShaftYield), "varies (1 of yield strength)");
        assert_eq!(of(&strong, &["run.limit.shaft_yield.value"], Limit::ShaftYield), "varies");
        assert_eq!(of(&strong, &["diaphragms.mid.material.yield_strength"], Limit::ShaftYield), "600 MPa");
    }

    #[test]
    fn the_table_names_keys_and_unjudged_stresses() {
        let text = table(&values(TURBINE, &[]), None);
        assert!(text.contains("  shaft_yield: not judged: no rotor.material.yield_strength"), "{text}");
        assert!(text.contains("warning: stresses of ring, blades and shaft are not judged"), "{text}");
        assert!(unjudged_stresses(&[]).is_none());
        let one = unjudged_stresses(&["shaft"]).expect("one part");
        assert!(one.starts_with("stresses of shaft are not judged"), "{one}");
        // a part that the machine does not have has no stress
        let point = "schema = 1\nname = \"p\"\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\ninitial_speed = 100\n\
            [rotor.bearings.a]\nstiffness = 4e4\n[run]\nend_time = 1\n";
        let text = table(&values(point, &[]), None);
        assert!(text.contains("  shaft_yield: not judged: no shaft\n") && !text.contains("warning"), "{text}");
    }
}
