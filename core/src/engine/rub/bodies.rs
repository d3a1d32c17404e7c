//! The two bodies of a contact, and the response of their increments to contact forces over a step.

use super::axes::{directions, on_rotor};
use super::left_out::LeftOut;
use super::section::Section;
use super::stator::Stator;
use crate::contact::{ContactReaction, Gap};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_model::machine::FrictionLaw;
use bladeoff_numerics::linalg::{axpy, distance, dot, norm};

/// Number of roundings of a radius in a gap: both components of `P - x`, its length, and the difference from R_r.
const GAP_ROUNDINGS: f64 = 16.0;

/// Rotor and stator of one diaphragm.
pub(super) struct Bodies<'a> {
    /// Rotor at the diaphragm.
    pub section: Section,
    /// Stator with its ring.
    pub stator: Stator<'a>,
    /// Static displacements of the truncated modes.
    pub left_out: LeftOut<'a>,
    /// Friction coefficient mu.
    pub friction: f64,
    /// Friction law: sliding only, or sticking and sliding.
    pub law: FrictionLaw,
}

impl Bodies<'_> {
    /// Rotor centre at n+1 in the stator's frame, from its position at n and the increments, including the truncated modes \[m\].
    pub fn after(&self, x_n: [f64; 2], d: &Increments) -> [f64; 2] {
        let dx = self.section.increment(&d.lateral);
        std::array::from_fn(|axis| x_n[axis] + dx[axis] + self.left_out.shift[axis])
    }

    /// Removes the contact force of the step from the stator and the truncated modes.
    pub fn release(&mut self) {
        self.left_out.spring_back();
        self.left_out.held = 0.0;
        if let Some(ring) = &mut self.stator.ring {
            ring.release();
        }
    }

    /// Sets the field of the stator at n+1.
    pub fn field_after(&mut self) {
        self.stator.field_after(&self.left_out);
    }

    /// Gap at n in the run's own gap function, as the contact of the previous step left it. The rotor centre is given without the truncated modes.
    /// The contact force of the previous step is the one that closes this gap.
    pub fn gap_at_n(&mut self, x: [f64; 2]) -> Gap {
        self.stator.gap_at_n(x, &self.left_out)
    }

    /// Gap at the place `at` due to a unit normal force at the place `acting`, truncated modes only \[m/N\].
    pub fn left_out_between(&self, at: &Gap, acting: &Gap) -> f64 {
        self.left_out.between(&self.stator.surface, at, acting)
    }

    /// Adds a contact force that the truncated modes follow.
    pub fn give_way(&mut self, acting: &Gap, force: &ContactReaction) {
        self.left_out.give_way(&self.stator.surface, acting, force);
    }

    /// Sets the ring's rows at the place of the force and at the place of the gap.
    pub fn load_rows(&mut self, acting: &Gap, gap: &Gap) {
        if let Some(ring) = &mut self.stator.ring {
            ring.load_rows(acting, gap, &self.stator.surface);
        }
    }

    /// Adds the response to a contact force to the increments `free`, and sets the ring's increment with this force.
    pub fn push(&mut self, force: &ContactReaction, acting: &Gap, free: &mut Increments) {
        self.section.push(on_rotor(force, acting), force.tangential, free);
        if let Some(ring) = &mut self.stator.ring {
            ring.restart();
            axpy(force.normal, &ring.normal.response, &mut ring.d);
            axpy(force.tangential, &ring.tangent.response, &mut ring.d);
        }
    }

    /// Centred slip velocity at the place of the current rows \[m/s\], rotor relative to ring, positive along the tangent.
    pub fn centred_slip(&self, line: &ShaftLine<'_>, acting: &Gap, d: &Increments) -> f64 {
        let (_, tangent) = directions(acting);
        let (before, torsion_before) = (&line.lateral.stepper.previous, &line.torsion.stepper.previous);
        let (dx, before) = (self.section.increment(&d.lateral), self.section.increment(before));
        let mut slip = tangent[0] * (dx[0] + before[0]) + tangent[1] * (dx[1] + before[1]);
        slip += self.section.radius * (self.section.turn(&d.torsion) + self.section.turn(torsion_before));
        if let Some(ring) = &self.stator.ring {
            slip -= dot(&ring.tangent.force, &ring.d) + dot(&ring.tangent.force, &ring.stepper.previous);
        }
        0.5 * slip / line.dt
    }

    /// Whether the ring's increment converged in the last round.
    pub fn ring_settled(&self) -> bool {
        // rounding of the gap (1e-16 of the radius) limits the convergence of the ring's increment
        let floor = 1e-13 * self.section.radius.max(self.stator.gap);
        self.stator.ring.as_ref().is_none_or(|ring| ring.settled(floor))
    }

    /// Relative change of the increments in a round. The scale has three parts: the motion, the response to the contact force in one step, and the
    /// rounding of the state. A rotor coming to rest on the ring has only the last two. Changes due to a force of `rounding` \[N\] are ignored.
    /// `driven` is [`Spin::driven`](crate::engine) before the round.
    pub fn change(
        &self,
        line: &ShaftLine<'_>,
        driven: f64,
        (d, next): (&Increments, &Increments),
        normal: f64,
        rounding: f64,
    ) -> f64 {
        let responses = self.section.reach();
        let by_friction = self.friction * self.section.radius * self.section.torsional_reach();
        let size = line.lateral_scale(norm(&next.lateral) + normal * responses);
        let torsional_size = norm(&next.torsion) + normal * by_friction + line.torsional_scale() + f64::MIN_POSITIVE;
        let moved = (distance(&next.lateral, &d.lateral) - rounding * responses).max(0.0);
        let drive_change = (line.spin.driven() - driven).abs();
        let twisted = distance(&next.torsion, &d.torsion) + drive_change - rounding * by_friction;
        (moved / size).max(twisted.max(0.0) / torsional_size)
    }

    /// Error of the normal force due to rounding of the gap, the difference of two radii \[N\]. If the contact compliance is small, as for the full
    /// engine with a short step, the last digit of the radius changes the force by more than its convergence tolerance. The iteration then alternates
    /// between two neighbouring gaps.
    /// Verified by `a_small_gap_settles_in_both_engines` in `tests/contact/small_gap.rs`.
    pub fn rounding_of_force(&self) -> f64 {
        GAP_ROUNDINGS * f64::EPSILON * (self.section.radius + self.stator.gap) / self.scale()
    }

    /// Compliance of rotor and ring that converts a change of force into a change of position \[m/N\].
    pub fn scale(&self) -> f64 {
        let ring = self.stator.ring.as_ref();
        let ring = ring.map_or(0.0, |ring| dot(&ring.normal.force, &ring.normal.response));
        let rotor = &self.section.compliance;
        ring + rotor[0][0].max(rotor[1][1])
    }
}
