//! Contact result of one step.

use crate::contact::{ContactReaction, Gap, NotUnique};
use crate::record::Touch;
use bladeoff_model::outcome::Cause;

/// Contact of the step at n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepContact {
    /// Contact force: normal and tangential part \[N\].
    pub force: ContactReaction,
    /// Force on the rotor in the stator's frame \[N\].
    pub on_rotor: [f64; 2],
    /// Gap and place at the end of the converged step, in the run's own gap function.
    pub gap: Gap,
    /// Centred slip velocity of the rotor relative to the ring \[m/s\].
    pub slip: f64,
    /// Whether the slip direction, frozen at the prediction, differs from that of the solution.
    pub reversed: bool,
    /// Whether one contact point had no fixed point, so that the step was solved with several points or at the predicted place.
    pub no_fixed_point: bool,
    /// Whether the rotor penetrated the predicted ring at more than one local minimum.
    pub several_minima: bool,
    /// Number of points with a force. The force is the sum over these points, the slip that of the most loaded one.
    pub points: usize,
    /// Energy dissipated by friction, by the normal force and by Hyp 1's model work in the step \[J\].
    pub friction_work: f64,
    pub normal_work: f64,
    pub model_work: f64,
}

impl StepContact {
    /// Contact quantities for the recorders.
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

/// Failure of a contact step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactFailure {
    /// The contact force is not unique.
    NotUnique(NotUnique),
    /// The iteration did not converge.
    NoConvergence,
    /// The iteration did not converge, and the step without contact would end outside the ring.
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
