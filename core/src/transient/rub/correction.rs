//! The contact step: force, places and speeds iterated together.

use super::place_search::PlaceSearch;
use super::{Attempt, ContactFailure, Rounds, Rub, StepContact, TOLERANCE, bilinear, directions, on_rotor};
use crate::contact::{Compliance, ContactForce, Gap, NotUnique, Place, slide, stick_or_slide};
use crate::linalg::{axpy, dot};
use crate::transient::shaft_line::{ShaftLine, distance, norm};
use bladeoff_model::machine::{Detection, ForceLocation, FrictionLaw};

/// Roundings of a radius in a gap: of both components of `P - x`, its length, and the difference to R_r.
const GAP_ROUNDINGS: f64 = 16.0;

impl Rub<'_> {
    /// Corrects the predicted increments `(d, d_twist)` (in: without contact, out: with it).
    ///
    /// `line.settle` must be called by the caller with the result.
    pub fn correct(
        &mut self,
        line: &mut ShaftLine<'_>,
        time: f64,
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Result<Option<StepContact>, ContactFailure> {
        let x_n = self.local(line.place(self.node));
        if let Some(stiffness) = self.spring {
            return self.spring_contact(line, time, stiffness, x_n, d, d_twist);
        }
        let dx = self.increment(d);
        let predicted_x = [x_n[0] + dx[0], x_n[1] + dx[1]];
        self.release_ring();
        if self.is_far(predicted_x) {
            return Ok(None);
        }
        if let Some(ring) = &mut self.ring {
            ring.refresh_field();
        }
        let predicted = self.own_gap(predicted_x);
        if predicted.value >= 0.0 {
            return Ok(None);
        }
        let searched = self.ring.as_ref().filter(|_| self.detection != Detection::Hyp1);
        self.several_minima = searched.is_some_and(|ring| ring.detector.minima_within(self.rotor_radius) > 1);
        let force_place = match self.location {
            ForceLocation::Next => None,
            ForceLocation::Current => Some(self.gap_at(x_n)),
        };
        self.load_rows(force_place.as_ref().unwrap_or(&predicted), &predicted);
        let sign = self.centred_slip(line, &force_place.unwrap_or(predicted), d, d_twist).signum();
        let attempt = Attempt { x_n, sign, predicted, force_place, time };
        let (prediction, prediction_twist) = (d.to_vec(), d_twist.to_vec());
        let updating = self.detection != Detection::Hyp2Frozen;
        let mut no_fixed_point = false;
        let mut result = self.iterate(line, &attempt, updating, d, d_twist)?;
        if result.is_none() && updating {
            no_fixed_point = true;
            d.copy_from_slice(&prediction);
            d_twist.copy_from_slice(&prediction_twist);
            self.release_ring();
            if self.several_points
                && let Some(contact) = self.several(line, &attempt, d, d_twist)
            {
                return Ok(Some(contact));
            }
            d.copy_from_slice(&prediction);
            d_twist.copy_from_slice(&prediction_twist);
            self.release_ring();
            result = self.iterate(line, &attempt, false, d, d_twist)?;
        }
        let failure = if self.is_beyond(predicted_x) { ContactFailure::Outside } else { ContactFailure::NoConvergence };
        let (force, gap) = result.ok_or(failure)?;
        if force.normal <= 0.0 {
            return Ok(None);
        }
        Ok(Some(self.account(line, &attempt, (force, gap, no_fixed_point), d, d_twist)))
    }

    /// The ring's increment without contact.
    fn release_ring(&mut self) {
        self.spring_back();
        if let Some(ring) = &mut self.ring {
            ring.d.copy_from_slice(&ring.free);
        }
    }

    /// Iterates force, places and speeds; `None` without convergence.
    fn iterate(
        &mut self,
        line: &mut ShaftLine<'_>,
        attempt: &Attempt,
        updating: bool,
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Result<Option<(ContactForce, Gap)>, ContactFailure> {
        let (mut last, mut last_acting) = (ContactForce::NONE, attempt.predicted);
        let mut search = PlaceSearch::default();
        let mut rounds = Rounds::default();
        loop {
            self.iterations += 1;
            self.spring_back();
            self.give_way(&last_acting, last.normal);
            let x = self.after(attempt.x_n, d);
            if let Some(ring) = &mut self.ring {
                ring.refresh_field();
            }
            let gap = if updating { self.own_gap(x) } else { self.fixed_gap(x, attempt.predicted.place) };
            let acting = match attempt.force_place {
                Some(place) => place,
                None if !updating => gap,
                None => match search.next(gap.place.alpha) {
                    None => return Ok(None),
                    Some(alpha) if alpha == gap.place.alpha => gap,
                    Some(alpha) => self.acting_at(alpha, x, &gap),
                },
            };
            self.load_rows(&acting, &gap);
            let mut free = std::mem::take(&mut self.candidate);
            let mut free_twist = std::mem::take(&mut self.candidate_twist);
            let driven = line.driven();
            line.respond(attempt.time, d, d_twist, &mut free, &mut free_twist);
            // the gap is under the last force: the modes left out follow the new one instead
            let sprung = Gap { value: gap.value - self.residual_between(&gap, &last_acting) * last.normal, ..gap };
            let solved = self.solve(&sprung, &acting, attempt.sign, (d, &free, &free_twist));
            let force = match solved {
                Ok(force) => force,
                Err(error) => {
                    (self.candidate, self.candidate_twist) = (free, free_twist);
                    return Err(ContactFailure::NotUnique(error));
                }
            };
            self.apply(&force, &acting, &mut free, &mut free_twist);
            line.add_drive_torque(self.drive_lever * force.tangential * self.rotor_radius);
            let change = (force.normal - last.normal).abs().max((force.tangential - last.tangential).abs());
            let moved = self.change(line, driven, (d, d_twist), (&free, &free_twist), force.normal);
            let steady =
                change * self.scale() <= 1e-14 * self.rotor_radius.max(self.gap) + 1e-11 * force.normal * self.scale();
            d.copy_from_slice(&free);
            d_twist.copy_from_slice(&free_twist);
            (self.candidate, self.candidate_twist) = (free, free_twist);
            (last, last_acting) = (force, acting);
            if rounds.done > 0 && moved <= TOLERANCE && steady && self.ring_settled() {
                return Ok(Some((force, gap)));
            }
            if !rounds.another(moved) {
                return Ok(None);
            }
        }
    }

    /// The gap record of a force that acts at another angle than the gap's own.
    fn acting_at(&self, alpha: f64, x: [f64; 2], gap: &Gap) -> Gap {
        let place = Place::at_angle(self.ring.as_ref().map(|_| &self.surface), alpha);
        match self.detection {
            Detection::Hyp1 => Gap { place, ..*gap },
            Detection::Hyp2 | Detection::Hyp2Frozen => self.fixed_gap(x, place),
        }
    }

    /// Force on the linearised gap and slip.
    fn solve(
        &self,
        gap: &Gap,
        acting: &Gap,
        sign: f64,
        (d, free, free_twist): (&[f64], &[f64], &[f64]),
    ) -> Result<ContactForce, NotUnique> {
        let (dx, dx_free) = (self.increment(d), self.increment(free));
        let change = gap.place.polar([dx_free[0] - dx[0], dx_free[1] - dx[1]]);
        let mut g0 = gap.value + gap.rotor_gradient[0] * change[0] + gap.rotor_gradient[1] * change[1];
        let (normal, tangent) = directions(acting);
        let gradient = gap.place.cartesian(gap.rotor_gradient);
        let along = |a, b| bilinear(&self.compliance, a, b);
        let radius = self.rotor_radius;
        let mut w = Compliance {
            nn: -along(gradient, normal),
            nt: -along(gradient, tangent),
            tn: -along(tangent, normal),
            tt: -along(tangent, tangent) - radius * radius * self.twist_compliance,
        };
        let mut slip = tangent[0] * dx_free[0] + tangent[1] * dx_free[1] + radius * dot(&self.twist_row, free_twist);
        if let Some(ring) = &self.ring {
            g0 += dot(&ring.gap_row, &ring.free) - dot(&ring.gap_row, &ring.d);
            w.nn += dot(&ring.gap_row, &ring.normal.response);
            w.nt += dot(&ring.gap_row, &ring.tangent.response);
            w.tn -= dot(&ring.tangent.force, &ring.normal.response);
            w.tt -= dot(&ring.tangent.force, &ring.tangent.response);
            slip -= dot(&ring.tangent.force, &ring.free);
        }
        w.nn += self.residual_between(gap, acting);
        match self.law {
            FrictionLaw::Slip => slide(g0, w, self.friction, sign),
            FrictionLaw::StickSlip => stick_or_slide(g0, slip, w, self.friction),
        }
    }

    /// Adds the response to a contact force to increments without it; the ring's increment becomes the one with it.
    pub(super) fn apply(&mut self, force: &ContactForce, acting: &Gap, free: &mut [f64], free_twist: &mut [f64]) {
        for (f, response) in on_rotor(force, acting).into_iter().zip(&self.responses) {
            axpy(f, response, free);
        }
        axpy(-force.tangential * self.rotor_radius, &self.twist_response, free_twist);
        if let Some(ring) = &mut self.ring {
            ring.scratch.copy_from_slice(&ring.d);
            ring.d.copy_from_slice(&ring.free);
            axpy(force.normal, &ring.normal.response, &mut ring.d);
            axpy(force.tangential, &ring.tangent.response, &mut ring.d);
        }
    }

    pub(super) fn ring_settled(&self) -> bool {
        // rounding of the gap (1e-16 of the radius) is the floor of what the ring's increment can settle to
        let floor = 1e-13 * self.rotor_radius.max(self.gap);
        self.ring.as_ref().is_none_or(|ring| {
            let scale = ring.radial_bound.iter().fold(0.0_f64, |max, bound| max.max(*bound));
            distance(&ring.d, &ring.scratch) * scale <= 1e-10 * norm(&ring.d) * scale + floor
        })
    }

    /// Change of the increments in a round, relative to their size: that of the motion, that of what the contact force alone
    /// makes of a step, and rounding of the state. A rotor that comes to rest on the ring has none but the last two. What rounding
    /// of the gap makes of them ([`Rub::rounding_of_force`]) counts as none.
    pub(super) fn change(
        &self,
        line: &ShaftLine<'_>,
        driven: f64,
        (d, d_twist): (&[f64], &[f64]),
        (next, next_twist): (&[f64], &[f64]),
        normal: f64,
    ) -> f64 {
        let responses = norm(&self.responses[0]) + norm(&self.responses[1]);
        let by_friction = self.friction * self.rotor_radius * norm(&self.twist_response);
        let rounding = self.rounding_of_force();
        let size = line.lateral_scale(norm(next) + normal * responses);
        let twist_size = norm(next_twist) + normal * by_friction + line.twist_scale() + f64::MIN_POSITIVE;
        let moved = (distance(next, d) - rounding * responses).max(0.0);
        let twisted = distance(next_twist, d_twist) + (line.driven() - driven).abs() - rounding * by_friction;
        (moved / size).max(twisted.max(0.0) / twist_size)
    }

    /// What rounding of the gap, the difference of two radii, makes of the normal force \[N\]: a contact of small compliance, as that of
    /// full finite elements over a short step, turns the last digit of the radius into more than what the force settles to, and the
    /// iteration then takes turns between two neighbouring gaps. None on a spring, whose force is not found from a gap to be closed.
    /// Verified by `a_small_gap_settles_in_both_engines` in `tests/small_gap.rs`.
    pub(super) fn rounding_of_force(&self) -> f64 {
        if self.spring.is_some() {
            return 0.0;
        }
        GAP_ROUNDINGS * f64::EPSILON * (self.rotor_radius + self.gap) / self.scale()
    }

    /// Compliance that turns a change of force into a change of place \[m/N\].
    fn scale(&self) -> f64 {
        let ring = self.ring.as_ref().map_or(0.0, |ring| dot(&ring.normal.force, &ring.normal.response));
        ring + self.compliance[0][0].max(self.compliance[1][1])
    }

    /// Ring rows of the force place and of the gap place.
    fn load_rows(&mut self, acting: &Gap, gap: &Gap) {
        if let Some(ring) = &mut self.ring {
            let [n_r, n_t] = acting.normal;
            let (mut normal, mut tangent) = (std::mem::take(&mut ring.normal), std::mem::take(&mut ring.tangent));
            ring.load(acting.place, [n_r, n_t], &self.surface, &mut normal);
            ring.load(acting.place, [-n_t, n_r], &self.surface, &mut tangent);
            (ring.normal, ring.tangent) = (normal, tangent);
            ring.load_gap_row(gap, &self.surface);
        }
    }

    /// Centred slip velocity of increments at the place whose rows are loaded \[m/s\].
    pub(super) fn centred_slip(&self, line: &ShaftLine<'_>, acting: &Gap, d: &[f64], d_twist: &[f64]) -> f64 {
        let (_, tangent) = directions(acting);
        let dx = self.increment(d);
        let before = self.increment(&line.lateral.previous);
        let mut slip = tangent[0] * (dx[0] + before[0]) + tangent[1] * (dx[1] + before[1]);
        slip += self.rotor_radius * (dot(&self.twist_row, d_twist) + dot(&self.twist_row, &line.twist.previous));
        if let Some(ring) = &self.ring {
            slip -= dot(&ring.tangent.force, &ring.d) + dot(&ring.tangent.force, &ring.stepper.previous);
        }
        0.5 * slip / line.dt
    }

    /// Works and quantities of a converged contact step.
    fn account(
        &mut self,
        line: &ShaftLine<'_>,
        attempt: &Attempt,
        (force, gap, no_fixed_point): (ContactForce, Gap, bool),
        d: &[f64],
        d_twist: &[f64],
    ) -> StepContact {
        let acting = attempt.force_place.unwrap_or(gap);
        let slip = self.centred_slip(line, &acting, d, d_twist);
        let (normal, _) = directions(&acting);
        let (dx, before) = (self.increment(d), self.increment(&line.lateral.previous));
        let step = [0.5 * (dx[0] + before[0]), 0.5 * (dx[1] + before[1])];
        let mut opening = -(normal[0] * step[0] + normal[1] * step[1]);
        if let Some(ring) = &self.ring {
            opening += 0.5 * (dot(&ring.normal.force, &ring.d) + dot(&ring.normal.force, &ring.stepper.previous));
        }
        // Hyp 1: the approximate gap opens by v_alpha d(gamma) more than the bodies move apart
        let model_work = force.normal * acting.model_slope * acting.place.polar(step)[1];
        self.held = 0.5 * force.normal * force.normal * self.residual_between(&acting, &acting);
        self.spring_back();
        self.give_way(&acting, force.normal);
        let residual = if self.detection == Detection::Hyp2Frozen || no_fixed_point {
            let x = self.after(attempt.x_n, d);
            if let Some(ring) = &mut self.ring {
                ring.refresh_field();
            }
            self.own_gap(x)
        } else {
            gap
        };
        StepContact {
            force,
            on_rotor: on_rotor(&force, &acting),
            gap: residual,
            slip,
            reversed: self.law == FrictionLaw::Slip && slip * attempt.sign < 0.0,
            no_fixed_point,
            several_minima: self.several_minima,
            points: 1,
            friction_work: force.tangential * slip * line.dt,
            normal_work: -force.normal * opening - model_work,
            model_work,
        }
    }
}
