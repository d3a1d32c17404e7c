//! Predictor of ring and rotor at n+1: the impulses of the last step are assumed to act again.
//!
//! ```text
//! c          static correction per unit impulse: static displacement less that of an impulse train, for each mode of ring and rotor
//! d          displacement by n+1 of a unit impulse at n, without c
//! statics    c (2 J_n - J_(n-1))                        those of the force extrapolated to n+1                                   (1)
//! predicted  free motion + (d + c) J_(n-1)              (1) with J_n = J_(n-1), at the positions of the last step                (2)
//! assumed    (d + 2 c) J_(n-1)                          the part of (2) that depends on J_n                                      (3)
//! ```
//! Gap minima and normals are taken at (2). The conditions on J_n are linear, so they start from (2) less (3).
//!
//! In the free motion no impulse of the step acts, and even a light rub penetrates by 0.2 mm there. Positions and normals of the
//! free motion had an error of first order (impulse of a long rub 2e-3 off at 40 us, 5e-4 with (2)), and jumped from step to step
//! in a whip. With static corrections of J_n alone the force was ahead of the gap by a step. On that share of the compliance this
//! acts as damping in proportion to the step: loads and impulses at the beginning of rubs were too small on every machine.
//!
//! Limits: the truncated modes of the ring are not in (2). Verified by `whip_is_that_of_the_reduced_engine`
//! (`tests/exponential/exponential_run.rs`), `random_machines_rub_as_in_the_reduced_engine`.

use super::gap_minimum::GapMinimum;
use super::impulsed_ring::STATIC_WEIGHT;
use super::ring_kernels::add_scaled_rows;
use crate::contact::ContactReaction;
use crate::eight::Eight;
use crate::engine::exponential::plane::{across, times};
use bladeoff_numerics::linalg::lanes::{Lane, flat};

/// Prediction of ring and rotor at n+1 before the impulses of the step are known.
pub(crate) struct ContactPredictor {
    /// d + c and c of each mode of the ring \[s\].
    compliance: Vec<Lane>,
    static_correction: Vec<Lane>,
    /// Impulses of the last step: on each mode of the ring, on the rotor \[N s\], and the normal ones of the latter.
    modal_impulses: Vec<Lane>,
    impulse: [f64; 2],
    normal_impulse: [f64; 2],
    /// Predicted amplitudes of the ring's modes, (2); the assumed part (3); and the displacement over the step from the position
    /// at n with its static correction.
    pub ring: Vec<Lane>,
    pub ring_correction: Vec<Lane>,
    pub ring_travel: Vec<Lane>,
    /// Predicted displacement of the rotor by impulses in (2), the assumed part (3), and the static correction in the
    /// displacement over the step, all in the stator's axes \[m\].
    pub rotor_displacement: [f64; 2],
    pub rotor_correction: [f64; 2],
    pub rotor_travel_correction: [f64; 2],
}

/// Impulses of the last step of a predictor.
#[derive(Default)]
pub(crate) struct LastImpulses {
    modal: Vec<Lane>,
    impulse: [f64; 2],
    normal: [f64; 2],
}

impl ContactPredictor {
    /// Creates a predictor for a ring whose modes have these compliances d + c and static corrections c.
    pub fn new([compliance, static_correction]: [Vec<Lane>; 2]) -> Self {
        let zeros = vec![Lane::default(); static_correction.len()];
        Self {
            compliance,
            static_correction,
            modal_impulses: zeros.clone(),
            impulse: [0.0; 2],
            normal_impulse: [0.0; 2],
            ring: zeros.clone(),
            ring_correction: zeros.clone(),
            ring_travel: zeros,
            rotor_displacement: [0.0; 2],
            rotor_correction: [0.0; 2],
            rotor_travel_correction: [0.0; 2],
        }
    }

    /// d + c and c of each mode of the ring \[s\].
    pub fn corrections(&self) -> [&[Lane]; 2] {
        [&self.compliance, &self.static_correction]
    }

    /// Reverses the sign of the static correction, as a fault. Returns it as it was.
    #[cfg(test)]
    pub fn reverse_static_correction(&mut self) -> Vec<Lane> {
        let before = self.static_correction.clone();
        for (compliance, correction) in self.compliance.iter_mut().zip(&mut self.static_correction) {
            for (compliance, correction) in compliance.0.iter_mut().zip(&mut correction.0) {
                *compliance -= 2.0 * *correction;
                *correction = -*correction;
            }
        }
        before
    }

