//! Several contact points on one ring, for steps without a fixed point at one place.
//!
//! Contact along the whole ring is a complementarity problem with conditions at every angle:
//! ```text
//! g(alpha) >= 0 for all alpha,   lambda(alpha) >= 0,   lambda(alpha) g(alpha) = 0
//! ```
//! The exchange method first solves the conditions at a few kept angles (initially the predicted place), then adds the minima that still penetrate,
//! until no minimum penetrates. At a kept angle the distance `|P(alpha) - x|` and its gradient are exact, so no place has to be searched and nothing
//! alternates. The forces at the kept angles come from [`complementarity`].
//! Source: docs/theory/03-contact.md ("the true remedy ... several contact points per ring"); exchange method for semi-infinite conditions. Verified
//! by `several_points_leave_no_penetration`, `high_friction_invents_no_energy` (`core/tests/contact/whip.rs`).

use super::axes::{directions, on_rotor};
use super::bodies::Bodies;
use super::one_point::Attempt;
use super::ring::UnitForce;
use super::rounds::{Rounds, Work};
use super::step_contact::StepContact;
use crate::contact::complementarity::{self, Block, Coupled, POINTS};
use crate::contact::{ContactReaction, Gap, Place};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_model::machine::FrictionLaw;
use bladeoff_numerics::linalg::{axpy, dot};

/// Maximum number of contact points of a ring.
const MOST: usize = 16;
/// Penetration of a minimum that requires a new point, as a share of the predicted penetration.
const SHARE: f64 = 1e-4;
/// Relative convergence tolerance of the increments. The motion hardly depends on how close points share their force.
const TOLERANCE: f64 = 1e-9;
/// Accepted relative change of the increments if close points keep exchanging force.
const LOOSE: f64 = 1e-5;
/// Smallest difference of two kept angles \[rad\].
const SAME: f64 = 2e-3;

/// Kept place with its unit forces on the ring.
struct Point {
    /// Fixed position on the ring.
    place: Place,
    /// Exact gap at this place.
    gap: Gap,
    /// Unit force along the normal, and its response.
    normal: UnitForce,
    /// Unit force along the tangent, and its response.
    tangent: UnitForce,
    /// Contact force of the last round.
    force: ContactReaction,
}

/// Kept places of the last step with several points, and scratch.
#[derive(Default)]
pub(super) struct Several {
    /// Points at the kept places.
    points: Vec<Point>,
    /// Scratch: places of local minima.
    places: Vec<Place>,
}

impl Several {
    /// Corrects the predicted increments with as many points as necessary; `None` without a ring or without a solution. The number of points is at
    /// most [`MOST`]; penetration that remains is reported.
    pub fn correct(
        &mut self,
        bodies: &mut Bodies<'_>,
        line: &mut ShaftLine<'_>,
        attempt: &Attempt,
        d: &mut Increments,
        work: &mut Work,
    ) -> Option<StepContact> {
        self.points.clear();
        let deepest = self.exchange(bodies, line, attempt, d, work)?;
        let contact = account(bodies, line, attempt, &self.points, deepest, d);
        (contact.force.normal > 0.0).then_some(contact)
    }

    /// Adds minima that penetrate until no minimum does; returns the deepest remaining minimum.
    fn exchange(
        &mut self,
        bodies: &mut Bodies<'_>,
        line: &mut ShaftLine<'_>,
        attempt: &Attempt,
        d: &mut Increments,
        work: &mut Work,
    ) -> Option<Gap> {
        let allowed = -SHARE * attempt.predicted.value.abs();
        let Self { points, places } = self;
        points.push(Point::new(bodies, attempt.predicted.place)?);
        loop {
            hold(bodies, line, attempt, points, d, work)?;
            follow(bodies, points);
            let x = bodies.after(attempt.x_n, d);
            bodies.field_after();
            let mut minima = bodies.stator.minima(x, places);
            let deepest = *minima.first()?;
            minima.retain(|gap| {
                let kept = |point: &Point| angle_between(point.place.alpha, gap.place.alpha) < SAME;
                gap.value < allowed && !points.iter().any(kept)
            });
            minima.truncate(MOST - points.len());
            // penetration that remains without another point is still smaller than with one point, and is reported
            if minima.is_empty() {
                return Some(deepest);
            }
            for gap in minima {
                points.push(Point::new(bodies, gap.place)?);
            }
        }
    }
}

