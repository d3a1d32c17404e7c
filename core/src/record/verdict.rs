//! Status of a row: guards (numerical checks) and limits of the physical model.

use super::end::End;
use super::energies::EnergyBalance;
use super::limits::LimitRecorder;
use super::ring::RingRecorders;
use crate::structure::{MAX_TRUNCATION_ERROR, Structure};
use bladeoff_model::machine::{DiaphragmKind, Engine, FrictionLaw, Machine, OnExceed};
use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Status};

/// Status of a run, with its first cause and all causes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Verdict {
    pub status: Status,
    pub cause: Option<Cause>,
    pub causes: CauseSet,
}

impl Verdict {
    /// Judges a run that has ended, by `run.guard` and `run.limit`. A guard that was broken when the run exceeded a limit stays broken, whether
    /// the run ended there or not.
    pub fn of(
        guards: &Guards,
        energies: &EnergyBalance,
        rings: &[RingRecorders],
        limits: &LimitRecorder,
        machine: &Machine,
        structure: &Structure,
        end: &End,
    ) -> Self {
        let mut causes = causes_of_all(energies, rings, machine, structure);
        guards.at_limit.iter().for_each(|cause| causes.insert(cause));
        let failure = end.failure;
        if let Some(cause) = failure {
            causes.insert(cause);
        }
        if touched(rings) && structure.truncation_error_at_contact(machine) > MAX_TRUNCATION_ERROR {
            causes.insert(Cause::ModalBasis);
        }
        let first_cause = failure.or_else(|| causes.iter().next());
        let left = (end.cause == EndCause::TableRange).then_some(Cause::TableRange);
        left.into_iter().for_each(|cause| causes.insert(cause));
        let beyond = limits.beyond().map(|(limit, _)| limit.cause()).or(left);
        limits.exceeded(OnExceed::Beyond).iter().for_each(|cause| causes.insert(cause));
        let status = match (failure, first_cause, beyond) {
            (Some(_), ..) => Status::Failed,
            (None, Some(_), _) => Status::Invalid,
            (None, None, Some(_)) => Status::Beyond,
            (None, None, None) => Status::Ok,
        };
        let cause = first_cause.or(beyond);
        Verdict { status, cause, causes }
    }
}

/// Record of whether all guards have held so far, for a run in progress.
///
/// Each guard of `run.guard` is judged by the values up to the present step, and the modal basis from the first contact on. A broken guard
/// stays broken here, even if it would hold again at the end of the run (the largest total energy may grow, a normal work may reverse). While
/// impacts are so short that truncated modes may not follow them, nothing is marked as guarded. So a guarded value is a lower bound. Exception: a
/// limit of the model that is exceeded within 1 ms of the first touch marks the values reached, although the length of the impact is not known.
#[derive(Debug, Clone, Default)]
pub(crate) struct Guards {
    /// Whether a guard has been broken.
    any_broken: bool,
    /// Whether the truncation error of the modal basis at the contacts is acceptable; `None` before the first contact.
    carried: Option<bool>,
    /// Guards that were broken when the run exceeded a limit of the model.
    at_limit: CauseSet,
}

impl Guards {
    /// Returns whether all guards hold now and have always held, and the impacts so far are surely carried by the kept modes.
    pub fn hold(
        &mut self,
        energies: &EnergyBalance,
        rings: &[RingRecorders],
        machine: &Machine,
        structure: &Structure,
    ) -> bool {
        if self.any_broken {
            return false;
        }
        self.any_broken = !self.hold_now(energies, rings, machine, structure);
        let is_carried = |(place, ring): (usize, &RingRecorders)| {
            let lengths = [ring.contact.impact_length(), ring.contact.open_length()];
            lengths.into_iter().flatten().all(|length| structure.surely_carries(place, length))
        };
        !self.any_broken && flexible(rings, machine).all(is_carried)
    }

    /// Returns whether all guards hold at the step in which the run exceeds a limit of the model, as in the verdict of a run that ends here.
    pub fn hold_at_limit(
        &mut self,
        energies: &EnergyBalance,
        rings: &[RingRecorders],
        machine: &Machine,
        structure: &Structure,
    ) -> bool {
        self.at_limit = causes_of_all(energies, rings, machine, structure);
        self.at_limit.bits() == 0 && self.hold_now(energies, rings, machine, structure)
    }

