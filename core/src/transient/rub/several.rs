//! Several contact points on one ring, where one point has no fixed point.
//!
//! Contact along the whole ring is a complementarity problem with a condition at every angle:
//! ```text
//! g(alpha) >= 0 for all alpha,   lambda(alpha) >= 0,   lambda(alpha) g(alpha) = 0
//! ```
//! It is solved by exchange: the conditions at a few kept angles first (from the predicted place on), then the minima
//! that still penetrate are added, until none does. At a kept angle the distance `|P(alpha) - x|` and its gradient are exact,
//! so no place has to be found and nothing alternates. The forces at the kept angles are those of `coupled`.
//! Source: physics.md section 3 ("the true remedy ... several contact points per ring"); the exchange method for
//! semi-infinite conditions. Verified by `several_points_leave_no_penetration`, `high_friction_invents_no_energy`
//! (`core/tests/whip.rs`).

use super::coupled::{Block, Coupled, POINTS};
use super::ring::RingForce;
use super::{Attempt, Rounds, Rub, StepContact, bilinear, directions, on_rotor};
use crate::contact::{ContactForce, Gap, Place};
use crate::linalg::{axpy, dot};
use crate::transient::shaft_line::ShaftLine;
use bladeoff_model::machine::FrictionLaw;

/// A minimum penetrates when it is deeper than this share of the predicted penetration.
const SHARE: f64 = 1e-4;
/// Convergence of increments, relative: close points share their force in ways that hardly differ.
const TOLERANCE: f64 = 1e-9;
/// Convergence of increments that is enough where close points go on exchanging force.
const LOOSE: f64 = 1e-5;
/// Two angles closer than this are one \[rad\].
const SAME: f64 = 2e-3;

/// One kept place with the rows of its unit forces on the ring and their responses.
pub(super) struct Point {
    place: Place,
    gap: Gap,
    normal: RingForce,
    tangent: RingForce,
    force: ContactForce,
}