impl Point {
    /// Point without force; `None` without a ring.
    fn new(bodies: &Bodies<'_>, place: Place) -> Option<Self> {
        let size = bodies.stator.ring.as_ref()?.d.len();
        let gap = bodies.stator.fixed_gap([0.0; 2], place);
        let (normal, tangent) = (UnitForce::none(size), UnitForce::none(size));
        Some(Self { place, gap, normal, tangent, force: ContactReaction::NONE })
    }
}

/// Solves for the forces at the kept places, together with the non-linear terms of the shaft line. Points that nearly coincide may exchange force
/// without end; the resulting change is then below [`LOOSE`].
fn hold(
    bodies: &mut Bodies<'_>,
    line: &mut ShaftLine<'_>,
    attempt: &Attempt,
    points: &mut [Point],
    d: &mut Increments,
    work: &mut Work,
) -> Option<()> {
    let mut rounds = Rounds::default();
    loop {
        work.iterations += 1;
        follow(bodies, points);
        let x = bodies.after(attempt.x_n, d);
        bodies.field_after();
        let (stator, ring) = (&bodies.stator, bodies.stator.ring.as_ref()?);
        for point in points.iter_mut() {
            point.gap = stator.fixed_gap(x, point.place);
            let [n_r, n_t] = point.gap.normal;
            ring.load(point.place, [n_r, n_t], &stator.surface, &mut point.normal);
            ring.load(point.place, [-n_t, n_r], &stator.surface, &mut point.tangent);
        }
        let free = &mut work.free;
        let driven = line.spin.driven();
        line.respond(attempt.time, d, free);
        let before: f64 = points.iter().map(|p| p.force.normal).sum();
        let solved = solve(bodies, points, attempt.sign, (d, free));
        push(bodies, points, free);
        let torque: f64 = points.iter().map(|p| p.force.tangential * bodies.section.radius).sum();
        line.spin.add_drive_torque(bodies.section.drive_torque(torque));
        let after: f64 = points.iter().map(|p| p.force.normal).sum();
        let rounding = bodies.rounding_of_force();
        let change = bodies.change(line, driven, (d, free), after, rounding);
        let steady = (after - before).abs() <= 1e-9 * after + rounding;
        d.copy_from(free);
        solved?;
        if rounds.done > 0 && change <= TOLERANCE && steady && bodies.ring_settled() {
            return Some(());
        }
        if !rounds.another(change) {
            return (change <= LOOSE).then_some(());
        }
    }
}

/// Forces at the kept points, starting from the present ones.
fn solve(bodies: &Bodies<'_>, points: &mut [Point], sign: f64, (d, free): (&Increments, &Increments)) -> Option<()> {
    let (friction, law, section) = (bodies.friction, bodies.law, &bodies.section);
    let mut coupled = Coupled { w: Default::default(), start: [[0.0; 2]; POINTS], friction, law, sign };
    let mut forces = [ContactReaction::NONE; POINTS];
    let (dx, dx_free) = (section.increment(&d.lateral), section.increment(&free.lateral));
    let turn = section.radius * section.turn(&free.torsion);
    for (k, point) in points.iter().enumerate() {
        let (n, t) = directions(&point.gap);
        let (mut gap, mut slip) = (point.gap.value, t[0] * dx_free[0] + t[1] * dx_free[1] + turn);
        gap -= n[0] * (dx_free[0] - dx[0]) + n[1] * (dx_free[1] - dx[1]);
        if let Some(ring) = &bodies.stator.ring {
            gap += dot(&point.normal.force, &ring.free) - dot(&point.normal.force, &ring.d);
            slip -= dot(&point.tangent.force, &ring.free);
        }
        for (j, other) in points.iter().enumerate() {
            let left_out = bodies.left_out_between(&point.gap, &other.gap);
            // the gap contains the effect of the last forces: the truncated modes follow the new forces instead
            gap -= left_out * other.force.normal;
            coupled.w[k][j] = coupling(bodies, point, other, left_out);
        }
        (coupled.start[k], forces[k]) = ([gap, slip], point.force);
    }
    complementarity::solve(&mut coupled, &mut forces[..points.len()])?;
    for (point, force) in points.iter_mut().zip(forces) {
        point.force = force;
    }
    Some(())
}

