//! Contact by impulses: one ring and the rotor inside it, over a step.
//!
//! ```text
//! impulses (J_n, J_t) at n,  g >= 0 at n+1 along the ring,  J_n >= 0,  J_n g = 0,  |J_t| <= mu J_n                        (1)
//! g_k = g_k(free) + n_k.(D_kl (J_n n_l + J_t t_l))                     D: rotor and ring by an impulse at n, statics of trains included
//! works at n   J_n g', J_t s',  g' and s' the means of the rates before and after the impulses ([`super::impact`])                         (2)
//! ```
//! The scheme of forward-increment Lagrange multipliers (docs/theory/04-time-integration.md) with exact propagation in the place of central differences.
//! An impulse acts along normal and tangent of its place at n, where that pressed in the step before; otherwise along those at n+1. That makes the place of second order in the step.
//! (1) is solved at the nearest places ([`super::survey`]) that the whole last impulses would lead to ([`super::foreseen`]), and where it pressed before;
//! candidates that then still penetrate join them: nothing is iterated over the state, which is linear. (2) is what the impulses do on the modes, exactly.

use super::broad_phase::{BroadPhase, GapMinimum};
use super::contact_point::{ContactPoint, PressedPoint, SettledRing};
use super::contact_predictor::ContactPredictor;
use super::delassus_operator::DelassusOperator;
use super::impact::{FreeStep, Impact, SurfaceTurn};
use super::impulsed_ring::{ImpulsedRing, RingPropagator, STATIC_WEIGHT};
use super::penetration::{AfterImpulses, PenetrationSearch};
use super::ring_kernels::{PointRows, StepState, add_two, along_both, each_along, write_rows};
use super::ring_points::{RingPoints, beside, modes, parabola, ring_of};
use crate::contact::ContactForce;
use crate::contact::complementarity::{self, Coupled, POINTS};
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
use crate::engine::exponential::plane::{across, product, turned};
use crate::linalg::eight::{Eight, by_width};
use crate::linalg::lanes::Lane;
use crate::structure::Structure;
use bladeoff_model::machine::{Diaphragm, FrictionLaw};
use std::sync::Arc;

/// A candidate penetrates when it is deeper than this share of the deepest before any impulse.
const SHARE: f64 = 1e-4;

/// One ring under way.
pub(crate) struct ContactStep {
    /// Sine and cosine of the stator's angle, and its centre.
    angle: (f64, f64),
    offset: [f64; 2],
    gap: f64,
    radius: f64,
    law: FrictionLaw,
    /// Contact step \[s\].
    h: f64,
    ring_points: Arc<RingPoints>,
    pub ring: ImpulsedRing,
    /// Displacement of each mode per impulse by n+1, with [`STATIC_WEIGHT`] times what a train lacks.
    compliance: Vec<Lane>,
    /// Displacement of the rotor per impulse in the modes left out, in the stator's axes.
    rotor_truncated_flexibility: [[f64; 2]; 2],
    propagators: Vec<RingPropagator>,
    broad_phase: BroadPhase,
    penetration: PenetrationSearch,
    impulses: Vec<Lane>,
    predictor: ContactPredictor,
    coupled: Box<Coupled>,
    points: Vec<ContactPoint>,
    forces: Vec<ContactForce>,
    /// Rows of the points of this step and of the last one, and which are this one's.
    rows: [PointRows; 2],
    now: usize,
    /// What pressed in the last step, and where, and the slots of its rows.
    pressed: Vec<PressedPoint>,
    surface: SurfaceTurn,
}

