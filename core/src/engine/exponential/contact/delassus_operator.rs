//! Delassus operator of a contact step: gap and slip at a point of the ring per impulse at another.
//!
//! ```text
//! W = modes of the ring + truncated modes of the ring + modes of the rotor + truncated modes of the rotor + rotation of its surface
//! ```
//! Static corrections have the weight of J_n in (1) of [`super::contact_predictor`]. The part of the ring's modes comes from the
//! rows of the points ([`super::ring_kernels`]).

use super::contact_point::PressedPoint;
use super::gap_minimum::GapMinimum;
use super::impulsed_ring::STATIC_WEIGHT;
use super::ring_points::RingPoints;
use crate::contact::complementarity::Block;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::plane::{across, by_rows, product, times, turned};

/// Response of the rotor to impulses of a contact step, in the stator's axes.
pub(crate) struct DelassusOperator {
    /// Displacement of the rotor's modes at n+1 per impulse at n, without static correction \[m/(N s)\].
    pub rotor_response: [[f64; 2]; 2],
    /// Displacement of the rotor's modes at n+1 per impulse at n, with static correction \[m/(N s)\].
    rotor_compliance: [[f64; 2]; 2],
    /// Displacement of the rotor's truncated modes per impulse \[m/(N s)\].
    truncated_flexibility: [[f64; 2]; 2],
    /// Slip of the rotor's surface over the step per tangential impulse \[m/(N s)\].
    rolling_compliance: f64,
}

impl DelassusOperator {
    /// Creates the operator in the axes of a stator with this sine and cosine of its angle.
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

    /// Displacement of the rotor by a normal and a tangential impulse at a position \[m\]. The truncated modes respond to the
    /// normal impulse only.
    #[inline(always)]
    pub fn rotor_displacement(&self, acting: &GapMinimum, normal: f64, tangential: f64) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let impulse = [normal * m[0] + tangential * s[0], normal * m[1] + tangential * s[1]];
        let (corrected, truncated) = (times(&self.rotor_compliance, impulse), times(&self.truncated_flexibility, m));
        [corrected[0] + normal * truncated[0], corrected[1] + normal * truncated[1]]
    }

    /// Change of the gap at a position by a unit normal and a unit tangential impulse at another, without the modes of the ring
    /// \[m/(N s)\].
    #[inline(always)]
    pub fn truncated_response(&self, ring: &RingPoints, at: &GapMinimum, acting: &GapMinimum) -> [f64; 2] {
        let (m, s) = (acting.normal, across(acting.normal));
        let truncated = product(at.normal, times(&self.truncated_flexibility, m))
            + product(at.polar, by_rows(&ring.truncated_response(at.index, acting.index), acting.polar));
        [
            product(at.normal, times(&self.rotor_compliance, m)) + truncated,
            product(at.normal, times(&self.rotor_compliance, s)),
        ]
    }

    /// Closure of the gap at a position by the impulses of the last step in the ring's truncated modes
    /// ([`StaticCorrection`](super::impulsed_ring::StaticCorrection)) \[m\].
    #[inline(always)]
    pub fn previous_truncated_response(ring: &RingPoints, at: &GapMinimum, pressed: &[PressedPoint]) -> f64 {
        let mut closure = 0.0;
        for PressedPoint { position, force, .. } in pressed {
            let displacement = by_rows(&ring.truncated_response(at.index, position.index), position.polar);
            closure += ring.static_correction.previous_share() * force.normal * product(at.polar, displacement);
        }
        closure
    }

    /// Gap and slip at a position by a unit normal and a unit tangential impulse at another: first row gap, second row slip.
    /// `modal_coupling` is the part of the ring's modes: normal row by both impulses, then tangential row.
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
