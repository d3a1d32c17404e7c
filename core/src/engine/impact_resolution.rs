//! Finer default step of a run whose impacts are shorter than its step resolves.
//!
//! ```text
//! h' = h n/(M N),   at least h_0/R                 M = 1.25, R = 8
//! ```
//! n: steps per impact of the run (column `steps_per_impact`, `crate::record`), N: `run.guard.impact_steps`, h: its contact step, h_0: the default
//! contact step. A run with n < N is repeated with h', rounded down to two digits, until n >= N or h' = h_0/R. The step depends on the machine
//! alone, not on the follower: equal runs have equal steps.
//!
//! Source: ours. Estimates of the length of an impact from the modes of ring and rotor were wrong by factors of 1.3 to 1000
//! (docs/theory/short-impacts.md), so the length is measured. n grows by less than h/h', because a finer step also finds shorter impacts; hence M.
//! Limits: the exponential engine alone, and only without `run.contact_step`. The reference engines keep their default step. A run with n < N at h_0/R
//! is `invalid`. A failed run is not repeated, nor one that a limit ends within 1 ms of its first touch (`crate::record`), nor one whose
//! truncated modes do not follow the impacts (`crate::structure`): finer steps make these shorter still. Verified by `core/tests/contact/short_impacts.rs`.

use super::choice;
use super::time_step::{StartError, TimeStep};
use crate::record::{End, Follower, Frame, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::{Engine, Machine};

/// M: the next step aims for this multiple of N steps per impact.
const MARGIN: f64 = 1.25;
/// R: largest refinement of the default step. A run that is repeated with this refinement takes nine times as long as a single one.
const MAX_REFINEMENT: f64 = 8.0;

/// A finished run and its step.
pub(super) struct Resolved {
    pub plan: TimeStep,
    pub recorders: Recorders,
    pub end: End,
}

impl Resolved {
    fn of(
        machine: &Machine,
        structure: &Structure,
        plan: TimeStep,
        follower: &mut dyn Follower,
    ) -> Result<Self, StartError> {
        let (recorders, end) = choice::run(machine, structure, &plan, follower)?;
        Ok(Self { plan, recorders, end })
    }
}

/// Time step of a run: the default, or a finer step if the impacts require one. Unless the step is given, the function simulates the run. The follower
/// observes nothing but may end the run.
///
/// # Errors
/// [`StartError`] for a run that cannot be started.
pub fn resolved_time_step(
    machine: &Machine,
    structure: &Structure,
    follower: &mut dyn Follower,
) -> Result<TimeStep, StartError> {
    let default = TimeStep::new(machine, structure)?;
    if is_fixed(machine) {
        return Ok(default);
    }
    Ok(resolved(machine, structure, default, &mut Unseen { follower, before: 0 })?.plan)
}

/// Whether the step of a run does not depend on its impacts.
fn is_fixed(machine: &Machine) -> bool {
    machine.run.engine != Engine::Exponential || machine.run.contact_step.is_some() || machine.diaphragms.is_empty()
}

/// Runs a machine with a step that resolves its impacts. A follower that cannot begin again observes only the last of several runs.
pub(super) fn run(
    machine: &Machine,
    structure: &Structure,
    follower: &mut dyn Follower,
) -> Result<Resolved, StartError> {
    if !is_fixed(machine) && follower.begins_again() {
        let default = TimeStep::new(machine, structure)?;
        return resolved(machine, structure, default, follower);
    }
    let plan = resolved_time_step(machine, structure, follower)?;
    Resolved::of(machine, structure, plan, follower)
}

/// Repeats a run with finer steps until the step resolves its impacts.
fn resolved(
    machine: &Machine,
    structure: &Structure,
    default: TimeStep,
    follower: &mut dyn Follower,
) -> Result<Resolved, StartError> {
    let mut plan = default;
    loop {
        let run = Resolved::of(machine, structure, plan, follower)?;
        let missing = run.end.failure.is_none().then(|| run.recorders.impact_resolution(machine, structure));
        let finer = missing.flatten().and_then(|ratio| plan.finer(ratio / MARGIN, default.step / MAX_REFINEMENT));
        match finer.and_then(|finer| finer.allowed(machine).ok()) {
            Some(finer) => plan = finer,
            None => return Ok(run),
        }
    }
}

/// Follower that observes nothing and passes the question of whether a run continues to another follower.
pub(super) struct Unseen<'a> {
    pub follower: &'a mut dyn Follower,
    /// Number of steps of earlier runs.
    pub before: u64,
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