impl ContactStep {
    /// A flexible ring of a machine at rest, in contact steps of `h` \[s\].
    pub fn new(
        diaphragm: &Diaphragm,
        structure: &Structure,
        index: usize,
        candidates: &Arc<RingPoints>,
        h: f64,
    ) -> Result<Self, ExponentialError> {
        let part = ring_of(structure, index)?;
        let contact = &diaphragm.contact;
        let modes = modes(part);
        let ring = ImpulsedRing::new(&modes, h);
        let places = structure.rotor.plane_places(contact.node);
        let angle = libm::sincos(diaphragm.angle);
        let [whole, lacking] = ring.compliance();
        let ahead = |k: (&Lane, &Lane)| Lane(std::array::from_fn(|i| k.0.0[i] + (STATIC_WEIGHT - 1.0) * k.1.0[i]));
        let yields: Vec<Lane> = whole.iter().zip(&lacking).map(ahead).collect();
        let zeros = vec![Lane::default(); yields.len()];
        let rows = PointRows::new(POINTS, yields.len());
        let rotor_left_out = structure
            .lateral_residual
            .as_ref()
            .map_or([[0.0; 2]; 2], |all| turned(angle, &places.map(|row| places.map(|column| all[(row, column)] / h))));
        Ok(Self {
            angle,
            offset: contact.offset,
            gap: contact.gap,
            radius: contact.rotor_radius,
            law: contact.friction_law,
            h,
            rotor_truncated_flexibility: rotor_left_out,
            broad_phase: BroadPhase::new(candidates, contact.rotor_radius + contact.gap, contact.rotor_radius),
            penetration: PenetrationSearch::new(candidates.count()),
            ring_points: Arc::clone(candidates),
            predictor: ContactPredictor::new([whole, lacking]),
            compliance: yields,
            ring,
            propagators: Vec::new(),
            impulses: zeros,
            rows: [rows.clone(), rows],
            now: 0,
            coupled: Box::new(Coupled {
                w: Default::default(),
                start: [[0.0; 2]; POINTS],
                friction: contact.friction,
                law: contact.friction_law,
                sign: 1.0,
            }),
            points: Vec::with_capacity(POINTS),
            forces: Vec::with_capacity(POINTS),
            pressed: Vec::with_capacity(POINTS),
            surface: SurfaceTurn::default(),
        })
    }

    /// Whether impulses acted in the last step.
    pub fn in_contact(&self) -> bool {
        !self.pressed.is_empty()
    }

    /// A place in the machine's axes, from the ring's centre.
    pub fn displacement_from_centre(&self, place: [f64; 2]) -> [f64; 2] {
        [place[0] - self.offset[0], place[1] - self.offset[1]]
    }

    /// How far the rotor's centre may be from the ring's before it can touch, wherever the ring's modes carry it \[m\].
    pub fn clearance(&self) -> f64 {
        self.gap - self.ring.reach(&self.ring_points.reach)
    }

    /// The rotor's centre from the ring's, in the stator's axes.
    pub fn displacement_in_stator_axes(&self, place: [f64; 2]) -> [f64; 2] {
        self.to_stator_axes(self.displacement_from_centre(place))
    }

    /// Takes the ring over a step of `h = 2^level` contact steps in which nothing touches.
    pub fn propagate_ring(&mut self, level: usize, h: f64) {
        while self.propagators.len() <= level {
            let shorter = libm::exp2(self.propagators.len() as f64 - level as f64);
            self.propagators.push(self.ring.propagator(h * shorter));
        }
        self.ring.propagate(&self.propagators[level]);
        self.surface.forget();
        if !self.pressed.is_empty() {
            self.reset();
        }
    }

    /// Nothing presses any more.
    fn reset(&mut self) {
        self.pressed.clear();
        self.predictor.reset();
    }

    /// Takes the ring over a step in which it may be touched; `None` where it is not.
    ///
    /// # Errors
    /// [`ExponentialError::NoImpulses`].
    pub fn solve(&mut self, free: &FreeStep<'_>) -> Result<Option<Impact>, ExponentialError> {
        touch(self, free)
    }

    #[inline(always)]
    fn solve_kernel<V: Eight>(&mut self, free: &FreeStep<'_>) -> Result<Option<Impact>, ExponentialError> {
        self.ring.propagate_free::<V>();
        self.now = 1 - self.now;
        let moved = DelassusOperator::new(
            self.angle,
            self.rotor_truncated_flexibility,
            free.response,
            self.radius * self.radius * free.rolling,
        );
        loop {
            let found = match self.gather::<V>(free, &moved) {
                Some(found) => self.press::<V>(found, free, &moved),
                None if self.pressed.is_empty() => {
                    self.surface.take(free.turn, self.h);
                    return Ok(None);
                }
                None => None,
            };
            match found {
                Some(left) => return Ok(Some(self.finish::<V>(free, left))),
                None if self.pressed.is_empty() => return Err(ExponentialError::NoImpulses),
                // no condition is violated, or nothing fulfils them, at the places that the last forces lead to: those without foresight decide
                None => self.reset(),
            }
        }
    }

