//! One diaphragm under way: the ring's motion and its contact with the rotor.
//!
//! A contact is found on the predicted step (no contact force), then force, places and speeds are iterated together until
//! the linearised gap at n+1 is zero (paper, Algorithm 1, with its loop condition corrected): `correction`. Without a fixed
//! point (physics.md section 3) the predicted place is kept and the step counted.

mod correction;
mod coupled;
mod lemke;
mod pivoting;
mod place_search;
mod residual;
mod ring;
mod several;
mod spring;

use self::residual::residual_at;
use self::ring::Ring;
use super::shaft_line::ShaftLine;
use crate::contact::{ContactForce, Gap, NotUnique, Place, exact_gap, polar_gap};
use crate::linalg::dot;
use crate::outcome::Cause;
use crate::record::Touch;
use crate::stator::Surface;
use crate::structure::Structure;
use bladeoff_model::machine::{
    ContactPoints, ContactSurface, Detection, Diaphragm, DiaphragmKind, ForceLocation, FrictionLaw,
};

/// What contact did in the step at n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepContact {
    pub force: ContactForce,
    /// On the rotor, in the stator's axes \[N\].
    pub on_rotor: [f64; 2],
    /// Gap and place of the converged step, in the run's own gap function.
    pub gap: Gap,
    /// Centred slip velocity \[m/s\].
    pub slip: f64,
    /// Slip direction frozen at the prediction and not kept by the solution.
    pub reversed: bool,
    /// One contact point has no fixed point: solved with several, or at the predicted place.
    pub no_fixed_point: bool,
    /// The rotor penetrated the predicted ring at more than one local minimum.
    pub several_minima: bool,
    /// Points that carry a force; the force is then the sum over them, the slip that of the most loaded one.
    pub points: usize,
    /// Energy taken out by friction, by the normal force and by Hyp 1's model work in the step \[J\].
    pub friction_work: f64,
    pub normal_work: f64,
    pub model_work: f64,
}

impl StepContact {
    /// What recorders see of it.
    pub fn touch(&self) -> Touch {
        Touch {
            normal: self.force.normal,
            sticks: self.force.sticks,
            gap: self.gap.value,
            points: self.points,
            reversed: self.reversed,
            no_fixed_point: self.no_fixed_point,
            several_minima: self.several_minima,
        }
    }
}

/// A contact step that could not be computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactFailure {
    NotUnique(NotUnique),
    NoConvergence,
    /// The same where the step without contact would lead beyond the ring.
    Outside,
}

impl ContactFailure {
    /// What a run ends with by it.
    pub fn cause(self) -> Cause {
        match self {
            ContactFailure::NotUnique(_) => Cause::LossOfUniqueness,
            ContactFailure::NoConvergence => Cause::Diverged,
            ContactFailure::Outside => Cause::OutsideRing,
        }
    }
}

/// What a contact step starts from.
struct Attempt {
    x_n: [f64; 2],
    sign: f64,
    predicted: Gap,
    force_place: Option<Gap>,
    time: f64,
}

