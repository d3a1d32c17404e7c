//! One run of the exponential engine from its start to its end, watched by recorders.
//!
//! Loads, the rotor in the ring, and contact are seen at every step. Stresses and what the bearings' damping takes are seen at the instants of an interval of eight contact steps at
//! least (`LOOKS`): moments where their bound exceeds what they have had (`measured`), damping by the trapezoidal rule. Stores of energy, and what damping takes of a whole step
//! (`within`; in flight those of the state at n) are forms of all motion: they are seen every 64 (`BALANCES`) and 8 (`LOSSES`: at more they miss what ringing shaft modes of some machines lose after impacts; 32, `CALM`, until something has touched; 2, `FALLS`, where the spin falls fast; 1 after a disturbed start). Works of contact, of braking and of the damping of ring and twist are those of each step.
//!
//! Limits: peaks of stresses between two looks are missed; a look is at most as far from the next as the longest flight. Verified by `tests/exponential_run.rs`.

use super::ExponentialError;
use super::apart::Apart;
use super::damped::Damped;
use super::eye::{Ahead, Eye};
use super::flight::Instant;
use super::losses::{Losses, Taken};
use super::ring_eye::RingEye;
use super::ring_look::RingLook;
use super::settings::FlightSettings;
use super::shaft_look::ShaftLook;
use super::transient::{Done, Transient};
use super::within::Room;
use super::yielding::{Watch, Yielding};
use crate::record::{At, End, Energies, Follower, Recorders, RingInstant, Touch};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause, Limit};

/// Contact steps from one look at the whole motion to the next, at least; each of the first steps ([`Transient::begins`]) has one.
const LOOKS: u64 = 8;
/// Contact steps from one look at what the shaft's damping takes to the next, and from one balance of energies to the next, at least, each with a look; each of the first steps has all.
const LOSSES: u64 = 8;
/// Where friction all but stops the spin ([`super::flight::Flight::falls`]), and up to a balance after that: whips are faster than eight steps show, and looks at that part of each whirl alone in which the spin falls favour it.
const FALLS: u64 = 2;
/// The former as long as nothing has touched: until then the shaft rings of the release alone.
const CALM: u64 = 32;
const BALANCES: u64 = 64;

/// One run in contact steps of `settings.step`, from its start to its end.
///
/// # Errors
/// [`ExponentialError`] of a machine that this engine does not cover, or that has no basis at its start.
pub(in crate::engine) fn run(
    machine: &Machine,
    structure: &Structure,
    settings: FlightSettings,
    follower: &mut dyn Follower,
) -> Result<(Recorders, End), ExponentialError> {
    let mut run = Run::new(machine, structure, settings)?;
    run.damped.see(&run.transient.flight, run.speed, &mut run.recorders);
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
    let end = run.arrive(cause, failure, follower);
    Ok((run.recorders, end))
}

