//! The shaft line during a run: lateral motion, spin and torsion. Every non-linear term is evaluated at the nodes.
//!
//! One step solves the central-difference equations with centred gyroscopic, unbalance and braking terms by fixed-point iteration, which contracts by
//! about `Omega dt`. The full and the reduced engine run the same code and differ in [`crate::structure::Coordinates`]. A step consists of
//! [`ShaftLine::prepare`], rounds of [`ShaftLine::respond`], [`ShaftLine::settle`] and [`ShaftLine::advance`].

mod brake;
mod field;
mod increments;
#[cfg(test)]
mod lagrangian_tests;
mod masses;
mod piece;
mod prescribed;
mod spin;
mod stepper;
mod tables;
mod torques;
mod unbalances;

pub(crate) use increments::Increments;
pub(crate) use masses::{masses, sites};
pub(crate) use piece::{Jump, PieceMotion};
pub(crate) use prescribed::{angle_of, speed_of};
pub(crate) use stepper::Stepper;

use field::Field;
use spin::Spin;
use tables::Tables;
use torques::Torques;
use unbalances::Unbalances;

use crate::rotor::{BearingSite, RotorMatrices, UnbalanceSite};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{axpy, norm};

/// Scale of the lateral increments as a share of the state, at least. Increments of a rotor at rest are rounding of its state.
const RESTING: f64 = 1e-4;
/// Scale of the lateral increments as a share of those that the unbalances alone would cause by their turn, at least. psi'' is a difference of
/// increments `psi' dt`, divided by dt^2, and 1e-12 of this share is 18 roundings of that difference.
const TURNING: f64 = 4e-3;

/// State and operators of the shaft line during one run.
pub(crate) struct ShaftLine<'a> {
    pub rotor: &'a RotorMatrices,
    /// Time step \[s\].
    pub dt: f64,
    /// Lateral motion \[m\] and \[rad\].
    pub lateral: Field<'a>,
    /// Torsion: angles of the nodes relative to the mean spin angle \[rad\].
    pub torsion: Field<'a>,
    /// Mean spin.
    pub spin: Spin,
    unbalances: Unbalances,
    /// Torques over time; `None` without.
    torques: Option<Torques>,
    /// Norm of the lateral increment per radian of each unbalance's turn over a step, `|A^-1 m d/dt^2|`.
    levers: Vec<f64>,
    /// Product S_g x of every gyroscopic site at n.
    gyro_x: Vec<f64>,
    weight: Weight,
    /// Whether any bearing has skew stiffness or a table.
    has_skew: bool,
    /// Speed-dependent part of the bearing coefficients.
    pub tables: Tables,
    /// Contact forces of the other diaphragms, which [`ShaftLine::respond`] adds while one diaphragm is solved.
    pub others: Option<OtherForces>,
}

/// Response over a step to the contact forces of other diaphragms.
#[derive(Debug, Clone)]
pub(crate) struct OtherForces {
    /// Increments due to these forces.
    pub increments: Increments,
    /// Reaction torque of the drive of a prescribed speed to these forces \[N m\].
    pub drive_torque: f64,
}

impl OtherForces {
    /// Response to no force.
    pub fn none(line: &ShaftLine<'_>) -> Self {
        Self { increments: Increments::zeros(line.lateral.size(), line.torsion.size()), drive_torque: 0.0 }
    }
}

/// Constant lateral force: weight, and forces of bearing seats off the bearing line.
struct Weight {
    /// Forces on the nodal degrees of freedom \[N\].
    nodal: Vec<f64>,
    /// Generalised forces on the coordinates.
    projected: Vec<f64>,
}

impl<'a> ShaftLine<'a> {
    /// Shaft line at rest in its undeformed position; `None` if a mass matrix is singular.
    pub fn new(machine: &Machine, structure: &'a Structure, dt: f64) -> Option<Self> {
        let rotor = &structure.rotor;
        let sites = sites(machine);
        let (lateral_mass, torsional_mass) = masses(structure, &sites);
        let lateral = Field::new(&structure.lateral, &lateral_mass, dt)?;
        let torsion = Field::new(&structure.torsion, &torsional_mass, dt)?;
        let nodal = rotor.constant_force(&machine.rotor, &sites);
        let mut projected = vec![0.0; lateral.size()];
        structure.lateral.coordinates.project(&nodal, &mut projected);
        let levers = sites.iter().map(|site| {
            let length = rotor.plane_places(site.node).map(|dof| {
                let (row, mut response) = (lateral.row(dof), vec![0.0; lateral.size()]);
                lateral.stepper.compliance(&row, &mut response);
                norm(&response)
            });
            (site.mass * site.radius).abs() * libm::hypot(length[0], length[1]) / (dt * dt)
        });
        Some(Self {
            rotor,
            dt,
            levers: levers.collect(),
            spin: Spin::new(machine, structure, &torsion.stepper),
            unbalances: Unbalances::new(machine, sites),
            torques: Torques::new(machine, &torsion, dt),
            gyro_x: vec![0.0; 8 * rotor.gyro.len()],
            weight: Weight { nodal, projected },
            has_skew: rotor.bearings.iter().any(|b| b.skew != 0.0) || !rotor.tables.is_empty(),
            tables: Tables::new(rotor, machine.rotor.initial_speed),
            lateral,
            torsion,
            others: None,
        })
    }

