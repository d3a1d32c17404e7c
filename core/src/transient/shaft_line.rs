//! The shaft line under way: lateral motion, spin and twist, with every non-linear term evaluated at the nodes.
//!
//! One step solves, by fixed-point iteration, the central-difference equations with centred gyroscopic, unbalance and
//! braking terms; the iteration contracts by about `Omega dt`. Both engines run this code: they differ in [`Coordinates`].

mod beginning;

use super::brake::Brake;
use super::prescribed::{Prescribed, angle_of, speed_of};
use super::stepper::Stepper;
use crate::linalg::{Matrix, dot};
use crate::rotor::{RotorMatrices, Turn, UnbalanceSite};
use crate::structure::{Coordinates, Structure};
use bladeoff_model::machine::Machine;

/// Increments of a rotor at rest are rounding of its state; they are judged by at least this part of it.
const RESTING: f64 = 1e-4;
/// Lateral increments are judged by at least this part of those that the unbalances would make alone if they turned without
/// the rotor: psi'' is a difference of increments `psi' dt` over dt^2, and 1e-12 of this part is 18 roundings of them.
const TURNING: f64 = 4e-3;

/// State and operators of the shaft line during one run.
pub(crate) struct ShaftLine<'a> {
    pub rotor: &'a RotorMatrices,
    lateral_map: &'a Coordinates,
    twist_map: &'a Coordinates,
    pub dt: f64,
    pub lateral: Stepper,
    /// Twist relative to phi.
    pub twist: Stepper,
    /// Mean spin angle \[rad\].
    pub phi: f64,
    /// s in coordinates: `W = s . d / dt`.
    spin_row: Vec<f64>,
    /// Coordinates of a uniform rotation by 1 rad.
    rigid: Vec<f64>,
    pub unbalances: Vec<UnbalanceSite>,
    /// sin and cos of each unbalance's angle at n.
    angles: Vec<(f64, f64)>,
    /// How each of them turns, over the step or in the instant of the start.
    turns: Vec<Turn>,
    pub gravity: [f64; 2],
    brake: Brake,
    /// Lateral increment per radian of each unbalance's turn over a step, `|A^-1 m d/dt^2|`.
    levers: Vec<f64>,
    pub prescribed: Option<Prescribed>,
    /// Constant lateral force (weight) at the nodes and in coordinates, zero without gravity.
    nodal_weight: Vec<f64>,
    weight: Vec<f64>,
    /// Nodal state at n.
    pub x: Vec<f64>,
    pub x_previous: Vec<f64>,
    /// psi_i at n relative to phi.
    pub beta: Vec<f64>,
    pub psi_previous: Vec<f64>,
    /// S_g x of every gyroscopic site at n.
    gyro_x: Vec<f64>,
    has_skew: bool,
    /// Scratch: nodal increments and forces of the last evaluation.
    pub d_nodal: Vec<f64>,
    pub d_psi: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    v_psi: Vec<f64>,
    a_psi: Vec<f64>,
    force: Vec<f64>,
    torque: Vec<f64>,
    force_q: Vec<f64>,
    torque_q: Vec<f64>,
}