    /// Finds the impulses at the points that were gathered, and at what they leave closed; what is left of the least gap then, `None` where nothing fulfils the conditions.
    #[inline(always)]
    fn press<V: Eight>(
        &mut self,
        (to, [depth, slip]): ([f64; 2], [f64; 2]),
        free: &FreeStep<'_>,
        moved: &DelassusOperator,
    ) -> Option<f64> {
        self.coupled.sign = slip.signum();
        self.couple::<V>(0, None, moved);
        let mut replaced = 0;
        loop {
            self.forces.clear();
            for point in &self.points {
                self.forces.push(point.force);
            }
            complementarity::solve(&mut self.coupled, &mut self.forces)?;
            for (point, force) in self.points.iter_mut().zip(&self.forces) {
                point.force = *force;
            }
            self.respond::<V>();
            let (left, index) = self.find_penetration::<V>(to, moved);
            let full = self.points.len() == POINTS;
            let open = self.points.iter().position(|point| point.force.normal == 0.0);
            match index.filter(|_| left < SHARE * depth) {
                Some(index) if !full || (open.is_some() && replaced < POINTS) => {
                    // one that stayed open makes room, and the last one takes its place
                    let open = open.filter(|_| full);
                    let slot = open.map_or(self.points.len(), |open| self.points.swap_remove(open).slot);
                    replaced += usize::from(open.is_some());
                    let count = self.points.len();
                    let place = self.broad_phase.minimum_near(&self.ring_points, index, to, &self.predictor.ring);
                    join(self, &place, slot, free, moved);
                    self.couple::<V>(count, open, moved);
                }
                _ => return Some(left),
            }
        }
    }

    /// Takes the places that may press among the points: where the rotor is, and gap and slip without impulses of the deepest; `None` where no place is pressed.
    #[inline(always)]
    fn gather<V: Eight>(&mut self, free: &FreeStep<'_>, moved: &DelassusOperator) -> Option<([f64; 2], [f64; 2])> {
        let lacking = turned(self.angle, &free.response.static_correction);
        self.predictor.predict::<V>(
            &self.ring.displacement,
            &self.ring.travel,
            [&moved.rotor_response, &lacking, &self.rotor_truncated_flexibility],
        );
        let ([x, y], [dx, dy]) = (self.displacement_in_stator_axes(free.to), self.predictor.held_force);
        let to = [x + dx, y + dy];
        self.broad_phase.find_minima::<V>(&self.ring_points, to, &self.predictor.ring);
        self.points.clear();
        let nearest = self.broad_phase.minima.len();
        // nearest places, and then where it pressed
        for at in 0..nearest + self.pressed.len() {
            let index = if at < nearest {
                self.broad_phase.minima[at]
            } else {
                let (index, count) = (self.pressed[at - nearest].place.index, self.ring_points.count());
                if self.points.iter().any(|point| beside(point.place.index, index, count)) {
                    continue;
                }
                index
            };
            let place = self.broad_phase.minimum_near(&self.ring_points, index, to, &self.predictor.ring);
            let (joins, room) = if at < nearest { (place.gap < 0.0, POINTS - 2) } else { (true, POINTS - 1) };
            if joins && self.points.len() < room {
                join(self, &place, self.points.len(), free, moved);
            }
        }
        let deepest = self.points.iter().min_by(|one, other| one.start[0].total_cmp(&other.start[0]))?;
        (deepest.start[0] < 0.0).then_some((to, deepest.start))
    }

    /// Takes a place among the points, its rows in a slot.
    #[inline(always)]
    fn add_point<V: Eight>(&mut self, place: &GapMinimum, slot: usize, free: &FreeStep<'_>, moved: &DelassusOperator) {
        let place = *place;
        let Self { ring_points: candidates, rows, now, predictor: foreseen, compliance: yields, pressed, .. } = self;
        let count = candidates.count();
        let known = pressed.iter().find(|last| beside(last.place.index, place.index, count));
        let (acting, force, acts) = match known {
            Some(last) => (last.place, last.force, Some(last.slot)),
            None => (place, ContactForce::NONE, None),
        };
        let [before, behind] = candidates.neighbours(place.index);
        let three = [candidates.of(before), candidates.of(place.index), candidates.of(behind)];
        let [one, other] = rows;
        let (own, last) = if *now == 0 { (one, other) } else { (other, one) };
        let said = write_rows::<V>(
            three,
            parabola(place.share),
            [place.polar, across(place.polar)],
            acts.map(|slot| last.along(slot)),
            StepState { yields, way: &foreseen.way, undone: &foreseen.ring_correction },
            own.of_mut(slot),
        );
        let own = moved.coupling(candidates, &place, &acting, said.own);
        let before = DelassusOperator::previous_truncated_response(candidates, &place, pressed);
        let step = self.to_stator_axes([free.to[0] - free.from[0], free.to[1] - free.from[1]]);
        let along = across(place.normal);
        let slip = product(along, step) + free.turn * self.radius - said.passed;
        let start = [
            place.gap - said.opened - before + product(place.normal, self.predictor.rotor_correction),
            slip - product(along, self.predictor.lagging_deflection),
        ];
        self.points.push(ContactPoint { place, acting, acts, slot, own, start, force });
    }