    /// Shaft line at n, before [`ShaftLine::prepare`], with the unbalances of another machine. `change` is added to the increments of the previous
    /// step. `None` if a mass matrix is singular.
    pub fn released(&self, machine: &Machine, structure: &'a Structure, change: &Jump) -> Option<Self> {
        let mut line = Self::new(machine, structure, self.dt)?;
        line.lateral.take_over(&self.lateral, &change.lateral);
        line.torsion.take_over(&self.torsion, &change.torsion);
        line.spin.angle = self.spin.angle;
        line.tables = self.tables.repeated();
        line.refresh();
        Some(line)
    }

    /// Motion of an unbalance mass at n, after [`ShaftLine::settle`].
    pub fn piece(&self, site: &UnbalanceSite) -> PieceMotion {
        let (lateral, torsion, node) = (&self.lateral, &self.torsion, site.torsional_node);
        let psi = self.spin.angle + torsion.x[node] + site.phase;
        PieceMotion {
            node: [&lateral.x, &lateral.v, &lateral.a].map(|of| self.rotor.at(site.node, of)),
            angle: [psi, torsion.v[node], torsion.a[node]],
        }
    }

    /// Sets the state at t = 0 from coordinates; `previous` are the fictitious increments of the step before.
    pub fn begin(&mut self, q: &[f64], previous: &Increments) {
        self.lateral.stepper.q.copy_from_slice(q);
        self.lateral.put(q);
        self.come_from(previous);
        self.refresh();
    }

    /// Sets the torsion at t = 0 from coordinates.
    pub fn begin_torsion(&mut self, q: &[f64]) {
        self.torsion.stepper.q.copy_from_slice(q);
        self.torsion.put(q);
    }

    /// Replaces the increments of the previous step.
    pub fn come_from(&mut self, previous: &Increments) {
        self.lateral.come_from(&previous.lateral);
        self.torsion.come_from(&previous.torsion);
    }

    /// Sets coordinates and velocities, all nodes turning with the same spin, for [`ShaftLine::instant_forces`].
    pub fn instant(&mut self, q: &[f64], velocity: &[f64], spin: f64) {
        self.lateral.put(q);
        self.refresh();
        self.lateral.speed(velocity);
        self.torsion.v.fill(spin);
    }

    /// Evaluates generalised forces and torques of this state for given accelerations: all except the braking torque and the terms of M, C and K.
    pub fn instant_forces(&mut self, lateral: &[f64], torsion: &[f64]) {
        self.lateral.accelerate(lateral);
        self.torsion.accelerate(torsion);
        self.evaluate_instant();
        if self.has_skew {
            self.add_skew_forces();
        }
        self.lateral.project();
        for (sum, weight) in self.lateral.force_q.iter_mut().zip(&self.weight.projected) {
            *sum += weight;
        }
        self.torsion.project();
    }

    /// Begins the step from n at a time \[s\] and a mean spin \[rad/s\].
    pub fn prepare(&mut self, time: f64, speed: f64) {
        self.tables.at_speed(self.rotor, speed);
        if self.has_skew {
            self.lateral.force.fill(0.0);
            self.add_skew_forces();
            self.lateral.project();
            for (sum, weight) in self.lateral.force_q.iter_mut().zip(&self.weight.projected) {
                *sum += weight;
            }
            self.lateral.stepper.prepare(Some(&self.lateral.force_q));
        } else {
            self.lateral.stepper.prepare(Some(&self.weight.projected));
        }
        self.torsion.stepper.prepare(self.torques.as_mut().map(|torques| torques.at_step(time)));
    }

