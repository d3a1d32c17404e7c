//! Stator of a diaphragm: a flexible ring, or a radial spring without mass.

use super::contact_step::ContactStep;
use super::contact_step_result::{ContactStepResult, FreeStep};
use super::radial_spring::RadialSpring;
use super::stator_axes::StatorAxes;
use crate::engine::exponential::ExponentialError;

/// Stator with the solver of its contact steps.
pub(crate) enum Stator {
    /// Flexible ring.
    Ring(Box<ContactStep>),
    /// Radial spring.
    Spring(Box<RadialSpring>),
}

/// Contact of the rotor with one stator.
pub(crate) struct StatorContact {
    pub axes: StatorAxes,
    pub stator: Stator,
    /// Radial gap at rest, and largest distance of the rotor's centre from that of the stator \[m\].
    gap: f64,
    largest_distance: f64,
}

impl StatorContact {
    /// Creates the contact with a flexible ring.
    pub fn of_ring(axes: StatorAxes, ring: ContactStep) -> Self {
        let largest_distance = ring.ring_radius();
        Self { axes, stator: Stator::Ring(Box::new(ring)), gap: 0.0, largest_distance }
    }

    /// Creates the contact with a radial spring. The spring yields as far as it is pressed.
    pub fn of_spring(axes: StatorAxes, spring: RadialSpring, gap: f64) -> Self {
        Self { axes, stator: Stator::Spring(Box::new(spring)), gap, largest_distance: f64::INFINITY }
    }

    /// Flexible ring; `None` for a stator without degrees of freedom.
    pub fn ring(&self) -> Option<&ContactStep> {
        match &self.stator {
            Stator::Ring(ring) => Some(ring),
            Stator::Spring(_) => None,
        }
    }

    /// Whether impulses acted in the last step.
    pub fn in_contact(&self) -> bool {
        match &self.stator {
            Stator::Ring(ring) => ring.in_contact(),
            Stator::Spring(spring) => spring.in_contact,
        }
    }

    /// Distance of the rotor's centre from that of the stator below which no contact is possible \[m\].
    pub fn clearance(&self) -> f64 {
        match &self.stator {
            Stator::Ring(ring) => ring.clearance(),
            Stator::Spring(_) => self.gap,
        }
    }

    /// Whether a rotor with this displacement in the machine's axes has left the stator.
    pub fn is_outside(&self, displacement: [f64; 2]) -> bool {
        let [x, y] = self.axes.place(displacement);
        x * x + y * y > self.largest_distance * self.largest_distance
    }

    /// Energy of a stator without degrees of freedom \[J\].
    pub fn spring_energy(&self) -> f64 {
        match &self.stator {
            Stator::Ring(_) => 0.0,
            Stator::Spring(spring) => spring.energy,
        }
    }

    /// Takes the stator over a step of free motion of `h = 2^doublings` contact steps \[s\].
    pub fn propagate(&mut self, doublings: usize, h: f64) {
        match &mut self.stator {
            Stator::Ring(ring) => ring.propagate_ring(doublings, h),
            Stator::Spring(spring) => spring.pass(),
        }
    }

    /// Takes the stator over a contact step. Returns the contact of the step; `None` where nothing touches.
    ///
    /// # Errors
    /// [`ExponentialError::NoImpulses`] where no impulses fulfil the conditions of a ring.
    pub fn solve(&mut self, free: &FreeStep<'_>) -> Result<Option<ContactStepResult>, ExponentialError> {
        match &mut self.stator {
            Stator::Ring(ring) => ring.solve(free),
            Stator::Spring(spring) => Ok(spring.solve(free)),
        }
    }
}
