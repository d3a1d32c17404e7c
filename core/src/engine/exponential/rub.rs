//! Contact by impulses: one ring and the rotor inside it, over a step.
//!
//! ```text
//! impulses (J_n, J_t) at n at some candidates,  g_c >= 0 at n+1 at all of them,  J_n >= 0,  J_n g = 0,  |J_t| <= mu J_n     (1)
//! g_c = g_c(free) + n_c.(D_cb (J_n n_b + J_t t_b))                     D: rotor and ring by an impulse at n, statics of trains included
//! ```
//! The scheme of forward-increment Lagrange multipliers (docs/theory/04-time-integration.md) with exact propagation in the place of central differences.
//! (1) is solved at a few candidates, those that then still penetrate join them: nothing is iterated over the state, which is linear.

use super::ExponentialError;
use super::bound::length;
use super::candidates::{CandidateGap, Candidates};
use super::kick::Kick;
use super::kicked_ring::KickedRing;
use super::oscillators::OscillatorStep;
use crate::contact::ContactForce;
use crate::contact::complementarity::{self, Coupled, POINTS};
use crate::linalg::Matrix;
use crate::structure::Structure;
use bladeoff_model::machine::{ContactSurface, Diaphragm, FrictionLaw};

/// Candidates of a ring, at least, and of each of its elements. Fewer would be felt one by one: a rotor that whirls past them is shaken at their number times
/// its rate, by the sagitta between two (lab rig, 64 of them: 0.6 um of a gap of 0.5 mm).
const CANDIDATES: usize = 192;
const PER_ELEMENT: usize = 4;
/// A candidate penetrates when it is deeper than this share of the deepest before any impulse.
const SHARE: f64 = 1e-4;

/// One ring under way.
#[derive(Debug, Clone)]
pub(super) struct Rub {
    /// Sine and cosine of the stator's angle, and its centre.
    angle: (f64, f64),
    offset: [f64; 2],
    gap: f64,
    radius: f64,
    friction: f64,
    law: FrictionLaw,
    candidates: Candidates,
    pub ring: KickedRing,
    /// Displacements per impulse, candidate by candidate; and of the modes left out, which follow normal forces alone.
    moved: Matrix,
    left_out: Option<Matrix>,
    rotor_left_out: [[f64; 2]; 2],
    flights: Vec<OscillatorStep>,
    near: Vec<usize>,
    pressed: Vec<(usize, ContactForce)>,
}

/// What a step's contact does.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Impact {
    /// Impulse on the rotor, in the machine's axes \[N s\], and of the friction's torque \[N m s\].
    pub on_rotor: [f64; 2],
    pub torque: f64,
    /// Sum of normal impulses \[N s\], work of friction \[J\].
    pub normal: f64,
    pub friction_work: f64,
}

/// The step without contact: places of the rotor at n and n+1 in the machine's axes, its kick, and how its surface turns.
pub(super) struct FreeStep<'a> {
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub kick: &'a Kick,
    pub turn: f64,
    pub rolling: f64,
    pub h: f64,
}

impl Rub {
    /// A flexible ring of a machine at rest, in contact steps of `h` \[s\].
    pub fn new(diaphragm: &Diaphragm, structure: &Structure, index: usize, h: f64) -> Result<Self, ExponentialError> {
        let part = structure.rings[index].as_ref();
        let part = part.ok_or(ExponentialError::NotCovered { what: "a stator without freedoms" })?;
        let contact = &diaphragm.contact;
        let inner = contact.surface == ContactSurface::InnerFace;
        let surface = part.matrices.surface(contact.rotor_radius + contact.gap, inner);
        let per_element = CANDIDATES.div_ceil(surface.nodes).max(PER_ELEMENT);
        let candidates = Candidates::new(part, &surface, contact.rotor_radius, per_element);
        let modes: Vec<(f64, f64)> = (0..part.part.coordinates.size())
            .map(|j| (part.part.stiffness[(j, j)], part.part.damping[(j, j)]))
            .collect();
        if modes.iter().any(|&(square, _)| square <= 0.0) {
            return Err(ExponentialError::NotCovered { what: "a ring that nothing holds" });
        }
        let ring = KickedRing::new(&modes, h);
        let yields: Vec<f64> = ring.yields().iter().zip(ring.lacking()).map(|(a, b)| a + b).collect();
        let places = structure.rotor.plane_places(contact.node);
        let rotor_left_out = structure
            .lateral_residual
            .as_ref()
            .map_or([[0.0; 2]; 2], |all| places.map(|row| places.map(|column| all[(row, column)] / h)));
        Ok(Self {
            angle: libm::sincos(diaphragm.angle),
            offset: contact.offset,
            gap: contact.gap,
            radius: contact.rotor_radius,
            friction: contact.friction,
            law: contact.friction_law,
            moved: candidates.yielding(&yields),
            left_out: candidates.left_out.as_ref().map(|flexibility| flexibility / h),
            rotor_left_out,
            candidates,
            ring,
            flights: Vec::new(),
            near: Vec::new(),
            pressed: Vec::new(),
        })
    }