    /// Writes the conditions of the points from one on, and of another one.
    #[inline(always)]
    fn couple<V: Eight>(&mut self, from: usize, other: Option<usize>, moved: &DelassusOperator) {
        let Self { coupled, points, rows, now, ring_points: candidates, .. } = self;
        let (rows, other) = (&rows[*now], other.unwrap_or(usize::MAX));
        for (k, at) in points.iter().enumerate() {
            coupled.start[k] = at.start;
            for (j, acting) in points.iter().enumerate() {
                if k == j {
                    // a solve adds a little to each point's own
                    coupled.w[k][k] = at.own;
                } else if k >= from || j >= from || k == other || j == other {
                    let of_modes = along_both::<V>(rows.along(at.slot), rows.by(acting.slot));
                    coupled.w[k][j] = moved.coupling(candidates, &at.place, &acting.acting, of_modes);
                }
            }
        }
    }

    /// What all impulses make of the ring's modes, beyond what was foreseen.
    #[inline(always)]
    fn respond<V: Eight>(&mut self) {
        let Self { impulses, points, rows, now, predictor: foreseen, .. } = self;
        for (impulse, known) in impulses.iter_mut().zip(&foreseen.ring_correction) {
            (V::all(0.0) - V::load(known)).store(impulse);
        }
        for point in points.iter().filter(|point| point.force.normal > 0.0) {
            add_two::<V>([point.force.normal, point.force.tangential], rows[*now].by(point.slot), impulses);
        }
    }

    /// The least gap below zero under the impulses found, beyond the points, and of which candidate; after `respond`.
    #[inline(always)]
    fn find_penetration<V: Eight>(&mut self, x: [f64; 2], moved: &DelassusOperator) -> (f64, Option<usize>) {
        let Self {
            penetration: remaining,
            broad_phase: survey,
            ring_points: candidates,
            points,
            predictor: foreseen,
            impulses,
            pressed,
            ..
        } = self;
        remaining.closest_violated_point::<V>(
            survey,
            &AfterImpulses { candidates, points, foreseen, moved, impulses, x, pressed },
        )
    }

