//! Motion of a run: shaft line and rings at step n, and the step from n to n+1.

use super::predictor::Predictor;
use super::rub::{Rub, StepContact};
use super::shaft_line::{Increments, Jump, ShaftLine};
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, RotorKind};
use bladeoff_model::outcome::Cause;

/// Displacement, in multiples of the model's size, beyond which a run counts as diverged.
pub(super) const DIVERGED: f64 = 10.0;

/// State of the shaft line and of all diaphragms at n.
pub(super) struct Motion<'a> {
    /// Lateral motion, spin and torsion of the shaft.
    pub line: ShaftLine<'a>,
    /// One diaphragm each, in the machine's order.
    pub rubs: Vec<Rub<'a>>,
    /// Number of steps, time \[s\] and mean spin \[rad/s\] at n.
    pub step: u64,
    pub time: f64,
    pub speed: f64,
    /// Increments of the step from n, and the contact with each diaphragm in it.
    pub d: Increments,
    pub contacts: Vec<Option<StepContact>>,
    /// Iteration of the step without contact.
    pub(super) predictor: Predictor,
    /// Whether the run ends when the rotor stops.
    can_stop: bool,
    /// Size of the model \[m\].
    size: f64,
}

impl<'a> Motion<'a> {
    /// Motion at t = 0 of a shaft line whose initial state is set.
    pub fn new(machine: &Machine, line: ShaftLine<'a>, rubs: Vec<Rub<'a>>) -> Self {
        Self {
            step: 0,
            time: 0.0,
            speed: machine.rotor.initial_speed,
            d: line.previous(),
            contacts: vec![None; rubs.len()],
            predictor: Predictor::new(&line),
            can_stop: line.spin.prescribed.is_none() && machine.rotor.initial_speed > 0.0,
            size: size(machine),
            line,
            rubs,
        }
    }

    /// Restarts from other increments of the step before t = 0.
    pub fn restart(&mut self) {
        self.d = self.line.previous();
        self.predictor.restart(&self.line);
        self.rubs.iter_mut().for_each(Rub::forget_iterations);
    }

    /// Solves the step from n again with the unbalances of another machine. `change` is added to the increments of the previous step.
    pub fn release(&mut self, machine: &Machine, structure: &'a Structure, change: &Jump) -> Result<(), Cause> {
        let line = self.line.released(machine, structure, change).ok_or(Cause::NonFinite)?;
        self.rubs.iter_mut().for_each(|rub| rub.begin_again(&line));
        self.line = line;
        self.solve()?;
        self.settle();
        Ok(())
    }

    /// Solves the step from n: increments and contacts.
    pub fn solve(&mut self) -> Result<(), Cause> {
        self.predict()?;
        self.correct()
    }

    /// Predicts the step without contact.
    pub fn predict(&mut self) -> Result<(), Cause> {
        self.line.prepare(self.time, self.speed);
        self.rubs.iter_mut().for_each(Rub::prepare);
        self.contacts.fill(None);
        self.predictor.predict(&mut self.line, self.time, &mut self.d)
    }

    /// Corrects the prediction by the contact with each diaphragm.
    fn correct(&mut self) -> Result<(), Cause> {
        if self.rubs.len() > 1 {
            return self.correct_together();
        }
        for (rub, contact) in self.rubs.iter_mut().zip(&mut self.contacts) {
            *contact = rub.correct(&mut self.line, self.time, &mut self.d)?;
        }
        Ok(())
    }

    /// Takes the previous step's increments, without contact, for a step that cannot be computed.
    pub fn repeat(&mut self) {
        self.d = self.line.previous();
        self.contacts.fill(None);
    }

    /// Computes velocities and accelerations at n from the increments of the step.
    pub fn settle(&mut self) {
        self.line.settle(&self.d);
    }

    /// Cause of failure if the state at n+1, not yet accepted, is not finite or has diverged.
    pub fn beyond(&self) -> Option<Cause> {
        let next = self.line.lateral.x.iter().zip(&self.line.lateral.d).map(|(x, dx)| (x + dx).abs());
        // `max` ignores NaN
        let reach = next.fold(0.0_f64, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) });
        if !reach.is_finite() {
            return Some(Cause::NonFinite);
        }
        (reach > DIVERGED * self.size).then_some(Cause::Diverged)
    }

    /// Advances to n+1. Returns whether the rotor stopped in this step.
    pub fn advance(&mut self) -> bool {
        let (over_step, reached) = self.line.spin_after(self.time, &self.d.torsion);
        self.predictor.keep(&self.line);
        self.line.advance(&self.d);
        self.rubs.iter_mut().for_each(Rub::advance);
        self.step += 1;
        self.time = self.step as f64 * self.line.dt;
        let stopped = self.can_stop && over_step <= 0.0;
        // a rotor that stops within the last half step does not turn backwards
        self.speed = if stopped || self.can_stop && reached < 0.0 { 0.0 } else { reached };
        stopped
    }

    /// Nodes and contact forces on the rotor, in the machine's axes \[N\].
    pub fn pressed(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        let pressed = self.rubs.iter().zip(&self.contacts);
        pressed.filter_map(|(rub, contact)| Some((rub.node(), rub.outwards(contact.as_ref()?.on_rotor))))
    }

    /// Whether the rotor's centre is outside a ring.
    pub fn is_outside(&mut self) -> bool {
        self.rubs.iter_mut().any(|rub| rub.is_outside(&self.line))
    }

    /// Mean spin at n, centred \[rad/s\].
    pub fn centred_spin(&self) -> f64 {
        self.line.centred_spin(&self.d.torsion)
    }

    /// Number of rounds of the non-linear solution, summed over all steps.
    pub fn iterations(&self) -> u64 {
        self.predictor.iterations + self.rubs.iter().map(Rub::iterations).sum::<u64>()
    }
}

/// Characteristic size of a model \[m\].
pub(super) fn size(machine: &Machine) -> f64 {
    match &machine.rotor.kind {
        RotorKind::Shaft(shaft) => shaft.nodes.last().copied().unwrap_or(1.0),
        // a point mass has no length, so its clearance defines the size; without clearance a large value
        RotorKind::PointMass(_) => {
            let clearances = machine.diaphragms.iter().map(|d| 1e4 * (d.contact.gap + d.contact.rotor_radius));
            clearances.reduce(f64::max).unwrap_or(1e6)
        }
    }
}
