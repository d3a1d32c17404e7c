//! Contact by impulses: one ring and the rotor inside it, over a step.
//!
//! ```text
//! impulses (J_n, J_t) at n,  g >= 0 at n+1 along the ring,  J_n >= 0,  J_n g = 0,  |J_t| <= mu J_n                        (1)
//! g_k = g_k(free) + n_k.(D_kl (J_n n_l + J_t t_l))                     D: rotor and ring by an impulse at n, statics of trains included
//! works at n   J_n g', J_t s',  g' and s' the means of the rates before and after the impulses                             (2)
//! ```
//! The scheme of forward-increment Lagrange multipliers (docs/theory/04-time-integration.md) with exact propagation in the place of central differences.
//! An impulse acts along normal and tangent of its place at n, where that pressed in the step before; otherwise along those at n+1. That makes the place of second order in the step.
//! (1) is solved at the nearest places ([`super::survey`]) of the free step with the statics of the last impulses ([`super::foreseen`]), and where it pressed before;
//! candidates that then still penetrate join them: nothing is iterated over the state, which is linear. (2) is what the impulses do on the modes, exactly.

use super::ExponentialError;
use super::candidates::{Candidates, beside, modes, parabola, ring_of};
use super::foreseen::Foreseen;
use super::kick::Kick;
use super::kicked_ring::KickedRing;
use super::moved::Moved;
use super::oscillators::OscillatorStep;
use super::plane::{across, product, times, turned};
use super::point::{Point, Rows};
use super::remaining::{Remaining, Struck};
use super::rows::{add_both, both_products, rows_at, yielding};
use super::survey::{Place, Survey};
use crate::contact::ContactForce;
use crate::contact::complementarity::{self, Coupled, POINTS};
use crate::structure::Structure;
use bladeoff_model::machine::{Diaphragm, FrictionLaw};
use std::sync::Arc;

/// A candidate penetrates when it is deeper than this share of the deepest before any impulse.
const SHARE: f64 = 1e-4;

/// One ring under way.
pub(super) struct Rub {
    /// Sine and cosine of the stator's angle, and its centre.
    angle: (f64, f64),
    offset: [f64; 2],
    gap: f64,
    radius: f64,
    law: FrictionLaw,
    /// Contact step \[s\].
    h: f64,
    candidates: Arc<Candidates>,
    pub ring: KickedRing,
    /// Displacement of each mode per impulse, with what trains of them lack.
    yields: Vec<f64>,
    /// Displacement of the rotor per impulse in the modes left out, in the stator's axes.
    rotor_left_out: [[f64; 2]; 2],
    flights: Vec<OscillatorStep>,
    survey: Survey,
    remaining: Remaining,
    impulses: Vec<f64>,
    foreseen: Foreseen,
    coupled: Box<Coupled>,
    points: Vec<Point>,
    forces: Vec<ContactForce>,
    rows: Vec<Rows>,
    /// What pressed in the last step, and where.
    pressed: Vec<(Place, ContactForce)>,
    /// The ring's modes along normal and tangent of what pressed.
    last: Vec<[Vec<f64>; 2]>,
}

/// What a step's contact does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Impact {
    /// Impulse on the rotor, in the machine's axes \[N s\], and of the friction's torque \[N m s\].
    pub on_rotor: [f64; 2],
    pub torque: f64,
    /// Sums of normal and tangential impulses \[N s\], works of friction and of normal impulses, taken out \[J\].
    pub normal: f64,
    pub tangential: f64,
    pub friction_work: f64,
    pub normal_work: f64,
    /// Least gap that is left \[m\].
    pub gap: f64,
    pub points: usize,
    pub sticks: bool,
    pub reversed: bool,
    /// Of the place that presses most: angle \[rad\], slip \[m/s\].
    pub angle: f64,
    pub slip: f64,
}

/// Ring and rotor at an instant with the statics of the impulses that led there.
pub(super) struct Settled {
    /// Of the ring's modes.
    pub amplitudes: Vec<f64>,
    /// Where it is pressed: angles \[rad\], and normal forces in polar axes \[N\].
    pub pressed: Vec<(f64, [f64; 2])>,
    /// The rotor's centre, in the stator's axes \[m\].
    pub rotor: [f64; 2],
}

/// The step without contact.
pub(super) struct FreeStep<'a> {
    /// Places of the rotor at n and n+1, its velocity at n, in the machine's axes.
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub velocity: [f64; 2],
    pub kick: &'a Kick,
    /// Turn of the rotor's surface over the step \[rad\], and per angular impulse; its rate at n \[rad/s\], and the jump of that per angular impulse.
    pub turn: f64,
    pub rolling: f64,
    pub rate: f64,
    pub jump: f64,
}

