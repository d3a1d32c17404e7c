//! Contact step: contact of one ring with the rotor inside it, by impulses at the beginning of the step.
//!
//! ```text
//! impulses    (J_n, J_t) at n,   g >= 0 at n+1,   J_n >= 0,   J_n g = 0,   |J_t| <= mu J_n                                       (1)
//! gap         g_k = g_k(free) + n_k.sum_l D_kl (J_n n_l + J_t t_l)      at each contact point k                                  (2)
//! works       J_n g',  J_t s'                                           g', s': means of the rates before and after the impulses (3)
//! ```
//! g: gap \[m\]; J_n, J_t: normal and tangential impulse on the ring \[N s\]; n, t: normal and tangent of a point; D: Delassus
//! operator, the displacement of rotor and ring at n+1 per impulse at n ([`DelassusOperator`]), static corrections included; mu:
//! friction coefficient; s': slip rate ([`super::contact_step_result`]).
//!
//! This is the scheme of forward-increment Lagrange multipliers (docs/theory/04-time-integration.md) with exact propagation in
//! place of central differences. A step has four parts:
//!
//! 1. The predictor gives ring and rotor at n+1 as the impulses of the last step would have them ([`ContactPredictor`]).
//! 2. The broad phase finds the minima of the gap there ([`BroadPhase`]). Minima with a negative gap become contact points, and
//!    so do the points that pressed in the last step.
//! 3. (1) with (2) is solved for the impulses. Points that still penetrate join ([`PenetrationSearch`]), and (1) is solved again.
//!    Nothing is iterated over the state, because the motion is linear in the impulses.
//! 4. The impulses are applied to the ring here, and to the rotor by the caller.
//!
//! An impulse acts along normal and tangent of its point at n where that point pressed in the last step, otherwise along those at
//! n+1. This makes the direction of second order in the step. Verified by `tests/exponential/exponential_rub.rs`.

mod conditions;
mod step_parts;

use super::broad_phase::BroadPhase;
use super::contact_point::{ContactPoint, PressedPoint};
use super::contact_predictor::ContactPredictor;
use super::contact_step_result::{ContactStepResult, FreeStep, MeanMotion, SurfaceTurn};
use super::delassus_operator::DelassusOperator;
use super::impulsed_ring::{ImpulsedRing, RingPropagator, STATIC_WEIGHT};
use super::penetration::PenetrationSearch;
use super::ring_kernels::{PointRows, add_scaled_rows, products_with};
use super::ring_points::{RingPoints, are_adjacent, modal_parameters};
use super::stator_axes::StatorAxes;
use crate::contact::ContactReaction;
use crate::contact::complementarity::{self, Coupled, POINTS};
use crate::eight::Eight;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::plane::{across, product, turned};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::structure::Structure;
use bladeoff_model::machine::{Contact, ContactPoints, Detection, Diaphragm, FrictionLaw};
use bladeoff_numerics::linalg::lanes::Lane;
pub(super) use conditions::add_point;
use std::sync::Arc;

/// A point penetrates where its negative gap is more than this ratio of the largest penetration without impulses.
const PENETRATION_RATIO: f64 = 1e-4;

