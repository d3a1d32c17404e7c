//! One run of the exponential engine from its start to its end, watched by recorders.
//!
//! Loads, the rotor in the ring, and contact are seen at every step. Stresses, stores of energy and the damping of shaft, bearings and twist take the motion of all nodes: they
//! are seen at the instants of an interval of eight contact steps at least (`LOOKS`), damping by the trapezoidal rule between them. Works of contact, of the ring's damping and of braking are those of each step.
//!
//! Limits: peaks of stresses between two looks are missed; a look is at most as far from the next as the longest flight. Verified by `tests/exponential_run.rs`.

use super::ExponentialError;
use super::eye::{Ahead, Eye};
use super::settings::FlightSettings;
use super::shape::Shape;
use super::transient::{Done, Transient};
use crate::engine::motion::{DIVERGED, size};
use crate::record::{At, End, Energies, Follower, Recorders, RingInstant, Touch};
use crate::rotor::braking_torque;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause};

/// Contact steps from one look at the whole motion to the next, at least; each of the first steps has one.
const LOOKS: u64 = 8;

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
    let (mut cause, mut failure) = loop {
        if !follower.goes_on(run.steps) {
            break (EndCause::Failure, Some(Cause::StepLimit));
        }
        match run.step(follower) {
            Ok(None) => {}
            Ok(Some(end)) => break (end, None),
            Err(cause) => break (EndCause::Failure, Some(cause)),
        }
    };
    if failure.is_none() {
        // the last balance is that of the end
        let at = At { time: run.transient.flight.time(), speed: run.speed };
        if let Err(found) = run.look(run.transient.flight.ticks(), at) {
            (cause, failure) = (EndCause::Failure, Some(found));
        }
    }
    let Run { steps, speed, .. } = run;
    let end = End { cause, time: run.transient.flight.time(), speed, failure, steps, iterations: steps };
    run.recorders.finish(&end, machine, structure);
    run.show_end(failure, follower);
    Ok((run.recorders, end))
}

