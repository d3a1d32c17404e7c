//! Observer of a run: records the motion and shows it to a follower, and never changes it.
//!
//! Loads, the rotor in the ring, and contact are recorded in every step. Stresses and energies are observed when they are due ([`super::observation_schedule`]), stresses also where their
//! bound exceeds a limit ([`super::yield_watch`]).
//!
//! Limits: peaks of stresses between two observations are missed, unless a limit watches them. Verified by `tests/exponential/exponential_run.rs`.

use super::damping_watch::DampingWatch;
use super::energy_balance::{EnergyBalance, Pending, add_works, energies_of, ring_energy};
use super::frame_sampler::{FrameSampler, MotionAhead};
use super::observation_schedule::{Due, ObservationSchedule, RunState};
use super::ring_clearance::{RingClearance, ring_clearances};
use super::ring_stress_check::RingStressCheck;
use super::shaft_stresses::ShaftStresses;
use super::yield_watch::{WatchResult, YieldWatch};
use crate::engine::exponential::stepping::diaphragm_contact::DiaphragmContact;
use crate::engine::exponential::stepping::transient::Transient;
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::engine::release::Due as ReleaseDue;
use crate::record::{At, End, Follower, Recorders, RingInstant, Touch};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause, Limit};

/// Observer of a run.
pub(crate) struct Observer<'a> {
    machine: &'a Machine,
    structure: &'a Structure,
    pub recorders: Recorders,
    /// Contact step \[s\].
    h: f64,
    /// Spin at n \[rad/s\]; 0 where the rotor has stopped.
    pub speed: f64,
    /// The rotor has touched: the modes of a ring are not at rest.
    has_touched: bool,
    /// Energy of the rings at n \[J\], known behind a free step in which a ring moved.
    ring_energy: Option<f64>,
    schedule: ObservationSchedule,
    energy: EnergyBalance,
    shaft_stresses: ShaftStresses,
    /// By diaphragm.
    ring_stresses: Vec<RingStressCheck>,
    /// `None` where no material has a yield strength.
    yield_watch: Option<YieldWatch>,
    /// Clearance of the whole ring of each diaphragm; `None` without a flexible ring.
    ring_clearances: Vec<Option<RingClearance<'a>>>,
    damping: DampingWatch,
    /// Made when a follower first asks for an instant.
    frames: Option<Box<FrameSampler<'a>>>,
}

/// The observation of one step, from n on.
pub(crate) struct StepObservation {
    at: At,
    contact_steps: u64,
    due: Due,
    /// The step is one of a start, or of a disturbed run: powers are means over it even where it is free.
    is_averaged: bool,
    pending: Option<Pending>,
    /// The follower is shown the motion at n.
    is_shown: bool,
    /// Energies are shown at n although none are due.
    completes_terms: bool,
    watch: WatchResult,
    /// Angle of rotation at n \[rad\].
    angle: f64,
    /// Energy of the rings at n \[J\], where the step is free and a ring moves.
    ring_before: Option<f64>,
}

impl StepObservation {
    /// Largest step that shows the first excess of a yield limit to one contact step, in doublings of the contact step.
    pub fn max_doublings(&self) -> usize {
        self.watch.max_doublings
    }
}

impl<'a> Observer<'a> {
    /// Observer of a run that begins, in contact steps of `h` \[s\].
    pub fn new(machine: &'a Machine, structure: &'a Structure, h: f64, transient: &Transient) -> Self {
        let mut recorders = Recorders::new(machine, &structure.rings, h);
        recorders.search_nothing();
        recorders.settle_shaft(machine, structure);
        let yield_limits = [Limit::RingYield, Limit::BladeYield, Limit::ShaftYield]
            .map(|limit| machine.run.limits[limit as usize].value);
        let yield_watch = YieldWatch::new(&recorders, yield_limits);
        let shaft_stresses = ShaftStresses::new(machine, structure, &transient.free_motion, &recorders, h);
        let mut observer = Self {
            machine,
            structure,
            recorders,
            h,
            speed: transient.free_motion.speed(),
            has_touched: false,
            ring_energy: None,
            schedule: ObservationSchedule::default(),
            energy: EnergyBalance::new(h, transient),
            shaft_stresses,
            ring_stresses: structure.rings.iter().map(|part| RingStressCheck::new(part.as_ref(), h)).collect(),
            yield_watch,
            ring_clearances: ring_clearances(machine, structure),
            damping: DampingWatch::default(),
            frames: None,
        };
        observer.damping.update(&transient.free_motion, observer.speed, &mut observer.recorders);
        observer
    }

