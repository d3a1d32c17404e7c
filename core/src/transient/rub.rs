//! One diaphragm under way: the ring's motion and its contact with the rotor.
//!
//! A contact is found on the predicted step (no contact force), then force, places and speeds are iterated together until
//! the linearised gap at n+1 is zero (paper, Algorithm 1, with its loop condition corrected). Without a fixed point
//! (physics.md section 3) the predicted place is kept and the step counted.

use super::shaft_line::{ShaftLine, distance, norm};
use super::stepper::Stepper;
use crate::contact::{Compliance, ContactForce, Detector, Gap, NotUnique, Place, exact_gap, polar_gap, slide, stick_or_slide};
use crate::linalg::{Matrix, axpy, dot};
use crate::machine::{ContactSurface, Detection, Diaphragm, DiaphragmKind, ForceLocation, FrictionLaw};
use crate::stator::Surface;
use crate::structure::{Coordinates, RingPart, Structure};

/// What contact did in the step at n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepContact {
    pub force: ContactForce,
    /// Gap and place of the converged step, in the run's own gap function.
    pub gap: Gap,
    /// Centred slip velocity [m/s].
    pub slip: f64,
    /// Slip direction frozen at the prediction and not kept by the solution.
    pub reversed: bool,
    /// Took the predicted place because the iteration has no fixed point.
    pub no_fixed_point: bool,
    /// Energy taken out by friction, by the normal force and by Hyp 1's model work in the step [J].
    pub friction_work: f64,
    pub normal_work: f64,
    pub model_work: f64,
}

/// A contact step that could not be computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactFailure {
    NotUnique(NotUnique),
    NoConvergence,
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
    /// Static flexibility of the lateral modes left out, at the node in the stator's axes [m/N].
    residual: [[f64; 2]; 2],
    /// Energy held by the static flexibility of the modes left out, at this step and the one before [J].
    pub held: f64,
    pub held_before: f64,
    /// Compliance of the node in the stator's axes [m/N].
    compliance: [[f64; 2]; 2],
    twist_row: Vec<f64>,
    twist_response: Vec<f64>,
    twist_compliance: f64,
    /// Torque that a prescribed speed's drive adds per torque on the node.
    drive_lever: f64,
    pub iterations: u64,
    candidate: Vec<f64>,
    candidate_twist: Vec<f64>,
}

/// The flexible ring of a diaphragm.
struct Ring<'a> {
    coordinates: &'a Coordinates,
    stepper: Stepper,
    detector: Detector,
    /// Increment without contact, current increment.
    free: Vec<f64>,
    d: Vec<f64>,
    field: Vec<f64>,
    scratch: Vec<f64>,
    /// Static flexibility of the modes left out.
    residual: Option<&'a Matrix>,
    /// Bound of |v| per unit of each coordinate.
    radial_bound: Vec<f64>,
    normal: RingForce,
    tangent: RingForce,
    gap_row: Vec<f64>,
    /// Something has touched it: before that its increments are exactly zero and cost nothing.
    moving: bool,
}

/// Generalised force of a unit force on the ring and its response A^-1.
struct RingForce {
    force: Vec<f64>,
    response: Vec<f64>,
}