    /// Returns whether all guards hold by the values up to the present step.
    fn hold_now(
        &mut self,
        energies: &EnergyBalance,
        rings: &[RingRecorders],
        machine: &Machine,
        structure: &Structure,
    ) -> bool {
        let carried = || structure.truncation_error_at_contact(machine) <= MAX_TRUNCATION_ERROR;
        broken_guards(energies, rings, machine, structure).bits() == 0
            && energies.is_finite()
            && (!touched(rings) || *self.carried.get_or_insert_with(carried))
    }
}

fn touched(rings: &[RingRecorders]) -> bool {
    rings.iter().any(|ring| ring.contact.touched())
}

/// Returns the guards that the recorded values break, without that of the modal basis.
fn broken_guards(
    energies: &EnergyBalance,
    rings: &[RingRecorders],
    machine: &Machine,
    structure: &Structure,
) -> CauseSet {
    let mut causes = CauseSet::default();
    let guard = &machine.run.guard;
    if energies.relative_error() > guard.energy_balance {
        causes.insert(Cause::EnergyBalance);
    }
    if energies.now.normal.abs() > guard.normal_work * energies.normal_work_reference() {
        causes.insert(Cause::NormalWork);
    }
    for (diaphragm, ring) in machine.diaphragms.iter().zip(rings) {
        let contact = &diaphragm.contact;
        if ring.contact.penetration().is_some_and(|depth| depth > guard.penetration * contact.gap) {
            causes.insert(Cause::Penetration);
        }
        if ring.contact.reversals() > 0 && contact.friction_law == FrictionLaw::Slip {
            causes.insert(Cause::SlipReversal);
        }
    }
    if impact_resolution(rings, machine, structure).is_some() {
        causes.insert(Cause::UnderResolved);
    }
    causes
}

/// Returns the guards that the recorded values break, with that of the modal basis for the measured impacts, which takes longer to judge.
fn causes_of_all(
    energies: &EnergyBalance,
    rings: &[RingRecorders],
    machine: &Machine,
    structure: &Structure,
) -> CauseSet {
    let mut causes = broken_guards(energies, rings, machine, structure);
    if !carries_impacts(rings, machine, structure) {
        causes.insert(Cause::ModalBasis);
    }
    causes
}

/// Smallest ratio of steps per impact to `run.guard.impact_steps`; `None` where the step resolves all impacts.
///
/// Without a static residual of truncated modes the contact acts on masses. They take a part of an impact in one step at any step, and the time step
/// of `full` and `reduced` resolves their motion. `exponential` is judged all the same: with all modes and fine steps its impulse was up to twice
/// that of `full` (`core/tests/data/short_impacts.toml` at 0.1 us). A rigid stator takes a whole impact in one step.
pub(super) fn impact_resolution(rings: &[RingRecorders], machine: &Machine, structure: &Structure) -> Option<f64> {
    let is_judged = |place: usize| machine.run.engine == Engine::Exponential || structure.has_residual(place);
    let judged = flexible(rings, machine).filter(|(place, _)| is_judged(*place));
    let steps = judged.filter_map(|(_, ring)| ring.contact.steps_per_impact()).reduce(f64::min)?;
    (steps < machine.run.guard.impact_steps).then(|| steps / machine.run.guard.impact_steps)
}

/// Whether the kept modes carry the impacts on all flexible rings.
pub(super) fn carries_impacts(rings: &[RingRecorders], machine: &Machine, structure: &Structure) -> bool {
    let mut lengths = flexible(rings, machine).filter_map(|(place, ring)| Some((place, ring.contact.impact_length()?)));
    lengths.all(|(place, length)| structure.carries_impacts(machine, place, length))
}

/// Recorders of the flexible rings, each with the place of its diaphragm.
fn flexible<'a>(rings: &'a [RingRecorders], machine: &'a Machine) -> impl Iterator<Item = (usize, &'a RingRecorders)> {
    let all = machine.diaphragms.iter().zip(rings).enumerate();
    all.filter(|(_, (diaphragm, _))| matches!(diaphragm.kind, DiaphragmKind::Flexible(_)))
        .map(|(place, (_, ring))| (place, ring))
}