/// One diaphragm.
pub(crate) struct Rub<'a> {
    pub detection: Detection,
    friction: f64,
    law: FrictionLaw,
    location: ForceLocation,
    rotor_radius: f64,
    pub gap: f64,
    offset: [f64; 2],
    turn: (f64, f64),
    surface: Surface,
    /// Stiffness of a quasi-static radial spring instead of multipliers.
    spring: Option<f64>,
    pub node: usize,
    ring: Option<Ring<'a>>,
    /// Lateral coordinates of the node along the stator's axes, and A^-1 of them.
    rows: [Vec<f64>; 2],
    responses: [Vec<f64>; 2],
    /// Static flexibility of the lateral modes left out, at the node in the stator's axes \[m/N\].
    residual: [[f64; 2]; 2],
    /// Static displacement of the node by them under the forces of the step \[m\].
    shift: [f64; 2],
    /// The same under the forces of the step before: those that led to the place at n.
    shift_before: [f64; 2],
    /// Energy held by the static flexibility of the modes left out, at this step and the one before \[J\].
    pub held: f64,
    pub held_before: f64,
    /// Compliance of the node in the stator's axes \[m/N\].
    compliance: [[f64; 2]; 2],
    twist_row: Vec<f64>,
    twist_response: Vec<f64>,
    twist_compliance: f64,
    /// Torque that a prescribed speed's drive adds per torque on the node.
    drive_lever: f64,
    pub iterations: u64,
    /// Whether the rotor penetrates the predicted ring at more than one local minimum.
    several_minima: bool,
    /// Whether a step without fixed point is solved with several points, and those of the last such step.
    several_points: bool,
    points: Vec<several::Point>,
    places: Vec<Place>,
    candidate: Vec<f64>,
    candidate_twist: Vec<f64>,
}

/// Convergence of increments, relative.
const TOLERANCE: f64 = 1e-11;
/// Rounds of a contact step before it counts as one without fixed point.
const CONTACT_ITERATIONS: usize = 40;
/// Rounds at most of one that still gains: the spin under an unbalance that outweighs its inertia takes as many without contact.
const MOST_ITERATIONS: usize = 600;
/// A round gains that changes less than this part of what the one before changed.
const GAIN: f64 = 0.98;

/// Counts the rounds of a contact step.
#[derive(Default)]
struct Rounds {
    done: usize,
    last: f64,
}

impl Rounds {
    /// Whether another round is worth its while after one that changed the increments by so much.
    fn another(&mut self, change: f64) -> bool {
        self.done += 1;
        let gains = change < GAIN * self.last;
        self.last = change;
        self.done < CONTACT_ITERATIONS || gains && self.done < MOST_ITERATIONS
    }
}

impl<'a> Rub<'a> {
    pub fn new(
        diaphragm: &Diaphragm,
        structure: &'a Structure,
        line: &ShaftLine<'_>,
        location: ForceLocation,
        dt: f64,
    ) -> Option<Self> {
        let contact = &diaphragm.contact;
        let ring = structure.rings.first().and_then(Option::as_ref);
        let radius = contact.rotor_radius + contact.gap;
        let inner = contact.surface == ContactSurface::InnerFace;
        let surface = match ring {
            Some(ring) => ring.matrices.surface(radius, inner),
            None => Surface::circle(radius),
        };
        let ring = match ring {
            None => None,
            Some(part) => Some(Ring::new(part, surface, dt)?),
        };
        let (rows, twist_row) = line.rows(contact.node);
        let (sin, cos) = libm::sincos(diaphragm.angle);
        let turned = |a: &[f64], b: &[f64]| -> [Vec<f64>; 2] {
            let pair = || a.iter().zip(b);
            [pair().map(|(u, v)| cos * u + sin * v).collect(), pair().map(|(u, v)| cos * v - sin * u).collect()]
        };
        let rows = turned(&rows[0], &rows[1]);
        let responses: [Vec<f64>; 2] = std::array::from_fn(|axis| {
            let mut response = vec![0.0; rows[axis].len()];
            line.lateral.compliance(&rows[axis], &mut response);
            response
        });
        let compliance = std::array::from_fn(|i| std::array::from_fn(|j| dot(&rows[i], &responses[j])));
        let mut twist_response = vec![0.0; twist_row.len()];
        line.twist.compliance(&twist_row, &mut twist_response);
        let drive_lever = line.hold_speed(&mut twist_response);
        let twist_compliance = dot(&twist_row, &twist_response);
        let spring = match diaphragm.kind {
            DiaphragmKind::RadialSpring { stiffness } => Some(stiffness),
            _ => None,
        };
        Some(Self {
            detection: contact.detection,
            friction: contact.friction,
            law: contact.friction_law,
            location,
            rotor_radius: contact.rotor_radius,
            gap: contact.gap,
            offset: contact.offset,
            turn: (sin, cos),
            surface,
            spring,
            node: contact.node,
            ring,
            candidate: vec![0.0; rows[0].len()],
            candidate_twist: vec![0.0; twist_row.len()],
            residual: residual_at(structure, contact.node, (sin, cos)),
            shift: [0.0; 2],
            shift_before: [0.0; 2],
            held: 0.0,
            held_before: 0.0,
            rows,
            responses,
            compliance,
            twist_row,
            twist_response,
            twist_compliance,
            drive_lever,
            iterations: 0,
            several_minima: false,
            several_points: contact.points == ContactPoints::Several
                && contact.detection == Detection::Hyp2
                && location == ForceLocation::Next,
            points: Vec::new(),
            places: Vec::new(),
        })
    }

