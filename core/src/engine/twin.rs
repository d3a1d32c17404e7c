//! Twin of a run: a second run of the same machine with an initial speed higher by the fraction `run.twin`.
//!
//! ```text
//! twin_bearing_load_change = (F_twin - F)/F,   F = max_bearing_load_N,   and likewise for the other quantities of [`Twin`]
//! ```
//! Without rub the response is proportional to a shift of the speed. In heavy rub neighbouring runs diverge from impact to impact, until their peaks
//! are two draws from one distribution. A single value is then a sample of this distribution, and the twin shows its width. Bearing loads alone do
//! not show it: an unbalance may determine them while contact impulses differ by a factor of two.
//! Verified by `tests/runs/twin.rs`.

use super::choice::run;
use super::impact_resolution::Unseen;
use super::time_step::TimeStep;
use crate::record::{End, Follower, Recorders, Twin};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Status;

/// Twin of a run that has ended, if one is requested. A failed run is not compared. The follower does not observe the twin, but may end it;
/// the twin has then failed.
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
        // a twin that cannot start (because it would start inside the diaphragm) has failed
        return Some(Twin::alone(Status::Failed));
    };
    let status = other.verdict(&machine, structure, &end).status;
    Some(if is_compared(status) {
        Twin::of(&own.compared(), &other.compared(), limit, status)
    } else {
        Twin::alone(status)
    })
}

/// Whether a run with this status reached its end. A run that stopped earlier has smaller maxima.
fn is_compared(status: Status) -> bool {
    matches!(status, Status::Ok | Status::Invalid)
}

/// Machine with its initial speed, and all prescribed speeds, higher by the fraction `run.twin`.
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