/// Flexible or rigid ring of a diaphragm, and the solver of its contact steps.
pub(crate) struct ContactStep {
    pub axes: StatorAxes,
    /// Radial gap of the ring at rest, and radius of the rotor \[m\].
    gap: f64,
    pub(super) radius: f64,
    law: FrictionLaw,
    /// Hypothesis of the contact.
    pub(super) detection: Detection,
    /// Whether a step has several points, as `hyp2` by default; otherwise it has one place ([`super::single_place`]).
    has_several_points: bool,
    /// Whether the place of this step is the nearest point under its own impulse ([`super::fixed_point`]); true for several points.
    pub(super) has_fixed_point: bool,
    /// v_alpha/|x| at the place of `hyp1` of the last step, and of this one.
    pub(super) model_slopes: [f64; 2],
    /// Contact step \[s\].
    pub(super) h: f64,
    pub(super) ring_points: Arc<RingPoints>,
    pub ring: ImpulsedRing,
    /// Displacement at n+1 per impulse at n of each mode, with [`STATIC_WEIGHT`] times its static correction.
    pub(super) compliance: Vec<Lane>,
    /// Displacement of the rotor's truncated modes per impulse, in the stator's axes \[m/(N s)\].
    pub(super) rotor_truncated_flexibility: [[f64; 2]; 2],
    /// Propagators of the ring over steps of 2^k contact steps, by k.
    propagators: Vec<RingPropagator>,
    pub(super) broad_phase: BroadPhase,
    pub(super) penetration: PenetrationSearch,
    /// Modal impulses on the ring, and before they are known the response of the modes that the search for penetration uses.
    pub(super) impulses: Vec<Lane>,
    pub(super) predictor: ContactPredictor,
    /// Complementarity conditions (1) of the points.
    pub(super) conditions: Box<Coupled>,
    /// Contact points of this step, and their impulses.
    pub(super) points: Vec<ContactPoint>,
    pub(super) forces: Vec<ContactReaction>,
    /// Rows of the contact points of two steps: this step's are at `current`, the last step's at the other index.
    pub(super) point_rows: [Vec<PointRows>; 2],
    pub(super) current: usize,
    /// Points that pressed in the last step.
    pub(super) pressed: Vec<PressedPoint>,
    /// Turn of the rotor's surface over the last contact step.
    surface_turn: SurfaceTurn,
    /// Impulses of the last step that a search has forgotten.
    kept: step_parts::LastStep,
    /// Fault that a test injects into the contact.
    #[cfg(test)]
    pub fault: Option<crate::engine::exponential::settings::Fault>,
}

impl ContactStep {
    /// Creates the contact of a machine at rest with a flexible or a rigid ring, in contact steps of `h` \[s\].
    pub fn new(
        diaphragm: &Diaphragm,
        structure: &Structure,
        index: usize,
        ring_points: &Arc<RingPoints>,
        h: f64,
    ) -> Self {
        let part = structure.rings[index].as_ref();
        let contact = &diaphragm.contact;
        let modes = modal_parameters(part);
        let ring = ImpulsedRing::new(&modes, h);
        let dofs = structure.rotor.plane_places(contact.node);
        let axes = StatorAxes::new(diaphragm);
        let [corrected_compliance, static_correction] = ring.compliance();
        let extrapolated =
            |k: (&Lane, &Lane)| Lane(std::array::from_fn(|i| k.0.0[i] + (STATIC_WEIGHT - 1.0) * k.1.0[i]));
        let compliance: Vec<Lane> = corrected_compliance.iter().zip(&static_correction).map(extrapolated).collect();
        let zeros = vec![Lane::default(); compliance.len()];
        let rows = vec![PointRows::new(compliance.len()); POINTS];
        let rotor_truncated_flexibility = structure.lateral_residual.as_ref().map_or([[0.0; 2]; 2], |all| {
            turned(axes.angle, &dofs.map(|row| dofs.map(|column| all[(row, column)] / h)))
        });
        Self {
            axes,
            gap: contact.gap,
            radius: contact.rotor_radius,
            law: contact.friction_law,
            // all hypotheses have one place in a rigid ring, at the angle of the rotor's centre
            detection: part.map_or(Detection::Hyp1, |_| contact.detection),
            has_several_points: part.is_some() && has_several_points(contact),
            has_fixed_point: true,
            model_slopes: [0.0; 2],
            h,
            rotor_truncated_flexibility,
            broad_phase: BroadPhase::new(ring_points, contact.rotor_radius + contact.gap, contact.rotor_radius),
            penetration: PenetrationSearch::new(ring_points.count()),
            ring_points: Arc::clone(ring_points),
            predictor: ContactPredictor::new([corrected_compliance, static_correction]),
            compliance,
            ring,
            propagators: Vec::new(),
            impulses: zeros,
            point_rows: [rows.clone(), rows],
            current: 0,
            conditions: Box::new(Coupled {
                w: Default::default(),
                start: [[0.0; 2]; POINTS],
                friction: contact.friction,
                law: contact.friction_law,
                sign: 1.0,
            }),
            points: Vec::with_capacity(POINTS),
            forces: Vec::with_capacity(POINTS),
            pressed: Vec::with_capacity(POINTS),
            surface_turn: SurfaceTurn::default(),
            kept: step_parts::LastStep::default(),
            #[cfg(test)]
            fault: None,
        }
    }