    /// Rotor centre in the stator's frame, from nodal u and v.
    pub fn local(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.local_direction([u - self.offset[0], v - self.offset[1]])
    }

    /// A vector (no place) in the stator's frame.
    pub fn local_direction(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn;
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// A vector (no place) of the stator's frame in the machine's.
    pub fn outwards(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn;
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Coordinates of the ring at n once it moves.
    pub fn ring_coordinates(&self) -> Option<&[f64]> {
        self.ring.as_ref().filter(|ring| ring.moving).map(|ring| ring.stepper.q.as_slice())
    }

    fn increment(&self, d: &[f64]) -> [f64; 2] {
        [dot(&self.rows[0], d), dot(&self.rows[1], d)]
    }

    /// Rotor centre at n+1 in the stator's frame by an increment, the modes left out included.
    fn after(&self, x_n: [f64; 2], d: &[f64]) -> [f64; 2] {
        let dx = self.increment(d);
        std::array::from_fn(|axis| x_n[axis] + dx[axis] + self.shift[axis])
    }

    /// Begins the step: the ring's motion without contact.
    pub fn prepare(&mut self) {
        (self.held_before, self.held) = (self.held, 0.0);
        self.shift_before = self.shift;
        if let Some(ring) = &mut self.ring {
            std::mem::swap(&mut ring.left_out, &mut ring.left_out_before);
        }
        self.spring_back();
        if let Some(ring) = &mut self.ring {
            ring.prepare();
        }
    }

    /// Gap of a rotor centre and ring field in the run's own gap function.
    fn own_gap(&mut self, x: [f64; 2]) -> Gap {
        match (&mut self.ring, self.detection) {
            (ring, Detection::Hyp1) => {
                polar_gap(&self.surface, ring.as_ref().map(|r| r.field.as_slice()), self.rotor_radius, x)
            }
            (Some(ring), Detection::Hyp2 | Detection::Hyp2Frozen) => {
                let place = ring.detector.closest(&ring.field, x);
                exact_gap(&self.surface, Some(&ring.field), self.rotor_radius, x, place)
            }
            // an undeformed circle is closest at the angle of the rotor centre: both gaps are one
            (None, _) => polar_gap(&self.surface, None, self.rotor_radius, x),
        }
    }

    fn fixed_gap(&self, x: [f64; 2], place: Place) -> Gap {
        let field = self.ring.as_ref().map(|ring| ring.field.as_slice());
        exact_gap(&self.surface, field, self.rotor_radius, x, place)
    }

    /// Whether the predicted step cannot touch, from a bound on the ring's radial displacement.
    fn is_far(&self, x: [f64; 2]) -> bool {
        let room = self.gap - (x[0] * x[0] + x[1] * x[1]).sqrt();
        match &self.ring {
            None => room > 0.0,
            Some(ring) => room > ring.radial_reach(),
        }
    }

    /// The gap at n in the run's own gap function, as the contact of the step before left it: its force is the one that was to
    /// leave none here.
    pub fn gap_at(&mut self, [x, y]: [f64; 2]) -> Gap {
        if let Some(ring) = &mut self.ring {
            ring.field_at_n();
        }
        self.own_gap([x + self.shift_before[0], y + self.shift_before[1]])
    }

    /// Whether the rotor's centre at n is beyond the line of the ring that touches, at its own angle: detection would find the
    /// ring's outside there, or no contact. Beyond the undeformed line it is outside wherever the ring may be: one that is pushed along
    /// (Hyp 1 puts its force at the rotor's own angle) would be found out late. A radial spring yields as far as it is pressed, and its
    /// line with it.
    pub fn is_outside(&mut self, x: [f64; 2]) -> bool {
        let distance = (x[0] * x[0] + x[1] * x[1]).sqrt();
        // far inside, whatever the ring does
        if self.is_spring() || distance <= self.gap + 0.5 * self.rotor_radius {
            return false;
        }
        if self.is_beyond(x) {
            return true;
        }
        if let Some(ring) = &mut self.ring {
            ring.field_at_n();
        }
        let field = self.ring.as_ref().map(|ring| ring.field.as_slice());
        polar_gap(&self.surface, field, 0.0, x).value <= 0.0
    }

    /// Whether a place is beyond the line of the undeformed ring that touches: no linear ring is pushed so far.
    fn is_beyond(&self, x: [f64; 2]) -> bool {
        (x[0] * x[0] + x[1] * x[1]).sqrt() >= self.surface.radius
    }

    /// Whether the stator is a massless spring, which may start loaded.
    pub fn is_spring(&self) -> bool {
        self.spring.is_some()
    }

    /// Nodal freedoms of the ring at n, after [`Rub::gap_at`].
    pub fn ring_field(&self) -> Option<&[f64]> {
        self.ring.as_ref().map(|ring| ring.field.as_slice())
    }

    /// Radial and tangential displacement of the ring at a gap's place \[m\], after [`Rub::gap_at`].
    pub fn ring_displacement(&self, gap: &Gap) -> [f64; 2] {
        self.ring.as_ref().map_or([0.0; 2], |ring| {
            let point = self.surface.point(&ring.field, gap.place.element, gap.place.xi);
            [point.radial - self.surface.radius, point.tangential]
        })
    }
    /// Kinetic and strain energy of the ring between n and n+1, and the work of its damping over the step \[J\].
    pub fn ring_energies(&self) -> (f64, f64) {
        self.ring
            .as_ref()
            .map_or((0.0, 0.0), |ring| (ring.stepper.kinetic_energy(&ring.d), ring.stepper.strain_energy(&ring.d)))
    }

    /// Work of the ring's damping over the step at n \[J\].
    pub fn ring_damping_work(&mut self) -> f64 {
        self.ring.as_mut().map_or(0.0, |ring| if ring.moving { ring.stepper.damping_work(&ring.d) } else { 0.0 })
    }

    /// Accepts the ring's increment.
    pub fn advance(&mut self) {
        if let Some(ring) = &mut self.ring
            && (ring.moving || ring.d.iter().any(|&d| d != 0.0))
        {
            ring.moving = true;
            ring.stepper.advance(&ring.d);
        }
    }
}

/// Normal and tangent in the stator's Cartesian axes.
fn directions(gap: &Gap) -> ([f64; 2], [f64; 2]) {
    let n = gap.place.cartesian(gap.normal);
    (n, [-n[1], n[0]])
}

/// Force on the rotor in the stator's Cartesian axes \[N\].
fn on_rotor(force: &ContactForce, acting: &Gap) -> [f64; 2] {
    let (normal, tangent) = directions(acting);
    [0, 1].map(|axis| -(force.normal * normal[axis] + force.tangential * tangent[axis]))
}

/// `a^T m b`.
fn bilinear(m: &[[f64; 2]; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * (m[0][0] * b[0] + m[0][1] * b[1]) + a[1] * (m[1][0] * b[0] + m[1][1] * b[1])
}
