//! The twin of a run: the same machine with an initial speed that differs by `run.twin` of it.
//!
//! ```text
//! twin_bearing_load_change = (F_twin - F)/F,   F = max_bearing_load_N
//! ```
//! A run without rub answers a shift of its speed in proportion. In heavy rub neighbouring runs part from impact to impact
//! until their peaks are two draws of one distribution; a single load is then a sample of it, and the twin shows how wide it is.
//! Verified by `tests/twin.rs`.

use super::{NoHistory, Plan, one_run};
use crate::outcome::{Outcome, Status, TWIN_WORDS, columns};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Computes the twin where there is to be one and writes its columns. A run that failed has nothing to compare with.
pub(super) fn compare(machine: &Machine, structure: &Structure, plan: &Plan, outcome: &mut Outcome) {
    if machine.run.twin == 0.0 || outcome.status == Status::Failed {
        return;
    }
    let twin = shifted(machine);
    // one that cannot start (it would begin inside the diaphragm) has failed
    let found = one_run(&twin, structure, plan, &mut NoHistory).ok();
    let status = found.as_ref().map_or(Status::Failed, |found| found.status);
    let columns = columns(machine);
    let place = |name: &str| columns.iter().position(|column| column.name == name);
    let load = |outcome: &Outcome| place("max_bearing_load_N").and_then(|at| outcome.values[at]);
    let change = found.filter(|found| found.status != Status::Failed).and_then(|found| {
        let (own, other) = (load(outcome)?, load(&found)?);
        (own > 0.0).then(|| (other - own) / own)
    });
    let word = TWIN_WORDS.iter().position(|word| *word == status.word()).map(|at| at as f64);
    for (name, value) in [("twin_bearing_load_change", change), ("twin_status", word)] {
        if let Some(at) = place(name) {
            outcome.values[at] = value;
        }
    }
}

/// The machine with its initial speed, and every speed of a prescribed one, larger by `run.twin` of it.
fn shifted(machine: &Machine) -> Machine {
    let mut twin = machine.clone();
    let factor = 1.0 + machine.run.twin;
    twin.run.twin = 0.0;
    twin.rotor.initial_speed *= factor;
    if let Some(law) = &mut twin.rotor.speed_law {
        law.speeds.iter_mut().for_each(|speed| *speed *= factor);
    }
    twin
}