/// Gap and slip at point `k` due to a unit normal and a unit tangential force at point `j` \[m/N\].
fn coupling(bodies: &Bodies<'_>, k: &Point, j: &Point, left_out: f64) -> Block {
    let ((n_k, t_k), (n_j, t_j)) = (directions(&k.gap), directions(&j.gap));
    let rotor = |a, b| bodies.section.along(a, b);
    [
        [
            rotor(n_k, n_j) + dot(&k.normal.force, &j.normal.response) + left_out,
            rotor(n_k, t_j) + dot(&k.normal.force, &j.tangent.response),
        ],
        [
            -rotor(t_k, n_j) - dot(&k.tangent.force, &j.normal.response),
            -rotor(t_k, t_j) - bodies.section.rolling() - dot(&k.tangent.force, &j.tangent.response),
        ],
    ]
}

/// Adds the responses to all forces, as [`Bodies::push`] does for one.
fn push(bodies: &mut Bodies<'_>, points: &[Point], free: &mut Increments) {
    if let Some(ring) = &mut bodies.stator.ring {
        ring.restart();
    }
    for point in points {
        let force = &point.force;
        bodies.section.push(on_rotor(force, &point.gap), force.tangential, free);
        if let Some(ring) = &mut bodies.stator.ring {
            axpy(force.normal, &point.normal.response, &mut ring.d);
            axpy(force.tangential, &point.tangent.response, &mut ring.d);
        }
    }
}

/// Lets the truncated modes follow the forces of all points.
fn follow(bodies: &mut Bodies<'_>, points: &[Point]) {
    bodies.left_out.spring_back();
    for point in points.iter().filter(|point| point.force.normal > 0.0) {
        bodies.give_way(&point.gap, &point.force);
    }
}

/// Contact quantities and works of a step with several points.
fn account(
    bodies: &mut Bodies<'_>,
    line: &ShaftLine<'_>,
    attempt: &Attempt,
    points: &[Point],
    deepest: Gap,
    d: &Increments,
) -> StepContact {
    let section = &bodies.section;
    let step = section.centred_step(line, d);
    let turned = section.turn(&d.torsion) + section.turn(&line.torsion.stepper.previous);
    let turn = 0.5 * section.radius * turned;
    let mut sum = StepContact {
        force: ContactReaction { normal: 0.0, tangential: 0.0, sticks: true },
        on_rotor: [0.0; 2],
        gap: deepest,
        slip: 0.0,
        reversed: false,
        no_fixed_point: true,
        several_minima: attempt.several_minima,
        points: 0,
        friction_work: 0.0,
        normal_work: 0.0,
        model_work: 0.0,
    };
    let (mut held, mut most) = (0.0, 0.0);
    for point in points.iter().filter(|point| point.force.normal > 0.0) {
        let (n, t) = directions(&point.gap);
        let (mut opening, mut slip) = (-(n[0] * step[0] + n[1] * step[1]), t[0] * step[0] + t[1] * step[1] + turn);
        if let Some(ring) = &bodies.stator.ring {
            opening += ring.centred_step(&point.normal.force);
            slip -= ring.centred_step(&point.tangent.force);
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
        sum.reversed |= bodies.law == FrictionLaw::Slip && slip * force.tangential < 0.0;
        let yielding: f64 = points.iter().map(|j| bodies.left_out_between(&point.gap, &j.gap) * j.force.normal).sum();
        held += 0.5 * force.normal * yielding;
        if force.normal > most {
            (most, sum.slip) = (force.normal, slip / line.dt);
        }
    }
    bodies.left_out.held = held;
    sum
}

fn angle_between(a: f64, b: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    let difference = a - b;
    (difference - turn * (difference / turn).round()).abs()
}
