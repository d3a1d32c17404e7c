//! Notes on bearings whose peak loads are those of the discretisation, not of the machine. They depend on machines, modes and steps, not on rows.
//!
//! Samples that agree in these are checked once. If a study has more different samples than can be checked, extreme samples come first: the
//! stiffest and the most damped of each bearing, and the smallest and the largest value of each parameter that affects structure or step, by
//! engine and number of modes. Samples evenly between these extremes follow. The worst sample is therefore nearly always checked.

use crate::engine;
use crate::terminal::{BearingNote, Beyond, bearings_beyond, matrices_of, with_word};
use bladeoff_core::structure::{Structure, same_structure};
use bladeoff_model::machine::{DiaphragmKind, Engine, Machine, ParamValue};
use bladeoff_study::{Parameter, Samples};
use std::collections::{BTreeMap, HashSet};

/// Largest number of samples whose bearings and values are compared.
const MOST_COMPARED: u64 = 20_000;
/// Number of steps between two extremes, with one check each.
const SPREAD: usize = 16;
/// Largest number of checks, and of structures built for them; at least one structure for each extreme.
const MOST_LOOKS: usize = 64;
const STRUCTURES: std::ops::RangeInclusive<usize> = 16..=32;

/// One line for each bearing and kind of note; empty without notes, or without a machine. The modes are those chosen by this build.
#[must_use]
pub fn bearings_of(samples: &Samples) -> Vec<String> {
    let Some(first) = machine_of(samples, 0) else { return Vec::new() };
    let what = || format!("{}, to see what part of its bearing loads is missing", matrices_of(&first));
    with_word(what, || {
        let moving = moving(samples, &first);
        let all = if moving.is_empty() { 1 } else { samples.count() };
        look(samples, &moving, all)
    })
}

/// Machine of a sample; `None` if it cannot be built.
fn machine_of(samples: &Samples, sample: u64) -> Option<Machine> {
    samples.try_machine(sample).ok().flatten()?.build().ok()
}

/// Properties besides the structure that affect the steps and the mass at a bearing.
#[derive(Debug, Clone, PartialEq)]
struct Beside {
    steps: [Option<f64>; 2],
    /// Initial and prescribed speeds \[rad/s\].
    speeds: Vec<f64>,
    /// Nodes and signed masses \[kg\].
    unbalances: Vec<(usize, f64)>,
    /// Stiffness of the stators that are a spring \[N/m\].
    springs: Vec<f64>,
}

impl Beside {
    fn of(machine: &Machine) -> Self {
        let rotor = &machine.rotor;
        let law = rotor.speed_law.iter().flat_map(|law| law.speeds.iter().copied());
        Self {
            steps: [machine.run.step, machine.run.contact_step],
            speeds: std::iter::once(rotor.initial_speed).chain(law).collect(),
            unbalances: rotor.unbalances.iter().map(|unbalance| (unbalance.node, unbalance.signed_mass())).collect(),
            springs: machine
                .diaphragms
                .iter()
                .filter_map(|diaphragm| match diaphragm.kind {
                    DiaphragmKind::RadialSpring { stiffness } => Some(stiffness),
                    _ => None,
                })
                .collect(),
        }
    }
}

/// Indices of the parameters that affect structure, engine or step.
fn moving(samples: &Samples, first: &Machine) -> Vec<usize> {
    let Some(base) = samples.try_machine(0).ok().flatten() else { return Vec::new() };
    let beside = Beside::of(first);
    let moves = |parameter: &Parameter, value: &ParamValue| {
        let mut other = base.clone();
        let other = other.set(&parameter.info, value).ok().and_then(|()| other.build().ok());
        // a value that is invalid on its own may be valid with the values of another sample
        other.is_none_or(|other| !same_structure(&other, first) || Beside::of(&other) != beside)
    };
    let values = samples.different_values(2);
    let parameters = samples.parameters().iter().zip(&values).enumerate();
    let of_machine = parameters.filter(|(_, (parameter, _))| !parameter.is_variable);
    of_machine
        .filter(|(_, (parameter, values))| values.iter().any(|value| moves(parameter, value)))
        .map(|(place, _)| place)
        .collect()
}

