//! Finds combinations that are not valid machines before any sample runs.
//!
//! Reading the study checks every value of `[[vary]]` alone. Here whole machines are built, because some checks span several keys (an inner
//! diameter and an outer one, a disc and the length of its shaft). Up to [`CHECKED_COMBINATIONS`] samples: all of them. Beyond: every value of
//! every axis with the other axes at their first value, and every corner (all combinations of first and last values). Of a design, the same
//! number of evenly spread points; all points if values are derived by formulas. A combination that this check misses fails in its sample.
//!
//! Uncertain and derived values are checked in every sample, whatever their number: a distribution is rejected earlier only if more than
//! 1e-12 of it is invalid, and values of formulas are not known in advance.

use super::axis::show;
use super::error::StudyError;
use super::parameter::Parameter;
use super::samples::Samples;
use bladeoff_model::machine::{MachineDef, ParamValue, ValueError};
use bladeoff_system::threads::in_parallel;
use bladeoff_text::document::{Collector, Problem, Problems};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Largest number of samples of which every machine is built.
pub const CHECKED_COMBINATIONS: u64 = 100_000;

/// Most axes whose corners are built: 2^12 machines.
const MOST_CORNER_AXES: usize = 12;

/// Combinations with the same problem.
struct Infeasible {
    problem: Problem,
    count: u64,
    first: u64,
}

/// Builds the machines of the study.
///
/// # Errors
/// Each kind of problem, with the number of combinations and the first of them; threads that cannot be started.
pub fn check_machines(samples: &Samples) -> Result<(), StudyError> {
    if samples.study().machine().is_none() {
        return Ok(());
    }
    check_releases(samples)?;
    check_values(samples)?;
    let derives = samples.study().sampled.values.derives();
    let chosen = Chosen::new(samples, CHECKED_COMBINATIONS);
    let all = samples.count() <= CHECKED_COMBINATIONS || derives && samples.layout().is_some();
    let checked = if all { samples.count() } else { chosen.count() };
    let found = in_parallel(|| gather(checked, |at| if all { samples.machine(at) } else { chosen.machine(at) }))?;
    if found.is_empty() {
        return Ok(());
    }
    let describe = |at| if all { samples.describe(at) } else { chosen.describe(at) };
    Err(StudyError::Problems(vec![report(samples, checked, found, describe)]))
}

/// Rejects a parameter that releases an unbalance which the study's machine does not release: all samples have the columns of that machine.
fn check_releases(samples: &Samples) -> Result<(), StudyError> {
    let study = samples.study();
    let Some(machine) = study.machine().and_then(|machine| machine.def.build().ok()) else { return Ok(()) };
    let mut problems = Collector::new(&study.file, &study.text);
    for parameter in samples.parameters() {
        let path = &*parameter.info.path;
        let named = path.strip_prefix("rotor.unbalances.").and_then(|below| below.split_once(".release_"));
        let Some((name, key)) = named else { continue };
        if machine.rotor.unbalances.iter().any(|one| one.name == name && one.release.is_none()) {
            let message = "the machine of the study has no release of this unbalance";
            let problem = problems.add(parameter.place.clone(), path, message);
            problem.allowed = Some(format!("a value of release_{key} in the machine file, or in [set]"));
        }
    }
    problems.finish().map_err(|problems| StudyError::Problems(vec![problems]))
}