    /// Observes the motion at n, before the size of the step is chosen.
    ///
    /// # Errors
    /// [`Cause::NonFinite`] and [`Cause::Diverged`] of a motion that cannot be.
    pub fn begin(&mut self, transient: &mut Transient, follower: &mut dyn Follower) -> Result<StepObservation, Cause> {
        let contact_steps = transient.free_motion.contact_steps();
        let at = At { time: transient.free_motion.time(), speed: self.speed };
        let is_starting = transient.is_starting();
        let due = self.schedule.due(RunState {
            contact_steps,
            is_starting,
            is_disturbed: transient.disturbed,
            spin_changes_fast: transient.free_motion.spin_changes_fast(),
            has_touched: self.has_touched,
        });
        let pending = if due.motion { Some(self.observe(due, at, transient)?) } else { None };
        let is_shown = follower.wants(contact_steps, at.time);
        if (due.dissipation || is_shown) && follower.wants_energies() {
            let works = self.recorders.energies.now;
            self.energy.take_terms(transient, self.structure).take_works(&works);
        }
        let watch = match &mut self.yield_watch {
            Some(watch) => watch.watch(transient, &mut self.recorders),
            None => WatchResult { max_doublings: usize::MAX, ..WatchResult::default() },
        };
        if !due.motion && watch.shaft {
            self.observe_shaft(at, transient)?;
        } else if !due.motion && transient.torques_change() {
            self.shaft_stresses.update_torsion(&transient.free_motion, &mut self.recorders, at);
        }
        Ok(StepObservation {
            at,
            contact_steps,
            due,
            is_averaged: is_starting || transient.disturbed,
            pending,
            is_shown,
            completes_terms: is_shown && !due.dissipation && self.energy.terms.is_some(),
            watch,
            angle: 0.0,
            ring_before: None,
        })
    }

    /// Observes and shows what the step would change: a free step of `2^doublings` contact steps, or a contact step.
    pub fn before_step(
        &mut self,
        step: &mut StepObservation,
        doublings: Option<usize>,
        transient: &mut Transient,
        follower: &mut dyn Follower,
    ) {
        let is_free = doublings.is_some();
        if step.pending.is_some() && (!is_free || step.is_averaged) {
            self.energy.keep_motion(transient);
        }
        // the impulse at n of a contact step is known behind it
        if let Some(pending) = step.pending.take_if(|_| is_free) {
            let impulses = step.is_averaged.then_some(&[][..]);
            self.complete(pending, impulses, transient);
        }
        if step.is_shown {
            self.frames(transient).sample(transient);
        }
        if step.completes_terms && is_free {
            self.energy.complete_terms(step.contact_steps, None, transient, self.recorders.energies.now);
        }
        if let Some(doublings) = doublings.filter(|_| follower.follows()) {
            self.show_free_step(doublings, step.is_shown, transient, follower);
        }
        step.angle = transient.free_motion.angle();
        let known = self.ring_energy.take();
        step.ring_before = (is_free && self.has_touched).then(|| known.unwrap_or_else(|| ring_energy(transient)));
    }

    /// Records a step that has been done, and shows it where it was a contact step.
    #[inline]
    pub fn after_step(
        &mut self,
        step: &mut StepObservation,
        doublings: Option<usize>,
        transient: &mut Transient,
        follower: &mut dyn Follower,
    ) {
        let is_contact_step = doublings.is_none();
        if step.pending.is_some() || (step.completes_terms && is_contact_step) {
            let impulses = std::mem::take(&mut transient.impulses);
            if let Some(pending) = step.pending.take() {
                self.complete(pending, Some(&impulses), transient);
            }
            if step.completes_terms && is_contact_step {
                self.energy.complete_terms(step.contact_steps, Some(&impulses), transient, self.recorders.energies.now);
            }
            transient.impulses = impulses;
        }
        self.damping.update(&transient.free_motion, transient.free_motion.speed(), &mut self.recorders);
        self.record(step, doublings, transient);
        self.ring_energy = add_works(&mut self.recorders.energies.now, !is_contact_step, step.ring_before, transient);
        if is_contact_step {
            self.show_contact_step(step, transient, follower);
        }
    }

