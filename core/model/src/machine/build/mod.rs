//! Builds the validated [`Machine`] from slots: checks missing keys, and values against each other. All problems are collected, so each check
//! runs as far as the values it needs are valid.

mod bearing_table;
mod braking;
mod covered;
mod diaphragm;
mod factor;
mod inertia;
mod layer;
mod limits;
mod lost;
mod monitor;
mod path;
mod places;
mod reader;
mod rotor;
mod run;
mod shaft;
mod support;
mod torque;

pub(super) use covered::choose;
pub use lost::{MOST_LOST, Overdrawn, overdrawn};
pub(super) use reader::Reader;
pub(super) use run::guard_of;

use super::layout::{Layout, State};
use super::model::Machine;
use bladeoff_text::document::{Collector, Problems};

/// Builds the machine; `problems` has the problems found while reading the file.
pub(super) fn build<'a>(layout: &'a Layout, states: &'a [State], problems: Collector<'a>) -> Result<Machine, Problems> {
    let mut reader = Reader::new(layout, states, problems);
    reader.check_presence();
    let run = run::run(&mut reader);
    let rotor = rotor::rotor(&mut reader, run.as_ref());
    let braking = braking::braking(&mut reader);
    let torques = torque::torques(&mut reader, rotor.nodes.as_ref(), braking.as_ref());
    let diaphragms = diaphragm::diaphragms(&mut reader, rotor.nodes.as_ref());
    let monitors = monitor::monitors(&mut reader, rotor.nodes.as_ref());
    covered::check(&mut reader);
    limits::check(&mut reader, rotor.rotor.as_ref(), diaphragms.as_deref());
    let mut problems = reader.problems;
    match (run, rotor.rotor, braking, torques, diaphragms, monitors) {
        (Some(run), Some(rotor), Some(braking), Some(torques), Some(diaphragms), Some(monitors))
            if problems.is_empty() =>
        {
            Ok(Machine { name: layout.name.clone(), run, rotor, braking, torques, diaphragms, monitors })
        }
        _ => {
            if problems.is_empty() {
                // A value is missing only if it was reported; if that ever fails, this problem avoids a panic.
                problems.add(0..0, "", "the machine is incomplete");
            }
            Err(problems.into_problems())
        }
    }
}