    /// Forgets the impulses of the last step.
    #[inline(always)]
    pub fn reset(&mut self) {
        self.modal_impulses.fill(Lane::default());
        (self.impulse, self.normal_impulse) = ([0.0; 2], [0.0; 2]);
    }

    /// Copies the impulses of the last step.
    pub fn copy_last(&self, last: &mut LastImpulses) {
        last.modal.clone_from(&self.modal_impulses);
        (last.impulse, last.normal) = (self.impulse, self.normal_impulse);
    }

    /// Sets the impulses of the last step to a copy.
    pub fn set_last(&mut self, last: &LastImpulses) {
        self.modal_impulses.clone_from(&last.modal);
        (self.impulse, self.normal_impulse) = (last.impulse, last.normal);
    }

    /// Adds an impulse of the last step at a position with these rows along its normal and tangent.
    #[inline(always)]
    pub fn add_impulse<V: Eight>(&mut self, position: &GapMinimum, force: &ContactReaction, rows: [&[Lane]; 2]) {
        add_scaled_rows::<V>([force.normal, force.tangential], rows, &mut self.modal_impulses);
        let (n, t) = (position.normal, across(position.normal));
        for i in 0..2 {
            self.normal_impulse[i] += n[i] * force.normal;
            self.impulse[i] += n[i] * force.normal + t[i] * force.tangential;
        }
    }

    /// Predicts ring and rotor at n+1 from the free motion of the ring and its displacement over the step. The matrices are the
    /// displacement of the rotor per impulse, its static correction, and its truncated flexibility, in the stator's axes
    /// \[m/(N s)\].
    #[inline(always)]
    pub fn predict<V: Eight>(
        &mut self,
        ring: &[Lane],
        free_travel: &[Lane],
        [displacement_response, static_correction, truncated]: [&[[f64; 2]; 2]; 3],
    ) {
        let count = ring.len();
        let (compliance, corrections, impulses) =
            (&self.compliance[..count], &self.static_correction[..count], &self.modal_impulses[..count]);
        let (ring_correction, predicted) = (&mut self.ring_correction[..count], &mut self.ring[..count]);
        let (ring_travel, free_travel) = (&mut self.ring_travel[..count], &free_travel[..count]);
        for i in 0..count {
            let impulse = V::load(&impulses[i]);
            let (response, correction) = (V::load(&compliance[i]) * impulse, V::load(&corrections[i]) * impulse);
            (V::load(&ring[i]) + response).store(&mut predicted[i]);
            (response + correction).store(&mut ring_correction[i]);
            (V::load(&free_travel[i]) - V::all(STATIC_WEIGHT) * correction).store(&mut ring_travel[i]);
        }
        let (displacement, deflection) =
            (times(displacement_response, self.impulse), times(static_correction, self.impulse));
        let truncated = times(truncated, self.normal_impulse);
        for i in 0..2 {
            self.rotor_displacement[i] = -(displacement[i] + deflection[i] + truncated[i]);
            self.rotor_correction[i] = -(displacement[i] + STATIC_WEIGHT * (deflection[i] + truncated[i]));
            self.rotor_travel_correction[i] = -STATIC_WEIGHT * deflection[i];
        }
    }

    /// Static correction of the rotor's displacement for the impulses of the last step \[m\].
    pub fn static_deflection(&self, [static_correction, truncated]: [&[[f64; 2]; 2]; 2]) -> [f64; 2] {
        let ([u, v], truncated) = (times(static_correction, self.impulse), times(truncated, self.normal_impulse));
        [-u - truncated[0], -v - truncated[1]]
    }

    /// Adds the static correction for the impulses of the last step to amplitudes of the ring's modes.
    pub fn add_static_deflection(&self, amplitudes: &mut [f64]) {
        for ((amplitude, correction), impulse) in
            amplitudes.iter_mut().zip(flat(&self.static_correction)).zip(flat(&self.modal_impulses))
        {
            *amplitude += correction * impulse;
        }
    }
}
