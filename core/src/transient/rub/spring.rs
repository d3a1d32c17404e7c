//! Massless quasi-static radial spring instead of a ring: reference cases.

use super::{CONTACT_ITERATIONS, ContactFailure, Rub, StepContact, TOLERANCE, bilinear, directions, on_rotor};
use crate::contact::{ContactForce, Gap, polar_gap};
use crate::linalg::dot;
use crate::machine::FrictionLaw;
use crate::transient::shaft_line::ShaftLine;

impl Rub<'_> {
    /// Massless quasi-static spring: the force follows from the place at n, only friction depends on the step.
    pub(super) fn spring_contact(
        &mut self,
        line: &mut ShaftLine<'_>,
        time: f64,
        stiffness: f64,
        x_n: [f64; 2],
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Result<Option<StepContact>, ContactFailure> {
        let gap = polar_gap(&self.surface, None, self.rotor_radius, x_n);
        if gap.value >= 0.0 {
            return Ok(None);
        }
        let normal = -stiffness * gap.value;
        let (_, tangent) = directions(&gap);
        let mut sign = 0.0;
        let mut force = ContactForce { normal, tangential: 0.0, sticks: false };
        let w_tt = -bilinear(&self.compliance, tangent, tangent)
            - self.rotor_radius * self.rotor_radius * self.twist_compliance;
        for iteration in 0..CONTACT_ITERATIONS {
            self.iterations += 1;
            let mut free = std::mem::take(&mut self.candidate);
            let mut free_twist = std::mem::take(&mut self.candidate_twist);
            let driven = line.driven();
            line.respond(time, d, d_twist, &mut free, &mut free_twist);
            self.apply(&ContactForce { tangential: 0.0, ..force }, &gap, &mut free, &mut free_twist);
            match self.law {
                FrictionLaw::Slip => {
                    if iteration == 0 {
                        sign = self.centred_slip(line, &gap, &free, &free_twist).signum();
                    }
                    force.tangential = self.friction * normal * sign;
                }
                FrictionLaw::StickSlip => {
                    let dx = self.increment(&free);
                    let slip =
                        tangent[0] * dx[0] + tangent[1] * dx[1] + self.rotor_radius * dot(&self.twist_row, &free_twist);
                    let holding = -slip / w_tt;
                    let limit = self.friction * normal;
                    force.sticks = holding.abs() <= limit;
                    force.tangential = holding.clamp(-limit, limit);
                }
            }
            self.apply(&ContactForce { normal: 0.0, ..force }, &gap, &mut free, &mut free_twist);
            line.add_drive_torque(self.drive_lever * force.tangential * self.rotor_radius);
            let settled = self.change(line, driven, (d, d_twist), (&free, &free_twist), normal) <= TOLERANCE;
            d.copy_from_slice(&free);
            d_twist.copy_from_slice(&free_twist);
            (self.candidate, self.candidate_twist) = (free, free_twist);
            if iteration > 0 && settled {
                let slip = self.centred_slip(line, &gap, d, d_twist);
                return Ok(Some(StepContact {
                    force,
                    on_rotor: on_rotor(&force, &gap),
                    // the massless stator follows the rotor: nothing penetrates
                    gap: Gap { value: 0.0, ..gap },
                    slip,
                    reversed: self.law == FrictionLaw::Slip && slip * sign < 0.0,
                    several_minima: false,
                    no_fixed_point: false,
                    points: 1,
                    friction_work: force.tangential * slip * line.dt,
                    normal_work: 0.0,
                    model_work: 0.0,
                }));
            }
        }
        Err(ContactFailure::NoConvergence)
    }

    /// Potential of a radial spring at a rotor centre in the stator's frame \[J\].
    pub fn spring_energy(&self, x: [f64; 2]) -> f64 {
        self.spring.map_or(0.0, |stiffness| {
            let depth = ((x[0] * x[0] + x[1] * x[1]).sqrt() - self.gap).max(0.0);
            0.5 * stiffness * depth * depth
        })
    }
}