/// Convergence of increments, relative.
const TOLERANCE: f64 = 1e-11;
/// Iterations of a contact step before it counts as one without fixed point.
const CONTACT_ITERATIONS: usize = 40;

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

    /// Coordinates of the ring at n once it moves.
    pub fn ring_coordinates(&self) -> Option<&[f64]> {
        self.ring.as_ref().filter(|ring| ring.moving).map(|ring| ring.stepper.q.as_slice())
    }

    fn increment(&self, d: &[f64]) -> [f64; 2] {
        [dot(&self.rows[0], d), dot(&self.rows[1], d)]
    }

    /// Static flexibility of the modes left out: gap by a unit normal and by a unit tangential force at a place [m/N].
    fn residual_flexibility(&self, acting: &Gap) -> (f64, f64) {
        let (n, t) = directions(acting);
        let along = |a: [f64; 2], b: [f64; 2]| {
            let r = &self.residual;
            a[0] * (r[0][0] * b[0] + r[0][1] * b[1]) + a[1] * (r[1][0] * b[0] + r[1][1] * b[1])
        };
        let (mut nn, mut nt) = (along(n, n), along(n, t));
        if let Some((ring, residual)) = self.ring.as_ref().and_then(|ring| Some((ring, ring.residual?))) {
            debug_assert!(ring.field.len() == residual.nrows());
            let [n_r, n_t] = acting.normal;
            let shapes = self.surface.shapes(acting.place.element, acting.place.xi);
            for (i, r_i, t_i) in shapes {
                let row = n_r * r_i + n_t * t_i;
                for (j, r_j, t_j) in shapes {
                    nn += row * residual[(i, j)] * (n_r * r_j + n_t * t_j);
                    nt += row * residual[(i, j)] * (n_r * t_j - n_t * r_j);
                }
            }
        }
        (nn, nt)
    }

    /// Begins the step: the ring's motion without contact.
    pub fn prepare(&mut self) {
        (self.held_before, self.held) = (self.held, 0.0);
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

    /// The gap at n in the run's own gap function, for records.
    pub fn gap_at(&mut self, x: [f64; 2]) -> Gap {
        if let Some(ring) = &mut self.ring {
            ring.coordinates.expand_head(&ring.stepper.q, &mut ring.field);
        }
        self.own_gap(x)
    }

    /// Whether the stator is a massless spring, which may start loaded.
    pub fn is_spring(&self) -> bool {
        self.spring.is_some()
    }

    /// Radial and tangential displacement of the ring at a gap's place [m], after [`Rub::gap_at`].
    pub fn ring_displacement(&self, gap: &Gap) -> [f64; 2] {
        self.ring.as_ref().map_or([0.0; 2], |ring| {
            let point = self.surface.point(&ring.field, gap.place.element, gap.place.xi);
            [point.radial - self.surface.radius, point.tangential]
        })
    }

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
        if let Some(ring) = &mut self.ring {
            ring.d.copy_from_slice(&ring.free);
        }
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
        let force_place = match self.location {
            ForceLocation::Next => None,
            ForceLocation::Current => Some(self.gap_at(x_n)),
        };
        self.load_rows(force_place.as_ref().unwrap_or(&predicted), &predicted);
        let sign = self.centred_slip(line, &predicted_or(force_place, predicted), d, d_twist).signum();
        let attempt = Attempt { x_n, sign, predicted, force_place, time };
        let (prediction, prediction_twist) = (d.to_vec(), d_twist.to_vec());
        let updating = self.detection != Detection::Hyp2Frozen;
        let mut no_fixed_point = false;
        let mut result = self.iterate(line, &attempt, updating, d, d_twist)?;
        if result.is_none() && updating {
            no_fixed_point = true;
            d.copy_from_slice(&prediction);
            d_twist.copy_from_slice(&prediction_twist);
            if let Some(ring) = &mut self.ring {
                ring.d.copy_from_slice(&ring.free);
            }
            result = self.iterate(line, &attempt, false, d, d_twist)?;
        }
        let (force, gap) = result.ok_or(ContactFailure::NoConvergence)?;
        if force.normal <= 0.0 {
            return Ok(None);
        }
        Ok(Some(self.account(line, &attempt, force, gap, no_fixed_point, d, d_twist)))
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
        let mut last = ContactForce::NONE;
        let mut search = PlaceSearch::default();
        for iteration in 0..CONTACT_ITERATIONS {
            self.iterations += 1;
            let dx = self.increment(d);
            let x = [attempt.x_n[0] + dx[0], attempt.x_n[1] + dx[1]];
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
            line.respond(attempt.time, d, d_twist, &mut free, &mut free_twist);
            let solved = self.solve(&gap, &acting, attempt.sign, (d, &free, &free_twist));
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
            let moved = distance(&free, d) <= TOLERANCE * norm(&free) + f64::MIN_POSITIVE
                && distance(&free_twist, d_twist) <= TOLERANCE * norm(&free_twist);
            let steady = change * self.scale() <= 1e-14 * self.rotor_radius.max(self.gap) + 1e-11 * force.normal * self.scale();
            d.copy_from_slice(&free);
            d_twist.copy_from_slice(&free_twist);
            (self.candidate, self.candidate_twist) = (free, free_twist);
            last = force;
            if iteration > 0 && moved && steady && self.ring_settled() {
                return Ok(Some((force, gap)));
            }
        }
        Ok(None)
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
        let along = |a: [f64; 2], b: [f64; 2]| {
            let s = &self.compliance;
            a[0] * (s[0][0] * b[0] + s[0][1] * b[1]) + a[1] * (s[1][0] * b[0] + s[1][1] * b[1])
        };
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
        let (nn, nt) = self.residual_flexibility(acting);
        (w.nn, w.nt) = (w.nn + nn, w.nt + nt);
        match self.law {
            FrictionLaw::Slip => slide(g0, w, self.friction, sign),
            FrictionLaw::StickSlip => stick_or_slide(g0, slip, w, self.friction),
        }
    }

    /// Adds the response to a contact force to increments without it; the ring's increment becomes the one with it.
    fn apply(&mut self, force: &ContactForce, acting: &Gap, free: &mut [f64], free_twist: &mut [f64]) {
        let (normal, tangent) = directions(acting);
        for axis in 0..2 {
            let f = -(force.normal * normal[axis] + force.tangential * tangent[axis]);
            axpy(f, &self.responses[axis], free);
        }
        axpy(-force.tangential * self.rotor_radius, &self.twist_response, free_twist);
        if let Some(ring) = &mut self.ring {
            ring.scratch.copy_from_slice(&ring.d);
            ring.d.copy_from_slice(&ring.free);
            axpy(force.normal, &ring.normal.response, &mut ring.d);
            axpy(force.tangential, &ring.tangent.response, &mut ring.d);
        }
    }

    fn ring_settled(&self) -> bool {
        // rounding of the gap (1e-16 of the radius) is the floor of what the ring's increment can settle to
        let floor = 1e-13 * self.rotor_radius.max(self.gap);
        self.ring.as_ref().is_none_or(|ring| {
            let scale = ring.radial_bound.iter().fold(0.0_f64, |max, bound| max.max(*bound));
            distance(&ring.d, &ring.scratch) * scale <= 1e-10 * norm(&ring.d) * scale + floor
        })
    }

    /// Compliance that turns a change of force into a change of place [m/N].
    fn scale(&self) -> f64 {
        let ring = self.ring.as_ref().map_or(0.0, |ring| dot(&ring.normal.force, &ring.normal.response));
        ring + self.compliance[0][0].max(self.compliance[1][1])
    }

    /// Ring rows of the force place and of the gap place.
    fn load_rows(&mut self, acting: &Gap, gap: &Gap) {
        if let Some(ring) = &mut self.ring {
            let [n_r, n_t] = acting.normal;
            ring.load_force(acting.place, [n_r, n_t], &self.surface, true);
            ring.load_force(acting.place, [-n_t, n_r], &self.surface, false);
            ring.load_gap_row(gap, &self.surface);
        }
    }

    /// Centred slip velocity of increments at the place whose rows are loaded [m/s].
    fn centred_slip(&self, line: &ShaftLine<'_>, acting: &Gap, d: &[f64], d_twist: &[f64]) -> f64 {
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
        force: ContactForce,
        gap: Gap,
        no_fixed_point: bool,
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
        let (nn, nt) = self.residual_flexibility(&acting);
        let yielding = nn * force.normal + nt * force.tangential;
        self.held = 0.5 * force.normal * yielding;
        let mut residual = if self.detection == Detection::Hyp2Frozen || no_fixed_point {
            let x = [attempt.x_n[0] + dx[0], attempt.x_n[1] + dx[1]];
            if let Some(ring) = &mut self.ring {
                ring.refresh_field();
            }
            self.own_gap(x)
        } else {
            gap
        };
        residual.value += yielding;
        StepContact {
            force,
            gap: residual,
            slip,
            reversed: self.law == FrictionLaw::Slip && slip * attempt.sign < 0.0,
            no_fixed_point,
            friction_work: force.tangential * slip * line.dt,
            normal_work: -force.normal * opening - model_work,
            model_work,
        }
    }

    /// Massless quasi-static spring: the force follows from the place at n, only friction depends on the step.
    fn spring_contact(
        &mut self,
        line: &mut ShaftLine<'_>,
        time: f64,
        stiffness: f64,
        x_n: [f64; 2],
        d: &mut [f64],
        d_twist: &mut [f64],
    ) -> Result<Option<StepContact>, ContactFailure> {
        let gap = polar_gap(&self.surface, None, self.rotor_radius, x_n);
        if gap.value >= 0.0 {
            return Ok(None);
        }
        let normal = -stiffness * gap.value;
        let (_, tangent) = directions(&gap);
        let mut sign = 0.0;
        let mut force = ContactForce { normal, tangential: 0.0, sticks: false };
        let w_tt = {
            let s = &self.compliance;
            let along = tangent[0] * (s[0][0] * tangent[0] + s[0][1] * tangent[1])
                + tangent[1] * (s[1][0] * tangent[0] + s[1][1] * tangent[1]);
            -along - self.rotor_radius * self.rotor_radius * self.twist_compliance
        };
        for iteration in 0..CONTACT_ITERATIONS {
            self.iterations += 1;
            let mut free = std::mem::take(&mut self.candidate);
            let mut free_twist = std::mem::take(&mut self.candidate_twist);
            line.respond(time, d, d_twist, &mut free, &mut free_twist);
            self.apply(&ContactForce { tangential: 0.0, ..force }, &gap, &mut free, &mut free_twist);
            match self.law {
                FrictionLaw::Slip => {
                    if iteration == 0 {
                        sign = self.centred_slip(line, &gap, &free, &free_twist).signum();
                    }
                    force.tangential = self.friction * normal * sign;
                }
                FrictionLaw::StickSlip => {
                    let dx = self.increment(&free);
                    let slip = tangent[0] * dx[0]
                        + tangent[1] * dx[1]
                        + self.rotor_radius * dot(&self.twist_row, &free_twist);
                    let holding = -slip / w_tt;
                    let limit = self.friction * normal;
                    force.sticks = holding.abs() <= limit;
                    force.tangential = holding.clamp(-limit, limit);
                }
            }
            self.apply(&ContactForce { normal: 0.0, ..force }, &gap, &mut free, &mut free_twist);
            line.add_drive_torque(self.drive_lever * force.tangential * self.rotor_radius);
            let moved = distance(&free, d) <= TOLERANCE * norm(&free) + f64::MIN_POSITIVE
                && distance(&free_twist, d_twist) <= TOLERANCE * norm(&free_twist);
            d.copy_from_slice(&free);
            d_twist.copy_from_slice(&free_twist);
            (self.candidate, self.candidate_twist) = (free, free_twist);
            if iteration > 0 && moved {
                let slip = self.centred_slip(line, &gap, d, d_twist);
                return Ok(Some(StepContact {
                    force,
                    // the massless stator follows the rotor: nothing penetrates
                    gap: Gap { value: 0.0, ..gap },
                    slip,
                    reversed: self.law == FrictionLaw::Slip && slip * sign < 0.0,
                    no_fixed_point: false,
                    friction_work: force.tangential * slip * line.dt,
                    normal_work: 0.0,
                    model_work: 0.0,
                }));
            }
        }
        Err(ContactFailure::NoConvergence)
    }

    /// Potential of a radial spring at a rotor centre in the stator's frame [J].
    pub fn spring_energy(&self, x: [f64; 2]) -> f64 {
        self.spring.map_or(0.0, |stiffness| {
            let depth = ((x[0] * x[0] + x[1] * x[1]).sqrt() - self.gap).max(0.0);
            0.5 * stiffness * depth * depth
        })
    }

    /// Kinetic and strain energy of the ring between n and n+1, and the work of its damping over the step [J].
    pub fn ring_energies(&self) -> (f64, f64) {
        self.ring.as_ref().map_or((0.0, 0.0), |ring| {
            (ring.stepper.kinetic_energy(&ring.d), ring.stepper.strain_energy(&ring.d))
        })
    }

    /// Work of the ring's damping over the step at n [J].
    pub fn ring_damping_work(&mut self) -> f64 {
        self.ring.as_mut().map_or(0.0, |ring| if ring.moving { ring.stepper.damping_work(&ring.d) } else { 0.0 })
    }

    /// Accepts the ring's increment.
    pub fn advance(&mut self) {
        if let Some(ring) = &mut self.ring {
            if ring.moving || ring.d.iter().any(|&d| d != 0.0) {
                ring.moving = true;
                ring.stepper.advance(&ring.d);
            }
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

/// Search for the angle at which a contact force makes its own place the closest one.
///
/// Plain iteration converges by as little as -0.6 a round in heavy rub (the ring slides under the rotor as it is pressed), and
/// not at all beyond -1: the secant through the last two rounds is taken while they stay on one minimum.
#[derive(Default)]
struct PlaceSearch {
    /// Angle used and residual (place found - place used) of the last round.
    last: Option<(f64, f64)>,
    used: Option<f64>,
    jumps: u32,
}

impl PlaceSearch {
    /// The angle to use after `found` was closest; `None` when two minima keep taking turns.
    fn next(&mut self, found: f64) -> Option<f64> {
        let Some(used) = self.used else {
            self.used = Some(found);
            return Some(found);
        };
        let residual = wrapped(found - used);
        if residual.abs() > JUMP {
            self.jumps += 1;
            if self.jumps > 4 {
                return None;
            }
            (self.last, self.used) = (None, Some(found));
            return self.used;
        }
        let plain = used + residual;
        let next = match self.last {
            Some((before, residual_before)) if (residual - residual_before).abs() > 0.2 * residual_before.abs() => {
                let secant = used - residual * wrapped(used - before) / (residual - residual_before);
                if wrapped(secant - used).abs() <= 5.0 * residual.abs() { secant } else { plain }
            }
            _ => plain,
        };
        self.last = Some((used, residual));
        self.used = Some(next);
        self.used
    }
}

/// A contact angle that moves by more than this has changed to another minimum [rad].
const JUMP: f64 = 0.02;

/// An angle difference in -pi..pi.
fn wrapped(angle: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    angle - turn * (angle / turn).round()
}

/// Residual flexibility of the rotor at a node, turned into the stator's axes.
fn residual_at(structure: &Structure, node: usize, (sin, cos): (f64, f64)) -> [[f64; 2]; 2] {
    let Some(all) = &structure.lateral_residual else { return [[0.0; 2]; 2] };
    let places = structure.rotor.plane_places(node);
    let axes = [[cos, sin], [-sin, cos]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let mut sum = 0.0;
            for (a, &row) in places.iter().enumerate() {
                for (b, &col) in places.iter().enumerate() {
                    sum += axes[i][a] * all[(row, col)] * axes[j][b];
                }
            }
            sum
        })
    })
}

