//! Contact place of `hyp2` with `contact.points = "one"`: the point of the ring that is nearest to the rotor under its own impulse.
//!
//! ```text
//! P = nearest point of the ring at n+1 under (J_n, J_t),   (J_n, J_t) solves g(P) + W J_n = 0 at P              (1)
//! ```
//! The impulse at a place moves the nearest point. (1) is iterated from the nearest point without impulses on, by the secant
//! through the last two rounds ([`PlaceSearch`]). The nearest point of a round is that reached downhill from its place.
//!
//! (1) has no solution where a place is pressed away before the rotor touches it. The step then has the place without
//! impulses, as `hyp2-frozen`, and is counted (`no_fixed_point_steps`).
//!
//! Source: Algorithm 1 of DETC2007-34625 with its loop condition corrected, as on the reduced engine (`engine/rub/one_point.rs`).
//! Limits: those of [`super::single_place`]; the truncated modes are not in the place. Verified by `tests/contact/one_point.rs`.

use super::contact_step::{ContactStep, add_point};
use super::contact_step_result::FreeStep;
use super::delassus_operator::DelassusOperator;
use super::gap_minimum::GapMinimum;
use super::single_place::nearest_from;
use crate::contact::{ContactReaction, PlaceSearch, complementarity};
use crate::eight::Eight;

/// Largest number of rounds of a step.
const MAX_ROUNDS: usize = 40;
/// Distance of two places below which they are the same, in spacings of the ring points: 1e-12 m of the gap.
const SAME_PLACE: f64 = 1e-3;

impl ContactStep {
    /// Moves the place of the step until it is the nearest point under its own impulse (1), from the solution at the place without
    /// impulses on. `rotor`: predicted displacement of the rotor. `None` where no impulses fulfil the contact conditions.
    #[inline(always)]
    pub(super) fn find_fixed_point<V: Eight>(
        &mut self,
        rotor: [f64; 2],
        free: &FreeStep<'_>,
        operator: &DelassusOperator,
    ) -> Option<()> {
        let start = self.points.first()?.position;
        let mut search = PlaceSearch::default();
        search.next(self.angle_of(&start));
        let mut place = start;
        for _ in 0..MAX_ROUNDS {
            if self.points.first()?.force.normal <= 0.0 {
                break;
            }
            self.evaluate_ring_response::<V>();
            let x = self.move_by_impulses::<V>(rotor, operator);
            let radii = [self.broad_phase.radius, self.broad_phase.rotor_radius];
            let found = nearest_from(&self.ring_points, radii, place.index, x, &self.impulses);
            if self.apart(&found, &place) < SAME_PLACE {
                return Some(());
            }
            let Some(angle) = search.next(self.angle_of(&found)) else { break };
            place = self.place_on_predicted_motion::<V>(self.ring_points.locate(angle), rotor);
            if self.solve_at::<V>(&place, free, operator).is_none() {
                break;
            }
        }
        self.has_fixed_point = false;
        self.solve_at::<V>(&start, free, operator)
    }

    /// Solves the contact conditions at one place.
    #[inline(always)]
    fn solve_at<V: Eight>(
        &mut self,
        place: &GapMinimum,
        free: &FreeStep<'_>,
        operator: &DelassusOperator,
    ) -> Option<()> {
        self.points.clear();
        add_point(self, place, 0, free, operator);
        self.write_conditions::<V>(0, None, operator);
        self.forces.clear();
        self.forces.push(ContactReaction::NONE);
        complementarity::solve(&mut self.conditions, &mut self.forces)?;
        self.points[0].force = self.forces[0];
        Some(())
    }

    /// Angle of a place \[rad\].
    fn angle_of(&self, place: &GapMinimum) -> f64 {
        (place.index as f64 + 0.5 + place.offset) * self.ring_points.spacing
    }

    /// Distance of two places, in spacings of the ring points.
    fn apart(&self, one: &GapMinimum, other: &GapMinimum) -> f64 {
        let count = self.ring_points.count() as f64;
        let apart = (one.index as f64 + one.offset - other.index as f64 - other.offset).abs();
        apart.min(count - apart)
    }
}
