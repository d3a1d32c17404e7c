//! The two bodies of a contact, and what its forces make of their increments over a step.

use super::axes::{directions, on_rotor};
use super::left_out::LeftOut;
use super::section::Section;
use super::stator::Stator;
use crate::contact::{ContactReaction, Gap};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_model::machine::FrictionLaw;
use bladeoff_numerics::linalg::{axpy, distance, dot, norm};

/// Roundings of a radius in a gap: of both components of `P - x`, its length, and the difference to R_r.
const GAP_ROUNDINGS: f64 = 16.0;

/// Rotor and stator of one diaphragm.
pub(super) struct Bodies<'a> {
    pub section: Section,
    pub stator: Stator<'a>,
    pub left_out: LeftOut<'a>,
    pub friction: f64,
    pub law: FrictionLaw,
}

impl Bodies<'_> {
    /// Rotor centre at n+1 in the stator's frame by increments, the modes left out included.
    pub fn after(&self, x_n: [f64; 2], d: &Increments) -> [f64; 2] {
        let dx = self.section.increment(&d.lateral);
        std::array::from_fn(|axis| x_n[axis] + dx[axis] + self.left_out.shift[axis])
    }

    /// Back to the step without contact, as far as the stator and the modes left out know it.
    pub fn release(&mut self) {
        self.left_out.spring_back();
        self.left_out.held = 0.0;
        if let Some(ring) = &mut self.stator.ring {
            ring.release();
        }
    }

    /// The field of the stator at n+1.
    pub fn field_after(&mut self) {
        self.stator.field_after(&self.left_out);
    }

    /// The gap at n, of a rotor centre without the modes left out, in the run's own gap function, as the contact of the step before
    /// left it: its force is the one that was to leave none here.
    pub fn gap_at_n(&mut self, x: [f64; 2]) -> Gap {
        self.stator.gap_at_n(x, &self.left_out)
    }

    /// Gap at one place by a unit normal force at another, of the modes left out \[m/N\].
    pub fn left_out_between(&self, at: &Gap, acting: &Gap) -> f64 {
        self.left_out.between(&self.stator.surface, at, acting)
    }

    /// Adds a contact force that the truncated modes follow.
    pub fn give_way(&mut self, acting: &Gap, force: &ContactReaction) {
        self.left_out.give_way(&self.stator.surface, acting, force);
    }

    /// Ring rows of the place that the force acts at, and of the gap's.
    pub fn load_rows(&mut self, acting: &Gap, gap: &Gap) {
        if let Some(ring) = &mut self.stator.ring {
            ring.load_rows(acting, gap, &self.stator.surface);
        }
    }

    /// Adds the response to a contact force to increments without it; the ring's increment becomes the one with it.
    pub fn push(&mut self, force: &ContactReaction, acting: &Gap, free: &mut Increments) {
        self.section.push(on_rotor(force, acting), force.tangential, free);
        if let Some(ring) = &mut self.stator.ring {
            ring.restart();
            axpy(force.normal, &ring.normal.response, &mut ring.d);
            axpy(force.tangential, &ring.tangent.response, &mut ring.d);
        }
    }

    /// Centred slip velocity of increments at the place whose rows are loaded \[m/s\].
    pub fn centred_slip(&self, line: &ShaftLine<'_>, acting: &Gap, d: &Increments) -> f64 {
        let (_, tangent) = directions(acting);
        let (before, twist_before) = (&line.lateral.stepper.previous, &line.twist.stepper.previous);
        let (dx, before) = (self.section.increment(&d.lateral), self.section.increment(before));
        let mut slip = tangent[0] * (dx[0] + before[0]) + tangent[1] * (dx[1] + before[1]);
        slip += self.section.radius * (self.section.turn(&d.twist) + self.section.turn(twist_before));
        if let Some(ring) = &self.stator.ring {
            slip -= dot(&ring.tangent.force, &ring.d) + dot(&ring.tangent.force, &ring.stepper.previous);
        }
        0.5 * slip / line.dt
    }

    /// Whether the increment of the ring has settled in the last round.
    pub fn ring_settled(&self) -> bool {
        // rounding of the gap (1e-16 of the radius) is the floor of what the ring's increment can settle to
        let floor = 1e-13 * self.section.radius.max(self.stator.gap);
        self.stator.ring.as_ref().is_none_or(|ring| ring.settled(floor))
    }

    /// Change of the increments in a round, relative to their size: that of the motion, that of what the contact force alone
    /// makes of a step, and rounding of the state. A rotor that comes to rest on the ring has none but the last two. What
    /// `rounding` of the force \[N\] makes of them counts as none. `driven` is [`Spin::driven`](crate::engine) before the round.
    pub fn change(
        &self,
        line: &ShaftLine<'_>,
        driven: f64,
        (d, next): (&Increments, &Increments),
        normal: f64,
        rounding: f64,
    ) -> f64 {
        let responses = self.section.reach();
        let by_friction = self.friction * self.section.radius * self.section.twist_reach();
        let size = line.lateral_scale(norm(&next.lateral) + normal * responses);
        let twist_size = norm(&next.twist) + normal * by_friction + line.twist_scale() + f64::MIN_POSITIVE;
        let moved = (distance(&next.lateral, &d.lateral) - rounding * responses).max(0.0);
        let drive_change = (line.spin.driven() - driven).abs();
        let twisted = distance(&next.twist, &d.twist) + drive_change - rounding * by_friction;
        (moved / size).max(twisted.max(0.0) / twist_size)
    }

    /// What rounding of the gap, the difference of two radii, makes of the normal force \[N\]: a contact of small compliance, as that of
    /// full finite elements over a short step, turns the last digit of the radius into more than what the force settles to, and the
    /// iteration then takes turns between two neighbouring gaps.
    /// Verified by `a_small_gap_settles_in_both_engines` in `tests/contact/small_gap.rs`.
    pub fn rounding_of_force(&self) -> f64 {
        GAP_ROUNDINGS * f64::EPSILON * (self.section.radius + self.stator.gap) / self.scale()
    }

    /// Compliance that turns a change of force into a change of place \[m/N\].
    pub fn scale(&self) -> f64 {
        let ring = self.stator.ring.as_ref();
        let ring = ring.map_or(0.0, |ring| dot(&ring.normal.force, &ring.normal.response));
        let rotor = &self.section.compliance;
        ring + rotor[0][0].max(rotor[1][1])
    }
}
