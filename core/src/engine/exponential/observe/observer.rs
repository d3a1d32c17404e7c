//! Observer of a run: records the motion and shows it to a follower, and never changes it.
//!
//! Loads, the rotor in the ring, and contact are recorded in every step. Stresses and energies are observed when they are due ([`super::observation_schedule`]), stresses also where their
//! bound exceeds a limit ([`super::yield_watch`]).
//!
//! Limits: peaks of stresses between two observations are missed, unless a limit watches them. Verified by `tests/exponential/exponential_run.rs`.

use super::damping_watch::DampingWatch;
use super::energy_balance::{EnergyBalance, Pending, add_works, ring_energy};
use super::frame_sampler::{FrameSampler, MotionAhead};
use super::observation_schedule::{Due, ObservationSchedule, RunState};
use super::ring_clearance::RingClearance;
use super::ring_stress_check::RingStressCheck;
use super::shaft_stresses::ShaftStresses;
use super::yield_watch::{WatchResult, YieldWatch};
use crate::engine::exponential::contact::contact_step_result::ContactStepResult;
use crate::engine::exponential::stepping::transient::{StepResult, Transient};
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
    /// The rotor has touched: the ring's modes are not at rest.
    has_touched: bool,
    schedule: ObservationSchedule,
    energy: EnergyBalance,
    shaft_stresses: ShaftStresses,
    ring_stresses: RingStressCheck,
    /// `None` where no material has a yield strength.
    yield_watch: Option<YieldWatch>,
    /// Clearance of the whole ring; `None` without a flexible ring.
    ring_clearance: Option<RingClearance<'a>>,
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
    /// Energy of the ring at n \[J\], where the step is free and the ring moves.
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
        let yield_limits = [Limit::RingYield, Limit::BladeYield, Limit::ShaftYield]
            .map(|limit| machine.run.limits[limit as usize].value);
        let yield_watch = YieldWatch::new(&recorders, yield_limits);
        let steps = (h, transient.contact.is_some());
        let shaft_stresses = ShaftStresses::new(machine, structure, &transient.free_motion, &recorders, steps);
        let mut observer = Self {
            machine,
            structure,
            recorders,
            h,
            speed: transient.free_motion.speed(),
            has_touched: false,
            schedule: ObservationSchedule::default(),
            energy: EnergyBalance::new(h, transient),
            shaft_stresses,
            ring_stresses: RingStressCheck::default(),
            yield_watch,
            ring_clearance: RingClearance::new(machine, structure),
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
            self.complete(pending, step.is_averaged.then_some([0.0; 2]), transient);
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
        step.ring_before = (is_free && self.has_touched).then(|| ring_energy(transient));
    }

    /// Records a step that has been done, and shows it where it was a contact step.
    #[inline]
    pub fn after_step(
        &mut self,
        mut step: StepObservation,
        result: &StepResult,
        transient: &mut Transient,
        follower: &mut dyn Follower,
    ) {
        let impulse = Some(result.impact.map_or([0.0; 2], |impact| impact.impulse));
        if let Some(pending) = step.pending.take() {
            self.complete(pending, impulse, transient);
        }
        if step.completes_terms && result.doublings.is_none() {
            self.energy.complete_terms(step.contact_steps, impulse, transient, self.recorders.energies.now);
        }
        self.damping.update(&transient.free_motion, transient.free_motion.speed(), &mut self.recorders);
        self.record(&step, result, transient);
        add_works(&mut self.recorders.energies.now, result, step.ring_before, transient);
        if result.doublings.is_none() {
            self.show_contact_step(&step, result.impact.as_ref(), transient, follower);
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
        let place = transient
            .contact
            .as_ref()
            .map(|contact| contact.stator.axes.place(transient.free_motion.contact_displacement(0)));
        // a limit of steps ends a run between two steps
        let goes_on = matches!(end.failure, None | Some(Cause::StepLimit));
        let impact = if goes_on { transient.solve_next_contact() } else { None };
        let impulse = Some(impact.map_or([0.0; 2], |impact| impact.impulse));
        match pending {
            Some(pending) => {
                self.recorders.see_end(transient.loads(), place, at);
                self.complete(pending, impulse, transient);
            }
            // a run that failed is not observed there
            None => self.energy.complete_terms(contact_steps, impulse, transient, self.recorders.energies.now),
        }
        std::mem::take(&mut self.damping).end(&transient.free_motion, self.speed, &mut self.recorders);
        self.recorders.finish(&end, self.machine, self.structure);
        if let (true, Some(frames)) = (is_shown, &mut self.frames) {
            frames.speed = self.speed;
            let contact = impact.as_ref().map(|impact| (impact, self.h));
            frames.show(transient.loads(), contact, self.energy.energies(), follower);
        }
        end
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

    fn complete(&mut self, pending: Pending, impulse: Option<[f64; 2]>, transient: &mut Transient) {
        let Self { energy, recorders, machine, structure, .. } = self;
        energy.complete(pending, impulse, transient, (recorders, machine, structure));
    }

    /// Records loads, the rotor in the ring, contact, and stresses of the ring behind the step.
    #[inline(always)]
    fn record(&mut self, step: &StepObservation, result: &StepResult, transient: &Transient) {
        let Self { ring_clearance, ring_stresses, recorders, yield_watch, h, .. } = self;
        let touch = result.impact.as_ref().map(|impact| Touch {
            normal: impact.normal / *h,
            sticks: impact.sticks,
            gap: ring_clearance.as_mut().map_or(impact.gap, |ring| ring.least_gap(impact, transient)),
            points: impact.points,
            reversed: impact.reversed,
            no_fixed_point: impact.no_fixed_point,
            several_minima: false,
            friction_work: impact.friction_work,
        });
        self.has_touched |= touch.is_some();
        if result.impact.is_some() {
            ring_stresses.reset();
        }
        let is_watched = !step.due.motion && step.watch.ring;
        let ring = transient.contact.as_ref().and_then(|contact| contact.stator.ring());
        let observed = ring.filter(|_| (step.due.motion || is_watched) && self.has_touched);
        let coordinates = observed.and_then(|ring| ring_stresses.coordinates(ring, recorders));
        if let (true, Some(coordinates), Some(watch)) = (is_watched, coordinates, yield_watch) {
            recorders.watch_ring(watch.ring_limits(), coordinates, step.at);
        }
        let ring = transient.contact.as_ref().map(|contact| RingInstant {
            angle: step.angle,
            place: contact.stator.axes.place(result.displacement),
            velocity: contact.stator.axes.to_stator(result.velocity),
            touch,
            ring: coordinates.filter(|_| step.due.motion),
        });
        let contact_steps = result.doublings.map_or(1, |doublings| 1 << doublings);
        recorders.see_steps(contact_steps, step.at, transient.loads(), ring.as_ref());
    }

    /// Shows a contact step to a follower, with the motion at n where it asked for that.
    fn show_contact_step(
        &self,
        step: &StepObservation,
        impact: Option<&ContactStepResult>,
        transient: &Transient,
        follower: &mut dyn Follower,
    ) {
        if transient.contact.is_some() {
            follower.contact_force(0, step.at.time, impact.map_or(0.0, |impact| impact.normal / self.h));
        }
        if let Some(frames) = self.frames.as_ref().filter(|_| step.is_shown) {
            let contact = impact.map(|impact| (impact, self.h));
            frames.show(transient.loads(), contact, self.energy.energies(), follower);
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
            if transient.contact.is_some() {
                follower.contact_force(0, time, 0.0);
            }
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
                works.tables = ahead.free_motion.table_work();
                if let (Some(ring), true) = (&ahead.ring, self.has_touched) {
                    works.stator += ring_before - ring.energies().iter().sum::<f64>();
                }
                energies = self.energy.terms_ahead(contact_steps, ahead, self.structure, works).unwrap_or(energies);
                ahead.show(transient, self.frames(transient), energies, follower);
            }
        }
    }
}