    /// Computes the increments that follow from the forces at the increments `d`. Contact forces are not included, except those of
    /// [`ShaftLine::others`]. `time` is the time at n \[s\].
    pub fn respond(&mut self, time: f64, d: &Increments, free: &mut Increments) {
        self.settle(d);
        self.unbalances.turn(&self.torsion.previous, &self.torsion.d, self.dt);
        self.evaluate();
        self.lateral.project();
        self.torsion.project();
        self.spin.brake(self.centred_spin(&d.torsion), &mut self.torsion.force_q);
        self.lateral.respond(&mut free.lateral);
        self.torsion.respond(&mut free.torsion);
        self.spin.hold(time, &self.torsion.stepper.previous, &mut free.torsion);
        if let Some(others) = &self.others {
            axpy(1.0, &others.increments.lateral, &mut free.lateral);
            axpy(1.0, &others.increments.torsion, &mut free.torsion);
            self.spin.add_drive_torque(others.drive_torque);
        }
    }

    /// Computes nodal increments, velocities and accelerations from the increments of a round; the last call is for the increments that are accepted.
    pub fn settle(&mut self, d: &Increments) {
        self.lateral.see(&d.lateral);
        self.torsion.see(&d.torsion);
    }

    /// Accepts the increments of the step, which are those of the last [`ShaftLine::settle`].
    pub fn advance(&mut self, d: &Increments) {
        let turn = self.spin.turn(&d.torsion);
        self.lateral.stepper.advance(&d.lateral);
        self.torsion.stepper.advance(&d.torsion);
        for (q, rigid) in self.torsion.stepper.q.iter_mut().zip(&self.spin.rigid) {
            *q -= turn * rigid;
        }
        self.spin.angle += turn;
        for (x, dx) in self.lateral.x.iter_mut().zip(&self.lateral.d) {
            *x += dx;
        }
        for (beta, d_psi) in self.torsion.x.iter_mut().zip(&self.torsion.d) {
            *beta += d_psi - turn;
        }
        self.lateral.previous.copy_from_slice(&self.lateral.d);
        self.torsion.previous.copy_from_slice(&self.torsion.d);
        self.refresh();
    }

    /// Updates the terms that depend only on the position at n: angles of the unbalances, and S_g x.
    fn refresh(&mut self) {
        self.unbalances.place(self.spin.angle, &self.torsion.x);
        for (site, product) in self.rotor.gyro.iter().zip(self.gyro_x.chunks_exact_mut(8)) {
            product.fill(0.0);
            site.local_product(&self.lateral.x, product.try_into().expect("chunks of 8"));
        }
    }

    /// Evaluates the non-linear forces at n from velocities, accelerations and turns.
    fn evaluate(&mut self) {
        let (lateral, torsion) = (&mut self.lateral, &mut self.torsion);
        lateral.force.fill(0.0);
        torsion.force.fill(0.0);
        for (site, product) in self.rotor.gyro.iter().zip(self.gyro_x.chunks_exact(8)) {
            let product: &[f64; 8] = product.try_into().expect("chunks of 8");
            let (spin, spin_dot) = (site.mean(&torsion.v), site.mean(&torsion.a));
            let torque = site.apply(spin, spin_dot, &lateral.v, &lateral.a, product, &mut lateral.force);
            site.spread(torque, &mut torsion.force);
        }
        self.unbalances.push(self.rotor, &lateral.a, &mut lateral.force, &mut torsion.force);
        self.tables.add_damping_forces(&lateral.v, &mut lateral.force);
    }

    /// Evaluates the non-linear forces from angular velocities and accelerations instead of turns over a step.
    fn evaluate_instant(&mut self) {
        self.unbalances.turn_at(&self.torsion.v, &self.torsion.a);
        self.evaluate();
    }

    /// Adds the forces at n of skew bearing stiffness, and of the speed-dependent part of the stiffness in tables.
    fn add_skew_forces(&mut self) {
        for bearing in &self.rotor.bearings {
            bearing.push(bearing.skew_force(bearing.across(&self.lateral.x)), &mut self.lateral.force);
        }
        self.tables.add_stiffness_forces(&self.lateral.x, &mut self.lateral.force);
    }

    /// Sum of the torques over time before t = 0 \[N m\].
    pub fn torque_before(&self) -> f64 {
        self.torques.as_ref().map_or(0.0, Torques::sum_before)
    }

    /// Work of the torques over time in the step at n \[J\], after [`ShaftLine::settle`].
    pub fn torque_work(&self) -> f64 {
        self.torques.as_ref().map_or(0.0, |torques| torques.work(&self.torsion.v))
    }

    /// Whether all bearing tables cover a speed \[rad/s\].
    pub fn is_in_tables(&self, speed: f64) -> bool {
        Tables::cover(self.rotor, speed)
    }

    /// Mean spin at n, centred \[rad/s\].
    pub fn centred_spin(&self, torsion: &[f64]) -> f64 {
        self.spin.centred(torsion, &self.torsion.stepper.previous)
    }

