//! Parts of a contact step: its beginning, the search for the impulses, which can be repeated, and its end.
//!
//! A single diaphragm searches once. With several diaphragms a search is repeated when the impulses at another one have changed
//! (`stepping/diaphragm_contact.rs`). The impulses of the last step, which a search may forget, are then restored.

use super::super::contact_point::PressedPoint;
use super::super::contact_predictor::LastImpulses;
use super::super::contact_step_result::{ContactStepResult, FreeStep};
use super::ContactStep;
use crate::eight::{Eight, by_width};
use crate::engine::exponential::ExponentialError;

/// Contact points of the last step, and the impulses of the predictor; ring points, with offsets, of
/// the search before in this step that take part in the next.
#[derive(Default)]
pub(super) struct LastStep {
    pub(super) pressed: Vec<PressedPoint>,
    pub(super) predictor: LastImpulses,
    pub(super) searched: Vec<(usize, f64)>,
}

impl ContactStep {
    /// Passes a step of free motion with the ring at rest.
    pub fn pass_rest(&mut self) {
        self.surface_turn.forget();
    }

    /// Begins a contact step: takes the ring to n+1 without impulses.
    #[inline(always)]
    pub fn begin_step(&mut self) {
        self.current = 1 - self.current;
        self.kept.pressed.clear();
        self.kept.searched.clear();
        self.model_slopes[0] = self.model_slopes[1];
        propagate_step(self);
    }

    /// Takes back the impulses of the last step that a search in this one has forgotten, before the search is repeated. With
    /// `keeps_points` nothing is taken back, and the points of the search before take part where they are.
    pub fn restore_last_impulses(&mut self, keeps_points: bool) {
        if keeps_points {
            if !self.points.is_empty() {
                self.kept.searched.clear();
                self.kept
                    .searched
                    .extend(self.points.iter().map(|point| (point.position.index, point.position.offset)));
            }
            return;
        }
        if self.pressed.is_empty() && !self.kept.pressed.is_empty() {
            self.pressed.clone_from(&self.kept.pressed);
            self.predictor.set_last(&self.kept.predictor);
        }
    }

    /// Finds the impulses of a step that has begun. Returns the smallest gap that is left \[m\]; `None` where nothing touches.
    ///
    /// # Errors
    /// [`ExponentialError::NoImpulses`] where no impulses fulfil (1).
    pub fn find(&mut self, free: &FreeStep<'_>) -> Result<Option<f64>, ExponentialError> {
        find_impulses(self, free)
    }

    /// Ends a step with the impulses that were found last, and the smallest gap that they leave \[m\]. Returns the contact of the
    /// step; `None` where nothing touches.
    #[inline(always)]
    pub fn finish_step(&mut self, free: &FreeStep<'_>, least_gap: Option<f64>) -> Option<ContactStepResult> {
        match least_gap {
            Some(least_gap) => Some(finish_step(self, free, least_gap)),
            None => {
                self.surface_turn.take(free.surface_turn, self.h);
                None
            }
        }
    }

    /// Passes a contact step in which a ring at rest is not reached.
    pub fn pass_step(&mut self, surface_turn: f64) {
        self.surface_turn.take(surface_turn, self.h);
    }

    /// Impulse on the rotor in the stator's axes \[N s\], and its angular impulse \[N m s\], of the impulses that were found last.
    #[inline(always)]
    pub fn rotor_impulse(&self) -> ([f64; 2], f64) {
        let (mut impulse, mut torque) = ([0.0; 2], 0.0);
        for point in self.points.iter().filter(|point| point.force.normal > 0.0) {
            let (force, n) = (&point.force, point.acting.normal);
            impulse[0] -= force.normal * n[0] - force.tangential * n[1];
            impulse[1] -= force.normal * n[1] + force.tangential * n[0];
            torque -= force.tangential * self.radius;
        }
        (impulse, torque)
    }
}

by_width! { fn propagate_step(contact: &mut ContactStep) = propagate_step_kernel }
by_width! { fn find_impulses(contact: &mut ContactStep, free: &FreeStep<'_>) -> Result<Option<f64>, ExponentialError> = find_impulses_kernel }
by_width! { fn finish_step(contact: &mut ContactStep, free: &FreeStep<'_>, least_gap: f64) -> ContactStepResult = finish_step_kernel }

#[inline(always)]
fn propagate_step_kernel<V: Eight>(contact: &mut ContactStep) {
    contact.ring.propagate_free::<V>();
}

#[inline(always)]
fn find_impulses_kernel<V: Eight>(
    contact: &mut ContactStep,
    free: &FreeStep<'_>,
) -> Result<Option<f64>, ExponentialError> {
    contact.find_kernel::<V>(free)
}

#[inline(always)]
fn finish_step_kernel<V: Eight>(contact: &mut ContactStep, free: &FreeStep<'_>, least_gap: f64) -> ContactStepResult {
    contact.apply_impulses::<V>(free, least_gap)
}