    /// Reverses the sign of the static correction of the ring's modes, as a fault.
    #[cfg(test)]
    pub fn reverse_static_correction(&mut self) {
        let before = self.predictor.reverse_static_correction();
        let entries = self.compliance.iter_mut().zip(&before).flat_map(|(all, one)| all.0.iter_mut().zip(&one.0));
        entries.for_each(|(compliance, correction)| *compliance -= 2.0 * STATIC_WEIGHT * correction);
    }

    /// Changes the impulses by the fault that a test injects.
    #[cfg(test)]
    fn inject_fault(&mut self) {
        if self.fault == Some(crate::engine::exponential::settings::Fault::Restitution) {
            let begins = self.points.iter_mut().filter(|point| point.acting_slot.is_none());
            begins.for_each(|point| point.force.normal *= 3.0);
        }
    }

    /// Whether the ring is flexible.
    pub fn is_flexible(&self) -> bool {
        !self.ring.displacement.is_empty()
    }

    /// Radial gap at rest \[m\].
    pub fn gap(&self) -> f64 {
        self.gap
    }

    /// Whether impulses acted in the last step.
    pub fn in_contact(&self) -> bool {
        !self.pressed.is_empty()
    }

    /// Distance of the rotor's centre from the ring's below which no contact is possible, whatever the phases of the ring's modes
    /// \[m\].
    pub fn clearance(&self) -> f64 {
        self.gap - self.ring.reach(&self.ring_points.reach)
    }

    /// Takes the ring over a step of free motion of `h = 2^doublings` contact steps \[s\].
    pub fn propagate_ring(&mut self, doublings: usize, h: f64) {
        while self.propagators.len() <= doublings {
            let ratio = libm::exp2(self.propagators.len() as f64 - doublings as f64);
            self.propagators.push(self.ring.propagator(h * ratio));
        }
        self.ring.propagate(&self.propagators[doublings]);
        self.surface_turn.forget();
        if !self.pressed.is_empty() {
            self.forget_impulses();
        }
    }

    /// Forgets the impulses of the last step.
    fn forget_impulses(&mut self) {
        self.pressed.clear();
        self.predictor.reset();
    }

    #[inline(always)]
    fn find_kernel<V: Eight>(&mut self, free: &FreeStep<'_>) -> Result<Option<f64>, ExponentialError> {
        let operator = DelassusOperator::new(
            self.axes.angle,
            self.rotor_truncated_flexibility,
            free.response,
            self.radius * self.radius * free.rolling,
        );
        loop {
            let solution = match self.collect_points::<V>(free, &operator) {
                Some(start) => self.find_impulses::<V>(start, free, &operator),
                None if self.pressed.is_empty() => return Ok(None),
                None => None,
            };
            match solution {
                Some(least_gap) => return Ok(Some(least_gap)),
                None if self.pressed.is_empty() => return Err(ExponentialError::NoImpulses),
                // no gap is negative, or no impulses fulfil (1), at the predicted position: repeat without the prediction
                None => {
                    self.kept.pressed.clone_from(&self.pressed);
                    self.predictor.copy_last(&mut self.kept.predictor);
                    self.forget_impulses();
                }
            }
        }
    }

