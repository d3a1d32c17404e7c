//! One run of the exponential engine from its start to its end, watched by recorders.
//!
//! Loads, the rotor in the ring, and contact are seen at every step. Stresses and what the bearings' damping takes are seen at the instants of an interval of eight contact steps at
//! least (`LOOKS`): moments where their bound exceeds what they have had (`measured`), damping by the trapezoidal rule. Stores of energy, and what damping takes of a whole step
//! (`within`; in flight those of the state at n) are forms of all motion: they are seen every 64 (`BALANCES`) and 8 (`LOSSES`: at more they miss what ringing shaft modes of some machines lose after impacts; 32, `CALM`, until something has touched; 2, `FALLS`, where the spin falls fast; 1 after a disturbed start). Works of contact, of braking and of the damping of ring and twist are those of each step.
//!
//! Limits: peaks of stresses between two looks are missed; a look is at most as far from the next as the longest flight. Verified by `tests/exponential_run.rs`.

use super::damping_watch::DampingWatch;
use super::dissipated_energy::{DampingPowers, DissipatedEnergy};
use super::energy_terms::EnergyTerms;
use super::frame_sampler::{FrameSampler, MotionAhead};
use super::ring_clearance::RingClearance;
use super::ring_stress_check::RingStressCheck;
use super::shaft_stresses::ShaftStresses;
use super::yield_watch::{WatchResult, YieldWatch};
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::modal::dissipation::DissipationBuffer;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::exponential::stepping::motion_quantities::Instant;
use crate::engine::exponential::stepping::transient::{StepResult, Transient};
use crate::record::{At, End, Energies, Follower, Recorders, RingInstant, Touch};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause, Limit};

/// Contact steps from one look at the whole motion to the next, at least; each of the first steps ([`Transient::begins`]) has one.
const MOTION_INTERVAL: u64 = 8;
/// Contact steps from one look at what the shaft's damping takes to the next, and from one balance of energies to the next, at least, each with a look; each of the first steps has all.
const DISSIPATION_INTERVAL: u64 = 8;
/// Where friction all but stops the spin ([`super::flight::Flight::falls`]), and up to a balance after that: whips are faster than eight steps show, and looks at that part of each whirl alone in which the spin falls favour it.
const FAST_FALL_INTERVAL: u64 = 2;
/// The former as long as nothing has touched: until then the shaft rings of the release alone.
const CONTACT_FREE_INTERVAL: u64 = 32;
const BALANCE_INTERVAL: u64 = 64;

/// One run in contact steps of `settings.step`, from its start to its end.
///
/// # Errors
/// [`ExponentialError`] of a machine that this engine does not cover, or that has no basis at its start.
pub(in crate::engine) fn run(
    machine: &Machine,
    structure: &Structure,
    settings: StepSettings,
    follower: &mut dyn Follower,
) -> Result<(Recorders, End), ExponentialError> {
    let mut run = Run::new(machine, structure, settings)?;
    run.damped.update(&run.transient.free_motion, run.speed, &mut run.recorders);
    let (cause, failure) = loop {
        if !follower.goes_on(run.steps) {
            break (EndCause::Failure, Some(Cause::StepLimit));
        }
        match run.step(follower) {
            Ok(None) => {}
            Ok(Some(end)) => break (end, None),
            Err(cause) => break (EndCause::Failure, Some(cause)),
        }
    };
    let end = run.finish(cause, failure, follower);
    Ok((run.recorders, end))
}

/// A look at n that is to be settled.
struct Observation {
    ticks: u64,
    loses: bool,
    balances: bool,
    /// What the twist's damping has taken \[J\].
    damping_watch: f64,
}

