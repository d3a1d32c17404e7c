//! Check whether stresses of the ring can be larger than before.
//!
//! ```text
//! without impulses |q_k| <= a_k = sqrt(q_k^2 + q_k'^2/w_k^2):  |sigma| <= sum s_k a_k until the next impulse                            (1)
//! ```
//! Free modes only decay. Once (1) is not above the largest stresses so far, no observation before the next impulse can raise them, and the ring is not evaluated.
//! [`ROUNDING`] covers the rounding of all steps until then. Source of (1): [`crate::stress`]. Verified by `no_free_mode_exceeds_its_amplitude` ([`crate::engine::exponential::contact::impulsed_ring`]).

use crate::engine::exponential::contact::contact_step::ContactStep;
use crate::record::{Recorders, RingState};
use crate::stator::NodalForces;
use crate::stress::ForceAverage;
use crate::structure::RingPart;

/// Factor for the growth of a free mode by rounding: 1e-15 per step at most, in a billion steps.
const ROUNDING: f64 = 1.0 + 1e-6;

/// Check of one ring in a run.
#[derive(Debug, Default)]
pub(crate) struct RingStressCheck {
    /// Stresses cannot be larger than before until the next impulse.
    cannot_increase: bool,
    amplitudes: Vec<f64>,
    /// Contact forces of a step, and their mean.
    forces: NodalForces,
    mean: ForceAverage,
}

impl RingStressCheck {
    /// Check of a ring in contact steps of `h` \[s\]. `part`: `None` for a stator without degrees of freedom.
    pub fn new(part: Option<&RingPart>, h: f64) -> Self {
        Self { mean: part.map_or_else(ForceAverage::default, |part| ForceAverage::new(part, h)), ..Self::default() }
    }

    /// Takes the forces of a step of so many contact steps into their mean, where it is one over several.
    #[inline]
    pub fn take_step(&mut self, contact_step: &ContactStep, contact_steps: usize) {
        if !self.mean.needs_each_step() {
            return;
        }
        if contact_steps > 1 {
            self.mean.clear();
        } else {
            // without contact now and in the step before there are no forces to write
            if contact_step.in_contact() || !self.forces.is_empty() {
                contact_step.nodal_forces(&mut self.forces);
            }
            self.mean.take(&self.forces);
        }
    }

    /// State of the ring behind a step; `None` where no stress can be larger than before.
    pub fn state(
        &mut self,
        diaphragm: usize,
        contact_step: &ContactStep,
        recorders: &mut Recorders,
    ) -> Option<RingState<'_>> {
        if self.cannot_increase {
            return None;
        }
        if self.mean.needs_each_step() {
            self.mean.update();
        } else {
            contact_step.nodal_forces(self.mean.single());
        }
        if !contact_step.in_contact() && self.mean.mean().is_empty() {
            contact_step.ring.free_amplitudes(&mut self.amplitudes);
            self.amplitudes.iter_mut().for_each(|amplitude| *amplitude *= ROUNDING);
            self.cannot_increase = recorders.ring_rests(diaphragm, &self.amplitudes);
            if self.cannot_increase {
                return None;
            }
        }
        contact_step.corrected_amplitudes(&mut self.amplitudes);
        Some(RingState { coordinates: &self.amplitudes, forces: self.mean.mean() })
    }

    /// Forgets the bound: an impulse has acted on the ring.
    pub fn reset(&mut self) {
        self.cannot_increase = false;
    }
}