    /// Solves (1) at the collected points and at those that still penetrate. Returns the smallest gap that is left \[m\]; `None`
    /// where no impulses fulfil (1).
    #[inline(always)]
    fn find_impulses<V: Eight>(
        &mut self,
        (rotor, [depth, slip]): ([f64; 2], [f64; 2]),
        free: &FreeStep<'_>,
        operator: &DelassusOperator,
    ) -> Option<f64> {
        self.conditions.sign = slip.signum();
        self.write_conditions::<V>(0, None, operator);
        let mut replaced = 0;
        loop {
            self.forces.clear();
            for point in &self.points {
                self.forces.push(point.force);
            }
            complementarity::solve(&mut self.conditions, &mut self.forces)?;
            for (point, force) in self.points.iter_mut().zip(&self.forces) {
                point.force = *force;
            }
            self.evaluate_ring_response::<V>();
            if !self.has_several_points {
                if self.detection == Detection::Hyp2 {
                    self.find_fixed_point::<V>(rotor, free, operator)?;
                    self.evaluate_ring_response::<V>();
                }
                return Some(self.remaining_gap::<V>(rotor, operator));
            }
            let (least_gap, index) = self.find_penetration::<V>(rotor, operator);
            let full = self.points.len() == POINTS;
            let open_point = self.points.iter().position(|point| point.force.normal == 0.0);
            match index.filter(|_| least_gap < PENETRATION_RATIO * depth) {
                Some(index) if !full || (open_point.is_some() && replaced < POINTS) => {
                    // a point that stayed open is replaced; the last point moves to its index
                    let replaced_point = open_point.filter(|_| full);
                    let slot = replaced_point.map_or(self.points.len(), |at| self.points.swap_remove(at).slot);
                    replaced += usize::from(replaced_point.is_some());
                    let count = self.points.len();
                    let position = self.broad_phase.minimum_near(&self.ring_points, index, rotor, &self.predictor.ring);
                    add_point(self, &position, slot, free, operator);
                    self.write_conditions::<V>(count, replaced_point, operator);
                }
                _ => return Some(least_gap),
            }
        }
    }

    /// Collects the contact points of the step. Returns the predicted displacement of the rotor, and gap and slip of the deepest
    /// point without impulses; `None` where no gap is negative.
    #[inline(always)]
    fn collect_points<V: Eight>(
        &mut self,
        free: &FreeStep<'_>,
        operator: &DelassusOperator,
    ) -> Option<([f64; 2], [f64; 2])> {
        let static_correction = turned(self.axes.angle, &free.response.static_correction);
        self.predictor.predict::<V>(
            &self.ring.displacement,
            &self.ring.travel,
            [&operator.rotor_response, &static_correction, &self.rotor_truncated_flexibility],
        );
        let ([x, y], [dx, dy]) = (self.axes.place(free.end), self.predictor.rotor_displacement);
        let rotor = [x + dx, y + dy];
        self.points.clear();
        self.has_fixed_point = true;
        if self.has_several_points {
            self.collect_minima::<V>(rotor, free, operator);
        } else if let Some(place) = self.single_place::<V>(rotor)
            && (place.gap < 0.0 || self.in_contact())
        {
            add_point(self, &place, 0, free, operator);
        }
        let deepest = self.points.iter().min_by(|one, other| one.free[0].total_cmp(&other.free[0]))?;
        (deepest.free[0] < 0.0).then_some((rotor, deepest.free))
    }

    /// Collects the minima of the gap that are closed, and the points of the last step.
    #[inline(always)]
    fn collect_minima<V: Eight>(&mut self, rotor: [f64; 2], free: &FreeStep<'_>, operator: &DelassusOperator) {
        self.broad_phase.find_minima::<V>(&self.ring_points, rotor, &self.predictor.ring);
        for at in 0..self.kept.searched.len() {
            let position = self.place_on_predicted_motion::<V>(self.kept.searched[at], rotor);
            add_point(self, &position, at, free, operator);
        }
        let (minima, has_searched) = (self.broad_phase.minima.len(), !self.points.is_empty());
        // gap minima first, then the points of the last step
        for at in 0..minima + self.pressed.len() {
            let index =
                if at < minima { self.broad_phase.minima[at] } else { self.pressed[at - minima].position.index };
            let is_adjacent =
                |point: &ContactPoint| are_adjacent(point.position.index, index, self.ring_points.count());
            if (at >= minima || has_searched) && self.points.iter().any(is_adjacent) {
                continue;
            }
            let position = self.broad_phase.minimum_near(&self.ring_points, index, rotor, &self.predictor.ring);
            let (is_added, max_points) =
                if at < minima { (position.gap < 0.0, POINTS - 2) } else { (true, POINTS - 1) };
            if is_added && self.points.len() < max_points {
                add_point(self, &position, self.points.len(), free, operator);
            }
        }
    }