    /// Rows of the acting place of a point.
    #[inline(always)]
    fn acting<'a>(rows: &'a [PointRows; 2], now: usize, point: &ContactPoint) -> [&'a [Lane]; 2] {
        match point.acts {
            Some(slot) => rows[1 - now].along(slot),
            None => rows[now].along(point.slot),
        }
    }

    /// Takes the impulses: on the ring here, on the rotor by what is returned.
    #[inline(always)]
    fn finish<V: Eight>(&mut self, free: &FreeStep<'_>, left: f64) -> Impact {
        let Self { impulses, pressed, predictor: foreseen, points, rows, now, ring, .. } = self;
        let pressing = || points.iter().filter(|point| point.force.normal > 0.0);
        impulses.fill(Lane::default());
        pressed.clear();
        foreseen.reset();
        let (mut impulse, mut torque) = ([0.0; 2], 0.0);
        for point in pressing() {
            let (force, n) = (&point.force, point.acting.normal);
            impulse[0] -= force.normal * n[0] - force.tangential * n[1];
            impulse[1] -= force.normal * n[1] + force.tangential * n[0];
            torque -= force.tangential * self.radius;
            add_two::<V>([force.normal, force.tangential], Self::acting(rows, *now, point), impulses);
            foreseen.press::<V>(&point.place, force, rows[*now].along(point.slot));
            pressed.push(PressedPoint { place: point.place, force: *force, slot: point.slot });
        }
        ring.apply_impulses::<V>(impulses);
        let impulse = self.to_machine_axes(impulse);
        // (2)
        let (jump, more) =
            (free.response.velocity_jump, free.spin.impulse_answer(torque, &free.response.at_unbalances));
        let velocity =
            self.to_stator_axes([0, 1].map(|i| free.velocity[i] + 0.5 * (product(jump[i], impulse) + more[i])));
        let rate = free.rate + 0.5 * free.jump * torque;
        let turns = self.surface.take(free.turn + free.rolling * torque, self.h).unwrap_or(rate);
        let rolling = self.radius * turns;
        let mut impact = Impact {
            impulse,
            torque,
            normal: 0.0,
            tangential: 0.0,
            friction_work: 0.0,
            normal_work: 0.0,
            damped_work: torque * (turns - rate),
            gap: left,
            points: 0,
            sticks: true,
            reversed: false,
            angle: 0.0,
            slip: 0.0,
        };
        let mut most = 0.0;
        for point in self.points.iter().filter(|point| point.force.normal > 0.0) {
            let (force, acting) = (&point.force, &point.acting);
            let rates = each_along::<V, 2>(Self::acting(&self.rows, self.now, point), &self.ring.mean_velocity);
            let opening = rates[0] - product(acting.normal, velocity);
            let slip = product(across(acting.normal), velocity) + rolling - rates[1];
            impact.friction_work += force.tangential * slip;
            impact.normal_work -= force.normal * opening;
            impact.normal += force.normal;
            impact.tangential += force.tangential;
            impact.points += 1;
            impact.sticks &= force.sticks;
            impact.reversed |= self.law == FrictionLaw::Slip && slip * force.tangential < 0.0;
            if force.normal > most {
                most = force.normal;
                impact.slip = slip;
                impact.angle = (acting.index as f64 + 0.5 + acting.share) * self.ring_points.spacing;
            }
        }
        impact
    }

    /// Amplitudes of the ring's modes where it is, statics of the last impulses included.
    pub fn corrected_amplitudes(&self, amplitudes: &mut Vec<f64>) {
        amplitudes.clear();
        amplitudes.extend_from_slice(self.ring.amplitudes());
        if self.in_contact() {
            self.predictor.add_static_deflection(amplitudes);
        }
    }

    /// The ring and the rotor's centre at n, statics of the last impulses included, of a rotor at x in the stator's axes.
    pub fn corrected_shape(&self, x: [f64; 2], kick: Option<&ImpulseResponse>) -> SettledRing {
        let mut amplitudes = Vec::new();
        self.corrected_amplitudes(&mut amplitudes);
        let of = |PressedPoint { place, force, .. }: &PressedPoint| {
            let alpha = (place.index as f64 + 0.5 + place.share) * self.ring_points.spacing;
            (alpha, place.polar.map(|part| part * force.normal / self.h))
        };
        let lacks = kick.map_or([[0.0; 2]; 2], |kick| turned(self.angle, &kick.static_correction));
        let held = self.predictor.static_deflection([&lacks, &self.rotor_truncated_flexibility]);
        SettledRing {
            amplitudes,
            pressed: self.pressed.iter().map(of).collect(),
            rotor: [0, 1].map(|i| x[i] + held[i]),
        }
    }

    /// Distance of the centres beyond which the rotor's is outside the ring \[m\].
    pub fn ring_radius(&self) -> f64 {
        self.radius + self.gap
    }

    /// A vector of the machine's axes in the stator's.
    #[inline(always)]
    pub fn to_stator_axes(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x + sin * y, cos * y - sin * x]
    }

    #[inline(always)]
    fn to_machine_axes(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x - sin * y, sin * x + cos * y]
    }
}

by_width! { fn touch(rub: &mut ContactStep, free: &FreeStep<'_>) -> Result<Option<Impact>, ExponentialError> = touched }

#[inline(always)]
fn touched<V: Eight>(rub: &mut ContactStep, free: &FreeStep<'_>) -> Result<Option<Impact>, ExponentialError> {
    rub.solve_kernel::<V>(free)
}

by_width! {
    /// A function of its own: called from several places.
    fn join(rub: &mut ContactStep, place: &GapMinimum, slot: usize, free: &FreeStep<'_>, moved: &DelassusOperator) = add_point_kernel
}

#[inline(always)]
fn add_point_kernel<V: Eight>(
    rub: &mut ContactStep,
    place: &GapMinimum,
    slot: usize,
    free: &FreeStep<'_>,
    moved: &DelassusOperator,
) {
    rub.add_point::<V>(place, slot, free, moved);
}