/// Samples with the same problem in the value of a parameter: number, first sample, its value there.
type Wrong = BTreeMap<(usize, &'static str), (u64, u64, ParamValue)>;

/// Rejects drawn and derived values that their parameters do not allow.
fn check_values(samples: &Samples) -> Result<(), StudyError> {
    let study = samples.study();
    let Some(machine) = study.machine() else { return Ok(()) };
    let own: Vec<(usize, &Parameter)> =
        samples.parameters().iter().enumerate().filter(|(_, one)| one.is_own()).collect();
    if own.is_empty() {
        return Ok(());
    }
    let refusal = |parameter: &Parameter, value: &ParamValue| match value {
        ParamValue::Number(number) if !number.is_finite() => Some("not a finite number"),
        _ if parameter.is_variable => None,
        value => machine.def.check_value(&parameter.info, value).err().map(|error| match error {
            ValueError::NotWhole { .. } => "not a whole number",
            _ => "out of range",
        }),
    };
    let look = |mut wrong: Wrong, sample: u64| {
        let values = samples.values(sample);
        for &(place, parameter) in &own {
            if let Some(what) = refusal(parameter, &values[place]) {
                count_first(&mut wrong, (place, what), (1, sample, values[place].clone()));
            }
        }
        wrong
    };
    let both = |mut wrong: Wrong, other: Wrong| {
        other.into_iter().for_each(|(key, found)| count_first(&mut wrong, key, found));
        wrong
    };
    let found = in_parallel(|| (0..samples.count()).into_par_iter().fold(Wrong::new, look).reduce(Wrong::new, both))?;
    if found.is_empty() {
        return Ok(());
    }
    let mut problems = Collector::new(&study.file, &study.text);
    for ((place, what), (count, first, value)) in found {
        let parameter = &samples.parameters()[place];
        let message = format!("{what} in {count} of {} samples (first: {})", samples.count(), samples.describe(first));
        let problem = problems.add(parameter.place.clone(), &*parameter.info.path, message);
        problem.value = Some(show(&parameter.info, &value));
        problem.allowed = Some(parameter.info.allowed.clone());
    }
    Err(StudyError::Problems(vec![problems.into_problems()]))
}

/// Counts a finding and keeps its first sample.
fn count_first(wrong: &mut Wrong, key: (usize, &'static str), found: (u64, u64, ParamValue)) {
    match wrong.get_mut(&key) {
        None => drop(wrong.insert(key, found)),
        Some(known) => {
            let count = known.0 + found.0;
            if found.1 < known.1 {
                *known = found;
            }
            known.0 = count;
        }
    }
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

/// A message without its numbers, so that the same mistake with different values counts as one.
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
        let all = samples.parameters();
        let first = || all.first().map(|parameter| parameter.place.clone());
        let span = study.place_of(&infeasible.problem.key).or_else(first).unwrap_or(0..0);
        let message = if all.is_empty() {
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

/// The problems of one sample, at the position where the study gives the parameter its values, otherwise in the machine file.
#[must_use]
pub fn at_its_axis(samples: &Samples, refused: Problems) -> Problems {
    let study = samples.study();
    let Some(place) = refused.list.first().and_then(|problem| study.place_of(&problem.key)) else { return refused };
    let mut problems = Collector::new(&study.file, &study.text);
    for problem in &refused.list {
        let at = problems.add(place.clone(), &*problem.key, &*problem.message);
        at.value.clone_from(&problem.value);
        at.allowed.clone_from(&problem.allowed);
    }
    problems.into_problems()
}

/// Combinations to be checked in a study that is too large to check all. First, for a design, evenly spread samples; then every value of every
/// axis with the other axes at their first value; then the corners. The combinations of a design use its points in turn. Like samples, they
/// are generated from their number.
pub struct Chosen<'a> {
    samples: &'a Samples,
    /// Number of values of all axes together.
    edges: u64,
    /// Number of axes with corners.
    cornered: usize,
    /// Number of evenly spread samples of a design; 0 without a design.
    spread: u64,
}

impl<'a> Chosen<'a> {
    /// The combinations of this study; at most `most` evenly spread samples of a design.
    #[must_use]
    pub fn new(samples: &'a Samples, most: u64) -> Self {
        let axes = &samples.study().axes;
        let edges = axes.iter().map(|axis| axis.length).sum();
        let spread = samples.layout().map_or(0, |_| most.min(samples.count()));
        Self { samples, edges, cornered: axes.len().min(MOST_CORNER_AXES), spread }
    }

    /// Number of combinations.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.spread + self.combinations()
    }

    /// Number of values of all axes plus corners; none without axes.
    fn combinations(&self) -> u64 {
        if self.edges == 0 && self.spread > 0 { 0 } else { self.edges + (1 << self.cornered) }
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

    fn values(&self, at: u64) -> Vec<ParamValue> {
        let Some(combination) = at.checked_sub(self.spread) else {
            let sample = u128::from(at) * u128::from(self.samples.count()) / u128::from(self.spread);
            return self.samples.values(u64::try_from(sample).expect("below the number of samples"));
        };
        let positions = self.positions(combination);
        if self.spread == 0 {
            return self.samples.values_at(0, &positions);
        }
        let (points, combinations) = (self.samples.points(), self.combinations());
        let point = u128::from(combination) * u128::from(points) / u128::from(combinations);
        self.samples.values_at(u64::try_from(point).expect("below the number of points"), &positions)
    }

    /// Machine definition of a combination, in a study with a machine and checked values.
    ///
    /// # Panics
    /// The study has no machine.
    #[must_use]
    pub fn machine(&self, at: u64) -> MachineDef {
        let machine = self.samples.with_values(&self.values(at)).expect("every value was checked");
        machine.expect("asked of a study with a machine only")
    }

    /// Description of the varied values of a combination.
    #[must_use]
    pub fn describe(&self, at: u64) -> String {
        self.samples.describe_values(&self.values(at))
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
        let chosen = Chosen::new(&samples, 100);
        let all: Vec<Vec<u64>> = (0..chosen.count()).map(|at| chosen.positions(at)).collect();
        assert_eq!(all, [[0, 0], [1, 0], [0, 0], [0, 1], [0, 2], [0, 0], [1, 0], [0, 2], [1, 2]]);
        assert!(chosen.describe(8).ends_with("contact.gap = 2 mm, diaphragms.seal.contact.friction = 0.3"));
        assert_eq!(chosen.machine(8).identity(1), samples.machine(5).identity(1));
    }

    /// All values of each axis are checked in a design, too, whatever the number of evenly spread samples.
    #[test]
    fn chosen_of_a_design_are_spread_and_every_value_of_every_axis() {
        let folder = tempfile::tempdir().expect("temporary directory");
        fs::write(folder.path().join("m.toml"), include_str!("../../../studies/machines/lab_rig.toml"))
            .expect("written");
        let text = "schema = 1\nmachine = \"m.toml\"\n[design]\nkind = \"monte-carlo\"\nsamples = 4\n[[uncertain]]\npath = \"contact.gap\"\n\
                    distribution = \"uniform\"\nlower = 1e-3\nupper = 2e-3\n[[vary]]\npath = \"contact.friction\"\nvalues = [0.1, 0.2, 0.3, 0.4]\n";
        fs::write(folder.path().join("s.toml"), text).expect("written");
        let study = load(&folder.path().join("s.toml"), |_| Vec::new()).expect("valid");
        let samples = Samples::new(study, None, None).expect("small");
        let chosen = Chosen::new(&samples, 3);
        // three evenly spread samples, four values, two corners
        assert_eq!(chosen.count(), 9);
        let described: Vec<String> = (3..9).map(|at| chosen.describe(at)).collect();
        let friction: Vec<&str> = described.iter().filter_map(|text| text.rsplit(" = ").next()).collect();
        assert_eq!(friction, ["0.1", "0.2", "0.3", "0.4", "0.1", "0.4"], "{described:?}");
        // each combination is a sample of the study
        let all: Vec<u128> = (0..samples.count()).map(|sample| samples.machine(sample).identity(1)).collect();
        assert!((0..9).all(|at| all.contains(&chosen.machine(at).identity(1))), "{described:?}");
    }
}
