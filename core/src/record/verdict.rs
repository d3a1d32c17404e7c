//! Whether a row may be believed: the validity guard.

use super::{End, Recorders};
use crate::outcome::{Cause, CauseSet, Status};
use crate::structure::{MODAL_LAG, Structure};
use bladeoff_model::machine::{FrictionLaw, Machine};

/// Status of a run and what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Verdict {
    pub status: Status,
    pub cause: Option<Cause>,
    pub causes: CauseSet,
}

impl Recorders {
    /// Judges a run that has ended, by `run.guard`.
    pub fn verdict(&self, machine: &Machine, structure: &Structure, end: &End) -> Verdict {
        let mut causes = CauseSet::default();
        let guard = &machine.run.guard;
        let failure = end.failure;
        if let Some(cause) = failure {
            causes.insert(cause);
        }
        if self.energies.relative_error() > guard.energy_balance {
            causes.insert(Cause::EnergyBalance);
        }
        let works = &self.energies.now;
        let reference = works.friction.max(1e-3 * self.energies.initial().abs());
        if works.normal.abs() > guard.normal_work * reference {
            causes.insert(Cause::NormalWork);
        }
        for (diaphragm, ring) in machine.diaphragms.iter().zip(&self.rings) {
            let contact = &diaphragm.contact;
            if ring.contact.penetration().is_some_and(|depth| depth > guard.penetration * contact.gap) {
                causes.insert(Cause::Penetration);
            }
            if ring.contact.reversals() > 0 && contact.friction_law == FrictionLaw::Slip {
                causes.insert(Cause::SlipReversal);
            }
        }
        let touched = self.rings.iter().any(|ring| ring.contact.touched());
        if touched && structure.lag_at_contact(machine) > MODAL_LAG {
            causes.insert(Cause::ModalBasis);
        }
        let cause = failure.or_else(|| causes.iter().next());
        let status = match (failure, cause) {
            (Some(_), _) => Status::Failed,
            (None, Some(_)) => Status::Invalid,
            (None, None) => Status::Ok,
        };
        Verdict { status, cause, causes }
    }
}