impl<'a> ShaftLine<'a> {
    /// The shaft line of a run at rest in its undeformed place; `None` if a mass matrix is singular.
    pub fn new(machine: &Machine, structure: &'a Structure, dt: f64) -> Option<Self> {
        let rotor = &structure.rotor;
        let (lateral_map, twist_map) = (&structure.lateral.coordinates, &structure.twist.coordinates);
        let unbalances: Vec<UnbalanceSite> = machine.rotor.unbalances.iter().map(UnbalanceSite::new).collect();
        let (lateral_mass, twist_mass) = masses(structure, &unbalances);
        let lateral = Stepper::new(&structure.lateral, &lateral_mass, dt)?;
        let twist = Stepper::new(&structure.twist, &twist_mass, dt)?;
        let mut spin_row = vec![0.0; twist_map.size()];
        twist_map.project(&rotor.spin_weights, &mut spin_row);
        let rigid = structure.twist.coordinates_of(&rotor.twist_mass, &vec![1.0; rotor.nodes]);
        let gravity = machine.rotor.gravity;
        let mut nodal_weight = rotor.weight(gravity);
        for site in &unbalances {
            rotor.add_at(site.node, [site.mass * gravity[0], site.mass * gravity[1]], &mut nodal_weight);
        }
        let mut weight = vec![0.0; lateral_map.size()];
        lateral_map.project(&nodal_weight, &mut weight);
        let mut direction = vec![0.0; twist_map.size()];
        twist.compliance(&spin_row, &mut direction);
        let compliance = dot(&spin_row, &direction);
        let driven = machine.rotor.speed_law.is_some();
        let brake = Brake::new(machine.braking, driven, &spin_row, direction.clone(), dt);
        let prescribed = machine.rotor.speed_law.clone();
        let prescribed = prescribed.map(|law| Prescribed { law, direction, compliance, torque: 0.0 });
        let levers = unbalances.iter().map(|site| {
            let length = rotor.plane_places(site.node).map(|dof| {
                let (row, mut response) = (lateral_map.row(dof), vec![0.0; lateral_map.size()]);
                lateral.compliance(&row, &mut response);
                norm(&response)
            });
            (site.mass * site.radius).abs() * length[0].hypot(length[1]) / (dt * dt)
        });
        let levers = levers.collect();
        let (lateral_size, nodes) = (rotor.lateral_size(), rotor.nodes);
        let (zeros, zero_nodes) = (vec![0.0; lateral_size], vec![0.0; nodes]);
        Some(Self {
            rotor,
            lateral_map,
            twist_map,
            dt,
            phi: machine.rotor.initial.angle,
            spin_row,
            rigid,
            angles: vec![(0.0, 1.0); unbalances.len()],
            turns: vec![Turn::instant(0.0, 0.0); unbalances.len()],
            unbalances,
            gravity,
            brake,
            levers,
            prescribed,
            force_q: weight.clone(),
            nodal_weight,
            weight,
            x: zeros.clone(),
            x_previous: zeros.clone(),
            beta: zero_nodes.clone(),
            psi_previous: zero_nodes.clone(),
            gyro_x: vec![0.0; 8 * rotor.gyro.len()],
            has_skew: rotor.bearings.iter().any(|b| b.skew != 0.0),
            d_nodal: zeros.clone(),
            v: zeros.clone(),
            a: zeros.clone(),
            force: zeros,
            d_psi: zero_nodes.clone(),
            v_psi: zero_nodes.clone(),
            a_psi: zero_nodes.clone(),
            torque: zero_nodes,
            torque_q: vec![0.0; twist_map.size()],
            lateral,
            twist,
        })
    }

    /// What depends on the place at n alone: angles of the unbalances, S_g x.
    fn refresh(&mut self) {
        for (site, angle) in self.unbalances.iter().zip(&mut self.angles) {
            *angle = libm::sincos(self.phi + self.beta[site.twist_node] + site.phase);
        }
        for (site, product) in self.rotor.gyro.iter().zip(self.gyro_x.chunks_exact_mut(8)) {
            product.fill(0.0);
            site.local_product(&self.x, product.try_into().expect("chunks of 8"));
        }
    }

    /// Begins the step from n at `time`.
    pub fn prepare(&mut self) {
        if self.has_skew {
            self.force.fill(0.0);
            for bearing in &self.rotor.bearings {
                let skew = bearing.skew_force(self.rotor.at(bearing.node, &self.x));
                self.rotor.add_at(bearing.node, skew, &mut self.force);
            }
            self.lateral_map.project(&self.force, &mut self.force_q);
            for (sum, weight) in self.force_q.iter_mut().zip(&self.weight) {
                *sum += weight;
            }
            self.lateral.prepare(Some(&self.force_q));
        } else {
            self.lateral.prepare(Some(&self.weight));
        }
        self.twist.prepare(None);
    }