impl Rub<'_> {
    /// Corrects the predicted increments with as many points as it takes; `None` where the ring, the solve or the number of
    /// points does not allow it.
    pub(super) fn several(
        &mut self,
        line: &mut ShaftLine<'_>,
        attempt: &Attempt,
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Option<StepContact> {
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        let done = self.exchange(line, attempt, &mut points, d, d_twist);
        let contact = done.map(|deepest| self.account_points(line, &points, deepest, (d, d_twist)));
        self.points = points;
        contact.filter(|contact| contact.force.normal > 0.0)
    }

    /// Adds the minima that penetrate until none does; the deepest minimum that is left.
    fn exchange(
        &mut self,
        line: &mut ShaftLine<'_>,
        attempt: &Attempt,
        points: &mut Vec<Point>,
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Option<Gap> {
        let allowed = -SHARE * attempt.predicted.value.abs();
        points.push(self.point(attempt.predicted.place)?);
        loop {
            self.hold(line, attempt, points, d, d_twist)?;
            self.follow(points);
            let mut minima = self.minima(self.after(attempt.x_n, d));
            let deepest = *minima.first()?;
            minima.retain(|gap| {
                let kept = |point: &Point| angle_between(point.place.alpha, gap.place.alpha) < SAME;
                gap.value < allowed && !points.iter().any(kept)
            });
            minima.truncate(POINTS - points.len());
            // what is left without another point is still less than one point leaves, and reported as penetration
            if minima.is_empty() {
                return Some(deepest);
            }
            for gap in minima {
                points.push(self.point(gap.place)?);
            }
        }
    }

    fn point(&self, place: Place) -> Option<Point> {
        let size = self.ring.as_ref()?.d.len();
        let rows = || RingForce { force: vec![0.0; size], response: vec![0.0; size] };
        let gap = self.fixed_gap([0.0; 2], place);
        Some(Point { place, gap, normal: rows(), tangent: rows(), force: ContactForce::NONE })
    }

    /// Solves for the forces at kept places, the non-linear terms of the shaft line with them. Points that are nearly one may
    /// go on exchanging force without end: what they exchange is then smaller than [`LOOSE`].
    fn hold(
        &mut self,
        line: &mut ShaftLine<'_>,
        attempt: &Attempt,
        points: &mut [Point],
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Option<()> {
        let mut rounds = Rounds::default();
        loop {
            self.iterations += 1;
            self.follow(points);
            let x = self.after(attempt.x_n, d);
            self.ring.as_mut()?.refresh_field();
            for point in points.iter_mut() {
                point.gap = self.fixed_gap(x, point.place);
                let [n_r, n_t] = point.gap.normal;
                let ring = self.ring.as_ref()?;
                ring.load(point.place, [n_r, n_t], &self.surface, &mut point.normal);
                ring.load(point.place, [-n_t, n_r], &self.surface, &mut point.tangent);
            }
            let mut free = std::mem::take(&mut self.candidate);
            let mut free_twist = std::mem::take(&mut self.candidate_twist);
            let driven = line.driven();
            line.respond(attempt.time, d, d_twist, &mut free, &mut free_twist);
            let before: f64 = points.iter().map(|p| p.force.normal).sum();
            let solved = self.solve_points(points, attempt.sign, (d, &free, &free_twist));
            self.apply_points(points, &mut free, &mut free_twist);
            let torque: f64 = points.iter().map(|p| p.force.tangential * self.rotor_radius).sum();
            line.add_drive_torque(self.drive_lever * torque);
            let after: f64 = points.iter().map(|p| p.force.normal).sum();
            let change = self.change(line, driven, (d, d_twist), (&free, &free_twist), after);
            let steady = (after - before).abs() <= 1e-9 * after + self.rounding_of_force();
            d.copy_from_slice(&free);
            d_twist.copy_from_slice(&free_twist);
            (self.candidate, self.candidate_twist) = (free, free_twist);
            solved?;
            if rounds.done > 0 && change <= TOLERANCE && steady && self.ring_settled() {
                return Some(());
            }
            if !rounds.another(change) {
                return (change <= LOOSE).then_some(());
            }
        }
    }

    /// The forces at the kept points, from those that are there.
    fn solve_points(
        &self,
        points: &mut [Point],
        sign: f64,
        (d, free, free_twist): (&[f64], &[f64], &[f64]),
    ) -> Option<()> {
        let (friction, law) = (self.friction, self.law);
        let mut coupled = Coupled { w: Default::default(), start: [[0.0; 2]; POINTS], friction, law, sign };
        let mut forces = [ContactForce::NONE; POINTS];
        let (dx, dx_free) = (self.increment(d), self.increment(free));
        let turn = self.rotor_radius * dot(&self.twist_row, free_twist);
        for (k, point) in points.iter().enumerate() {
            let (n, t) = directions(&point.gap);
            let (mut gap, mut slip) = (point.gap.value, t[0] * dx_free[0] + t[1] * dx_free[1] + turn);
            gap -= n[0] * (dx_free[0] - dx[0]) + n[1] * (dx_free[1] - dx[1]);
            if let Some(ring) = &self.ring {
                gap += dot(&point.normal.force, &ring.free) - dot(&point.normal.force, &ring.d);
                slip -= dot(&point.tangent.force, &ring.free);
            }
            for (j, other) in points.iter().enumerate() {
                let left_out = self.residual_between(&point.gap, &other.gap);
                // the gap is under the last forces: the modes left out follow the new ones instead
                gap -= left_out * other.force.normal;
                coupled.w[k][j] = self.coupling(point, other, left_out);
            }
            (coupled.start[k], forces[k]) = ([gap, slip], point.force);
        }
        coupled.solve(&mut forces[..points.len()])?;
        for (point, force) in points.iter_mut().zip(forces) {
            point.force = force;
        }
        Some(())
    }

    /// Gap and slip at point `k` by a unit normal and a unit tangential force at point `j` \[m/N\].
    fn coupling(&self, k: &Point, j: &Point, left_out: f64) -> Block {
        let ((n_k, t_k), (n_j, t_j)) = (directions(&k.gap), directions(&j.gap));
        let rotor = |a, b| bilinear(&self.compliance, a, b);
        let twist = self.rotor_radius * self.rotor_radius * self.twist_compliance;
        [
            [
                rotor(n_k, n_j) + dot(&k.normal.force, &j.normal.response) + left_out,
                rotor(n_k, t_j) + dot(&k.normal.force, &j.tangent.response),
            ],
            [
                -rotor(t_k, n_j) - dot(&k.tangent.force, &j.normal.response),
                -rotor(t_k, t_j) - twist - dot(&k.tangent.force, &j.tangent.response),
            ],
        ]
    }

    fn apply_points(&mut self, points: &[Point], free: &mut [f64], free_twist: &mut [f64]) {
        if let Some(ring) = &mut self.ring {
            ring.scratch.copy_from_slice(&ring.d);
            ring.d.copy_from_slice(&ring.free);
        }
        for point in points {
            let (force, (normal, tangent)) = (&point.force, directions(&point.gap));
            for axis in 0..2 {
                let f = -(force.normal * normal[axis] + force.tangential * tangent[axis]);
                axpy(f, &self.responses[axis], free);
            }
            axpy(-force.tangential * self.rotor_radius, &self.twist_response, free_twist);
            if let Some(ring) = &mut self.ring {
                axpy(force.normal, &point.normal.response, &mut ring.d);
                axpy(force.tangential, &point.tangent.response, &mut ring.d);
            }
        }
    }

    /// The modes left out follow the forces of all points.
    fn follow(&mut self, points: &[Point]) {
        self.spring_back();
        for point in points.iter().filter(|point| point.force.normal > 0.0) {
            self.give_way(&point.gap, point.force.normal);
        }
    }

    /// The gaps at all minima, the deepest first.
    fn minima(&mut self, x: [f64; 2]) -> Vec<Gap> {
        let mut places = std::mem::take(&mut self.places);
        if let Some(ring) = &mut self.ring {
            ring.refresh_field();
            ring.detector.minima(&ring.field, x, &mut places);
        }
        let mut gaps: Vec<Gap> = places.iter().map(|&place| self.fixed_gap(x, place)).collect();
        gaps.sort_by(|a, b| a.value.total_cmp(&b.value));
        self.places = places;
        gaps
    }

    /// Works and quantities of a step with several points.
    fn account_points(
        &mut self,
        line: &ShaftLine<'_>,
        points: &[Point],
        deepest: Gap,
        (d, d_twist): (&[f64], &[f64]),
    ) -> StepContact {
        let (dx, before) = (self.increment(d), self.increment(&line.lateral.previous));
        let step = [0.5 * (dx[0] + before[0]), 0.5 * (dx[1] + before[1])];
        let turned = dot(&self.twist_row, d_twist) + dot(&self.twist_row, &line.twist.previous);
        let turn = 0.5 * self.rotor_radius * turned;
        let mut sum = StepContact {
            force: ContactForce { normal: 0.0, tangential: 0.0, sticks: true },
            on_rotor: [0.0; 2],
            gap: deepest,
            slip: 0.0,
            reversed: false,
            no_fixed_point: true,
            several_minima: self.several_minima,
            points: 0,
            friction_work: 0.0,
            normal_work: 0.0,
            model_work: 0.0,
        };
        (self.held, sum.points) = (0.0, 0);
        let mut most = 0.0;
        for point in points.iter().filter(|point| point.force.normal > 0.0) {
            let (n, t) = directions(&point.gap);
            let (mut opening, mut slip) = (-(n[0] * step[0] + n[1] * step[1]), t[0] * step[0] + t[1] * step[1] + turn);
            if let Some(ring) = &self.ring {
                let centred = |row: &[f64]| 0.5 * (dot(row, &ring.d) + dot(row, &ring.stepper.previous));
                opening += centred(&point.normal.force);
                slip -= centred(&point.tangent.force);
            }
            let force = &point.force;
            let [x, y] = on_rotor(force, &point.gap);
            sum.on_rotor = [sum.on_rotor[0] + x, sum.on_rotor[1] + y];
            sum.friction_work += force.tangential * slip;
            sum.normal_work -= force.normal * opening;
            sum.force.normal += force.normal;
            sum.force.tangential += force.tangential;
            sum.force.sticks &= force.sticks;
            sum.points += 1;
            sum.reversed |= self.law == FrictionLaw::Slip && slip * force.tangential < 0.0;
            let yielding: f64 = points.iter().map(|j| self.residual_between(&point.gap, &j.gap) * j.force.normal).sum();
            self.held += 0.5 * force.normal * yielding;
            if force.normal > most {
                (most, sum.slip) = (force.normal, slip / line.dt);
            }
        }
        sum
    }
}

fn angle_between(a: f64, b: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    let difference = a - b;
    (difference - turn * (difference / turn).round()).abs()
}