fn look(samples: &Samples, moving: &[usize], all: u64) -> Vec<String> {
    let (order, ends) = ends_first(samples, moving, all);
    let most = ends.clamp(*STRUCTURES.start(), *STRUCTURES.end());
    let mut search = BearingSearch { most, ..BearingSearch::default() };
    order.iter().for_each(|&sample| search.at(samples, sample));
    let BearingSearch { said, looked, .. } = search;
    let which = |said: &Said| match (all, looked == all) {
        (1, _) => String::new(),
        (_, true) => format!(" (in {} of the study's {all} samples; most with {})", said.count, said.shown),
        (_, false) => format!(" (worst of {looked} samples that were checked, of {all}: {})", said.shown),
    };
    said.values().map(|said| format!("{}{}", said.note.text(), which(said))).collect()
}

/// Samples with the extreme ones first, and the number of extremes; the first sample of the study is always first.
fn ends_first(samples: &Samples, moving: &[usize], all: u64) -> (Vec<u64>, usize) {
    let compared = all.min(MOST_COMPARED);
    let mut lists: BTreeMap<(&str, Option<usize>, usize, usize), Vec<(f64, u64)>> = BTreeMap::new();
    for i in 0..compared {
        // evenly spread if there are too many
        let sample = (u128::from(i) * u128::from(all) / u128::from(compared)) as u64;
        let Some(machine) = machine_of(samples, sample) else { continue };
        let run = &machine.run;
        let mut add = |what: usize, place: usize, key: f64| {
            lists.entry((run.engine.word(), run.rotor_modes, what, place)).or_default().push((key, sample));
        };
        for (place, bearing) in machine.rotor.bearings.iter().enumerate() {
            let largest = |of: &[[f64; 2]; 2]| of.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
            let (k, c) = (largest(&bearing.stiffness), largest(&bearing.damping));
            add(0, place, k);
            add(1, place, c);
            match run.engine {
                Engine::Exponential => add(2, place, run.contact_step.map_or(k, |step| k * step * step)),
                Engine::Reduced | Engine::Full => add(2, place, run.step.map_or(c, |step| c * step)),
            }
        }
        let values = samples.values(sample);
        for &place in moving {
            if let ParamValue::Number(value) = values[place] {
                add(3, place, value);
                add(4, place, -value);
            }
        }
    }
    lists.values_mut().for_each(|list| list.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1))));
    let mut seen = HashSet::from([0]);
    let mut order = vec![0];
    // first the extremes, then samples evenly between them, then the rest
    let length = lists.values().map(Vec::len).max().unwrap_or(0);
    let between = (1..SPREAD).map(|part| part * length / SPREAD);
    for rank in std::iter::once(0).chain(between).chain(1..length) {
        let ranked = lists.values().filter_map(|list| list.get(rank)).map(|(_, sample)| *sample);
        order.extend(ranked.filter(|sample| seen.insert(*sample)));
    }
    (order, lists.len())
}

/// Note on one bearing.
#[derive(Debug)]
struct Said {
    /// Number of samples with this note.
    count: u64,
    /// The most severe note, with a step that is small enough for all of the samples.
    note: BearingNote,
    /// Values of the varied parameters in the sample of that note.
    shown: String,
}

/// Search for notes on bearings.
#[derive(Debug, Default)]
struct BearingSearch {
    /// Largest number of structures to build.
    most: usize,
    structures: Vec<Structure>,
    known: Vec<(usize, Beside, Vec<BearingNote>)>,
    said: BTreeMap<(Beyond, String), Said>,
    looked: u64,
}

impl BearingSearch {
    fn at(&mut self, samples: &Samples, sample: u64) {
        let Some(machine) = machine_of(samples, sample) else { return };
        let Some(place) = self.structure_of(&machine).and_then(|at| self.look_of(&machine, at)) else { return };
        self.looked += 1;
        for note in &self.known[place].2 {
            let shown = || samples.describe(sample);
            let said = self.said.entry((note.beyond, note.bearing.clone()));
            let said = said.or_insert_with(|| Said { count: 0, note: note.clone(), shown: shown() });
            said.count += 1;
            let step = said.note.step.min(note.step);
            if note.far > said.note.far {
                (said.note, said.shown) = (note.clone(), shown());
            }
            said.note.step = step;
        }
    }