    /// Rows of the acting position of a contact point.
    #[inline(always)]
    fn acting_rows<'a>(rows: &'a [Vec<PointRows>; 2], current: usize, point: &ContactPoint) -> [&'a [Lane]; 2] {
        match point.acting_slot {
            Some(slot) => rows[1 - current][slot].along(),
            None => rows[current][point.slot].along(),
        }
    }

    /// Applies the impulses to the ring. Returns the contact of the step, with the impulse on the rotor.
    #[inline(always)]
    fn apply_impulses<V: Eight>(&mut self, free: &FreeStep<'_>, least_gap: f64) -> ContactStepResult {
        #[cfg(test)]
        self.inject_fault();
        let (rotor_impulse, torque) = self.rotor_impulse();
        let Self { impulses, pressed, predictor, points, point_rows, current, ring, .. } = self;
        let pressing = || points.iter().filter(|point| point.force.normal > 0.0);
        impulses.fill(Lane::default());
        pressed.clear();
        predictor.reset();
        for point in pressing() {
            let force = &point.force;
            add_scaled_rows::<V>(
                [force.normal, force.tangential],
                Self::acting_rows(point_rows, *current, point),
                impulses,
            );
            predictor.add_impulse::<V>(&point.position, force, point_rows[*current][point.slot].along());
            pressed.push(PressedPoint { position: point.position, force: *force, slot: point.slot });
        }
        ring.apply_impulses::<V>(impulses);
        let contact = ContactImpulse {
            diaphragm: free.diaphragm,
            impulse: self.axes.to_machine(rotor_impulse),
            torque,
            speed_jump: 0.0,
        };
        // works (3): mean rates before and after the impulses
        let MeanMotion { velocity, rate, surface_rate } = free.mean_motion(contact, &mut self.surface_turn, self.h);
        let velocity = self.axes.to_stator(velocity);
        let rolling = self.radius * surface_rate;
        let mut impact = ContactStepResult {
            contact,
            normal: 0.0,
            tangential: 0.0,
            friction_work: 0.0,
            normal_work: 0.0,
            model_work: 0.0,
            damped_work: torque * (surface_rate - rate),
            gap: least_gap,
            points: 0,
            sticks: true,
            reversed: false,
            no_fixed_point: !self.has_fixed_point,
            angle: 0.0,
            slip: 0.0,
        };
        let mut largest_normal = 0.0;
        for point in self.points.iter().filter(|point| point.force.normal > 0.0) {
            let (force, acting) = (&point.force, &point.acting);
            let rates = products_with::<V, 2>(
                Self::acting_rows(&self.point_rows, self.current, point),
                &self.ring.mean_velocity,
            );
            let opening = rates[0] - product(acting.normal, velocity);
            let slip = product(across(acting.normal), velocity) + rolling - rates[1];
            impact.friction_work += force.tangential * slip;
            let model_work = self.model_work(point, velocity);
            impact.model_work += model_work;
            impact.normal_work -= force.normal * opening + model_work;
            impact.normal += force.normal;
            impact.tangential += force.tangential;
            impact.points += 1;
            impact.sticks &= force.sticks;
            impact.reversed |= self.law == FrictionLaw::Slip && slip * force.tangential < 0.0;
            if force.normal > largest_normal {
                largest_normal = force.normal;
                impact.slip = slip;
                impact.angle = (acting.index as f64 + 0.5 + acting.offset) * self.ring_points.spacing;
            }
        }
        impact
    }

    /// Distance of the rotor's centre from the ring's centre at which the rotor has left the ring \[m\].
    pub fn ring_radius(&self) -> f64 {
        self.radius + self.gap
    }
}

/// Whether a contact has several points in a step: `hyp2`, where the machine does not ask for one.
pub(crate) fn has_several_points(contact: &Contact) -> bool {
    contact.detection == Detection::Hyp2 && contact.points == ContactPoints::Several
}
