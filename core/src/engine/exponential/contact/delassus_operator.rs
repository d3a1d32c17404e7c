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
    rotor: [[f64; 2]; 2],
    truncated_flexibility: [[f64; 2]; 2],
    rolling: f64,
}

impl DelassusOperator {
    /// In a stator's axes of this sine and cosine.
    #[inline(always)]
    pub fn new(angle: (f64, f64), mut left_out: [[f64; 2]; 2], kick: &ImpulseResponse, rolling: f64) -> Self {
        let mut whole = kick.displacement;
        for i in 0..2 {
            for j in 0..2 {
                whole[i][j] += STATIC_WEIGHT * kick.static_correction[i][j];
                left_out[i][j] *= STATIC_WEIGHT;
            }
        }
        Self {
            rotor_response: turned(angle, &kick.displacement),
            rotor: turned(angle, &whole),
            truncated_flexibility: left_out,
            rolling,
        }
    }

    /// Displacement of the rotor by an impulse along normal and tangent of a place, as [`Moved::beyond_modes`] has it.
    #[inline(always)]
    pub fn of_rotor(&self, acting: &GapMinimum, normal: f64, tangential: f64) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let along = [normal * m[0] + tangential * s[0], normal * m[1] + tangential * s[1]];
        let (whole, left_out) = (times(&self.rotor, along), times(&self.truncated_flexibility, m));
        [whole[0] + normal * left_out[0], whole[1] + normal * left_out[1]]
    }

    /// What is no mode of the ring in the gap at a place by a unit normal and a unit tangential impulse at another.
    #[inline(always)]
    pub fn truncated_response(&self, ring: &RingPoints, at: &GapMinimum, acting: &GapMinimum) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let left_out = product(at.normal, times(&self.truncated_flexibility, m))
            + product(at.polar, by_rows(&ring.left_out(at.index, acting.index), acting.polar));
        [product(at.normal, times(&self.rotor, m)) + left_out, product(at.normal, times(&self.rotor, s))]
    }

    /// How far the ring's modes left out still close the gap at a place by normal impulses of the step before: (2) of [`super::foreseen`].
    #[inline(always)]
    pub fn previous_truncated_response(ring: &RingPoints, at: &GapMinimum, pressed: &[PressedPoint]) -> f64 {
        let mut closed = 0.0;
        for PressedPoint { place, force, .. } in pressed {
            let by = by_rows(&ring.left_out(at.index, place.index), place.polar);
            closed += ring.static_correction.previous_share() * force.normal * product(at.polar, by);
        }
        closed
    }

    /// Gap and slip at a place by a unit normal and a unit tangential impulse at another, of which the ring's modes make so much: along the normal of the one by both, then
    /// along its tangent.
    #[inline(always)]
    pub fn coupling(&self, ring: &RingPoints, at: &GapMinimum, acting: &GapMinimum, of_modes: [f64; 4]) -> Block {
        let [n, t] = self.truncated_response(ring, at, acting);
        let (m, s) = (acting.normal, across(acting.normal));
        let along = across(at.normal);
        [
            [n + of_modes[0], t + of_modes[1]],
            [
                -product(along, times(&self.rotor, m)) - of_modes[2],
                -product(along, times(&self.rotor, s)) - of_modes[3] - self.rolling,
            ],
        ]
    }
}
