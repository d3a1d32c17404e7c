//! What contact did in a step.

use crate::contact::{ContactReaction, Gap, NotUnique};
use crate::record::Touch;
use bladeoff_model::outcome::Cause;

/// The contact of the step at n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepContact {
    pub force: ContactReaction,
    /// On the rotor, in the stator's frame \[N\].
    pub on_rotor: [f64; 2],
    /// Gap and place of the converged step, in the run's own gap function.
    pub gap: Gap,
    /// Centred slip velocity \[m/s\].
    pub slip: f64,
    /// Slip direction frozen at the prediction and not kept by the solution.
    pub reversed: bool,
    /// One contact point has no fixed point: solved with several, or at the predicted place.
    pub no_fixed_point: bool,
    /// The rotor penetrated the predicted ring at more than one local minimum.
    pub several_minima: bool,
    /// Points that carry a force; the force is then the sum over them, the slip that of the most loaded one.
    pub points: usize,
    /// Energy taken out by friction, by the normal force and by Hyp 1's model work in the step \[J\].
    pub friction_work: f64,
    pub normal_work: f64,
    pub model_work: f64,
}

impl StepContact {
    /// What recorders see of it.
    pub fn touch(&self) -> Touch {
        Touch {
            normal: self.force.normal,
            sticks: self.force.sticks,
            gap: self.gap.value,
            points: self.points,
            reversed: self.reversed,
            no_fixed_point: self.no_fixed_point,
            several_minima: self.several_minima,
            friction_work: self.friction_work,
        }
    }
}

/// A contact step that could not be computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactFailure {
    NotUnique(NotUnique),
    NoConvergence,
    /// The same where the step without contact would lead beyond the ring.
    Outside,
}

impl From<ContactFailure> for Cause {
    fn from(failure: ContactFailure) -> Self {
        match failure {
            ContactFailure::NotUnique(_) => Self::LossOfUniqueness,
            ContactFailure::NoConvergence => Self::Diverged,
            ContactFailure::Outside => Self::OutsideRing,
        }
    }
}
