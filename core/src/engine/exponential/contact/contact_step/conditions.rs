//! Conditions of the contact points of a step: gap and slip at each of them, as linear functions of the impulses at all.
//!
//! ```text
//! (g, s)_k = (g, s)_k(free) + sum_l W_kl (J_n, J_t)_l       g: gap at n+1 \[m\];  s: slip over the step \[m\]            (1)
//! ```
//! W_kl is a 2 x 2 block of the Delassus operator. Its part of the ring's modes is a product of rows of the points
//! ([`PointRows`](super::super::ring_kernels::PointRows)), that of the truncated modes and of the rotor comes from
//! [`DelassusOperator`]. The impulses that the predictor has assumed are taken out of the free values.

use super::super::contact_point::ContactPoint;
use super::super::contact_step_result::FreeStep;
use super::super::delassus_operator::DelassusOperator;
use super::super::gap_minimum::GapMinimum;
use super::super::penetration::AfterImpulses;
use super::super::ring_kernels::{StepState, add_scaled_rows, row_products, write_rows};
use super::super::ring_points::{are_adjacent, parabola};
use super::ContactStep;
use crate::contact::ContactReaction;
use crate::eight::{Eight, by_width};
use crate::engine::exponential::plane::{across, product};

impl ContactStep {
    /// Adds a contact point whose rows are written to `slot`.
    #[inline(always)]
    fn add_point<V: Eight>(
        &mut self,
        position: &GapMinimum,
        slot: usize,
        free: &FreeStep<'_>,
        operator: &DelassusOperator,
    ) {
        let position = *position;
        let Self { ring_points, point_rows, current, predictor, compliance, pressed, .. } = self;
        let count = ring_points.count();
        let previous = pressed.iter().find(|last| are_adjacent(last.position.index, position.index, count));
        let (acting, force, acting_slot) = match previous {
            Some(last) => (last.position, last.force, Some(last.slot)),
            None => (position, ContactReaction::NONE, None),
        };
        let [before, behind] = ring_points.neighbours(position.index);
        let three = [ring_points.rows(before), ring_points.rows(position.index), ring_points.rows(behind)];
        let [first, second] = point_rows;
        let (rows, last_rows) = if *current == 0 { (first, second) } else { (second, first) };
        let sums = write_rows::<V>(
            three,
            parabola(position.offset),
            [position.polar, across(position.polar)],
            acting_slot.map(|slot| last_rows[slot].along()),
            StepState { compliance, travel: &predictor.ring_travel, assumed: &predictor.ring_correction },
            &mut rows[slot],
        );
        let self_coupling = operator.coupling(ring_points, &position, &acting, sums.coupling);
        let closure = DelassusOperator::previous_truncated_response(ring_points, &position, pressed);
        let step = self.axes.to_stator([free.end[0] - free.start[0], free.end[1] - free.start[1]]);
        let tangent = across(position.normal);
        let slip = product(tangent, step) + free.surface_turn * self.radius - sums.travel_along_tangent;
        let free_gap_slip = [
            position.gap - sums.assumed_opening - closure + product(position.normal, self.predictor.rotor_correction),
            slip - product(tangent, self.predictor.rotor_travel_correction),
        ];
        self.points.push(ContactPoint {
            position,
            acting,
            acting_slot,
            slot,
            self_coupling,
            free: free_gap_slip,
            force,
        });
    }

    /// Writes the conditions of the points from index `from` on, and of a replaced one.
    #[inline(always)]
    pub(in super::super) fn write_conditions<V: Eight>(
        &mut self,
        from: usize,
        replaced: Option<usize>,
        operator: &DelassusOperator,
    ) {
        let Self { conditions, points, point_rows, current, ring_points, .. } = self;
        let (rows, replaced) = (&point_rows[*current], replaced.unwrap_or(usize::MAX));
        for (k, point) in points.iter().enumerate() {
            conditions.start[k] = point.free;
            for (j, acting) in points.iter().enumerate() {
                if k == j {
                    // the solver may have added a small compliance to the diagonal
                    conditions.w[k][k] = point.self_coupling;
                } else if k >= from || j >= from || k == replaced || j == replaced {
                    let modal_coupling = row_products::<V>(rows[point.slot].along(), rows[acting.slot].responses());
                    conditions.w[k][j] =
                        operator.coupling(ring_points, &point.position, &acting.acting, modal_coupling);
                }
            }
        }
    }

    /// Evaluates the response of the ring's modes at n+1 to all impulses, less the predicted one.
    #[inline(always)]
    pub(in super::super) fn evaluate_ring_response<V: Eight>(&mut self) {
        let Self { impulses: response, points, point_rows, current, predictor, .. } = self;
        for (response, correction) in response.iter_mut().zip(&predictor.ring_correction) {
            (V::all(0.0) - V::load(correction)).store(response);
        }
        for point in points.iter().filter(|point| point.force.normal > 0.0) {
            add_scaled_rows::<V>(
                [point.force.normal, point.force.tangential],
                point_rows[*current][point.slot].responses(),
                response,
            );
        }
    }

    /// Smallest negative gap under the impulses found, apart from the contact points, and the index of its ring point; 0 and
    /// `None` without one. Uses the response of [`ContactStep::evaluate_ring_response`].
    #[inline(always)]
    pub(super) fn find_penetration<V: Eight>(
        &mut self,
        x: [f64; 2],
        operator: &DelassusOperator,
    ) -> (f64, Option<usize>) {
        let Self { penetration, broad_phase, ring_points, points, predictor, impulses, pressed, .. } = self;
        penetration.closest_violated_point::<V>(
            broad_phase,
            &AfterImpulses { ring_points, points, predictor, operator, impulses, x, pressed },
        )
    }
}

by_width! {
    /// Adds a point; a function of its own because it is called from several places.
    pub(in super::super) fn add_point(contact: &mut ContactStep, position: &GapMinimum, slot: usize, free: &FreeStep<'_>, operator: &DelassusOperator) = add_point_kernel
}

#[inline(always)]
fn add_point_kernel<V: Eight>(
    contact: &mut ContactStep,
    position: &GapMinimum,
    slot: usize,
    free: &FreeStep<'_>,
    operator: &DelassusOperator,
) {
    contact.add_point::<V>(position, slot, free, operator);
}