fn predicted_or(force_place: Option<Gap>, predicted: Gap) -> Gap {
    force_place.unwrap_or(predicted)
}

/// Normal and tangent in the stator's Cartesian axes.
fn directions(gap: &Gap) -> ([f64; 2], [f64; 2]) {
    let n = gap.place.cartesian(gap.normal);
    (n, [-n[1], n[0]])
}

impl<'a> Ring<'a> {
    fn new(part: &'a RingPart, surface: Surface, dt: f64) -> Option<Self> {
        let coordinates = &part.part.coordinates;
        let size = coordinates.size();
        let zeros = || vec![0.0; size];
        let nodal = 4 * part.matrices.nodes;
        // |v| along an element stays below its nodal values plus the slopes' bulge of L/4 each side
        let arc = 2.0 * std::f64::consts::PI * part.matrices.mean_radius / part.matrices.nodes as f64;
        let mut radial_bound = zeros();
        for node in 0..part.matrices.nodes {
            let (value, slope) = (coordinates.row(4 * node + 2), coordinates.row(4 * node + 3));
            for k in 0..size {
                radial_bound[k] = f64::max(radial_bound[k], value[k].abs() + 0.25 * arc * slope[k].abs());
            }
        }
        Some(Self {
            coordinates,
            stepper: Stepper::new(&part.part, &part.part.mass, dt)?,
            detector: Detector::new(surface),
            free: zeros(),
            d: zeros(),
            field: vec![0.0; nodal],
            scratch: zeros(),
            residual: part.residual.as_ref(),
            radial_bound,
            normal: RingForce { force: zeros(), response: zeros() },
            tangent: RingForce { force: zeros(), response: zeros() },
            gap_row: zeros(),
            moving: false,
        })
    }