/// A run under way.
struct Run<'a> {
    machine: &'a Machine,
    structure: &'a Structure,
    transient: Transient,
    recorders: Recorders,
    steps: u64,
    /// Spin \[rad/s\]; 0 where the rotor has stopped.
    speed: f64,
    h: f64,
    /// Ring coordinates have something to say.
    has_touched: bool,
    dissipated: DissipatedEnergy,
    /// Where a look is settled when its impulse is known.
    instant: Instant,
    /// Time of the last balance, and of the last step in which the spin fell fast.
    last_balance: Option<u64>,
    last_fast_fall: Option<u64>,
    shaft_stresses: ShaftStresses,
    ring_look: RingStressCheck,
    /// Room for what is measured, and for a motion.
    seen: Vec<f64>,
    dissipation_buffer: DissipationBuffer,
    places: Vec<f64>,
    rates: Vec<f64>,
    /// Energies one by one, where the follower wants them.
    energy_terms: Option<Box<EnergyTerms>>,
    /// `None` where no material has a yield strength.
    yield_watch: Option<YieldWatch>,
    /// The whole ring.
    ring_clearance: Option<RingClearance<'a>>,
    /// Once a follower has asked for an instant.
    frames: Option<Box<FrameSampler<'a>>>,
    damped: DampingWatch,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, structure: &'a Structure, settings: StepSettings) -> Result<Self, ExponentialError> {
        let transient = Transient::new(machine, structure, settings, true)?;
        let mut recorders = Recorders::new(machine, &structure.rings, settings.step);
        recorders.search_nothing();
        let yielding = YieldWatch::new(
            &recorders,
            [Limit::RingYield, Limit::BladeYield, Limit::ShaftYield]
                .map(|limit| machine.run.limits[limit as usize].value),
        );
        let steps = (settings.step, transient.contact.is_some());
        let shaft = ShaftStresses::new(machine, structure, &transient.free_motion, &recorders, steps);
        Ok(Self {
            machine,
            structure,
            recorders,
            speed: transient.free_motion.speed(),
            steps: 0,
            h: settings.step,
            has_touched: false,
            dissipated: DissipatedEnergy::new(settings.step),
            instant: transient.free_motion.instant(),
            transient,
            last_balance: None,
            last_fast_fall: None,
            shaft_stresses: shaft,
            ring_look: RingStressCheck::default(),
            seen: Vec::new(),
            dissipation_buffer: DissipationBuffer::default(),
            places: Vec::new(),
            rates: Vec::new(),
            energy_terms: None,
            yield_watch: yielding,
            ring_clearance: RingClearance::new(machine, structure),
            frames: None,
            damped: DampingWatch::default(),
        })
    }

    /// From n to n+1; `Some` when the run has ended.
    fn step(&mut self, follower: &mut dyn Follower) -> Result<Option<EndCause>, Cause> {
        if self.machine.run.step_limit.is_some_and(|limit| self.steps >= limit) {
            return Err(Cause::StepLimit);
        }
        let ticks = self.transient.free_motion.contact_steps();
        let at = At { time: self.transient.free_motion.time(), speed: self.speed };
        let is_due = |last: Option<u64>, every: u64| last.is_none_or(|last| ticks - last >= every);
        let first = self.transient.is_starting();
        let balances = first || is_due(self.last_balance, BALANCE_INTERVAL);
        if self.transient.free_motion.spin_changes_fast() {
            self.last_fast_fall = Some(ticks);
        }
        let often = match (self.transient.disturbed, self.has_touched) {
            (true, _) => 1,
            _ if !is_due(self.last_fast_fall, BALANCE_INTERVAL) => FAST_FALL_INTERVAL,
            (_, true) => DISSIPATION_INTERVAL,
            _ => CONTACT_FREE_INTERVAL,
        };
        let [looked, lost] = self.dissipated.times();
        let loses = balances || is_due(lost, often);
        let looks = loses || is_due(looked, MOTION_INTERVAL);
        let look = if looks { Some(self.observe(ticks, at, loses, balances)?) } else { None };
        let shown = follower.wants(ticks, at.time);
        if (loses || shown) && follower.wants_energies() {
            let Self { transient, energy_terms: apart, structure, recorders, .. } = self;
            let apart = apart.get_or_insert_with(|| Box::new(EnergyTerms::new(structure, transient)));
            let ring = transient.contact.as_ref().map(|contact| &contact.contact_step.ring);
            apart.take_stores(&mut transient.free_motion, ring, structure);
            apart.take_works(&recorders.energies.now);
            apart.keep(&transient.free_motion);
        }
        let between = shown && !loses && self.energy_terms.is_some();
        let watch = self.yield_watch.as_mut().map(|of| of.watch(&mut self.transient, &mut self.recorders));
        if !looks && watch.is_some_and(|watch| watch.shaft) {
            self.stresses(at)?;
        }
        let most = watch.map_or(usize::MAX, |watch| watch.most);
        let level = self.transient.next_step_doublings().map(|level| level.min(most));
        // where something may touch, the impulse at n comes with the step
        let due = match (look, level) {
            (Some(look), Some(_)) => {
                // a start may come to rest within its first steps where damping is strong, and one that is disturbed rings
                let whole = first || self.transient.disturbed;
                if whole {
                    self.transient.free_motion.copy_instant(&mut self.instant);
                }
                self.complete_observation(look, whole.then_some([0.0; 2]));
                None
            }
            (look, _) => {
                if look.is_some() {
                    self.transient.free_motion.copy_instant(&mut self.instant);
                }
                look
            }
        };
        if shown {
            let Self { transient, frames: eye, machine, structure, .. } = self;
            eye.get_or_insert_with(|| Box::new(FrameSampler::new(machine, structure, transient))).sample(transient);
        }
        if between && level.is_some() {
            self.complete_energy_terms(ticks, None);
        }
        if let Some(level) = level.filter(|_| follower.follows()) {
            self.show_free_step(level, shown, follower);
        }
        let angle = self.transient.free_motion.angle();
        // nothing else changes it in flight
        let before = if level.is_some() && self.has_touched { self.ring_energy() } else { 0.0 };
        let done = self.transient.step(level)?;
        let impulse = done.impact.map_or([0.0; 2], |impact| impact.impulse);
        if let Some(look) = due {
            self.complete_observation(look, Some(impulse));
        }
        if between && level.is_none() {
            self.complete_energy_terms(ticks, Some(impulse));
        }
        self.damped.update(&self.transient.free_motion, self.transient.free_motion.speed(), &mut self.recorders);
        self.record(&done, at, angle, looks, watch);
        self.add_works(&done, before);
        self.steps += 1;
        if level.is_none() {
            self.show(&done, at, shown, follower);
        }
        self.end_cause(&done)
    }

    /// Tells a follower of a contact step, of which the instant was taken where it is to be `shown`.
    fn show(&self, done: &StepResult, at: At, shown: bool, follower: &mut dyn Follower) {
        let force = done.impact.map_or(0.0, |impact| impact.normal / self.h);
        if self.transient.contact.is_some() {
            follower.contact_force(0, at.time, force);
        }
        if let Some(eye) = self.frames.as_ref().filter(|_| shown) {
            let contact = done.impact.as_ref().map(|impact| (impact, self.h));
            eye.show(self.transient.loads().bearings, contact, self.energies(), follower);
        }
    }

    /// Tells a follower of the instants of a step in flight, the first of which was taken where it is to be `shown`.
    fn show_free_step(&mut self, level: usize, shown: bool, follower: &mut dyn Follower) {
        let (mut energies, ring_before) = (self.energies(), self.ring_energy());
        let Self {
            transient,
            frames: eye,
            energy_terms: apart,
            dissipated: losses,
            recorders,
            seen,
            has_touched: touched,
            machine,
            structure,
            ..
        } = self;
        let ticks = transient.free_motion.contact_steps();
        let (mut ahead, mut goes_on) = (None, true);
        for tick in ticks..ticks + (1 << level) {
            let time = tick as f64 * self.h;
            if transient.contact.is_some() {
                follower.contact_force(0, time, 0.0);
            }
            if tick == ticks && shown {
                transient.evaluate_loads();
                eye.iter().for_each(|eye| eye.show(transient.loads().bearings, None, energies, follower));
            } else if tick > ticks && goes_on && follower.wants(tick, time) {
                let eye = eye.get_or_insert_with(|| Box::new(FrameSampler::new(machine, structure, transient)));
                let ahead = ahead.get_or_insert_with(|| MotionAhead::of(transient));
                // no follower ends a run: what cannot be shown is left out
                goes_on = ahead.advance_to(tick);
                if !goes_on {
                    continue;
                }
                if let Some(apart) = apart.as_mut() {
                    let mut works = recorders.energies.now;
                    works.braking = ahead.free_motion.spin().braking_work();
                    if let (Some(ring), true) = (&ahead.ring, *touched) {
                        works.stator += ring_before - ring.energies().iter().sum::<f64>();
                    }
                    let taken = DampingPowers::in_free_motion(&mut ahead.free_motion, seen);
                    apart.take_stores(&mut ahead.free_motion, ahead.ring.as_ref(), structure);
                    apart.take_works(&losses.until(tick, &taken, works));
                    energies = apart.energies;
                }
                ahead.show(transient, eye, energies, follower);
            }
        }
    }

    /// Takes the instant at which the run has ended, with the loads and the impulse of the step that would follow, where there is one; the state is left there.
    fn finish(&mut self, mut cause: EndCause, mut failure: Option<Cause>, follower: &mut dyn Follower) -> End {
        let (ticks, time) = (self.transient.free_motion.contact_steps(), self.transient.free_motion.time());
        let at = At { time, speed: self.speed };
        // peaks and the last balance are those of the end
        let look = match failure.is_none().then(|| self.observe(ticks, at, true, true)).transpose() {
            Ok(look) => look,
            Err(found) => {
                (cause, failure) = (EndCause::Failure, Some(found));
                None
            }
        };
        let shown = follower.wants_end();
        if shown {
            let Self { transient, frames: eye, energy_terms: apart, machine, structure, .. } = self;
            let apart = apart.get_or_insert_with(|| Box::new(EnergyTerms::new(structure, transient)));
            let ring = transient.contact.as_ref().map(|contact| &contact.contact_step.ring);
            apart.take_stores(&mut transient.free_motion, ring, structure);
            apart.keep(&transient.free_motion);
            eye.get_or_insert_with(|| Box::new(FrameSampler::new(machine, structure, transient))).sample(transient);
        }
        let Self { transient, instant, recorders, .. } = self;
        transient.free_motion.copy_instant(instant);
        let place = transient.contact.as_ref().map(|contact| {
            contact.contact_step.displacement_in_stator_axes(transient.free_motion.contact_displacement(0))
        });
        // a budget ends a run between two steps
        let goes_on = matches!(failure, None | Some(Cause::StepLimit));
        let impact = if goes_on { transient.solve_next_contact() } else { None };
        let impulse = Some(impact.map_or([0.0; 2], |impact| impact.impulse));
        match look {
            Some(look) => {
                recorders.see_end(transient.loads(), place, at);
                self.complete_observation(look, impulse);
            }
            // a run that failed has no look there
            None => self.complete_energy_terms(ticks, impulse),
        }
        let end = End { cause, time, speed: self.speed, failure, steps: self.steps, iterations: self.steps };
        std::mem::take(&mut self.damped).end(&self.transient.free_motion, self.speed, &mut self.recorders);
        self.recorders.finish(&end, self.machine, self.structure);
        if let (Some(apart), Some(eye)) = (self.energy_terms.as_mut().filter(|_| shown), &mut self.frames) {
            eye.speed = self.speed;
            let contact = impact.as_ref().map(|impact| (impact, self.h));
            eye.show(self.transient.loads().bearings, contact, apart.energies, follower);
        }
        end
    }

    /// Why the run does not go on from n+1.
    fn end_cause(&mut self, done: &StepResult) -> Result<Option<EndCause>, Cause> {
        let speed = self.transient.free_motion.speed();
        if !(speed + done.displacement[0] + done.displacement[1]).is_finite() {
            return Err(Cause::NonFinite);
        }
        if self.recorders.limits.is_newly_beyond() {
            self.recorders.judge(self.machine, self.structure);
        }
        let run = &self.machine.run;
        let stopped = speed <= 0.0;
        self.speed = if stopped { 0.0 } else { speed };
        if self.transient.is_outside() {
            return Err(Cause::OutsideRing);
        }
        Ok(if stopped {
            Some(EndCause::Stopped)
        } else if self.recorders.limits.ends(self.machine) {
            Some(EndCause::Limit)
        } else if run.end_speed > 0.0 && speed <= run.end_speed {
            Some(EndCause::EndSpeed)
        } else {
            // half a step of slack: the last step ends at end_time, not one beyond it
            (self.transient.free_motion.time() >= run.end_time - 0.5 * self.h).then_some(EndCause::EndTime)
        })
    }

    /// Loads, the rotor in the ring, contact.
    #[inline(always)]
    fn record(&mut self, done: &StepResult, at: At, angle: f64, looks: bool, watch: Option<WatchResult>) {
        let Self { transient, ring_clearance: depth, .. } = self;
        let touch = done.impact.as_ref().map(|impact| Touch {
            normal: impact.normal / self.h,
            sticks: impact.sticks,
            gap: depth.as_mut().map_or(impact.gap, |depth| depth.least_gap(impact, transient)),
            points: impact.points,
            reversed: impact.reversed,
            no_fixed_point: false,
            several_minima: false,
            friction_work: impact.friction_work,
        });
        self.has_touched |= touch.is_some();
        let steps = done.doublings.map_or(1, |level| 1 << level);
        let watches = !looks && watch.is_some_and(|watch| watch.ring);
        let Self { transient, ring_look, recorders, yield_watch: yielding, .. } = self;
        if done.impact.is_some() {
            ring_look.reset();
        }
        let looked_at = transient.contact.as_ref().filter(|_| (looks || watches) && self.has_touched);
        let seen = looked_at.and_then(|contact| ring_look.coordinates(&contact.contact_step, recorders));
        if let (true, Some(seen), Some(yielding)) = (watches, seen, yielding) {
            recorders.watch_ring(yielding.of_ring(), seen, at);
        }
        let ring = transient.contact.as_ref().map(|contact| RingInstant {
            angle,
            place: contact.contact_step.displacement_in_stator_axes(done.displacement),
            velocity: contact.contact_step.to_stator_axes(done.velocity),
            touch,
            ring: seen.filter(|_| looks),
        });
        recorders.see_steps(steps, at, transient.loads(), ring.as_ref());
    }

    fn ring_energy(&self) -> f64 {
        self.transient.contact.as_ref().map_or(0.0, |contact| contact.contact_step.ring.energies().iter().sum())
    }

    /// Works of the step that has been done.
    fn add_works(&mut self, done: &StepResult, ring_before: f64) {
        let flown = if done.doublings.is_some() && self.has_touched { ring_before - self.ring_energy() } else { 0.0 };
        let now = &mut self.recorders.energies.now;
        now.braking = self.transient.free_motion.spin().braking_work();
        if let Some(impact) = &done.impact {
            now.friction += impact.friction_work;
            now.normal += impact.normal_work;
            now.structure += impact.damped_work;
        }
        if let Some(contact) = &self.transient.contact {
            now.stator += match done.doublings {
                Some(_) => flown,
                None => contact.contact_step.ring.step_dissipation(),
            };
        }
    }

    /// Sees the shaft's stresses at n.
    fn stresses(&mut self, at: At) -> Result<(), Cause> {
        self.shaft_stresses.update(&mut self.transient.free_motion, &mut self.recorders, self.structure, at)
    }

    /// Sees stresses at n, and stores where it `balances`; what it needs to be settled once the impulse there is known.
    fn observe(&mut self, ticks: u64, at: At, loses: bool, balances: bool) -> Result<Observation, Cause> {
        self.stresses(at)?;
        if balances {
            self.add_stored_energy();
        }
        Ok(Observation {
            ticks,
            loses,
            balances,
            damping_watch: self.transient.free_motion.spin().torsional_dissipation(),
        })
    }

    /// What bearings have taken since the last look; what all damping has beside their mean rates ([`super::within`]) and, with that, how it balances. With the impulse at the look; without one,
    /// in flight but for the first steps and those of a disturbed start, powers are those at n.
    fn complete_observation(&mut self, look: Observation, impulse: Option<[f64; 2]>) {
        let Self {
            transient,
            recorders,
            seen,
            dissipation_buffer: within,
            instant,
            energy_terms: apart,
            dissipated: losses,
            ..
        } = self;
        let Observation { ticks, loses, balances, damping_watch: damped } = look;
        let flight = &mut transient.free_motion;
        let (powers, whole) = match impulse {
            Some(impulse) => flight.damping_powers_after(instant, impulse, loses, (seen, within)),
            None => flight.damping_powers(loses, seen),
        };
        let behind = if impulse.is_some() { 0.5 } else { 0.0 };
        let taken = DampingPowers { bearings: powers, whole, behind, damped };
        let now = &mut recorders.energies.now;
        losses.add_bearing_losses(ticks, &taken, now);
        if !loses {
            return;
        }
        losses.add_losses(ticks, taken, now);
        if balances {
            self.last_balance = Some(ticks);
            recorders.energies.take();
            recorders.judge(self.machine, self.structure);
        }
        if let Some(apart) = apart {
            apart.take_works(&recorders.energies.now);
        }
    }

    /// Brings the works of an instant that is shown between two looks up to it, as [`Run::settle`] does those of a look; the run goes on as if nothing had been shown.
    fn complete_energy_terms(&mut self, ticks: u64, impulse: Option<[f64; 2]>) {
        let Self {
            transient,
            recorders,
            seen,
            dissipation_buffer: within,
            energy_terms: apart,
            dissipated: losses,
            ..
        } = self;
        let Some(apart) = apart else { return };
        let taken = match impulse {
            None => DampingPowers::in_free_motion(&mut transient.free_motion, seen),
            Some(impulse) => {
                let (bearings, whole) =
                    transient.free_motion.damping_powers_after(&mut apart.instant, impulse, true, (seen, within));
                DampingPowers { bearings, whole, behind: 0.5, damped: apart.damped }
            }
        };
        apart.take_works(&losses.until(ticks, &taken, recorders.energies.now));
    }

    /// Stores at n.
    fn add_stored_energy(&mut self) {
        let Self { transient, recorders, places, rates, seen, .. } = self;
        transient.free_motion.lateral_rates(rates);
        let stored = transient.free_motion.stored_energy(rates, places, seen);
        let flight = &transient.free_motion;
        let shift = flight.gyroscopic_speed_shift(stored.gyroscopic);
        let [turning, twisted] = flight.spin().energies(shift, flight.unbalance_velocities());
        let ring = transient.contact.as_ref().map_or([0.0; 2], |contact| contact.contact_step.ring.energies());
        recorders.energies.now.kinetic =
            stored.energy + (flight.spin().speed + shift) * stored.gyroscopic + turning + twisted + ring[0] + ring[1];
    }

    /// Energies one by one, as they were when they were taken last; none where the follower wants none.
    fn energies(&self) -> Energies {
        self.energy_terms.as_ref().map_or_else(Energies::default, |apart| apart.energies)
    }
}