    /// How far the rotor at a place may move before it can touch, wherever the ring's modes carry it \[m\].
    pub fn room(&self, place: [f64; 2]) -> f64 {
        let x = self.inwards([place[0] - self.offset[0], place[1] - self.offset[1]]);
        self.gap - length(x) - self.candidates.reach(self.ring.amplitudes())
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
        let before = self.ring.modes.place.clone();
        self.ring.drift();
        let [from, to] = [free.from, free.to].map(|x| self.inwards([x[0] - self.offset[0], x[1] - self.offset[1]]));
        let reach = self.candidates.reach(self.ring.amplitudes());
        let mut near = std::mem::take(&mut self.near);
        self.candidates.near(to, reach, &mut near);
        let open: Vec<[f64; 2]> =
            near.iter().map(|&c| self.candidates.displacement(c, &self.ring.modes.place)).collect();
        let gaps: Vec<CandidateGap> =
            near.iter().zip(&open).map(|(&c, &moved)| self.candidates.gap(c, moved, to)).collect();
        self.near = near;
        let deepest = (0..gaps.len()).min_by(|&a, &b| gaps[a].value.total_cmp(&gaps[b].value));
        let Some(deepest) = deepest.filter(|&at| gaps[at].value < 0.0) else {
            self.pressed.clear();
            return Ok(None);
        };
        let step = [to[0] - from[0], to[1] - from[1]];
        let slip = |at: usize| {
            let gap = &gaps[at];
            let (t, polar) = ([-gap.normal[1], gap.normal[0]], [-gap.polar[1], gap.polar[0]]);
            let was = self.candidates.displacement(gap.index, &before);
            let ring = polar[0] * (open[at][0] - was[0]) + polar[1] * (open[at][1] - was[1]);
            t[0] * step[0] + t[1] * step[1] + free.turn * self.radius - ring
        };
        // places among the near candidates, with what pressed there last
        let last = |c: usize| self.pressed.iter().find(|(index, _)| *index == c).map(|(_, force)| *force);
        let mut points: Vec<(usize, ContactForce)> =
            gaps.iter().enumerate().filter_map(|(at, gap)| Some((at, last(gap.index)?))).take(POINTS - 1).collect();
        if !points.iter().any(|(at, _)| *at == deepest) {
            points.push((deepest, ContactForce::NONE));
        }
        let allowed = SHARE * gaps[deepest].value;
        loop {
            let mut coupled = Coupled {
                w: Default::default(),
                start: [[0.0; 2]; POINTS],
                friction: self.friction,
                law: self.law,
                sign: slip(deepest).signum(),
            };
            for (k, &(at, _)) in points.iter().enumerate() {
                coupled.start[k] = [gaps[at].value, slip(at)];
                for (j, &(other, _)) in points.iter().enumerate() {
                    coupled.w[k][j] = self.coupling(&gaps[at], &gaps[other], free);
                }
            }
            let mut forces = [ContactForce::NONE; POINTS];
            for (force, (_, last)) in forces.iter_mut().zip(&points) {
                *force = *last;
            }
            complementarity::solve(&mut coupled, &mut forces[..points.len()]).ok_or(ExponentialError::NoImpulses)?;
            for ((_, last), force) in points.iter_mut().zip(forces) {
                *last = force;
            }
            // what still penetrates, by the linearised gaps
            let left = (0..gaps.len()).filter(|at| !points.iter().any(|(other, _)| other == at)).map(|at| {
                let pressed = points.iter().filter(|(_, force)| force.normal > 0.0);
                let moved = pressed.map(|(other, force)| {
                    let w = self.coupling(&gaps[at], &gaps[*other], free);
                    w[0][0] * force.normal + w[0][1] * force.tangential
                });
                (gaps[at].value + moved.sum::<f64>(), at)
            });
            match left.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((value, at)) if value < allowed && points.len() < POINTS => points.push((at, ContactForce::NONE)),
                _ => {
                    let slips: Vec<f64> = (0..points.len()).map(|k| slipped(&coupled, k, &points)).collect();
                    return Ok(Some(self.strike(&gaps, &points, &slips, free.h)));
                }
            }
        }
    }

    /// Takes the impulses: on the ring here, on the rotor by what is returned.
    fn strike(&mut self, gaps: &[CandidateGap], points: &[(usize, ContactForce)], slips: &[f64], h: f64) -> Impact {
        let mut impact = Impact::default();
        let mut on_modes = vec![0.0; self.ring.modes.place.len()];
        let (mut x, mut y) = (0.0, 0.0);
        self.pressed.clear();
        for ((at, force), slip) in points.iter().zip(slips).filter(|((_, force), _)| force.normal > 0.0) {
            let gap = &gaps[*at];
            let (n, p) = (gap.normal, gap.polar);
            x -= force.normal * n[0] - force.tangential * n[1];
            y -= force.normal * n[1] + force.tangential * n[0];
            let polar = [force.normal * p[0] - force.tangential * p[1], force.normal * p[1] + force.tangential * p[0]];
            self.candidates.add_force(gap.index, polar, &mut on_modes);
            impact.torque -= force.tangential * self.radius;
            impact.normal += force.normal;
            impact.friction_work += force.tangential * slip / h;
            self.pressed.push((gap.index, *force));
        }
        self.ring.kick(&on_modes);
        impact.on_rotor = self.outwards([x, y]);
        impact
    }

    /// Gap and slip at one candidate by a unit normal and a unit tangential impulse at another.
    fn coupling(&self, at: &CandidateGap, acting: &CandidateGap, free: &FreeStep<'_>) -> complementarity::Block {
        let across = |[a, b]: [f64; 2]| [-b, a];
        let (n, t) = (at.normal, across(at.normal));
        let (m, s) = (acting.normal, across(acting.normal));
        let (p, q) = (at.polar, across(at.polar));
        let (r, u) = (acting.polar, across(acting.polar));
        let rotor = |a: [f64; 2], b: [f64; 2]| {
            let (a, b) = (self.outwards(a), self.outwards(b));
            let (w, v) = (&free.kick.moved, &free.kick.lacking);
            (0..2).map(|i| a[i] * ((w[i][0] + v[i][0]) * b[0] + (w[i][1] + v[i][1]) * b[1])).sum::<f64>()
        };
        let table = |matrix: &Matrix, a: [f64; 2], b: [f64; 2]| {
            let entry = |i: usize, j: usize| matrix[(2 * at.index + i, 2 * acting.index + j)];
            a[0] * (entry(0, 0) * b[0] + entry(0, 1) * b[1]) + a[1] * (entry(1, 0) * b[0] + entry(1, 1) * b[1])
        };
        let ring = |a: [f64; 2], b: [f64; 2]| table(&self.moved, a, b);
        let mut left_out = self.left_out.as_ref().map_or(0.0, |matrix| table(matrix, p, r));
        let (a, b) = (self.outwards(n), self.outwards(m));
        for i in 0..2 {
            left_out += a[i] * (self.rotor_left_out[i][0] * b[0] + self.rotor_left_out[i][1] * b[1]);
        }
        [
            [rotor(n, m) + ring(p, r) + left_out, rotor(n, s) + ring(p, u)],
            [-rotor(t, m) - ring(q, r), -rotor(t, s) - ring(q, u) - self.radius * self.radius * free.rolling],
        ]
    }

    fn inwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x + sin * y, cos * y - sin * x]
    }

    fn outwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle;
        [cos * x - sin * y, sin * x + cos * y]
    }
}

/// Slip at a point over the step, under the impulses found.
fn slipped(coupled: &Coupled, k: usize, points: &[(usize, ContactForce)]) -> f64 {
    let moved = coupled.w[k].iter().zip(points).map(|(w, (_, f))| w[1][0] * f.normal + w[1][1] * f.tangential);
    coupled.start[k][1] + moved.sum::<f64>()
}
