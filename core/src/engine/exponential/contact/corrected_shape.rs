//! Displacement of ring and rotor at an instant, with the static correction of the contact forces, for observers.
//!
//! A train of impulses makes less than the static displacement of a mode ([`super::impulsed_ring`]), and the contact step has no
//! truncated modes. Both are added here, from the impulses of the last step. The motion itself does not change.

use super::contact_point::PressedPoint;
use super::contact_step::ContactStep;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::plane::{across, turned};
use crate::stator::NodalForces;

/// Ring and rotor at an instant, static corrections included.
pub(crate) struct CorrectedShape {
    /// Amplitudes of the ring's modes.
    pub amplitudes: Vec<f64>,
    /// Points where contact forces act: angle in the stator's axes \[rad\], and normal force in polar axes (radial, tangential)
    /// \[N\].
    pub pressed: Vec<(f64, [f64; 2])>,
    /// Displacement of the rotor's centre from the ring's, in the stator's axes \[m\].
    pub rotor: [f64; 2],
}

impl ContactStep {
    /// Writes the amplitudes of the ring's modes at n, static corrections included.
    pub fn corrected_amplitudes(&self, amplitudes: &mut Vec<f64>) {
        amplitudes.clear();
        amplitudes.extend_from_slice(self.ring.amplitudes());
        if self.in_contact() {
            self.predictor.add_static_deflection(amplitudes);
        }
    }

    /// Writes the contact forces of the last step on the ring where modes are truncated.
    pub fn nodal_forces(&self, forces: &mut NodalForces) {
        forces.clear();
        let pressed = self.pressed.iter().filter(|_| self.ring_points.has_truncated_modes());
        for PressedPoint { position, force, .. } in pressed {
            let alpha = (position.index as f64 + 0.5 + position.offset) * self.ring_points.spacing;
            let ([normal, tangential], tangent) =
                ([force.normal / self.h, force.tangential / self.h], across(position.polar));
            let parts = [0, 1].map(|i| normal * position.polar[i] + tangential * tangent[i]);
            forces.add_at(&self.ring_points.surface, self.ring_points.surface.locate(alpha), parts);
        }
    }

    /// Ring and rotor at n, static corrections included, for a rotor displaced by x in the stator's axes \[m\].
    pub fn corrected_shape(&self, x: [f64; 2], response: &ImpulseResponse) -> CorrectedShape {
        let mut amplitudes = Vec::new();
        self.corrected_amplitudes(&mut amplitudes);
        let force_at = |PressedPoint { position, force, .. }: &PressedPoint| {
            let alpha = (position.index as f64 + 0.5 + position.offset) * self.ring_points.spacing;
            (alpha, position.polar.map(|part| part * force.normal / self.h))
        };
        let static_correction = turned(self.axes.angle, &response.static_correction);
        let deflection = self.predictor.static_deflection([&static_correction, &self.rotor_truncated_flexibility]);
        CorrectedShape {
            amplitudes,
            pressed: self.pressed.iter().map(force_at).collect(),
            rotor: [0, 1].map(|i| x[i] + deflection[i]),
        }
    }
}