    /// Mean spin over the step and mean spin at n+1 \[rad/s\]; `time` is the time at n.
    pub fn spin_after(&self, time: f64, torsion: &[f64]) -> (f64, f64) {
        (self.spin.over_step(torsion), self.spin.reached(time, torsion, &self.torsion.stepper.previous))
    }

    /// Scale for the error of lateral increments: their norm, but at least the rounding of the state and of the unbalances' turns. (A rotor on stiff
    /// bearings moves far less than its unbalances.) After [`ShaftLine::respond`].
    pub fn lateral_scale(&self, increments: f64) -> f64 {
        let turns = self.unbalances.sites.iter().zip(&self.levers);
        let turns = turns.map(|(site, lever)| lever * self.torsion.d[site.torsional_node].abs());
        let least = TURNING * turns.sum::<f64>();
        (increments + RESTING * norm(&self.lateral.stepper.q)).max(least) + f64::MIN_POSITIVE
    }

    /// Least scale for the error of torsional increments, which are mere rounding at rest.
    pub fn torsional_scale(&self) -> f64 {
        self.spin.brake.scale()
    }

    /// Displacement of a node at n \[m\].
    pub fn place(&self, node: usize) -> [f64; 2] {
        self.rotor.at(node, &self.lateral.x)
    }

    /// Displacement \[m\] and centred velocity \[m/s\] of a node at n, after [`ShaftLine::settle`].
    pub fn node(&self, node: usize) -> ([f64; 2], [f64; 2]) {
        (self.rotor.at(node, &self.lateral.x), self.rotor.at(node, &self.lateral.v))
    }

    /// Displacement \[m\] and centred velocity \[m/s\] across a bearing or pedestal at n, after [`ShaftLine::settle`].
    pub fn across(&self, site: &BearingSite) -> ([f64; 2], [f64; 2]) {
        (site.across(&self.lateral.x), site.across(&self.lateral.v))
    }

    /// Increments of the previous step.
    pub fn previous(&self) -> Increments {
        let (lateral, torsion) = (&self.lateral.stepper.previous, &self.torsion.stepper.previous);
        Increments { lateral: lateral.clone(), torsion: torsion.clone() }
    }

    /// Rows of the lateral coordinates for a node's u and v, and of the torsional coordinates for its angle.
    pub fn rows(&self, node: usize) -> ([Vec<f64>; 2], Vec<f64>) {
        (self.rotor.plane_places(node).map(|dof| self.lateral.row(dof)), self.torsion.row(node))
    }

    /// Unbalances at their nodes.
    pub fn unbalances(&self) -> &[UnbalanceSite] {
        &self.unbalances.sites
    }

    /// Constant lateral force on the coordinates.
    pub fn weight(&self) -> &[f64] {
        &self.weight.projected
    }

    /// Constant lateral force at the nodes and pedestals \[N\].
    pub fn nodal_weight(&self) -> Vec<f64> {
        self.weight.nodal.clone()
    }

    /// Adds to nodal forces the gyroscopic moments and the forces of the unbalances at n, including the inertia of the unbalances;
    /// after [`ShaftLine::settle`].
    pub fn add_driving_forces(&self, force: &mut [f64]) {
        axpy(1.0, &self.lateral.force, force);
        self.unbalances.add_inertia(self.rotor, &self.lateral.a, force);
    }

    /// Kinetic and potential energy between n and n+1 \[J\]: gyroscopic, unbalance-coupling and gravity terms. After [`ShaftLine::settle`],
    /// before [`ShaftLine::advance`].
    pub fn coupling_energies(&self, d: &Increments) -> (f64, f64) {
        let (lateral, torsion) = (&self.lateral, &self.torsion);
        let dt = self.dt;
        let mut kinetic = 0.0;
        let middle: Vec<f64> = lateral.x.iter().zip(&lateral.d).map(|(x, dx)| x + 0.5 * dx).collect();
        for site in &self.rotor.gyro {
            kinetic += 0.5 * site.mean(&torsion.d) * site.bilinear(&lateral.d, &middle) / (dt * dt);
        }
        let mut potential = 0.0;
        if self.weight.nodal.iter().any(|force| *force != 0.0) {
            for (i, d) in d.lateral.iter().enumerate() {
                potential -= self.weight.projected[i] * (lateral.stepper.q[i] + 0.5 * d);
            }
        }
        let increments = (lateral.d.as_slice(), torsion.d.as_slice());
        self.unbalances.add_energies(self.rotor, increments, dt, (&mut kinetic, &mut potential));
        (kinetic, potential)
    }
}
