//! Bearings of a study's machines whose peak loads are not the machine's, whatever happens in a run. Rows do not tell; machines, modes and steps do.
//!
//! Samples with one structure, step and engine are one look. Of a study with more looks than are made, those are taken whose bearings are the stiffest and
//! the most damped, of each engine and number of modes: what is said is then of the worst, and that nothing is said holds for all.

use crate::engine;
use crate::report::{BearingNote, Beyond, bearings_beyond, matrices_of, with_word};
use bladeoff_core::structure::{Structure, same_structure};
use bladeoff_model::machine::{Machine, ParamValue};
use bladeoff_study::Samples;
use std::collections::BTreeMap;

/// Samples whose bearings are compared, at most.
const MOST_COMPARED: u64 = 20_000;
/// Structures that are built, at most.
const MOST_STRUCTURES: usize = 8;

/// What is said of one bearing.
#[derive(Debug)]
struct Said {
    /// Samples of which it is to be said.
    count: u64,
    /// The farthest beyond, and what varies in its sample.
    farthest: (BearingNote, String),
}

/// One line for each bearing and kind; none where there is nothing to say, or no machine.
#[must_use]
pub fn bearings_of(samples: &Samples) -> Vec<String> {
    let Some(first) = machine_of(samples, 0) else { return Vec::new() };
    let compared = if is_moved(samples, &first) { samples.count().min(MOST_COMPARED) } else { 1 };
    with_word(
        || format!("{}, to see what loads of its bearings lack", matrices_of(&first)),
        || look(samples, compared, if compared == 1 { 1 } else { samples.count() }),
    )
}

/// The machine of a sample; of an earlier build's study it may be none.
fn machine_of(samples: &Samples, sample: u64) -> Option<Machine> {
    samples.try_machine(sample).ok().flatten()?.build().ok()
}

/// Whether samples differ in structure, step or engine.
fn is_moved(samples: &Samples, first: &Machine) -> bool {
    let Some(base) = samples.try_machine(0).ok().flatten() else { return false };
    let moves = |(parameter, value): (&bladeoff_study::Parameter, &ParamValue)| {
        let mut other = base.clone();
        let other = other.set(&parameter.info, value).ok().and_then(|()| other.build().ok());
        // what is refused alone may be allowed beside other values
        other.is_none_or(|other| {
            !same_structure(&other, first)
                || (other.run.step, other.run.contact_step) != (first.run.step, first.run.contact_step)
        })
    };
    let values = samples.different_values(2);
    let parameters = samples.parameters().iter().zip(&values).filter(|(parameter, _)| !parameter.is_variable);
    parameters.flat_map(|(parameter, values)| values.iter().map(move |value| (parameter, value))).any(moves)
}

fn look(samples: &Samples, compared: u64, all: u64) -> Vec<String> {
    let mut looks = Looks::default();
    let order = worst_first(samples, compared, all);
    for &sample in &order {
        looks.at(samples, sample);
    }
    let Looks { said, looked, .. } = looks;
    let which = |said: &Said, shown: &str| match (all, looked == all) {
        (1, _) => String::new(),
        (_, true) if said.count == all => format!(" (in all {all} samples; most with {shown})"),
        (_, true) => format!(" (in {} of {all} samples; most with {shown})", said.count),
        (_, false) => {
            format!(" (worst of the {looked} samples with the stiffest and most damped bearings, of {all}: {shown})")
        }
    };
    said.values().map(|said| format!("{}{}", said.farthest.0.text, which(said, &said.farthest.1))).collect()
}

/// Samples by how stiff and how damped their bearings are, the first always the study's first: those of each engine and number of modes, each bearing, and
/// stiffness and damping in turn.
fn worst_first(samples: &Samples, compared: u64, all: u64) -> Vec<u64> {
    let mut lists: BTreeMap<(&str, Option<usize>, usize, bool), Vec<(f64, u64)>> = BTreeMap::new();
    for i in 0..compared {
        // evenly spread over those that are too many
        let sample = (u128::from(i) * u128::from(all) / u128::from(compared)) as u64;
        let Some(machine) = machine_of(samples, sample) else { continue };
        let run = &machine.run;
        let (step, contact_step) = (run.step.unwrap_or(1.0), run.contact_step.unwrap_or(1.0));
        for (place, bearing) in machine.rotor.bearings.iter().enumerate() {
            let largest =
                |matrix: &[[f64; 2]; 2]| matrix.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
            let keys = [largest(&bearing.stiffness) * contact_step * contact_step, largest(&bearing.damping) * step];
            for (kind, key) in keys.into_iter().enumerate() {
                lists.entry((run.engine.word(), run.rotor_modes, place, kind == 1)).or_default().push((key, sample));
            }
        }
    }
    let mut order = vec![0];
    lists.values_mut().for_each(|list| list.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1))));
    for rank in 0..compared as usize {
        order.extend(lists.values().filter_map(|list| list.get(rank)).map(|(_, sample)| *sample));
    }
    let mut seen = std::collections::HashSet::new();
    order.retain(|sample| seen.insert(*sample));
    order
}

/// What was seen so far.
#[derive(Debug, Default)]
struct Looks {
    structures: Vec<Structure>,
    /// Of a structure and a step.
    known: Vec<(usize, u64, Vec<BearingNote>)>,
    said: BTreeMap<(Beyond, String), Said>,
    looked: u64,
}

impl Looks {
    fn at(&mut self, samples: &Samples, sample: u64) {
        let Some(machine) = machine_of(samples, sample) else { return };
        let Some(at) = self.structure_of(&machine) else { return };
        let structure = &self.structures[at];
        let Ok(plan) = engine::step_plan(&machine, structure) else { return };
        self.looked += 1;
        let step = plan.step.to_bits();
        let place = self.known.iter().position(|(other, of, _)| (*other, *of) == (at, step)).unwrap_or_else(|| {
            self.known.push((at, step, bearings_beyond(&machine, structure, plan.step)));
            self.known.len() - 1
        });
        for note in &self.known[place].2 {
            let shown = || samples.describe(sample);
            let said = self.said.entry((note.beyond, note.bearing.clone()));
            let said = said.or_insert_with(|| Said { count: 0, farthest: (note.clone(), shown()) });
            said.count += 1;
            if note.far > said.farthest.0.far {
                said.farthest = (note.clone(), shown());
            }
        }
    }

    /// Where the structure of this machine is; `None`: it cannot be built, or there are enough.
    fn structure_of(&mut self, machine: &Machine) -> Option<usize> {
        if let Some(at) = self.structures.iter().position(|structure| structure.fits(machine)) {
            return Some(at);
        }
        if self.structures.len() == MOST_STRUCTURES {
            return None;
        }
        self.structures.push(engine::build(machine).ok()?);
        Some(self.structures.len() - 1)
    }
}