    /// Forces at the increments `(d, d_twist)` and the increments that follow from them without contact.
    pub fn respond(&mut self, time: f64, d: &[f64], d_twist: &[f64], free: &mut [f64], free_twist: &mut [f64]) {
        self.evaluate(d, d_twist);
        self.lateral_map.project(&self.force, &mut self.force_q);
        self.twist_map.project(&self.torque, &mut self.torque_q);
        let torque = self.brake.torque(self.centred_spin(d_twist));
        for (sum, s) in self.torque_q.iter_mut().zip(&self.spin_row) {
            *sum += torque * s;
        }
        self.lateral.increment(Some(&self.force_q), free);
        self.twist.increment(Some(&self.torque_q), free_twist);
        self.brake.settle(&self.spin_row, dot(&self.spin_row, &self.twist.previous), free_twist);
        self.impose_speed(time, free_twist);
    }

    /// Turns the spin increment into that of the prescribed speed, where there is one.
    pub fn impose_speed(&mut self, time: f64, d_twist: &mut [f64]) {
        if let Some(prescribed) = &mut self.prescribed {
            let wanted = angle_of(&prescribed.law, time + self.dt) - angle_of(&prescribed.law, time);
            prescribed.torque = (wanted - dot(&self.spin_row, d_twist)) / prescribed.compliance;
            crate::linalg::axpy(prescribed.torque, &prescribed.direction, d_twist);
        }
    }

    /// Keeps the mean spin of a twist response to a torque at zero where the speed is prescribed; returns the drive torque
    /// that takes per unit.
    pub fn hold_speed(&self, response: &mut [f64]) -> f64 {
        match &self.prescribed {
            None => 0.0,
            Some(prescribed) => {
                let lever = -dot(&self.spin_row, response) / prescribed.compliance;
                crate::linalg::axpy(lever, &prescribed.direction, response);
                lever
            }
        }
    }

    /// Mean spin increment that the drive of a prescribed speed gives in a step [rad]: its torque converges with the forces,
    /// while the increment of the spin itself is prescribed and always converged.
    pub fn driven(&self) -> f64 {
        self.prescribed.as_ref().map_or(0.0, |prescribed| prescribed.torque * prescribed.compliance)
    }

    /// Adds the reaction of the drive to a contact torque.
    pub fn add_drive_torque(&mut self, torque: f64) {
        if let Some(prescribed) = &mut self.prescribed {
            prescribed.torque -= torque;
        }
    }

    /// Displacement of a node at n.
    pub fn place(&self, node: usize) -> [f64; 2] {
        self.rotor.at(node, &self.x)
    }

    /// Non-linear nodal forces and torques at increments.
    fn evaluate(&mut self, d: &[f64], d_twist: &[f64]) {
        self.lateral_map.expand(d, &mut self.d_nodal);
        self.twist_map.expand(d_twist, &mut self.d_psi);
        let (rate, square) = (0.5 / self.dt, 1.0 / (self.dt * self.dt));
        centred(&self.d_nodal, &self.x_previous, rate, square, &mut self.v, &mut self.a);
        centred(&self.d_psi, &self.psi_previous, rate, square, &mut self.v_psi, &mut self.a_psi);
        for (site, turn) in self.unbalances.iter().zip(&mut self.turns) {
            *turn = Turn::stepped(self.psi_previous[site.twist_node], self.d_psi[site.twist_node], self.dt);
        }
        self.forces();
    }

    /// Forces from v, a, v_psi, a_psi and the turns at the place n.
    fn forces(&mut self) {
        self.force.fill(0.0);
        self.torque.fill(0.0);
        for (site, product) in self.rotor.gyro.iter().zip(self.gyro_x.chunks_exact(8)) {
            let product: &[f64; 8] = product.try_into().expect("chunks of 8");
            let (spin, spin_dot) = (site.mean(&self.v_psi), site.mean(&self.a_psi));
            let torque = site.apply(spin, spin_dot, &self.v, &self.a, product, &mut self.force);
            site.spread(torque, &mut self.torque);
        }
        for ((site, &angle), turn) in self.unbalances.iter().zip(&self.angles).zip(&self.turns) {
            let force = site.force(angle, turn, self.rotor.at(site.node, &self.a), self.gravity);
            self.rotor.add_at(site.node, force.force, &mut self.force);
            self.torque[site.twist_node] += force.torque;
        }
    }

