//! Combinations that no machine can have are found before anything runs.
//!
//! Every value was checked by itself when the study was read; here whole machines are built, because some checks
//! span several keys (an inner diameter and an outer one, a disc and the length of its shaft). Up to
//! [`CHECKED_COMBINATIONS`] samples: all of them. Beyond: every value of every axis with the other axes at their
//! first value, and every corner (all combinations of first and last values); what that misses fails in its sample.

use super::error::StudyError;
use super::samples::Samples;
use bladeoff_model::document::{Collector, Problem, Problems};
use bladeoff_model::machine::MachineDef;
use bladeoff_system::threads::in_parallel;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Up to this many samples every one is built.
pub const CHECKED_COMBINATIONS: u64 = 100_000;

/// Most axes whose corners are built: 2^12 machines.
const MOST_CORNER_AXES: usize = 12;

/// Combinations that fail in the same way.
struct Infeasible {
    problem: Problem,
    count: u64,
    first: u64,
}

/// Builds the machines of the study.
///
/// # Errors
/// Each way in which machines cannot be built, with the number of combinations and the first of them; threads that cannot be started.
pub fn check_machines(samples: &Samples) -> Result<(), StudyError> {
    let chosen = Chosen::new(samples);
    let all = samples.count() <= CHECKED_COMBINATIONS;
    let checked = if all { samples.count() } else { chosen.count() };
    let found = in_parallel(|| gather(checked, |at| if all { samples.machine(at) } else { chosen.machine(at) }))?;
    if found.is_empty() {
        return Ok(());
    }
    let describe = |at| if all { samples.describe(at) } else { chosen.describe(at) };
    Err(StudyError::Problems(vec![report(samples, checked, found, describe)]))
}

fn gather(count: u64, machine: impl Fn(u64) -> MachineDef + Sync) -> BTreeMap<(String, String), Infeasible> {
    let merge = |mut all: BTreeMap<(String, String), Infeasible>, other: BTreeMap<_, Infeasible>| {
        for (key, found) in other {
            match all.get_mut(&key) {
                None => drop(all.insert(key, found)),
                Some(known) => {
                    let count = known.count + found.count;
                    if found.first < known.first {
                        *known = found;
                    }
                    known.count = count;
                }
            }
        }
        all
    };
    (0..count)
        .into_par_iter()
        .filter_map(|at| machine(at).build().err().map(|problems| (at, problems)))
        .map(|(first, problems)| {
            let list = problems.list.into_iter().map(|problem| {
                let key = (problem.key.clone(), general(&problem.message));
                (key, Infeasible { problem, count: 1, first })
            });
            list.collect()
        })
        .reduce(BTreeMap::new, merge)
}

/// A message without its numbers, so that the same mistake at different values is one.
fn general(message: &str) -> String {
    message.chars().filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+')).collect()
}

fn report(
    samples: &Samples,
    total: u64,
    found: BTreeMap<(String, String), Infeasible>,
    describe: impl Fn(u64) -> String,
) -> Problems {
    let study = samples.study();
    let mut problems = Collector::new(&study.file, &study.text);
    for infeasible in found.into_values() {
        let varied = || study.axes.iter().flat_map(|axis| &axis.varied);
        let place = varied().find(|varied| varied.info.path == infeasible.problem.key).or_else(|| varied().next());
        let span = place.map_or(0..0, |varied| varied.place.clone());
        let message = if study.axes.is_empty() {
            format!("the machine cannot be built: {}", infeasible.problem.message)
        } else {
            format!(
                "{} of {total} {} a machine that cannot be built: {} (first: {})",
                infeasible.count,
                if infeasible.count == 1 { "combinations gives" } else { "combinations give" },
                infeasible.problem.message,
                describe(infeasible.first)
            )
        };
        let problem = problems.add(span, infeasible.problem.key, message);
        problem.value = infeasible.problem.value;
        problem.allowed = infeasible.problem.allowed;
        problem.nearest = infeasible.problem.nearest;
    }
    problems.finish().expect_err("called with at least one finding")
}

/// The refusal of one sample where the study gives the parameter its values, otherwise at its place in the machine file.
#[must_use]
pub fn at_its_axis(samples: &Samples, refused: Problems) -> Problems {
    let study = samples.study();
    let axis = |problem: &Problem| samples.parameters().find(|varied| varied.info.path == problem.key);
    let Some(varied) = refused.list.first().and_then(axis) else { return refused };
    let mut problems = Collector::new(&study.file, &study.text);
    for problem in &refused.list {
        let at = problems.add(varied.place.clone(), &*problem.key, &*problem.message);
        at.value.clone_from(&problem.value);
        at.allowed.clone_from(&problem.allowed);
    }
    problems.into_problems()
}

/// Combinations of a study too large to try all: every value of every axis with the other axes at their first, then the
/// corners. Like samples they are made from their number.
pub struct Chosen<'a> {
    samples: &'a Samples,
    /// Values of all axes together.
    edges: u64,
    /// Axes whose corners are made.
    cornered: usize,
}

impl<'a> Chosen<'a> {
    /// Those of this study.
    #[must_use]
    pub fn new(samples: &'a Samples) -> Self {
        let axes = &samples.study().axes;
        let edges = axes.iter().map(|axis| axis.length).sum();
        Self { samples, edges, cornered: axes.len().min(MOST_CORNER_AXES) }
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.edges + (1 << self.cornered)
    }

    fn positions(&self, at: u64) -> Vec<u64> {
        let axes = &self.samples.study().axes;
        let mut positions = vec![0; axes.len()];
        let mut left = at;
        for (position, axis) in positions.iter_mut().zip(axes) {
            if left < axis.length {
                *position = left;
                return positions;
            }
            left -= axis.length;
        }
        // The corner whose number has these bits.
        for (bit, (position, axis)) in positions.iter_mut().zip(axes).enumerate().take(self.cornered) {
            *position = (left >> bit & 1) * (axis.length - 1);
        }
        positions
    }

    /// The machine definition of one of them.
    #[must_use]
    pub fn machine(&self, at: u64) -> MachineDef {
        self.samples.machine_at(&self.positions(at))
    }

    /// What varies in it.
    #[must_use]
    pub fn describe(&self, at: u64) -> String {
        self.samples.describe_at(&self.positions(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load;
    use std::fs;

    #[test]
    fn chosen_are_every_value_of_every_axis_and_every_corner() {
        let folder = tempfile::tempdir().expect("temporary directory");
        fs::write(folder.path().join("m.toml"), include_str!("../../../studies/machines/lab_rig.toml"))
            .expect("written");
        let text = "schema = 1\nmachine = \"m.toml\"\n[[vary]]\npath = \"contact.gap\"\nvalues = [1e-3, 2e-3]\n\
                    [[vary]]\npath = \"contact.friction\"\nvalues = [0.1, 0.2, 0.3]\n";
        fs::write(folder.path().join("s.toml"), text).expect("written");
        let study = load(&folder.path().join("s.toml"), |_| Vec::new()).expect("valid");
        let samples = Samples::new(study, None, None).expect("small");
        let chosen = Chosen::new(&samples);
        let all: Vec<Vec<u64>> = (0..chosen.count()).map(|at| chosen.positions(at)).collect();
        assert_eq!(all, [[0, 0], [1, 0], [0, 0], [0, 1], [0, 2], [0, 0], [1, 0], [0, 2], [1, 2]]);
        assert!(chosen.describe(8).ends_with("contact.gap = 2 mm, diaphragms.seal.contact.friction = 0.3"));
        assert_eq!(chosen.machine(8).identity(), samples.machine(5).identity());
    }
}
