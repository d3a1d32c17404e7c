//! Unbalances of a run: angles at n and turns over a step.

use crate::rotor::{RotorMatrices, Turn, UnbalanceSite};
use bladeoff_model::machine::Machine;

/// All unbalances of a run.
#[derive(Debug, Clone)]
pub(crate) struct Unbalances {
    /// Mass, radius, phase and node of each unbalance.
    pub sites: Vec<UnbalanceSite>,
    /// Acceleration of gravity \[m/s2\].
    gravity: [f64; 2],
    /// sin and cos of each unbalance's angle at n.
    angles: Vec<(f64, f64)>,
    /// Turn of each unbalance over the step, or its angular velocity and acceleration at the start.
    turns: Vec<Turn>,
}

impl Unbalances {
    /// Unbalances of a machine at their nodes.
    pub fn new(machine: &Machine, sites: Vec<UnbalanceSite>) -> Self {
        let (angles, turns) = (vec![(0.0, 1.0); sites.len()], vec![Turn::instant(0.0, 0.0); sites.len()]);
        Self { sites, gravity: machine.rotor.gravity, angles, turns }
    }

    /// Sets the angles at n from the mean spin angle `phi` and the torsion angles of the nodes \[rad\].
    pub fn place(&mut self, phi: f64, torsion: &[f64]) {
        for (site, angle) in self.sites.iter().zip(&mut self.angles) {
            *angle = libm::sincos(phi + torsion[site.torsional_node] + site.phase);
        }
    }

    /// Sets the turns over a step from the angle increments of the nodes before and after n.
    pub fn turn(&mut self, previous: &[f64], next: &[f64], dt: f64) {
        for (site, turn) in self.sites.iter().zip(&mut self.turns) {
            *turn = Turn::stepped(previous[site.torsional_node], next[site.torsional_node], dt);
        }
    }

    /// Sets the turns from angular velocities and accelerations.
    pub fn turn_at(&mut self, velocity: &[f64], acceleration: &[f64]) {
        for (site, turn) in self.sites.iter().zip(&mut self.turns) {
            *turn = Turn::instant(velocity[site.torsional_node], acceleration[site.torsional_node]);
        }
    }

    /// Adds forces \[N\] and torques \[N m\] of the unbalances for given accelerations of the nodes.
    pub fn push(&self, rotor: &RotorMatrices, acceleration: &[f64], force: &mut [f64], torque: &mut [f64]) {
        for ((site, &angle), turn) in self.sites.iter().zip(&self.angles).zip(&self.turns) {
            let found = site.force(angle, turn, rotor.at(site.node, acceleration), self.gravity);
            rotor.add_at(site.node, found.force, force);
            torque[site.torsional_node] += found.torque;
        }
    }

    /// Adds the inertia forces of the unbalance masses, which are part of the mass matrix, to nodal forces.
    pub fn add_inertia(&self, rotor: &RotorMatrices, acceleration: &[f64], force: &mut [f64]) {
        for site in &self.sites {
            let [ax, ay] = rotor.at(site.node, acceleration);
            rotor.add_at(site.node, [-site.mass * ax, -site.mass * ay], force);
        }
    }

    /// Adds the kinetic and potential energies of a step that the matrices do not contain \[J\], from lateral and torsional increments.
    pub fn add_energies(
        &self,
        rotor: &RotorMatrices,
        (lateral, torsion): (&[f64], &[f64]),
        dt: f64,
        (kinetic, potential): (&mut f64, &mut f64),
    ) {
        for (site, &angle) in self.sites.iter().zip(&self.angles) {
            let turn = torsion[site.torsional_node];
            *kinetic += site.coupling_energy(angle, turn, rotor.at(site.node, lateral), dt);
            *potential += site.gravity_energy(angle, turn, self.gravity);
        }
    }
}
