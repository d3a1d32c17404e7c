//! One run of the exponential engine from its start to its end, watched by recorders.
//!
//! Loads, the rotor in the ring, and contact are seen at every step. Stresses, stores of energy and the damping of shaft, bearings and twist take the motion of all nodes: they
//! are seen at the instants of an interval of eight contact steps at least (`LOOKS`), damping by the trapezoidal rule between them. Works of contact, of the ring's damping and of braking are those of each step.
//!
//! Limits: peaks of stresses between two looks are missed; a look is at most as far from the next as the longest flight. Verified by `tests/exponential_run.rs`.

use super::ExponentialError;
use super::flight::FlightSettings;
use super::spin::Spin;
use super::transient::{Done, Transient};
use crate::record::{At, End, Recorders, RingInstant, Touch};
use crate::rotor::braking_torque;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Cause, EndCause, Outcome};

/// Contact steps from one look at the whole motion to the next, at least; each of the first steps has one.
const LOOKS: u64 = 8;

/// Simulates one run in contact steps of `settings.step`.
///
/// # Errors
/// [`ExponentialError`] of a machine that this engine does not cover, or that has no basis at a speed that it comes to.
pub fn simulate(
    machine: &Machine,
    structure: &Structure,
    settings: FlightSettings,
) -> Result<Outcome, ExponentialError> {
    if machine.run.twin != 0.0 {
        return Err(ExponentialError::NotCovered { what: "a twin (run.twin)" });
    }
    let mut run = Run::new(machine, structure, settings)?;
    let (cause, failure) = loop {
        match run.step()? {
            Goes::On => {}
            Goes::Ends(cause) => break (cause, None),
            Goes::Wrong(cause) => break (EndCause::Failure, Some(cause)),
        }
    };
    let Run { transient, mut recorders, steps, speed, .. } = run;
    let end = End { cause, time: transient.flight.time(), speed, failure, steps, iterations: steps };
    recorders.finish(&end, machine, structure);
    Ok(recorders.outcome(machine, structure, &end, None))
}

enum Goes {
    On,
    Ends(EndCause),
    Wrong(Cause),
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
    shape: Shape,
}

/// Room for the motion of all nodes.
struct Shape {
    /// q and q'.
    motion: Vec<f64>,
    nodal: Vec<f64>,
    twists: Vec<f64>,
    twist_rows: Vec<Vec<f64>>,
    /// Rows of u and v of each bearing's node.
    bearings: Vec<[Vec<f64>; 2]>,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, structure: &'a Structure, settings: FlightSettings) -> Result<Self, ExponentialError> {
        let transient = Transient::new(machine, structure, settings, true)?;
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let shape = Shape {
            motion: vec![0.0; 2 * map.size()],
            nodal: vec![0.0; map.nodal_size()],
            twists: vec![0.0; rotor.nodes],
            twist_rows: (0..rotor.nodes).map(|node| Spin::row_of(structure, node)).collect(),
            bearings: rotor.bearings.iter().map(|b| rotor.plane_places(b.node).map(|dof| map.row(dof))).collect(),
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
            shape,
        })
    }

    /// From n to n+1.
    fn step(&mut self) -> Result<Goes, ExponentialError> {
        if self.machine.run.step_limit.is_some_and(|limit| self.steps >= limit) {
            return Ok(Goes::Wrong(Cause::StepLimit));
        }
        let ticks = self.transient.flight.ticks();
        let at = At { time: self.transient.flight.time(), speed: self.speed };
        let looks = self.steps < LOOKS || self.looked.is_none_or(|(last, _)| ticks - last >= LOOKS);
        if looks {
            self.look(ticks, at);
        }
        let angle = self.transient.flight.angle();
        let before = self.ring_energy();
        let done = match self.transient.step() {
            Ok(done) => done,
            Err(ExponentialError::NoImpulses) => return Ok(Goes::Wrong(Cause::LossOfUniqueness)),
            Err(error) => return Err(error),
        };
        self.record(&done, at, angle, looks);
        self.works(&done, before);
        self.steps += 1;
        Ok(self.ended(&done))
    }

    /// Why the run does not go on from n+1.
    fn ended(&mut self, done: &Done) -> Goes {
        let speed = self.transient.flight.speed();
        if !(speed + done.place[0] + done.place[1]).is_finite() {
            return Goes::Wrong(Cause::NonFinite);
        }
        let run = &self.machine.run;
        let stopped = self.machine.rotor.initial_speed > 0.0 && speed <= 0.0;
        self.speed = if stopped { 0.0 } else { speed };
        if self.transient.is_outside() {
            return Goes::Wrong(Cause::OutsideRing);
        }
        if stopped {
            Goes::Ends(EndCause::Stopped)
        } else if run.end_speed > 0.0 && speed <= run.end_speed {
            Goes::Ends(EndCause::EndSpeed)
        } else if self.transient.flight.time() >= run.end_time - 0.5 * self.h {
            Goes::Ends(EndCause::EndTime)
        } else {
            Goes::On
        }
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
    fn look(&mut self, ticks: u64, at: At) {
        let Self { transient, recorders, shape, structure, .. } = self;
        let flight = &mut transient.flight;
        flight.motion(&mut shape.motion);
        let (q, velocity) = shape.motion.split_at(shape.motion.len() / 2);
        structure.lateral.coordinates.expand(q, &mut shape.nodal);
        flight.spin().twists(&shape.twist_rows, &mut shape.twists);
        recorders.see_shape(&shape.nodal, &shape.twists, at);

        let model = &flight.shared().grid.model;
        let [kinetic, strain, damping] = model.system.energies(flight.speed(), q, velocity);
        let [turning, twisted] = flight.spin().energies(flight.velocities());
        let [mut bearings, mut skew] = [0.0; 2];
        for (bearing, rows) in structure.rotor.bearings.iter().zip(&shape.bearings) {
            let of = |state: &[f64]| [0, 1].map(|i| crate::linalg::dot(&rows[i], state));
            let v = of(velocity);
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
        let ring = transient.contact.as_ref().map_or([0.0; 2], |contact| contact.rub.ring.energies());
        now.kinetic = kinetic + turning + ring[0];
        now.strain = strain + twisted + ring[1];
        now.gravity = -crate::linalg::dot(model.outputs.weight(), q);
        recorders.energies.take();
        recorders.judge_now(self.machine, structure);
    }
}
