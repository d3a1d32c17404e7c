//! Warning about a release angle that is fixed in a study although it influences the loads.

use super::Samples;
use bladeoff_model::machine::{DiaphragmKind, Machine, ParamValue, Presence};
use std::f64::consts::TAU;

/// Number of release angles in the suggested axis.
const STARTS: u32 = 6;
/// Tolerance for equal angles, as a fraction of the period.
const ROUNDING: f64 = 1e-9;

/// The release angle of a study that does not vary it although the loads depend on it.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedAngle {
    /// Path of the phase.
    pub path: String,
    /// Its value in the first machine examined \[rad\].
    pub value: f64,
    /// Parts of the machine that are not rotationally symmetric.
    pub because: Vec<String>,
    /// Period of the loads in the release angle \[rad\].
    pub period: f64,
    /// An angle with several values that all differ by whole periods, and its period \[rad\].
    pub repeated: Option<(String, f64)>,
    /// Whether `[set]` gives the phase.
    pub is_set: bool,
}

/// The fixed release angle of a study. `None`: an angle varies, no unbalance is released, or machine and surroundings are rotationally
/// symmetric, so that the angle only rotates the results.
///
/// The release angle is measured against the parts without rotational symmetry. So it changes with the phase of the released unbalance and
/// with the angle of the rotor at the start; against the blades of a diaphragm also with the angle of that diaphragm (but not against
/// offset, bearings and gravity, which stay in place); against another unbalance also with the phase of that one.
#[must_use]
pub fn fixed_angle(samples: &Samples) -> Option<FixedAngle> {
    if samples.count() == 0 || samples.study().machine().is_none() {
        return None;
    }
    let varied = samples.parameters().iter().enumerate().filter(|(_, one)| one.is_angle());
    let angles: Vec<Angle<'_>> =
        varied.map(|(place, one)| Angle { path: &one.info.path, values: samples.all_or_some_values(place) }).collect();
    // First, middle and last sample: if a varied parameter breaks the symmetry, one of them has that value.
    let machines = [0, samples.count() / 2, samples.count() - 1].map(|sample| samples.machine(sample).build());
    let found = machines.iter().flatten().filter_map(|machine| of_machine(machine, &angles));
    let mut found = found.max_by(|a, b| a.period.total_cmp(&b.period))?;
    let machine = samples.study().machine()?;
    found.is_set = machine.fixed.iter().any(|fixed| fixed.info.path == found.path);
    Some(found)
}

/// An angle to which a study gives values.
struct Angle<'a> {
    path: &'a str,
    values: Vec<ParamValue>,
}

/// Whether some of these angles do not differ by whole periods.
fn differs(values: &[ParamValue], period: f64) -> bool {
    let turns = |value: &ParamValue| match value {
        ParamValue::Number(angle) => angle / period,
        ParamValue::Choice(_) => 0.0,
    };
    let first = turns(&values[0]);
    values[1..].iter().map(|value| turns(value) - first).any(|turns| (turns - turns.round()).abs() > ROUNDING)
}

/// Period of an angle of this machine, if two values of the angle give the same start; otherwise `None`.
pub(crate) fn period_between(machine: &Machine, path: &str, values: [f64; 2]) -> Option<f64> {
    let whole = (values[1] - values[0]) / TAU;
    if (whole - whole.round()).abs() <= ROUNDING {
        return Some(TAU);
    }
    let angle = Angle { path, values: values.map(ParamValue::Number).to_vec() };
    of_machine(machine, &[angle])?.repeated.filter(|(found, _)| found == path).map(|(_, period)| period)
}