    /// Index of the notes on this machine; `None` if it cannot start, or the largest number of checks is reached.
    fn look_of(&mut self, machine: &Machine, at: usize) -> Option<usize> {
        let beside = Beside::of(machine);
        if let Some(place) = self.known.iter().position(|(of, other, _)| *of == at && *other == beside) {
            return Some(place);
        }
        if self.known.len() == MOST_LOOKS {
            return None;
        }
        let step = engine::time_step(machine, &self.structures[at]).ok()?.step;
        self.known.push((at, beside, bearings_beyond(machine, &self.structures[at], step)));
        Some(self.known.len() - 1)
    }

    /// Index of the structure of this machine; `None` if it cannot be built, or the largest number of structures is reached.
    fn structure_of(&mut self, machine: &Machine) -> Option<usize> {
        if let Some(at) = self.structures.iter().position(|structure| structure.fits(machine)) {
            return Some(at);
        }
        if self.structures.len() == self.most {
            return None;
        }
        // equal rings are reused
        let built = match self.structures.last() {
            Some(last) => last.rebuilt(machine).ok()?,
            None => engine::build(machine).ok()?,
        };
        self.structures.push(built);
        Some(self.structures.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_study::load;
    use std::fs;

    fn said(text: &str) -> Vec<String> {
        let folder = tempfile::tempdir().expect("temporary directory");
        fs::write(folder.path().join("m.toml"), include_str!("../../../studies/machines/lab_rig.toml"))
            .expect("written");
        let file = folder.path().join("s.toml");
        fs::write(&file, format!("schema = 1\nmachine = \"m.toml\"\n{text}")).expect("written");
        bearings_of(&Samples::new(load(&file, |_| Vec::new()).expect("valid"), None, None).expect("small"))
    }

    /// A mass at the bearing determines whether the step resolves the damping; there is one structure.
    #[test]
    fn what_is_said_does_not_hang_on_the_order_of_values() {
        for masses in ["[\"1 g\", \"90 g\"]", "[\"90 g\", \"1 g\"]"] {
            let set = "\"run.engine\" = \"reduced\"\n\"run.step\" = \"3.4 us\"\n\"blade_off.position\" = 1.0\n\
                       \"right.damping\" = 8e4\n\"run.rotor_modes\" = 36";
            let vary = format!("[[vary]]\npath = \"blade_off.mass\"\nvalues = {masses}");
            let notes = said(&format!("[set]\n{set}\n{vary}\n"));
            let of = notes.iter().find(|note| note.contains("does not resolve")).expect("said");
            assert!(of.contains("(in 1 of the study's 2 samples; most with") && of.contains("mass = 1 g)"), "{of}");
        }
    }

    /// An extreme value is found among thousands of samples in any position; a note that no parameter affects has no count.
    #[test]
    fn the_worst_is_found_wherever_it_stands() {
        let set = "[set]\n\"run.engine\" = \"reduced\"\n";
        let vary = |path: &str, from: &str, to: &str, count: u32| {
            format!("[[vary]]\npath = \"{path}\"\nfrom = {from}\nto = {to}\ncount = {count}\n")
        };
        for (from, to) in [("10", "1e5"), ("1e5", "10")] {
            let notes = said(
                &(set.to_owned() + &vary("right.damping", from, to, 60) + &vary("contact.friction", "0.1", "0.3", 50)),
            );
            let held = notes.iter().find(|note| note.contains("holds the shaft")).expect("said");
            assert!(held.contains("checked, of 3000: ") && held.contains("right.damping = 1e5 N s/m"), "{held}");
        }
        let notes = said(&(format!("{set}\"right.damping\" = 1e5\n") + &vary("contact.friction", "0.1", "0.3", 50)));
        assert!(!notes.is_empty() && notes.iter().all(|note| !note.contains("samples")), "{notes:?}");
        assert_eq!(said(&(set.to_owned() + &vary("contact.friction", "0.1", "0.3", 50))), [] as [String; 0]);
    }
}
