//! Coordinates of the ring at which a look may find larger stresses than before.
//!
//! ```text
//! without impulses |q_k| <= a_k = sqrt(q_k^2 + q_k'^2/w_k^2):  |sigma| <= sum s_k a_k until the next impulse                            (1)
//! ```
//! Free modes only decay. Once (1) is not above the largest stresses so far, no look before the next impulse can raise them, and the ring is not evaluated.
//! [`ROUNDING`] covers the rounding of all steps until then. Source of (1): [`crate::stress`]. Verified by `no_free_mode_exceeds_its_amplitude` ([`super::kicked_ring`]).

use crate::engine::exponential::contact::contact_step::ContactStep;
use crate::record::Recorders;

/// Factor for the growth of a free mode by rounding: 1e-15 per step at most, in a billion steps.
const ROUNDING: f64 = 1.0 + 1e-6;

/// Looks at the ring of a run.
#[derive(Debug, Default)]
pub(crate) struct RingStressCheck {
    /// No stress can be larger than before until the next impulse.
    cannot_increase: bool,
    amplitudes: Vec<f64>,
}

impl RingStressCheck {
    /// Coordinates of the ring behind a step that `touches` or not; `None` where no stress can be larger than before.
    pub fn coordinates(&mut self, rub: &ContactStep, recorders: &mut Recorders) -> Option<&[f64]> {
        if self.cannot_increase {
            return None;
        }
        if !rub.in_contact() {
            rub.ring.free_amplitudes(&mut self.amplitudes);
            self.amplitudes.iter_mut().for_each(|amplitude| *amplitude *= ROUNDING);
            self.cannot_increase = recorders.ring_rests(&self.amplitudes);
            if self.cannot_increase {
                return None;
            }
        }
        rub.corrected_amplitudes(&mut self.amplitudes);
        Some(&self.amplitudes)
    }

    /// Takes an impulse on the ring.
    pub fn reset(&mut self) {
        self.cannot_increase = false;
    }
}
