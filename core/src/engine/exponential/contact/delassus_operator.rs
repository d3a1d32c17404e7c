//! What impulses at places of the contact do to gap and slip at others, of their statics as much as [`super::foreseen`] says.

use super::broad_phase::GapMinimum;
use super::contact_point::PressedPoint;
use super::impulsed_ring::STATIC_WEIGHT;
use super::ring_points::RingPoints;
use crate::contact::complementarity::Block;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::plane::{across, by_rows, product, times, turned};

/// Displacements of the rotor per impulse, in the stator's axes: of its modes by n+1, of these with what trains lack, and of those left out; slip of its surface per
/// impulse.
pub(crate) struct DelassusOperator {
    pub rotor_response: [[f64; 2]; 2],
    rotor_compliance: [[f64; 2]; 2],
    truncated_flexibility: [[f64; 2]; 2],
    rolling_compliance: f64,
}

impl DelassusOperator {
    /// In a stator's axes of this sine and cosine.
    #[inline(always)]
    pub fn new(
        angle: (f64, f64),
        mut truncated: [[f64; 2]; 2],
        response: &ImpulseResponse,
        rolling_compliance: f64,
    ) -> Self {
        let mut corrected = response.displacement;
        for i in 0..2 {
            for j in 0..2 {
                corrected[i][j] += STATIC_WEIGHT * response.static_correction[i][j];
                truncated[i][j] *= STATIC_WEIGHT;
            }
        }
        Self {
            rotor_response: turned(angle, &response.displacement),
            rotor_compliance: turned(angle, &corrected),
            truncated_flexibility: truncated,
            rolling_compliance,
        }
    }

    /// Displacement of the rotor by an impulse along normal and tangent of a place, as [`Moved::beyond_modes`] has it.
    #[inline(always)]
    pub fn rotor_displacement(&self, acting: &GapMinimum, normal: f64, tangential: f64) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let tangent = [normal * m[0] + tangential * s[0], normal * m[1] + tangential * s[1]];
        let (corrected, truncated) = (times(&self.rotor_compliance, tangent), times(&self.truncated_flexibility, m));
        [corrected[0] + normal * truncated[0], corrected[1] + normal * truncated[1]]
    }

    /// What is no mode of the ring in the gap at a place by a unit normal and a unit tangential impulse at another.
    #[inline(always)]
    pub fn truncated_response(&self, ring: &RingPoints, at: &GapMinimum, acting: &GapMinimum) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let truncated = product(at.normal, times(&self.truncated_flexibility, m))
            + product(at.polar, by_rows(&ring.left_out(at.index, acting.index), acting.polar));
        [
            product(at.normal, times(&self.rotor_compliance, m)) + truncated,
            product(at.normal, times(&self.rotor_compliance, s)),
        ]
    }

    /// How far the ring's modes left out still close the gap at a place by normal impulses of the step before: (2) of [`super::foreseen`].
    #[inline(always)]
    pub fn previous_truncated_response(ring: &RingPoints, at: &GapMinimum, pressed: &[PressedPoint]) -> f64 {
        let mut closure = 0.0;
        for PressedPoint { position, force, .. } in pressed {
            let displacement = by_rows(&ring.left_out(at.index, position.index), position.polar);
            closure += ring.static_correction.previous_share() * force.normal * product(at.polar, displacement);
        }
        closure
    }

    /// Gap and slip at a place by a unit normal and a unit tangential impulse at another, of which the ring's modes make so much: along the normal of the one by both, then
    /// along its tangent.
    #[inline(always)]
    pub fn coupling(&self, ring: &RingPoints, at: &GapMinimum, acting: &GapMinimum, modal_coupling: [f64; 4]) -> Block {
        let [n, t] = self.truncated_response(ring, at, acting);
        let (m, s) = (acting.normal, across(acting.normal));
        let tangent = across(at.normal);
        [
            [n + modal_coupling[0], t + modal_coupling[1]],
            [
                -product(tangent, times(&self.rotor_compliance, m)) - modal_coupling[2],
                -product(tangent, times(&self.rotor_compliance, s)) - modal_coupling[3] - self.rolling_compliance,
            ],
        ]
    }
}
