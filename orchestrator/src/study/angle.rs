//! Whether a study leaves the release angle at one value where it decides the loads.

use super::Samples;
use bladeoff_core::machine::{DiaphragmKind, Machine};
use std::f64::consts::TAU;

/// Starts a cell that are proposed.
const STARTS: u32 = 6;

/// The release angle of a study that does not vary it although it matters.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedAngle {
    /// Path of the phase.
    pub path: String,
    /// Its value in every sample \[rad\].
    pub value: f64,
    /// What is not the same all round.
    pub because: Vec<String>,
    /// After this angle everything is as before \[rad\].
    pub period: f64,
}

/// What a study says nothing about: `None` where an angle varies, nothing is released, or machine and surroundings are the same all
/// round, so that the angle only turns the picture.
#[must_use]
pub fn fixed_angle(samples: &Samples) -> Option<FixedAngle> {
    // Phase of the unbalance, angle of the rotor at the start, angle of the stator.
    let varies = |path: &str| path.ends_with(".phase") || path.ends_with(".angle");
    if samples.count() == 0 || samples.parameters().any(|varied| varies(&varied.info.path)) {
        return None;
    }
    // The ends and the middle: where a parameter that varies takes the symmetry away, one of them has it.
    let machines = [0, samples.count() / 2, samples.count() - 1].map(|sample| samples.machine(sample).build());
    machines.iter().flatten().find_map(of_machine)
}

fn of_machine(machine: &Machine) -> Option<FixedAngle> {
    let unbalance = machine.rotor.unbalances.iter().find(|unbalance| unbalance.mass * unbalance.radius > 0.0)?;
    machine.diaphragms.first()?;
    let (mut because, mut order) = (Vec::new(), 0);
    // Everything is as before after a turn by the part of a circle that all of them share.
    let mut add = |what: String, turns: usize| {
        because.push(what);
        order = gcd(order, turns);
    };
    for diaphragm in &machine.diaphragms {
        if let DiaphragmKind::Flexible(stator) = &diaphragm.kind
            && let Some(blades) = &stator.blades
        {
            add(format!("the {} blades of diaphragm {}", blades.count, diaphragm.name), blades.count);
        }
        if diaphragm.contact.offset != [0.0, 0.0] {
            add(format!("the offset of diaphragm {}", diaphragm.name), 1);
        }
    }
    for bearing in &machine.rotor.bearings {
        if !(is_isotropic(&bearing.stiffness) && is_isotropic(&bearing.damping)) {
            add(format!("bearing {}", bearing.name), 2);
        }
    }
    if machine.rotor.gravity != [0.0, 0.0] {
        add("gravity".to_owned(), 1);
    }
    let path = format!("rotor.unbalances.{}.phase", unbalance.name);
    let period = TAU / order.max(1) as f64;
    (order > 0).then_some(FixedAngle { path, value: unbalance.phase, because, period })
}

/// Whether a 2 x 2 matrix is the same after any turn.
fn is_isotropic(m: &[[f64; 2]; 2]) -> bool {
    m[0][0] == m[1][1] && m[0][1] == -m[1][0]
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

impl FixedAngle {
    /// What it does to a study, and lines that vary it.
    #[must_use]
    pub fn text(&self) -> String {
        let degrees =
            |angle: f64| format!("{:.6}", angle.to_degrees()).trim_end_matches('0').trim_end_matches('.').to_owned();
        let last = self.period * f64::from(STARTS - 1) / f64::from(STARTS);
        let is = if self.because.len() == 1 && !self.because[0].contains("blades") { "is" } else { "are" };
        let lines = [
            format!("note: {} is {} deg in every sample.", self.path, degrees(self.value)),
            format!("{} {is} not the same all round, so this angle decides where", listed(&self.because)),
            "rotor and ring meet, and can move the loads by tens of per cent and reverse trends. Let it vary,"
                .to_owned(),
            "several starts a cell, and compare median and worst:".to_owned(),
            "  [[vary]]".to_owned(),
            format!("  path = \"{}\"", self.path),
            "  from = \"0 deg\"".to_owned(),
            format!("  to = \"{} deg\"", degrees(last)),
            format!("  count = {STARTS}"),
        ];
        lines.join("\n")
    }
}

/// "Gravity, bearing left and the 8 blades", with a capital.
fn listed(words: &[String]) -> String {
    let text = match words {
        [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => words.concat(),
    };
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::machine::MachineDef;

    fn rig(changes: &[(&str, &str)]) -> Machine {
        let text = include_str!("../../../studies/machines/lab_rig.toml");
        let text = changes.iter().fold(text.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1)
        });
        MachineDef::parse("lab_rig.toml", &text).and_then(|machine| machine.build()).expect("valid")
    }

    const FREE_RING: (&str, &str) = (
        "[diaphragms.seal.blades]\ncount = 8\nlength = \"40 mm\"\nthickness = \"1.5 mm\"\nwidth = \"10 mm\"\nelements = 1\n",
        "",
    );

    #[test]
    fn the_angle_matters_where_something_is_not_the_same_all_round() {
        let degrees = |machine: &Machine| of_machine(machine).map(|found| found.period.to_degrees().round());
        assert_eq!(degrees(&rig(&[])), Some(45.0), "eight blades");
        assert_eq!(degrees(&rig(&[FREE_RING])), None, "all round");
        let gravity = ("gravity = [0.0, 0.0]", "gravity = [0.0, \"-9.81 m/s2\"]");
        assert_eq!(degrees(&rig(&[FREE_RING, gravity])), Some(360.0));
        assert_eq!(degrees(&rig(&[gravity])), Some(360.0));
        let bearing = ("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 0.0], [0.0, 3e6]]");
        assert_eq!(degrees(&rig(&[FREE_RING, bearing])), Some(180.0));
        assert_eq!(degrees(&rig(&[bearing])), Some(180.0), "the largest part that both share");
        let circulating = ("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 1e5], [-1e5, 2e6]]");
        assert_eq!(degrees(&rig(&[FREE_RING, circulating])), None, "cross coupling alone is the same all round");
        let offset = ("offset = [\"0 mm\", \"0 mm\"]", "offset = [\"0.1 mm\", \"0 mm\"]");
        assert_eq!(degrees(&rig(&[FREE_RING, offset])), Some(360.0));
        assert_eq!(degrees(&rig(&[("mass = \"10 g\"", "mass = \"0 g\"")])), None, "nothing is released");
    }

    #[test]
    fn the_note_names_what_it_is_and_proposes_starts_within_the_period() {
        let text = of_machine(&rig(&[("phase = \"0 deg\"", "phase = \"30 deg\"")])).expect("it matters").text();
        for part in [
            "rotor.unbalances.blade_off.phase is 30 deg in every sample",
            "The 8 blades of diaphragm seal are not the same all round",
            "path = \"rotor.unbalances.blade_off.phase\"",
            "to = \"37.5 deg\"",
            "count = 6",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
