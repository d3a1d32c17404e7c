//! Combinations that no machine can have are found before anything runs.
//!
//! Every value was checked by itself when the study was read; here whole machines are built, because some checks
//! span several keys (an inner diameter and an outer one, a disc and the length of its shaft). Up to
//! [`CHECKED_COMBINATIONS`] samples: all of them. Beyond: every value of every axis with the other axes at their
//! first value, and every corner (all combinations of first and last values); what that misses fails in its sample.

use super::axis::show;
use super::{Samples, StudyError};
use bladeoff_core::document::{Collector, Problem, Problems};
use bladeoff_core::machine::MachineDef;
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
    shown: String,
}

/// Builds the machines of the study.
///
/// # Errors
/// Each way in which machines cannot be built, with the number of combinations and the first of them.
pub fn check_machines(samples: &Samples) -> Result<(), StudyError> {
    let (checked, found) = if samples.count() <= CHECKED_COMBINATIONS {
        let count = samples.count();
        (
            count,
            gather(
                (0..count).into_par_iter().map(|sample| (sample, samples.machine(sample), samples.describe(sample))),
            ),
        )
    } else {
        let machines = corners_and_edges(samples);
        let count = machines.len() as u64;
        let numbered = machines.into_par_iter().enumerate();
        (count, gather(numbered.map(|(at, (machine, shown))| (at as u64, machine, shown))))
    };
    if found.is_empty() {
        return Ok(());
    }
    Err(StudyError::Problems(vec![report(samples, checked, found)]))
}

fn gather(machines: impl ParallelIterator<Item = (u64, MachineDef, String)>) -> BTreeMap<(String, String), Infeasible> {
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
    machines
        .filter_map(|(at, machine, shown)| machine.build().err().map(|problems| (at, shown, problems)))
        .map(|(first, shown, problems)| {
            let list = problems.list.into_iter().map(|problem| {
                let key = (problem.key.clone(), general(&problem.message));
                (key, Infeasible { problem, count: 1, first, shown: shown.clone() })
            });
            list.collect()
        })
        .reduce(BTreeMap::new, merge)
}

/// A message without its numbers, so that the same mistake at different values is one.
fn general(message: &str) -> String {
    message.chars().filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+')).collect()
}

fn report(samples: &Samples, total: u64, found: BTreeMap<(String, String), Infeasible>) -> Problems {
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
                "{} of {total} combinations give a machine that cannot be built: {} (first: {})",
                infeasible.count, infeasible.problem.message, infeasible.shown
            )
        };
        let problem = problems.add(span, infeasible.problem.key, message);
        problem.value = infeasible.problem.value;
        problem.allowed = infeasible.problem.allowed;
        problem.nearest = infeasible.problem.nearest;
    }
    problems.finish().expect_err("called with at least one finding")
}

/// Machines at every value of every axis, the other axes at their first, and at the corners; and what varies in each.
pub(super) fn corners_and_edges(samples: &Samples) -> Vec<(MachineDef, String)> {
    let axes = &samples.study().axes;
    let mut positions: Vec<Vec<u64>> = Vec::new();
    for (at, axis) in axes.iter().enumerate() {
        positions.extend((0..axis.length).map(|position| {
            let mut one = vec![0; axes.len()];
            one[at] = position;
            one
        }));
    }
    let cornered = axes.len().min(MOST_CORNER_AXES);
    positions.extend((0..1u32 << cornered).map(|corner| {
        let end = |(at, axis): (usize, &super::Axis)| if corner >> at & 1 == 1 { axis.length - 1 } else { 0 };
        axes.iter().enumerate().map(|(at, axis)| if at < cornered { end((at, axis)) } else { 0 }).collect()
    }));
    let machine = |positions: Vec<u64>| {
        let mut machine = samples.study().machine.clone();
        let mut shown = Vec::new();
        for (axis, position) in axes.iter().zip(positions) {
            for varied in &axis.varied {
                let value = varied.values.at(position);
                shown.push(format!("{} = {}", varied.info.path, show(&varied.info, &value)));
                machine.set(&varied.info, &value).expect("type and range were checked when the study was read");
            }
        }
        (machine, shown.join(", "))
    };
    positions.into_iter().map(machine).collect()
}