impl From<ExponentialError> for Cause {
    /// Of a run that cannot go on.
    fn from(error: ExponentialError) -> Self {
        match error {
            ExponentialError::NoImpulses => Self::LossOfUniqueness,
            _ => Self::NoBasis,
        }
    }
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
    /// The last look: its time in contact steps, and powers of structure, bearings and skew stiffness then \[W\].
    looked: Option<(u64, [f64; 3])>,
    /// The energies of it.
    balanced: Energies,
    /// Jumps of all rates per impulse along each axis of the diaphragm's node, the last step's impulses, and room for rates.
    jumps: [Vec<f64>; 2],
    struck: [f64; 2],
    mean_rates: Vec<f64>,
    shape: Shape,
    /// Rows of u and v of each bearing's node.
    bearings: Vec<[Vec<f64>; 2]>,
    /// Largest displacement that is believed \[m\].
    reach: f64,
    /// Once a follower has asked for an instant.
    eye: Option<Box<Eye<'a>>>,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, structure: &'a Structure, settings: FlightSettings) -> Result<Self, ExponentialError> {
        let transient = Transient::new(machine, structure, settings, true)?;
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let system = &transient.flight.shared().grid.model.system;
        let jumps = match machine.diaphragms.first() {
            Some(diaphragm) => rotor.plane_places(diaphragm.contact.node).map(|dof| system.struck(&map.row(dof))),
            None => [vec![0.0; map.size()], vec![0.0; map.size()]],
        };
        Ok(Self {
            machine,
            structure,
            recorders: Recorders::new(machine, &structure.rings, settings.step),
            speed: transient.flight.speed(),
            transient,
            steps: 0,
            h: settings.step,
            touched: false,
            looked: None,
            balanced: Energies::default(),
            jumps,
            struck: [0.0; 2],
            mean_rates: vec![0.0; map.size()],
            shape: Shape::new(structure),
            bearings: rotor.bearings.iter().map(|b| rotor.plane_places(b.node).map(|dof| map.row(dof))).collect(),
            reach: DIVERGED * size(machine),
            eye: None,
        })
    }

    /// From n to n+1; `Some` when the run has ended.
    fn step(&mut self, follower: &mut dyn Follower) -> Result<Option<EndCause>, Cause> {
        if self.machine.run.step_limit.is_some_and(|limit| self.steps >= limit) {
            return Err(Cause::StepLimit);
        }
        let ticks = self.transient.flight.ticks();
        let at = At { time: self.transient.flight.time(), speed: self.speed };
        let looks = self.steps < LOOKS || self.looked.is_none_or(|(last, _)| ticks - last >= LOOKS);
        if looks {
            self.look(ticks, at)?;
        }
        let level = self.transient.level();
        let shown = follower.wants(ticks, at.time);
        if shown {
            let Self { transient, eye, machine, structure, .. } = self;
            eye.get_or_insert_with(|| Box::new(Eye::new(machine, structure))).look(transient);
        }
        if let Some(level) = level {
            self.fly_by(level, shown, follower)?;
        }
        let angle = self.transient.flight.angle();
        let before = self.ring_energy();
        let done = self.transient.step(level)?;
        self.record(&done, at, angle, looks);
        self.works(&done, before);
        self.steps += 1;
        self.struck = done.impact.map_or([0.0; 2], |impact| impact.on_rotor);
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
            eye.show(
                &self.transient.loads,
                done.impact.as_ref().map(|impact| (impact, self.h)),
                self.balanced,
                follower,
            );
        }
    }

    /// Tells a follower of the instants of a step in flight, the first of which was taken where it is to be `shown`.
    fn fly_by(&mut self, level: usize, shown: bool, follower: &mut dyn Follower) -> Result<(), Cause> {
        let Self { transient, eye, balanced, machine, structure, .. } = self;
        let ticks = transient.flight.ticks();
        let mut ahead = None;
        for tick in ticks..ticks + (1 << level) {
            let time = tick as f64 * self.h;
            if transient.contact.is_some() {
                follower.contact_force(0, time, 0.0);
            }
            if tick == ticks && shown {
                transient.weigh();
                eye.iter().for_each(|eye| eye.show(&transient.loads, None, *balanced, follower));
            } else if tick > ticks && follower.wants(tick, time) {
                let eye = eye.get_or_insert_with(|| Box::new(Eye::new(machine, structure)));
                ahead.get_or_insert_with(|| Ahead::of(transient)).show(tick, transient, eye, *balanced, follower)?;
            }
        }
        Ok(())
    }

    /// Shows the instant at which the run has ended: the state, time, spin and works of the row, with the loads and the contact of the step that would
    /// follow, where there is one.
    fn show_end(&mut self, failure: Option<Cause>, follower: &mut dyn Follower) {
        if !follower.wants_end() {
            return;
        }
        self.shape.take(&mut self.transient.flight, self.structure);
        self.store();
        let Self { transient, eye, recorders, h, machine, structure, speed, .. } = self;
        let eye = eye.get_or_insert_with(|| Box::new(Eye::new(machine, structure)));
        eye.look(transient);
        eye.speed = *speed;
        // a budget ends a run between two steps
        let goes_on = matches!(failure, None | Some(Cause::StepLimit));
        let impact = if goes_on { transient.ahead() } else { None };
        eye.show(&transient.loads, impact.as_ref().map(|impact| (impact, *h)), recorders.energies.now, follower);
    }

    /// Why the run does not go on from n+1.
    fn ended(&mut self, done: &Done) -> Result<Option<EndCause>, Cause> {
        let speed = self.transient.flight.speed();
        if !(speed + done.place[0] + done.place[1]).is_finite() {
            return Err(Cause::NonFinite);
        }
        let run = &self.machine.run;
        let stopped = speed <= 0.0;
        self.speed = if stopped { 0.0 } else { speed };
        if self.transient.is_outside() {
            return Err(Cause::OutsideRing);
        }
        Ok(if stopped {
            Some(EndCause::Stopped)
        } else if run.end_speed > 0.0 && speed <= run.end_speed {
            Some(EndCause::EndSpeed)
        } else {
            // half a step of slack: the last step ends at end_time, not one beyond it
            (self.transient.flight.time() >= run.end_time - 0.5 * self.h).then_some(EndCause::EndTime)
        })
    }

    /// Loads, the rotor in the ring, contact.
    fn record(&mut self, done: &Done, at: At, angle: f64, looks: bool) {
        let touch = done.impact.as_ref().map(|impact| Touch {
            normal: impact.normal / self.h,
            sticks: impact.sticks,
            gap: impact.gap,
            points: impact.points,
            reversed: impact.reversed,
            no_fixed_point: false,
            several_minima: false,
        });
        self.touched |= touch.is_some();
        let steps = done.level.map_or(1, |level| 1 << level);
        let ring = self.transient.contact.as_ref().map(|contact| RingInstant {
            angle,
            place: contact.rub.place(done.place),
            velocity: contact.rub.inwards(done.velocity),
            touch,
            ring: (looks && self.touched).then_some(contact.rub.ring.modes.place.as_slice()),
        });
        self.recorders.see_steps(steps, at, &self.transient.loads, ring.as_ref());
    }

    fn ring_energy(&self) -> f64 {
        self.transient.contact.as_ref().map_or(0.0, |contact| contact.rub.ring.energies().iter().sum())
    }

    /// Works of the step that has been done.
    fn works(&mut self, done: &Done, ring_before: f64) {
        let energy = self.ring_energy();
        let now = &mut self.recorders.energies.now;
        let steps = done.level.map_or(1.0, |level| f64::from(1_u32 << level));
        let power = |speed: f64| braking_torque(&self.machine.braking, speed) * speed;
        now.braking -= 0.5 * steps * self.h * (power(self.speed) + power(self.transient.flight.speed()));
        if let Some(impact) = &done.impact {
            now.friction += impact.friction_work;
            now.normal += impact.normal_work;
        }
        if let Some(contact) = &self.transient.contact {
            now.stator += match done.level {
                // nothing else changes its energy
                Some(_) => ring_before - energy,
                None => contact.rub.ring.damped(),
            };
        }
    }

    /// Sees the motion of all nodes at n: stresses, stores, what damping has taken since the last look.
    fn look(&mut self, ticks: u64, at: At) -> Result<(), Cause> {
        let Self { transient, recorders, shape, structure, .. } = self;
        let flight = &mut transient.flight;
        shape.take(flight, structure);
        // `max` passes over NaN
        let reach =
            shape.nodal.iter().fold(0.0_f64, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x.abs()) });
        if !reach.is_finite() {
            return Err(Cause::NonFinite);
        }
        if reach > self.reach {
            return Err(Cause::Diverged);
        }
        recorders.see_shape(&shape.nodal, &shape.twists, at);

        let (q, velocity) = (shape.coordinates(), shape.rates());
        let model = &flight.shared().grid.model;
        // damping acts on what is between the velocities before and after an impulse
        for (j, mean) in self.mean_rates.iter_mut().enumerate() {
            *mean = velocity[j] + 0.5 * (self.jumps[0][j] * self.struck[0] + self.jumps[1][j] * self.struck[1]);
        }
        let damping = model.system.damping_power(&self.mean_rates);
        let [mut bearings, mut skew] = [0.0; 2];
        for (bearing, rows) in structure.rotor.bearings.iter().zip(&self.bearings) {
            let of = |state: &[f64]| [0, 1].map(|i| crate::linalg::dot(&rows[i], state));
            let v = of(&self.mean_rates);
            bearings += bearing.damping_power(v);
            let force = bearing.skew_force(of(q));
            skew += force[0] * v[0] + force[1] * v[1];
        }
        let powers = [damping - bearings + flight.spin().damping_power(), bearings, skew];
        let now = &mut recorders.energies.now;
        if let Some((last, before)) = self.looked {
            let half = 0.5 * (ticks - last) as f64 * self.h;
            now.structure += half * (before[0] + powers[0]);
            now.bearings += half * (before[1] + powers[1]);
            now.skew += half * (before[2] + powers[2]);
        }
        self.looked = Some((ticks, powers));
        self.store();
        self.balanced = self.recorders.energies.now;
        self.recorders.energies.take();
        self.recorders.judge(self.machine, self.structure);
        Ok(())
    }

    /// Writes the stores at n, of the shape taken there.
    fn store(&mut self) {
        let Self { transient, recorders, shape, .. } = self;
        let (flight, now) = (&transient.flight, &mut recorders.energies.now);
        let model = &flight.shared().grid.model;
        let shift = flight.held_back();
        let (q, velocity) = (shape.coordinates(), shape.rates());
        let [kinetic, strain] = model.system.energies(flight.speed() + shift, q, velocity);
        let [turning, twisted] = flight.spin().energies(shift, flight.velocities());
        let ring = transient.contact.as_ref().map_or([0.0; 2], |contact| contact.rub.ring.energies());
        now.kinetic = kinetic + turning + ring[0];
        now.strain = strain + twisted + ring[1];
        now.gravity = -crate::linalg::dot(model.outputs.weight(), q);
    }
}