    fn prepare(&mut self) {
        if self.moving {
            self.stepper.prepare(None);
            self.stepper.increment(None, &mut self.free);
        }
        self.d.copy_from_slice(&self.free);
    }

    /// Nodal field of the ring at n+1 with the current increment.
    fn refresh_field(&mut self) {
        for i in 0..self.d.len() {
            self.scratch[i] = self.stepper.q[i] + self.d[i];
        }
        self.coordinates.expand_head(&self.scratch, &mut self.field);
    }

    /// Upper bound of |v| at n+1.
    fn radial_reach(&self) -> f64 {
        let mut reach = 0.0;
        for i in 0..self.d.len() {
            reach += self.radial_bound[i] * (self.stepper.q[i] + self.d[i]).abs();
        }
        reach
    }

    fn load_force(&mut self, place: Place, [radial, tangential]: [f64; 2], surface: &Surface, normal: bool) {
        let target = if normal { &mut self.normal } else { &mut self.tangent };
        target.force.fill(0.0);
        for (dof, r, t) in surface.shapes(place.element, place.xi) {
            self.coordinates.add_row(dof, radial * r + tangential * t, &mut target.force);
        }
        self.stepper.compliance(&target.force, &mut target.response);
    }

    fn load_gap_row(&mut self, gap: &Gap, surface: &Surface) {
        self.gap_row.fill(0.0);
        let [radial, tangential] = gap.ring_gradient;
        for (dof, r, t) in surface.shapes(gap.place.element, gap.place.xi) {
            self.coordinates.add_row(dof, radial * r + tangential * t, &mut self.gap_row);
        }
    }
}