impl Rub {
    /// A flexible ring of a machine at rest, in contact steps of `h` \[s\].
    pub fn new(
        diaphragm: &Diaphragm,
        structure: &Structure,
        index: usize,
        candidates: &Arc<Candidates>,
        h: f64,
    ) -> Result<Self, ExponentialError> {
        let part = ring_of(structure, index)?;
        let contact = &diaphragm.contact;
        let modes = modes(part);
        let ring = KickedRing::new(&modes, h);
        let places = structure.rotor.plane_places(contact.node);
        let angle = libm::sincos(diaphragm.angle);
        let zeros = vec![0.0; ring.modes.place.len()];
        let rows = Rows {
            normal: zeros.clone(),
            tangent: zeros.clone(),
            acting: [zeros.clone(), zeros.clone()],
            by_normal: zeros.clone(),
            by_tangent: zeros.clone(),
        };
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
            rotor_left_out,
            survey: Survey::new(candidates, contact.rotor_radius + contact.gap, contact.rotor_radius),
            remaining: Remaining::new(candidates.count()),
            candidates: Arc::clone(candidates),
            yields: ring.yields().iter().zip(ring.lacking()).map(|(a, b)| a + b).collect(),
            foreseen: Foreseen::new(ring.lacking()),
            ring,
            flights: Vec::new(),
            impulses: zeros,
            last: vec![[rows.normal.clone(), rows.normal.clone()]; POINTS],
            rows: vec![rows; POINTS],
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
        })
    }

    /// Whether impulses acted in the last step.
    pub fn presses(&self) -> bool {
        !self.pressed.is_empty()
    }

    /// A place in the machine's axes, from the ring's centre.
    pub fn off_centre(&self, place: [f64; 2]) -> [f64; 2] {
        [place[0] - self.offset[0], place[1] - self.offset[1]]
    }

    /// How far the rotor's centre may be from the ring's before it can touch, wherever the ring's modes carry it \[m\].
    pub fn room(&self) -> f64 {
        self.gap - self.ring.reach(self.candidates.reach())
    }

    /// The rotor's centre from the ring's, in the stator's axes.
    pub fn place(&self, place: [f64; 2]) -> [f64; 2] {
        self.inwards(self.off_centre(place))
    }

    /// Takes the ring over a step of `h = 2^level` contact steps in which nothing touches.
    pub fn fly(&mut self, level: usize, h: f64) {
        while self.flights.len() <= level {
            let shorter = libm::exp2(self.flights.len() as f64 - level as f64);
            self.flights.push(self.ring.modes.step(h * shorter));
        }
        let Self { ring, flights, pressed, .. } = self;
        ring.fly(&flights[level]);
        pressed.clear();
    }

    /// Takes the ring over a step in which it may be touched; `None` where it is not.
    pub fn touch(&mut self, free: &FreeStep<'_>) -> Result<Option<Impact>, ExponentialError> {
        self.ring.drift();
        let mut deepest = self.gather(free);
        if deepest.is_none() && !self.pressed.is_empty() {
            // what the last forces held away may come when they end
            self.pressed.clear();
            deepest = self.gather(free);
        }
        let Some((to, [depth, slip])) = deepest else { return Ok(None) };
        self.coupled.sign = slip.signum();
        let moved = Moved::new(self.angle, self.rotor_left_out, free.kick, self.radius * self.radius * free.rolling);
        self.couple(|_| true, &moved);
        let mut replaced = 0;
        loop {
            self.forces.clear();
            self.forces.extend(self.points.iter().map(|point| point.force));
            complementarity::solve(&mut self.coupled, &mut self.forces).ok_or(ExponentialError::NoImpulses)?;
            for (point, force) in self.points.iter_mut().zip(&self.forces) {
                point.force = *force;
            }
            self.respond();
            let (left, index) = self.remain(to, &moved);
            let full = self.points.len() == POINTS;
            let open = self.points.iter().position(|point| point.force.normal == 0.0);
            match index.filter(|_| left < SHARE * depth) {
                Some(index) if !full || (open.is_some() && replaced < POINTS) => {
                    // one that stayed open makes room, and the last one takes its place
                    let open = open.filter(|_| full);
                    if let Some(open) = open {
                        self.points.swap_remove(open);
                        self.rows.swap(open, self.points.len());
                        replaced += 1;
                    }
                    let count = self.points.len();
                    let place = self.survey.place(&self.candidates, index, to, &self.foreseen.ring);
                    self.join(place, free);
                    self.couple(|k| k >= count || Some(k) == open, &moved);
                }
                _ => return Ok(Some(self.strike(free, left))),
            }
        }
    }

    /// Takes the places that may press among the points: where the rotor is, and gap and slip without impulses of the deepest; `None` where no place is pressed.
    fn gather(&mut self, free: &FreeStep<'_>) -> Option<([f64; 2], [f64; 2])> {
        let lacking = turned(self.angle, &free.kick.lacking);
        self.foreseen.take(&self.pressed, &self.last, &self.ring.modes.place, [&lacking, &self.rotor_left_out]);
        let ([x, y], [dx, dy]) = (self.place(free.to), self.foreseen.held);
        let to = [x + dx, y + dy];
        self.survey.look(&self.candidates, to, &self.foreseen.ring);
        self.points.clear();
        for at in 0..self.survey.least_ones.len() {
            let index = self.survey.least_ones[at];
            let place = self.survey.place(&self.candidates, index, to, &self.foreseen.ring);
            if place.gap < 0.0 && self.points.len() < POINTS - 2 {
                self.join(place, free);
            }
        }
        for at in 0..self.pressed.len() {
            let (index, count) = (self.pressed[at].0.index, self.candidates.count());
            let known = self.points.iter().any(|point| beside(point.place.index, index, count));
            if !known && self.points.len() < POINTS - 1 {
                let place = self.survey.place(&self.candidates, index, to, &self.foreseen.ring);
                self.join(place, free);
            }
        }
        let deepest = self.points.iter().min_by(|one, other| one.start[0].total_cmp(&other.start[0]))?;
        (deepest.start[0] < 0.0).then_some((to, deepest.start))
    }

    /// Takes a place among the points.
    fn join(&mut self, place: Place, free: &FreeStep<'_>) {
        let count = self.candidates.count();
        let known = self.pressed.iter().position(|(last, _)| beside(last.index, place.index, count));
        let (acting, force) = known.map_or((place, ContactForce::NONE), |at| self.pressed[at]);
        let Rows { normal, tangent, acting: [n, t], by_normal, by_tangent } = &mut self.rows[self.points.len()];
        let three = {
            let [before, behind] = self.candidates.beside(place.index);
            [before, place.index, behind].map(|c| self.candidates.of(c))
        };
        let along = [place.polar, across(place.polar)];
        let ring = rows_at(three, parabola(place.share), along, normal, tangent, &self.ring.way);
        let acts =
            known.map_or([normal.as_slice(), tangent.as_slice()], |at| self.last[at].each_ref().map(Vec::as_slice));
        yielding(&self.yields, acts[0], n, by_normal);
        yielding(&self.yields, acts[1], t, by_tangent);
        let [opened, slipped] = both_products([normal, tangent], &self.foreseen.statics);
        let step = self.inwards([free.to[0] - free.from[0], free.to[1] - free.from[1]]);
        let along = across(place.normal);
        let slip = product(along, step) + free.turn * self.radius - ring;
        let start = [
            place.gap - opened + product(place.normal, self.foreseen.held),
            slip - product(along, self.foreseen.lagging) + slipped,
        ];
        self.points.push(Point { place, acting, start, force });
    }

    /// Writes the conditions of new points.
    fn couple(&mut self, new: impl Fn(usize) -> bool, moved: &Moved) {
        let Self { coupled, points, rows, candidates, .. } = self;
        for k in 0..points.len() {
            coupled.start[k] = points[k].start;
            for j in 0..points.len() {
                // a solve adds a little to each point's own
                if k == j || new(k) || new(j) {
                    let at = (&points[k].place, [&*rows[k].normal, &*rows[k].tangent]);
                    let acting = (&points[j].acting, [&*rows[j].by_normal, &*rows[j].by_tangent]);
                    coupled.w[k][j] = moved.coupling(candidates, at, acting);
                }
            }
        }
    }

    /// What all impulses make of the ring's modes, beyond the statics that were foreseen.
    fn respond(&mut self) {
        let Self { impulses, points, rows, foreseen, .. } = self;
        for (impulse, known) in impulses.iter_mut().zip(&foreseen.statics) {
            *impulse = -*known;
        }
        for (point, rows) in points.iter().zip(rows).filter(|(point, _)| point.force.normal > 0.0) {
            let force = [point.force.normal, point.force.tangential];
            add_both(force, [&rows.by_normal, &rows.by_tangent], impulses);
        }
    }

    /// The least gap below zero under the impulses found, beyond the points, and of which candidate; after `respond`.
    fn remain(&mut self, x: [f64; 2], moved: &Moved) -> (f64, Option<usize>) {
        let Self { remaining, survey, candidates, points, foreseen, impulses, .. } = self;
        remaining.least(survey, &Struck { candidates, points, foreseen, moved, impulses, x })
    }

    /// Takes the impulses: on the ring here, on the rotor by what is returned.
    fn strike(&mut self, free: &FreeStep<'_>, left: f64) -> Impact {
        self.impulses.fill(0.0);
        self.pressed.clear();
        let (mut on_rotor, mut torque) = ([0.0; 2], 0.0);
        for (point, rows) in self.points.iter().zip(&mut self.rows).filter(|(point, _)| point.force.normal > 0.0) {
            let (force, n) = (&point.force, point.acting.normal);
            on_rotor[0] -= force.normal * n[0] - force.tangential * n[1];
            on_rotor[1] -= force.normal * n[1] + force.tangential * n[0];
            add_both([force.normal, force.tangential], rows.acting.each_ref().map(Vec::as_slice), &mut self.impulses);
            torque -= force.tangential * self.radius;
            let [normal, tangent] = &mut self.last[self.pressed.len()];
            std::mem::swap(normal, &mut rows.normal);
            std::mem::swap(tangent, &mut rows.tangent);
            self.pressed.push((point.place, *force));
        }
        self.ring.kick(&self.impulses);
        let on_rotor = self.outwards(on_rotor);
        // (2)
        let jump = free.kick.jump;
        let velocity = self.inwards([0, 1].map(|i| free.velocity[i] + 0.5 * product(jump[i], on_rotor)));
        let rolling = self.radius * (free.rate + 0.5 * free.jump * torque);
        let mut impact = Impact {
            on_rotor,
            torque,
            normal: 0.0,
            tangential: 0.0,
            friction_work: 0.0,
            normal_work: 0.0,
            gap: left,
            points: 0,
            sticks: true,
            reversed: false,
            angle: 0.0,
            slip: 0.0,
        };
        let mut most = 0.0;
        for (point, rows) in self.points.iter().zip(&self.rows).filter(|(point, _)| point.force.normal > 0.0) {
            let (force, acting) = (&point.force, &point.acting);
            let rates = both_products(rows.acting.each_ref().map(Vec::as_slice), &self.ring.mean_rate);
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
                impact.angle = (acting.index as f64 + 0.5 + acting.share) * self.candidates.spacing;
            }
        }
        impact
    }

    /// The ring and the rotor's centre at n, statics of the last impulses included, of a rotor at x in the stator's axes.
    pub fn settled(&self, x: [f64; 2], kick: Option<&Kick>) -> Settled {
        let mut amplitudes = self.ring.place().to_vec();
        let lacking = self.ring.lacking();
        let mut on_ring = [0.0; 2];
        let mut pressed = Vec::with_capacity(self.pressed.len());
        for ((place, force), [normal, tangent]) in self.pressed.iter().zip(&self.last) {
            for (j, lacking) in lacking.iter().take(self.ring.place().len()).enumerate() {
                amplitudes[j] += lacking * (force.normal * normal[j] + force.tangential * tangent[j]);
            }
            let (n, t) = (place.normal, across(place.normal));
            for i in 0..2 {
                on_ring[i] += n[i] * force.normal + t[i] * force.tangential;
            }
            let alpha = (place.index as f64 + 0.5 + place.share) * self.candidates.spacing;
            pressed.push((alpha, place.polar.map(|part| part * force.normal / self.h)));
        }
        let lacks = kick.map_or([[0.0; 2]; 2], |kick| turned(self.angle, &kick.lacking));
        let (held, left) = (times(&lacks, on_ring), times(&self.rotor_left_out, on_ring));
        Settled { amplitudes, pressed, rotor: [0, 1].map(|i| x[i] - held[i] - left[i]) }
    }

    /// Distance of the centres beyond which the rotor's is outside the ring \[m\].
    pub fn outermost(&self) -> f64 {
        self.radius + self.gap
    }

    /// A vector of the machine's axes in the stator's.
    pub fn inwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x + sin * y, cos * y - sin * x]
    }

    fn outwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x - sin * y, sin * x + cos * y]
    }
}