    /// Mean spin at n, centred \[rad/s\].
    pub fn centred_spin(&self, d_twist: &[f64]) -> f64 {
        (dot(&self.spin_row, d_twist) + dot(&self.spin_row, &self.twist.previous)) * 0.5 / self.dt
    }

    /// Mean spin over the step from n to n+1, which is that at n + 1/2 \[rad/s\].
    pub fn spin_over_step(&self, d_twist: &[f64]) -> f64 {
        self.brake.spin(dot(&self.spin_row, d_twist)) / self.dt
    }

    /// Mean spin at n+1 \[rad/s\]: that of the law where it is prescribed, otherwise from the last two steps, of second order and
    /// exact for a constant acceleration. `time` is that of n.
    pub fn spin_reached(&self, time: f64, d_twist: &[f64]) -> f64 {
        if let Some(prescribed) = &self.prescribed {
            return speed_of(&prescribed.law, time + self.dt);
        }
        let over_step = self.spin_over_step(d_twist);
        // a rotor at rest stays there
        if over_step == 0.0 {
            return 0.0;
        }
        over_step + 0.5 * (over_step - dot(&self.spin_row, &self.twist.previous) / self.dt)
    }

    /// Work of the braking torque over the step at n \[J\], <= 0.
    pub fn braking_work(&self, spin: f64) -> f64 {
        self.brake.acted(spin) * spin * self.dt
    }

    /// What an error of lateral increments is measured by: their size, but no less than rounding of the state and of the
    /// unbalances' turns (a rotor on stiff bearings moves far less than its unbalances do). After [`ShaftLine::respond`].
    pub fn lateral_scale(&self, increments: f64) -> f64 {
        let turns =
            self.unbalances.iter().zip(&self.levers).map(|(site, lever)| lever * self.d_psi[site.twist_node].abs());
        let least = TURNING * turns.sum::<f64>();
        (increments + RESTING * norm(&self.lateral.q)).max(least) + f64::MIN_POSITIVE
    }

    /// The same for twist increments; at rest they are nothing but rounding.
    pub fn twist_scale(&self) -> f64 {
        self.brake.scale()
    }

    /// Accepts the increments of the step; `evaluate` must have seen exactly them (see [`ShaftLine::settle`]).
    pub fn advance(&mut self, d: &[f64], d_twist: &[f64]) {
        let turn = dot(&self.spin_row, d_twist);
        self.lateral.advance(d);
        self.twist.advance(d_twist);
        for (q, rigid) in self.twist.q.iter_mut().zip(&self.rigid) {
            *q -= turn * rigid;
        }
        self.phi += turn;
        for (x, dx) in self.x.iter_mut().zip(&self.d_nodal) {
            *x += dx;
        }
        for (beta, d_psi) in self.beta.iter_mut().zip(&self.d_psi) {
            *beta += d_psi - turn;
        }
        self.x_previous.copy_from_slice(&self.d_nodal);
        self.psi_previous.copy_from_slice(&self.d_psi);
        self.refresh();
    }

    /// Nodal increments and centred velocities of the step that is about to be accepted.
    pub fn settle(&mut self, d: &[f64], d_twist: &[f64]) {
        self.lateral_map.expand(d, &mut self.d_nodal);
        self.twist_map.expand(d_twist, &mut self.d_psi);
        let (rate, square) = (0.5 / self.dt, 1.0 / (self.dt * self.dt));
        centred(&self.d_nodal, &self.x_previous, rate, square, &mut self.v, &mut self.a);
        centred(&self.d_psi, &self.psi_previous, rate, square, &mut self.v_psi, &mut self.a_psi);
    }

    /// Displacement and centred velocity of a node at n, after [`ShaftLine::settle`].
    pub fn node(&self, node: usize) -> ([f64; 2], [f64; 2]) {
        (self.rotor.at(node, &self.x), self.rotor.at(node, &self.v))
    }

    /// Weight of shaft, discs and unbalances at the nodes \[N\].
    pub fn nodal_weight(&self) -> Vec<f64> {
        self.nodal_weight.clone()
    }