/// A look at n that is to be settled.
struct Look {
    ticks: u64,
    loses: bool,
    balances: bool,
    /// What the twist's damping has taken \[J\].
    damped: f64,
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
    touched: bool,
    losses: Losses,
    /// Where a look is settled when its impulse is known.
    instant: Instant,
    /// Time of the last balance, and of the last step in which the spin fell fast.
    balanced: Option<u64>,
    fell: Option<u64>,
    shaft: ShaftLook,
    ring_look: RingLook,
    /// Room for what is measured, and for a motion.
    seen: Vec<f64>,
    within: Room,
    places: Vec<f64>,
    rates: Vec<f64>,
    /// Energies one by one, where the follower wants them.
    apart: Option<Box<Apart>>,
    /// `None` where no material has a yield strength.
    yielding: Option<Yielding>,
    /// The whole ring.
    depth: Option<RingEye<'a>>,
    /// Once a follower has asked for an instant.
    eye: Option<Box<Eye<'a>>>,
    damped: Damped,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, structure: &'a Structure, settings: FlightSettings) -> Result<Self, ExponentialError> {
        let transient = Transient::new(machine, structure, settings, true)?;
        let mut recorders = Recorders::new(machine, &structure.rings, settings.step);
        recorders.search_nothing();
        let yielding = Yielding::new(
            &recorders,
            [Limit::RingYield, Limit::BladeYield, Limit::ShaftYield]
                .map(|limit| machine.run.limits[limit as usize].value),
        );
        let steps = (settings.step, transient.contact.is_some());
        let shaft = ShaftLook::new(machine, structure, &transient.flight, &recorders, steps);
        Ok(Self {
            machine,
            structure,
            recorders,
            speed: transient.flight.speed(),
            steps: 0,
            h: settings.step,
            touched: false,
            losses: Losses::new(settings.step),
            instant: transient.flight.instant(),
            transient,
            balanced: None,
            fell: None,
            shaft,
            ring_look: RingLook::default(),
            seen: Vec::new(),
            within: Room::default(),
            places: Vec::new(),
            rates: Vec::new(),
            apart: None,
            yielding,
            depth: RingEye::new(machine, structure),
            eye: None,
            damped: Damped::default(),
        })
    }

    /// From n to n+1; `Some` when the run has ended.
    fn step(&mut self, follower: &mut dyn Follower) -> Result<Option<EndCause>, Cause> {
        if self.machine.run.step_limit.is_some_and(|limit| self.steps >= limit) {
            return Err(Cause::StepLimit);
        }
        let ticks = self.transient.flight.ticks();
        let at = At { time: self.transient.flight.time(), speed: self.speed };
        let is_due = |last: Option<u64>, every: u64| last.is_none_or(|last| ticks - last >= every);
        let first = self.transient.begins();
        let balances = first || is_due(self.balanced, BALANCES);
        if self.transient.flight.falls() {
            self.fell = Some(ticks);
        }
        let often = match (self.transient.disturbed, self.touched) {
            (true, _) => 1,
            _ if !is_due(self.fell, BALANCES) => FALLS,
            (_, true) => LOSSES,
            _ => CALM,
        };
        let [looked, lost] = self.losses.times();
        let loses = balances || is_due(lost, often);
        let looks = loses || is_due(looked, LOOKS);
        let look = if looks { Some(self.look(ticks, at, loses, balances)?) } else { None };
        let shown = follower.wants(ticks, at.time);
        if (loses || shown) && follower.wants_energies() {
            let Self { transient, apart, structure, recorders, .. } = self;
            let apart = apart.get_or_insert_with(|| Box::new(Apart::new(structure, transient)));
            let ring = transient.contact.as_ref().map(|contact| &contact.rub.ring);
            apart.take_stores(&mut transient.flight, ring, structure);
            apart.take_works(&recorders.energies.now);
            apart.keep(&transient.flight);
        }
        let between = shown && !loses && self.apart.is_some();
        let watch = self.yielding.as_mut().map(|of| of.watch(&mut self.transient, &mut self.recorders));
        if !looks && watch.is_some_and(|watch| watch.shaft) {
            self.stresses(at)?;
        }
        let most = watch.map_or(usize::MAX, |watch| watch.most);
        let level = self.transient.level().map(|level| level.min(most));
        // where something may touch, the impulse at n comes with the step
        let due = match (look, level) {
            (Some(look), Some(_)) => {
                // a start may come to rest within its first steps where damping is strong, and one that is disturbed rings
                let whole = first || self.transient.disturbed;
                if whole {
                    self.transient.flight.keep(&mut self.instant);
                }
                self.settle(look, whole.then_some([0.0; 2]));
                None
            }
            (look, _) => {
                if look.is_some() {
                    self.transient.flight.keep(&mut self.instant);
                }
                look
            }
        };
        if shown {
            let Self { transient, eye, machine, structure, .. } = self;
            eye.get_or_insert_with(|| Box::new(Eye::new(machine, structure, transient))).look(transient);
        }
        if between && level.is_some() {
            self.catch_up(ticks, None);
        }
        if let Some(level) = level.filter(|_| follower.follows()) {
            self.fly_by(level, shown, follower);
        }
        let angle = self.transient.flight.angle();
        // nothing else changes it in flight
        let before = if level.is_some() && self.touched { self.ring_energy() } else { 0.0 };
        let done = self.transient.step(level)?;
        let impulse = done.impact.map_or([0.0; 2], |impact| impact.on_rotor);
        if let Some(look) = due {
            self.settle(look, Some(impulse));
        }
        if between && level.is_none() {
            self.catch_up(ticks, Some(impulse));
        }
        self.damped.see(&self.transient.flight, self.transient.flight.speed(), &mut self.recorders);
        self.record(&done, at, angle, looks, watch);
        self.works(&done, before);
        self.steps += 1;
        if level.is_none() {
            self.show(&done, at, shown, follower);
        }
        self.ended(&done)
    }

    /// Tells a follower of a contact step, of which the instant was taken where it is to be `shown`.
    fn show(&self, done: &Done, at: At, shown: bool, follower: &mut dyn Follower) {
        let force = done.impact.map_or(0.0, |impact| impact.normal / self.h);
        if self.transient.contact.is_some() {
            follower.contact_force(0, at.time, force);
        }
        if let Some(eye) = self.eye.as_ref().filter(|_| shown) {
            let contact = done.impact.as_ref().map(|impact| (impact, self.h));
            eye.show(self.transient.loads().bearings, contact, self.energies(), follower);
        }
    }

    /// Tells a follower of the instants of a step in flight, the first of which was taken where it is to be `shown`.
    fn fly_by(&mut self, level: usize, shown: bool, follower: &mut dyn Follower) {
        let (mut energies, ring_before) = (self.energies(), self.ring_energy());
        let Self { transient, eye, apart, losses, recorders, seen, touched, machine, structure, .. } = self;
        let ticks = transient.flight.ticks();
        let (mut ahead, mut goes_on) = (None, true);
        for tick in ticks..ticks + (1 << level) {
            let time = tick as f64 * self.h;
            if transient.contact.is_some() {
                follower.contact_force(0, time, 0.0);
            }
            if tick == ticks && shown {
                transient.weigh();
                eye.iter().for_each(|eye| eye.show(transient.loads().bearings, None, energies, follower));
            } else if tick > ticks && goes_on && follower.wants(tick, time) {
                let eye = eye.get_or_insert_with(|| Box::new(Eye::new(machine, structure, transient)));
                let ahead = ahead.get_or_insert_with(|| Ahead::of(transient));
                // no follower ends a run: what cannot be shown is left out
                goes_on = ahead.goes_to(tick);
                if !goes_on {
                    continue;
                }
                if let Some(apart) = apart.as_mut() {
                    let mut works = recorders.energies.now;
                    works.braking = ahead.flight.spin().braked();
                    if let (Some(ring), true) = (&ahead.ring, *touched) {
                        works.stator += ring_before - ring.energies().iter().sum::<f64>();
                    }
                    let taken = Taken::in_flight(&mut ahead.flight, seen);
                    apart.take_stores(&mut ahead.flight, ahead.ring.as_ref(), structure);
                    apart.take_works(&losses.until(tick, &taken, works));
                    energies = apart.energies;
                }
                ahead.show(transient, eye, energies, follower);
            }
        }
    }

    /// Takes the instant at which the run has ended, with the loads and the impulse of the step that would follow, where there is one; the state is left there.
    fn arrive(&mut self, mut cause: EndCause, mut failure: Option<Cause>, follower: &mut dyn Follower) -> End {
        let (ticks, time) = (self.transient.flight.ticks(), self.transient.flight.time());
        let at = At { time, speed: self.speed };
        // peaks and the last balance are those of the end
        let look = match failure.is_none().then(|| self.look(ticks, at, true, true)).transpose() {
            Ok(look) => look,
            Err(found) => {
                (cause, failure) = (EndCause::Failure, Some(found));
                None
            }
        };
        let shown = follower.wants_end();
        if shown {
            let Self { transient, eye, apart, machine, structure, .. } = self;
            let apart = apart.get_or_insert_with(|| Box::new(Apart::new(structure, transient)));
            let ring = transient.contact.as_ref().map(|contact| &contact.rub.ring);
            apart.take_stores(&mut transient.flight, ring, structure);
            apart.keep(&transient.flight);
            eye.get_or_insert_with(|| Box::new(Eye::new(machine, structure, transient))).look(transient);
        }
        let Self { transient, instant, recorders, .. } = self;
        transient.flight.keep(instant);
        let place = transient.contact.as_ref().map(|contact| contact.rub.place(transient.flight.place(0)));
        // a budget ends a run between two steps
        let goes_on = matches!(failure, None | Some(Cause::StepLimit));
        let impact = if goes_on { transient.ahead() } else { None };
        let impulse = Some(impact.map_or([0.0; 2], |impact| impact.on_rotor));
        match look {
            Some(look) => {
                recorders.see_end(transient.loads(), place, at);
                self.settle(look, impulse);
            }
            // a run that failed has no look there
            None => self.catch_up(ticks, impulse),
        }
        let end = End { cause, time, speed: self.speed, failure, steps: self.steps, iterations: self.steps };
        std::mem::take(&mut self.damped).end(&self.transient.flight, self.speed, &mut self.recorders);
        self.recorders.finish(&end, self.machine, self.structure);
        if let (Some(apart), Some(eye)) = (self.apart.as_mut().filter(|_| shown), &mut self.eye) {
            eye.speed = self.speed;
            let contact = impact.as_ref().map(|impact| (impact, self.h));
            eye.show(self.transient.loads().bearings, contact, apart.energies, follower);
        }
        end
    }

    /// Why the run does not go on from n+1.
    fn ended(&mut self, done: &Done) -> Result<Option<EndCause>, Cause> {
        let speed = self.transient.flight.speed();
        if !(speed + done.place[0] + done.place[1]).is_finite() {
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
            (self.transient.flight.time() >= run.end_time - 0.5 * self.h).then_some(EndCause::EndTime)
        })
    }

    /// Loads, the rotor in the ring, contact.
    #[inline(always)]
    fn record(&mut self, done: &Done, at: At, angle: f64, looks: bool, watch: Option<Watch>) {
        let Self { transient, depth, .. } = self;
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
        self.touched |= touch.is_some();
        let steps = done.level.map_or(1, |level| 1 << level);
        let watches = !looks && watch.is_some_and(|watch| watch.ring);
        let Self { transient, ring_look, recorders, yielding, .. } = self;
        if done.impact.is_some() {
            ring_look.strike();
        }
        let looked_at = transient.contact.as_ref().filter(|_| (looks || watches) && self.touched);
        let seen = looked_at.and_then(|contact| ring_look.coordinates(&contact.rub, recorders));
        if let (true, Some(seen), Some(yielding)) = (watches, seen, yielding) {
            recorders.watch_ring(yielding.of_ring(), seen, at);
        }
        let ring = transient.contact.as_ref().map(|contact| RingInstant {
            angle,
            place: contact.rub.place(done.place),
            velocity: contact.rub.inwards(done.velocity),
            touch,
            ring: seen.filter(|_| looks),
        });
        recorders.see_steps(steps, at, transient.loads(), ring.as_ref());
    }

    fn ring_energy(&self) -> f64 {
        self.transient.contact.as_ref().map_or(0.0, |contact| contact.rub.ring.energies().iter().sum())
    }

    /// Works of the step that has been done.
    fn works(&mut self, done: &Done, ring_before: f64) {
        let flown = if done.level.is_some() && self.touched { ring_before - self.ring_energy() } else { 0.0 };
        let now = &mut self.recorders.energies.now;
        now.braking = self.transient.flight.spin().braked();
        if let Some(impact) = &done.impact {
            now.friction += impact.friction_work;
            now.normal += impact.normal_work;
            now.structure += impact.damped_work;
        }
        if let Some(contact) = &self.transient.contact {
            now.stator += match done.level {
                Some(_) => flown,
                None => contact.rub.ring.damped(),
            };
        }
    }

    /// Sees the shaft's stresses at n.
    fn stresses(&mut self, at: At) -> Result<(), Cause> {
        self.shaft.see(&mut self.transient.flight, &mut self.recorders, self.structure, at)
    }

    /// Sees stresses at n, and stores where it `balances`; what it needs to be settled once the impulse there is known.
    fn look(&mut self, ticks: u64, at: At, loses: bool, balances: bool) -> Result<Look, Cause> {
        self.stresses(at)?;
        if balances {
            self.stores();
        }
        Ok(Look { ticks, loses, balances, damped: self.transient.flight.spin().damped() })
    }

    /// What bearings have taken since the last look; what all damping has beside their mean rates ([`super::within`]) and, with that, how it balances. With the impulse at the look; without one,
    /// in flight but for the first steps and those of a disturbed start, powers are those at n.
    fn settle(&mut self, look: Look, impulse: Option<[f64; 2]>) {
        let Self { transient, recorders, seen, within, instant, apart, losses, .. } = self;
        let Look { ticks, loses, balances, damped } = look;
        let flight = &mut transient.flight;
        let (powers, whole) = match impulse {
            Some(impulse) => flight.powers_behind(instant, impulse, loses, (seen, within)),
            None => flight.powers(loses, seen),
        };
        let behind = if impulse.is_some() { 0.5 } else { 0.0 };
        let taken = Taken { bearings: powers, whole, behind, damped };
        let now = &mut recorders.energies.now;
        losses.look(ticks, &taken, now);
        if !loses {
            return;
        }
        losses.lose(ticks, taken, now);
        if balances {
            self.balanced = Some(ticks);
            recorders.energies.take();
            recorders.judge(self.machine, self.structure);
        }
        if let Some(apart) = apart {
            apart.take_works(&recorders.energies.now);
        }
    }

    /// Brings the works of an instant that is shown between two looks up to it, as [`Run::settle`] does those of a look; the run goes on as if nothing had been shown.
    fn catch_up(&mut self, ticks: u64, impulse: Option<[f64; 2]>) {
        let Self { transient, recorders, seen, within, apart, losses, .. } = self;
        let Some(apart) = apart else { return };
        let taken = match impulse {
            None => Taken::in_flight(&mut transient.flight, seen),
            Some(impulse) => {
                let (bearings, whole) =
                    transient.flight.powers_behind(&mut apart.instant, impulse, true, (seen, within));
                Taken { bearings, whole, behind: 0.5, damped: apart.damped }
            }
        };
        apart.take_works(&losses.until(ticks, &taken, recorders.energies.now));
    }

    /// Stores at n.
    fn stores(&mut self) {
        let Self { transient, recorders, places, rates, seen, .. } = self;
        transient.flight.rates(rates);
        let stored = transient.flight.stored(rates, places, seen);
        let flight = &transient.flight;
        let shift = flight.held_back(stored.gyroscopic);
        let [turning, twisted] = flight.spin().energies(shift, flight.velocities());
        let ring = transient.contact.as_ref().map_or([0.0; 2], |contact| contact.rub.ring.energies());
        recorders.energies.now.kinetic =
            stored.energy + (flight.spin().speed + shift) * stored.gyroscopic + turning + twisted + ring[0] + ring[1];
    }

    /// Energies one by one, as they were when they were taken last; none where the follower wants none.
    fn energies(&self) -> Energies {
        self.apart.as_ref().map_or_else(Energies::default, |apart| apart.energies)
    }
}
