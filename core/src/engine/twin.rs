//! The twin of a run: the same machine with an initial speed that differs by `run.twin` of it.
//!
//! ```text
//! twin_bearing_load_change = (F_twin - F)/F,   F = max_bearing_load_N,   and likewise of the other quantities of [`Twin`]
//! ```
//! A run without rub answers a shift of its speed in proportion. In heavy rub neighbouring runs part from impact to impact
//! until their peaks are two draws of one distribution. A single value is then a sample of it, and the twin shows how wide it is. Bearing loads alone do not: an unbalance may determine them while
//! contact impulses differ by a factor of two.
//! Verified by `tests/runs/twin.rs`.

use super::choice::run;
use super::time_step::TimeStep;
use crate::record::{End, Follower, Frame, Recorders, Twin};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Status;

/// The twin of a run that has ended, where there is to be one. A run that failed is not compared. The follower sees
/// nothing of it, but may end it: it has failed then.
pub(super) fn of(
    own: &Recorders,
    end: &End,
    machine: &Machine,
    structure: &Structure,
    plan: &TimeStep,
    follower: &mut dyn Follower,
) -> Option<Twin> {
    let limit = machine.run.twin_limit;
    if machine.run.twin == 0.0 || !is_compared(own.verdict(machine, structure, end).status) {
        return None;
    }
    let machine = shifted(machine);
    let mut unseen = Unseen { follower, before: end.steps };
    let Ok((other, end)) = run(&machine, structure, plan, &mut unseen) else {
        // one that cannot start (it would begin inside the diaphragm) has failed
        return Some(Twin::alone(Status::Failed));
    };
    let status = other.verdict(&machine, structure, &end).status;
    Some(if is_compared(status) {
        Twin::of(&own.compared(), &other.compared(), limit, status)
    } else {
        Twin::alone(status)
    })
}

/// Whether a run with this status went to its end: one that stopped before has smaller maxima.
fn is_compared(status: Status) -> bool {
    matches!(status, Status::Ok | Status::Invalid)
}

/// Asks whether to go on, with the steps counted on from those of the first run.
struct Unseen<'a> {
    follower: &'a mut dyn Follower,
    before: u64,
}

impl Follower for Unseen<'_> {
    fn follows(&self) -> bool {
        false
    }
    fn goes_on(&mut self, step: u64) -> bool {
        self.follower.goes_on(self.before + step)
    }
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        false
    }
    fn wants_energies(&self) -> bool {
        false
    }
    fn see(&mut self, _frame: &Frame<'_>) {}
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