    /// Adds the gyroscopic moments and the forces of the unbalances at n, their inertia included, to nodal forces; after
    /// [`ShaftLine::settle`].
    pub fn add_driving_forces(&self, force: &mut [f64]) {
        crate::linalg::axpy(1.0, &self.force, force);
        for site in &self.unbalances {
            let [ax, ay] = self.rotor.at(site.node, &self.a);
            self.rotor.add_at(site.node, [-site.mass * ax, -site.mass * ay], force);
        }
    }

    /// Centred nodal velocities at n, after [`ShaftLine::settle`].
    pub fn velocity(&self) -> &[f64] {
        &self.v
    }

    /// Gyroscopic, unbalance-coupling and gravity energies between n and n+1 \[J\], after [`ShaftLine::settle`], before
    /// [`ShaftLine::advance`].
    pub fn coupling_energies(&self, d: &[f64]) -> (f64, f64) {
        let dt = self.dt;
        let mut kinetic = 0.0;
        let middle: Vec<f64> = self.x.iter().zip(&self.d_nodal).map(|(x, dx)| x + 0.5 * dx).collect();
        for site in &self.rotor.gyro {
            kinetic += 0.5 * site.mean(&self.d_psi) * site.bilinear(&self.d_nodal, &middle) / (dt * dt);
        }
        let mut potential = 0.0;
        if self.gravity != [0.0; 2] {
            for i in 0..d.len() {
                potential -= self.weight[i] * (self.lateral.q[i] + 0.5 * d[i]);
            }
        }
        for (site, &angle) in self.unbalances.iter().zip(&self.angles) {
            let turn = self.d_psi[site.twist_node];
            kinetic += site.coupling_energy(angle, turn, self.rotor.at(site.node, &self.d_nodal), dt);
            potential += site.gravity_energy(angle, turn, self.gravity);
        }
        (kinetic, potential)
    }

    /// Rows of the lateral coordinates for a node's u and v, and of twist for its angle.
    pub fn rows(&self, node: usize) -> ([Vec<f64>; 2], Vec<f64>) {
        (self.rotor.plane_places(node).map(|dof| self.lateral_map.row(dof)), self.twist_map.row(node))
    }
}

/// Lateral mass matrix of a run in coordinates.
pub(crate) fn lateral_mass(machine: &Machine, structure: &Structure) -> Matrix {
    let unbalances: Vec<UnbalanceSite> = machine.rotor.unbalances.iter().map(UnbalanceSite::new).collect();
    masses(structure, &unbalances).0
}

/// Mass matrices of a run in coordinates: the structure's and the constant-coefficient terms of its unbalances.
fn masses(structure: &Structure, unbalances: &[UnbalanceSite]) -> (Matrix, Matrix) {
    let (mut lateral, mut twist) = (structure.lateral.mass.clone(), structure.twist.mass.clone());
    for site in unbalances {
        for dof in structure.rotor.plane_places(site.node) {
            add_outer(&mut lateral, site.mass, &structure.lateral.coordinates.row(dof));
        }
        add_outer(&mut twist, site.mass * site.radius * site.radius, &structure.twist.coordinates.row(site.twist_node));
    }
    (lateral, twist)
}

pub(crate) fn add_outer(matrix: &mut Matrix, factor: f64, row: &[f64]) {
    if factor == 0.0 {
        return;
    }
    for (j, b) in row.iter().enumerate() {
        for (i, a) in row.iter().enumerate() {
            matrix[(i, j)] += factor * a * b;
        }
    }
}

#[inline]
fn centred(d: &[f64], previous: &[f64], rate: f64, square: f64, v: &mut [f64], a: &mut [f64]) {
    for i in 0..d.len() {
        v[i] = (d[i] + previous[i]) * rate;
        a[i] = (d[i] - previous[i]) * square;
    }
}

pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (x, y) in a.iter().zip(b) {
        sum += (x - y) * (x - y);
    }
    sum.sqrt()
}

pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
#[path = "lagrangian_tests.rs"]
mod lagrangian_tests;