    /// Observes the end of a run, with the loads and the impulse of the step that would follow, where there is one; the motion is left there.
    pub fn finish(&mut self, mut end: End, transient: &mut Transient, follower: &mut dyn Follower) -> End {
        let at = At { time: end.time, speed: self.speed };
        // peaks and the last balance are those of the end
        let pending = match end.failure.is_none().then(|| self.observe(Due::ALL, at, transient)).transpose() {
            Ok(pending) => pending,
            Err(cause) => {
                (end.cause, end.failure) = (EndCause::Failure, Some(cause));
                None
            }
        };
        let is_shown = follower.wants_end();
        if is_shown {
            self.energy.take_terms(transient, self.structure);
            self.frames(transient).sample(transient);
        }
        self.energy.keep_motion(transient);
        let contact_steps = transient.free_motion.contact_steps();
        let place = |(i, contact): (usize, &DiaphragmContact)| {
            contact.stator.axes.place(transient.free_motion.contact_displacement(i))
        };
        let places: Vec<[f64; 2]> = transient.contacts.iter().enumerate().map(place).collect();
        // a limit of steps ends a run between two steps
        let goes_on = matches!(end.failure, None | Some(Cause::StepLimit));
        if goes_on {
            transient.solve_next_contact();
        } else {
            transient.forget_contact();
        }
        let impulses = std::mem::take(&mut transient.impulses);
        match pending {
            Some(pending) => {
                self.recorders.see_end(transient.loads(), &places, at);
                self.complete(pending, Some(&impulses), transient);
            }
            // a run that failed is not observed there
            None => {
                self.energy.complete_terms(contact_steps, Some(&impulses), transient, self.recorders.energies.now);
            }
        }
        std::mem::take(&mut self.damping).end(&transient.free_motion, self.speed, &mut self.recorders);
        self.recorders.finish(&end, self.machine, self.structure);
        if let (true, Some(frames)) = (is_shown, &mut self.frames) {
            frames.speed = self.speed;
            frames.show(transient.loads(), Some(transient), self.energy.energies(), follower);
        }
        end
    }

    /// Takes a release: what is evaluated in modes is that of the machine with the mass from here on.
    pub fn released(&mut self, due: ReleaseDue, energy: f64, transient: &Transient) {
        let Self { machine, structure, recorders, h, .. } = self;
        recorders.see_release(due.unbalance, due.at);
        recorders.energies.now.released += energy;
        self.shaft_stresses = ShaftStresses::new(machine, structure, &transient.free_motion, recorders, *h);
        self.energy.follow_release();
        self.frames = None;
    }

