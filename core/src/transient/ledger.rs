//! Energy ledger: every store and every flow integrated on its own, so that their balance is a check and not a definition.

use super::rub::{Rub, StepContact};
use super::shaft_line::ShaftLine;

/// Energies of one instant and the work done up to it \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic: rotor, spin, gyroscopic coupling, unbalance, ring.
    pub kinetic: f64,
    /// Strain: shaft, bearings' potential part, twist, ring, radial spring.
    pub strain: f64,
    /// Gravity.
    pub gravity: f64,
    /// Dissipated by bearings.
    pub bearings: f64,
    /// Dissipated by structural damping of the shaft, in bending and in twist.
    pub structure: f64,
    /// Dissipated by the stator's damping.
    pub stator: f64,
    /// Taken by braking.
    pub braking: f64,
    /// Dissipated by contact friction.
    pub friction: f64,
    /// Taken out by the normal contact force.
    pub normal: f64,
    /// Hyp 1's model work, taken out.
    pub model: f64,
    /// Put in by skew bearing stiffness.
    pub skew: f64,
    /// Put in by the drive of a prescribed speed.
    pub drive: f64,
}

impl Energies {
    /// Energy stored.
    #[must_use]
    pub fn stored(&self) -> f64 {
        self.kinetic + self.strain + self.gravity
    }
    /// Energy that has left.
    #[must_use]
    pub fn taken(&self) -> f64 {
        self.bearings + self.structure + self.stator + self.braking + self.friction + self.normal + self.model
            - self.skew
            - self.drive
    }
}

/// Keeps the balance of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ledger {
    pub now: Energies,
    pub initial: f64,
    pub largest: f64,
    pub largest_error: f64,
    started: bool,
}

impl Ledger {
    /// Works of the step at n; `line` settled, nothing advanced yet.
    pub fn work(
        &mut self,
        line: &mut ShaftLine<'_>,
        rub: Option<(&mut Rub<'_>, Option<&StepContact>)>,
        d: &[f64],
        d_twist: &[f64],
    ) {
        let dt = line.dt;
        let mut bearings = 0.0;
        for bearing in &line.rotor.bearings {
            let (x, v) = line.node(bearing.node);
            bearings += dt * bearing.damping_power(v);
            if bearing.skew != 0.0 {
                let force = bearing.skew_force(x);
                self.now.skew += dt * (force[0] * v[0] + force[1] * v[1]);
            }
        }
        self.now.bearings += bearings;
        self.now.structure += line.lateral.damping_work(d) - bearings + line.twist.damping_work(d_twist);
        let spin = line.centred_spin(d_twist);
        self.now.braking -= line.braking_work(spin);
        if let Some(prescribed) = &line.prescribed {
            self.now.drive += prescribed.torque * spin * dt;
        }
        if let Some((rub, contact)) = rub {
            self.now.stator += rub.ring_damping_work();
            // what the modes left out hold is strain; what they let go at the end of a contact is lost
            self.now.normal -= rub.held - rub.held_before;
            if let Some(contact) = contact {
                self.now.friction += contact.friction_work;
                self.now.normal += contact.normal_work;
                self.now.model += contact.model_work;
            }
        }
    }

    /// Stores between n and n+1; before anything is advanced.
    pub fn stores(&mut self, line: &ShaftLine<'_>, rub: Option<&Rub<'_>>, d: &[f64], d_twist: &[f64]) {
        let (coupling, gravity) = line.coupling_energies(d);
        let (ring_kinetic, ring_strain) = rub.map_or((0.0, 0.0), Rub::ring_energies);
        let spring = rub.map_or(0.0, |rub| {
            let x = line.place(rub.node);
            let dx = line.rotor.at(rub.node, &line.d_nodal);
            rub.spring_energy(rub.local(x), rub.local([x[0] + dx[0], x[1] + dx[1]]))
        });
        self.now.kinetic =
            line.lateral.kinetic_energy(d) + line.twist.kinetic_energy(d_twist) + coupling + ring_kinetic;
        self.now.strain = line.lateral.strain_energy(d)
            + line.twist.strain_energy(d_twist)
            + ring_strain
            + spring
            + rub.map_or(0.0, |rub| rub.held);
        self.now.gravity = gravity;
    }

    /// The error of the balance, with the [`Ledger::stores`] of the same step.
    pub fn balance(&mut self) {
        let total = self.now.stored();
        if !self.started {
            // the works so far are those of half a step before and after t = 0: they belong to the start
            self.started = true;
            self.initial = total + self.now.taken();
        }
        self.largest = self.largest.max(total.abs());
        self.largest_error = self.largest_error.max((total + self.now.taken() - self.initial).abs());
    }

    /// Largest balance error over the largest total energy.
    pub fn relative_error(&self) -> f64 {
        if self.largest > 0.0 { self.largest_error / self.largest } else { 0.0 }
    }
}
