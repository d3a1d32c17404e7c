//! Stator of a diaphragm: a flexible or a rigid ring, or a radial spring without mass.

use super::contact_step::ContactStep;
use super::contact_step_result::{ContactStepResult, FreeStep};
use super::radial_spring::{RadialSpring, SpringImpulse};
use super::stator_axes::StatorAxes;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::torsion::spin::ContactImpulse;

/// Stator with the solver of its contact steps.
pub(crate) enum Stator {
    /// Flexible or rigid ring.
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
    /// Impulse that was found last in the present step; `None` where nothing was looked for.
    found: Option<Found>,
    /// The rotor has touched the stator: a ring is not at rest.
    pub has_touched: bool,
}

/// Impulse of a step that has not ended.
#[derive(Clone, Copy)]
enum Found {
    /// Smallest gap that the impulses on a ring leave \[m\]; `None` where nothing touches.
    Ring(Option<f64>),
    /// Impulse of a radial spring.
    Spring(SpringImpulse),
}

impl StatorContact {
    /// Creates the contact with a ring.
    pub fn of_ring(axes: StatorAxes, ring: ContactStep) -> Self {
        let largest_distance = ring.ring_radius();
        let gap = ring.gap();
        Self { axes, stator: Stator::Ring(Box::new(ring)), gap, largest_distance, found: None, has_touched: false }
    }

    /// Creates the contact with a radial spring. The spring yields as far as it is pressed.
    pub fn of_spring(axes: StatorAxes, spring: RadialSpring, gap: f64) -> Self {
        let stator = Stator::Spring(Box::new(spring));
        Self { axes, stator, gap, largest_distance: f64::INFINITY, found: None, has_touched: false }
    }

    /// Flexible ring; `None` for a stator without degrees of freedom.
    pub fn ring(&self) -> Option<&ContactStep> {
        match &self.stator {
            Stator::Ring(ring) if ring.is_flexible() => Some(ring),
            Stator::Ring(_) | Stator::Spring(_) => None,
        }
    }

    /// Radial gap at rest \[m\].
    pub fn gap(&self) -> f64 {
        self.gap
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
            Stator::Ring(ring) if self.has_touched => ring.clearance(),
            Stator::Ring(_) => self.gap,
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
            Stator::Ring(ring) if self.has_touched => ring.propagate_ring(doublings, h),
            Stator::Ring(ring) => ring.pass_rest(),
            Stator::Spring(spring) => spring.pass(),
        }
    }

    /// Takes the stator over a contact step. Writes the contact of the step; `None` where nothing touches.
    ///
    /// # Errors
    /// [`ExponentialError::NoImpulses`] where no impulses fulfil the conditions of a ring.
    #[inline(always)]
    pub fn solve(
        &mut self,
        free: &FreeStep<'_>,
        result: &mut Option<ContactStepResult>,
    ) -> Result<(), ExponentialError> {
        *result = match &mut self.stator {
            Stator::Ring(ring) => {
                ring.begin_step();
                let least_gap = ring.find(free)?;
                ring.finish_step(free, least_gap)
            }
            Stator::Spring(spring) => {
                let found = spring.find_impulse(free);
                spring.finish_step(free, &found)
            }
        };
        self.has_touched |= result.is_some();
        Ok(())
    }

    /// Finds the impulse of a contact step under given impulses at the other diaphragms. Can be repeated in a step, which
    /// [`StatorContact::finish_step`] ends. `keeps_points`: whether the points of the searches before in this step take part.
    ///
    /// # Errors
    /// [`ExponentialError::NoImpulses`] where no impulses fulfil the conditions of a ring.
    pub fn find(
        &mut self,
        free: &FreeStep<'_>,
        keeps_points: bool,
    ) -> Result<Option<ContactImpulse>, ExponentialError> {
        match &mut self.stator {
            Stator::Ring(ring) => {
                match self.found {
                    None => ring.begin_step(),
                    Some(_) => ring.restore_last_impulses(keeps_points),
                }
                let least_gap = ring.find(free)?;
                self.found = Some(Found::Ring(least_gap));
                Ok(least_gap.map(|_| {
                    let (impulse, torque) = ring.rotor_impulse();
                    let impulse = self.axes.to_machine(impulse);
                    ContactImpulse { diaphragm: free.diaphragm, impulse, torque, speed_jump: 0.0 }
                }))
            }
            Stator::Spring(spring) => {
                let found = spring.find_impulse(free);
                self.found = Some(Found::Spring(found));
                Ok((found.normal > 0.0).then(|| spring.contact_impulse(free, &found)))
            }
        }
    }

    /// Whether an impulse was looked for in the present step.
    pub fn is_searched(&self) -> bool {
        self.found.is_some()
    }

    /// Passes a contact step in which the rotor, whose section makes this turn \[rad\], does not reach the stator.
    pub fn pass_step(&mut self, surface_turn: f64) {
        match &mut self.stator {
            Stator::Ring(ring) => ring.pass_step(surface_turn),
            Stator::Spring(spring) => spring.pass_step(surface_turn),
        }
    }

    /// Ends a contact step with the impulse that was found last. Returns the contact of the step; `None` where nothing touches.
    pub fn finish_step(&mut self, free: &FreeStep<'_>) -> Option<ContactStepResult> {
        let result = match (&mut self.stator, self.found.take()) {
            (Stator::Ring(ring), Some(Found::Ring(least_gap))) => ring.finish_step(free, least_gap),
            (Stator::Spring(spring), Some(Found::Spring(found))) => spring.finish_step(free, &found),
            (Stator::Ring(_) | Stator::Spring(_), _) => None,
        };
        self.has_touched |= result.is_some();
        result
    }

    /// Whether nothing can touch in a contact step: a ring at rest is not reached at n+1, or a spring at both ends. Displacements of
    /// the rotor at n and n+1 \[m\] and velocity at n \[m/s\], in the machine's axes. A step with a search is not clear.
    #[inline(always)]
    pub fn is_clear(&self, [start, end, velocity]: [[f64; 2]; 3]) -> bool {
        let is_inside = |x: [f64; 2], gap: f64| {
            let [x, y] = self.axes.displacement_from_centre(x);
            x * x + y * y < gap * gap
        };
        let is_reached = match &self.stator {
            Stator::Ring(_) => self.has_touched || !is_inside(end, self.gap),
            Stator::Spring(spring) => {
                let gap = self.gap - spring.reach(velocity);
                gap <= 0.0 || !is_inside(start, gap) || !is_inside(end, gap)
            }
        };
        !is_reached && self.found.is_none()
    }
}