    fn frames(&mut self, transient: &Transient) -> &mut FrameSampler<'a> {
        let Self { frames, machine, structure, .. } = self;
        frames.get_or_insert_with(|| Box::new(FrameSampler::new(machine, structure, transient)))
    }

    /// Observes stresses at n, and energies as they are due.
    fn observe(&mut self, due: Due, at: At, transient: &mut Transient) -> Result<Pending, Cause> {
        self.observe_shaft(at, transient)?;
        Ok(self.energy.begin(due, transient, &mut self.recorders))
    }

    fn observe_shaft(&mut self, at: At, transient: &mut Transient) -> Result<(), Cause> {
        self.shaft_stresses.update(&mut transient.free_motion, &mut self.recorders, self.structure, at)
    }

    fn complete(&mut self, pending: Pending, impulses: Option<&[ContactImpulse]>, transient: &mut Transient) {
        let Self { energy, recorders, machine, structure, .. } = self;
        energy.complete(pending, impulses, transient, (recorders, machine, structure));
    }

    /// Records loads, the rotor in the rings, contact, and stresses of the rings behind the step.
    #[inline(always)]
    fn record(&mut self, step: &StepObservation, doublings: Option<usize>, transient: &Transient) {
        self.has_touched |= !transient.impulses.is_empty();
        let contact_steps = doublings.map_or(1, |doublings| 1 << doublings);
        let (loads, touches) = (transient.loads(), !transient.impulses.is_empty());
        self.recorders.see_loads(loads, step.at, touches);
        for (diaphragm, contact) in transient.contacts.iter().enumerate() {
            self.record_contact(step, contact_steps, (diaphragm, contact), transient);
        }
        self.recorders.see_yields();
    }

    /// Records the rotor in a diaphragm, contact, and stresses of the ring behind the step.
    #[inline(always)]
    fn record_contact(
        &mut self,
        step: &StepObservation,
        contact_steps: usize,
        (diaphragm, contact): (usize, &DiaphragmContact),
        transient: &Transient,
    ) {
        let Self { ring_clearances, ring_stresses, recorders, yield_watch, h, .. } = self;
        let ring_clearance = &mut ring_clearances[diaphragm];
        let touch = contact.impact.as_ref().map(|impact| Touch {
            normal: impact.normal / *h,
            sticks: impact.sticks,
            gap: ring_clearance.as_mut().map_or(impact.gap, |ring| ring.least_gap(impact, transient)),
            points: impact.points,
            reversed: impact.reversed,
            no_fixed_point: impact.no_fixed_point,
            several_minima: false,
            friction_work: impact.friction_work,
        });
        let ring_stresses = &mut ring_stresses[diaphragm];
        if touch.is_some() {
            ring_stresses.reset();
        }
        let flexible = contact.stator.ring();
        if let Some(ring) = flexible {
            ring_stresses.take_step(ring, contact_steps);
        }
        let is_watched = !step.due.motion && step.watch.ring;
        let is_observed = (step.due.motion || is_watched) && contact.stator.has_touched;
        let observed = flexible.filter(|_| is_observed);
        let state = observed.and_then(|ring| ring_stresses.state(diaphragm, ring, recorders));
        if let (true, Some(state), Some(watch)) = (is_watched, state, yield_watch) {
            recorders.watch_ring(diaphragm, watch.ring_limits(), state, step.at);
        }
        let ring = RingInstant {
            angle: step.angle,
            place: contact.stator.axes.place(contact.displacement),
            velocity: contact.stator.axes.to_stator(contact.velocity),
            touch,
            ring: state.filter(|_| step.due.motion),
        };
        recorders.see_ring(diaphragm, contact_steps, step.at, &ring);
    }

    /// Shows a contact step to a follower, with the motion at n where it asked for that.
    fn show_contact_step(&self, step: &StepObservation, transient: &Transient, follower: &mut dyn Follower) {
        for (diaphragm, contact) in transient.contacts.iter().enumerate() {
            let normal = contact.impact.as_ref().map_or(0.0, |impact| impact.normal / self.h);
            follower.contact_force(diaphragm, step.at.time, normal);
        }
        if let Some(frames) = self.frames.as_ref().filter(|_| step.is_shown) {
            frames.show(transient.loads(), Some(transient), self.energy.energies(), follower);
        }
    }

    /// Shows the instants of a free step to a follower; the first was sampled where it `is_first_shown`. A copy of the motion is advanced to the others.
    fn show_free_step(
        &mut self,
        doublings: usize,
        is_first_shown: bool,
        transient: &mut Transient,
        follower: &mut dyn Follower,
    ) {
        let (mut energies, ring_before) = (self.energy.energies(), ring_energy(transient));
        let first = transient.free_motion.contact_steps();
        let (mut ahead, mut goes_on) = (None, true);
        for contact_steps in first..first + (1 << doublings) {
            let time = contact_steps as f64 * self.h;
            (0..transient.contacts.len()).for_each(|diaphragm| follower.contact_force(diaphragm, time, 0.0));
            if contact_steps == first && is_first_shown {
                transient.evaluate_loads();
                if let Some(frames) = &self.frames {
                    frames.show(transient.loads(), None, energies, follower);
                }
            } else if contact_steps > first && goes_on && follower.wants(contact_steps, time) {
                let ahead = ahead.get_or_insert_with(|| MotionAhead::of(transient));
                // no follower ends a run: what cannot be shown is left out
                goes_on = ahead.advance_to(contact_steps);
                if !goes_on {
                    continue;
                }
                let mut works = self.recorders.energies.now;
                works.braking = ahead.free_motion.spin().braking_work();
                works.drive = ahead.free_motion.spin().drive_work();
                works.torques = ahead.free_motion.spin().torque_work();
                works.tables = ahead.free_motion.table_work();
                if self.has_touched {
                    works.stator += ring_before - energies_of(ahead.rings.iter().flatten()).iter().sum::<f64>();
                }
                energies = self.energy.terms_ahead(contact_steps, ahead, self.structure, works).unwrap_or(energies);
                ahead.show(transient, self.frames(transient), energies, follower);
            }
        }
    }
}