fn of_machine(machine: &Machine, angles: &[Angle<'_>]) -> Option<FixedAngle> {
    let unbalances = machine.rotor.unbalances.iter().filter(|unbalance| unbalance.mass * unbalance.radius > 0.0);
    // The released unbalance, rather than one that was present before.
    let unbalance = unbalances.clone().min_by_key(|unbalance| unbalance.presence == Presence::Before)?;
    if machine.diaphragms.is_empty() {
        return None;
    }
    // Whether an angle has values that are not whole periods apart; an angle with several equivalent values is recorded.
    let mut repeated = None;
    let mut varies = |path: &str, period: f64| {
        let Some(angle) = angles.iter().find(|angle| angle.path == path) else { return false };
        let varies = differs(&angle.values, period);
        if !varies && angle.values.len() > 1 {
            repeated = Some((path.to_owned(), period));
        }
        varies
    };
    let part = |order: usize| (order > 0).then(|| TAU / order as f64);
    let (mut because, mut order) = (Vec::new(), 0);
    // The common period is that of the largest common rotational symmetry.
    let mut add = |what: String, turns: usize| {
        because.push(what);
        order = gcd(order, turns);
    };
    // Symmetry of everything around the rotor.
    let mut all_around = 0;
    for diaphragm in &machine.diaphragms {
        if let DiaphragmKind::Flexible(stator) = &diaphragm.kind
            && let Some(blades) = &stator.blades
        {
            all_around = gcd(all_around, blades.count);
            if !part(blades.count).is_some_and(|period| varies(&format!("diaphragms.{}.angle", diaphragm.name), period))
            {
                add(format!("the {} blades of diaphragm {}", blades.count, diaphragm.name), blades.count);
            }
        }
        if diaphragm.contact.offset != [0.0, 0.0] {
            all_around = 1;
            add(format!("the offset of diaphragm {}", diaphragm.name), 1);
        }
    }
    for bearing in &machine.rotor.bearings {
        let is_round = |[x, y]: [f64; 2]| x.to_bits() == y.to_bits();
        let pedestal = bearing.pedestal.as_ref();
        let pedestal_is_round =
            pedestal.is_none_or(|p| is_round(p.mass) && is_round(p.stiffness) && is_round(p.damping));
        if bearing.elevation != [0.0, 0.0] {
            all_around = 1;
            add(format!("the elevation of bearing {}", bearing.name), 1);
        }
        if !(is_isotropic(&bearing.stiffness) && is_isotropic(&bearing.damping) && pedestal_is_round) {
            all_around = gcd(all_around, 2);
            add(format!("bearing {}", bearing.name), 2);
        }
    }
    if machine.rotor.gravity != [0.0, 0.0] {
        all_around = 1;
        add("gravity".to_owned(), 1);
    }
    // The angle of the whole rotor at the start.
    if part(all_around).is_some_and(|period| varies("rotor.initial.angle", period)) {
        return None;
    }
    // The phase of one unbalance relative to the others: its period is a whole turn.
    for other in unbalances.filter(|other| other.name != unbalance.name) {
        if !varies(&format!("rotor.unbalances.{}.phase", other.name), TAU) {
            because.push(format!("unbalance {}", other.name));
            order = 1;
        }
    }
    let path = format!("rotor.unbalances.{}.phase", unbalance.name);
    let period = part(order)?;
    if varies(&path, period) {
        return None;
    }
    Some(FixedAngle { path, value: unbalance.phase, because, period, repeated, is_set: false })
}

/// Whether a 2 x 2 matrix is invariant under rotation.
fn is_isotropic(m: &[[f64; 2]; 2]) -> bool {
    m[0][0] == m[1][1] && m[0][1] == -m[1][0]
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

impl FixedAngle {
    /// The warning text, with lines of a study file that vary the angle.
    #[must_use]
    pub fn text(&self) -> String {
        let degrees =
            |angle: f64| format!("{:.6}", angle.to_degrees()).trim_end_matches('0').trim_end_matches('.').to_owned();
        let last = self.period * f64::from(STARTS - 1) / f64::from(STARTS);
        let is = if self.because.len() == 1 && !self.because[0].contains("blades") { "is" } else { "are" };
        let said = match &self.repeated {
            None => format!("note: {} is {} deg in every sample.", self.path, degrees(self.value)),
            Some((path, period)) => {
                format!(
                    "note: all values of {path} are the same angle: they differ by whole periods of {} deg.",
                    degrees(*period)
                )
            }
        };
        let instead = match &self.repeated {
            Some((path, _)) if *path == self.path => "; instead of the values there are",
            _ if self.is_set => "; instead of its line in [set]",
            _ => "",
        };
        let lines = [
            said,
            format!("{} {is} not the same all round, so this angle determines where", listed(&self.because)),
            "rotor and ring meet, and can change the loads by tens of per cent and reverse trends. Let it vary,"
                .to_owned(),
            format!("several starts a cell, and compare median and worst{instead}:"),
            "  [[vary]]".to_owned(),
            format!("  path = \"{}\"", self.path),
            "  from = \"0 deg\"".to_owned(),
            format!("  to = \"{} deg\"", degrees(last)),
            format!("  count = {STARTS}"),
        ];
        lines.join("\n")
    }
}

/// Joins words, starting with a capital: "Gravity, bearing left and the 8 blades".
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
    use bladeoff_model::machine::MachineDef;

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
        let degrees = |machine: &Machine| of_machine(machine, &[]).map(|found| found.period.to_degrees().round());
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

    const BEFORE: (&str, &str) = (
        "[rotor.unbalances.blade_off]",
        "[rotor.unbalances.a_residual]\nposition = \"0.6 m\"\nmass = \"1 g\"\nradius = \"40 mm\"\npresent = \"before\"\n\n\
         [rotor.unbalances.blade_off]",
    );

    #[test]
    fn against_another_unbalance_the_phase_takes_the_whole_turn() {
        let found = of_machine(&rig(&[BEFORE]), &[]).expect("it matters");
        assert_eq!((found.path.as_str(), found.period), ("rotor.unbalances.blade_off.phase", TAU));
        let text = found.text();
        for part in ["The 8 blades of diaphragm seal and unbalance a_residual are", "to = \"300 deg\"", "count = 6"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        let round = of_machine(&rig(&[FREE_RING, BEFORE]), &[]).expect("it matters");
        assert_eq!(round.period, TAU);
    }

    #[test]
    fn an_angle_counts_against_what_it_turns_against() {
        let degrees =
            |list: &[f64]| list.iter().map(|angle| ParamValue::Number(angle.to_radians())).collect::<Vec<_>>();
        // Reasons for the warning, the period, and the angle whose values repeat.
        let fixed = |changes: &[(&str, &str)], path: &str, values: &[f64]| {
            let values = degrees(values);
            let found = of_machine(&rig(changes), &[Angle { path, values }])?;
            let repeated = found.repeated.map(|(path, period)| (path, period.to_degrees().round()));
            Some((found.because.join(", "), found.period.to_degrees().round(), repeated))
        };
        let (seal, gravity) = ("diaphragms.seal.angle", ("gravity = [0.0, 0.0]", "gravity = [0.0, \"-9.81 m/s2\"]"));
        let blades = "the 8 blades of diaphragm seal".to_owned();
        // The angle of the diaphragm changes the position of its blades and nothing else.
        assert_eq!(fixed(&[], seal, &[0.0, 10.0]), None);
        assert_eq!(fixed(&[], seal, &[0.0, 45.0]), Some((blades.clone(), 45.0, Some((seal.to_owned(), 45.0)))));
        assert_eq!(fixed(&[gravity], seal, &[0.0, 10.0]), Some(("gravity".to_owned(), 360.0, None)));
        assert_eq!(fixed(&[FREE_RING, gravity], seal, &[0.0, 10.0]), Some(("gravity".to_owned(), 360.0, None)));
        let both = format!("{blades}, gravity");
        assert_eq!(fixed(&[gravity], seal, &[0.0, 45.0]), Some((both, 360.0, Some((seal.to_owned(), 45.0)))));
        // The angle of the rotor at the start counts against all parts.
        let initial = "rotor.initial.angle";
        assert_eq!(fixed(&[gravity], initial, &[0.0, 45.0]), None);
        assert_eq!(fixed(&[], initial, &[0.0, 45.0]), Some((blades.clone(), 45.0, Some((initial.to_owned(), 45.0)))));
        // The phase of another unbalance counts against that unbalance alone.
        let other = "rotor.unbalances.a_residual.phase";
        assert_eq!(fixed(&[FREE_RING, BEFORE], other, &[0.0, 45.0]), None);
        assert_eq!(fixed(&[BEFORE], other, &[0.0, 45.0]), Some((blades, 45.0, None)));
        let own = "rotor.unbalances.blade_off.phase";
        assert_eq!(fixed(&[BEFORE], own, &[0.0, 45.0]), None);
        assert!(fixed(&[], own, &[0.0, 45.0]).is_some_and(|(_, _, repeated)| repeated.is_some()));
    }

    #[test]
    fn angles_whole_periods_apart_are_the_same_angle() {
        let list =
            |degrees: &[f64]| degrees.iter().map(|angle| ParamValue::Number(angle.to_radians())).collect::<Vec<_>>();
        assert!(!differs(&list(&[0.0, 360.0]), TAU) && !differs(&list(&[10.0, 55.0, -35.0]), TAU / 8.0));
        assert!(differs(&list(&[0.0, 45.0]), TAU) && differs(&list(&[0.0, 45.0, 46.0]), TAU / 8.0));
        assert!(!differs(&list(&[7.0]), TAU));
    }

    #[test]
    fn the_note_names_what_it_is_and_proposes_starts_within_the_period() {
        let text = of_machine(&rig(&[("phase = \"0 deg\"", "phase = \"30 deg\"")]), &[]).expect("it matters").text();
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
