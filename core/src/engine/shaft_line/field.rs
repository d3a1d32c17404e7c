//! A displacement field during a run: coordinates by central differences, and the resulting motion of the nodes.

use super::stepper::Stepper;
use crate::structure::{Coordinates, Part};
use bladeoff_numerics::linalg::Matrix;

/// Lateral displacements or torsion of the shaft line.
#[derive(Debug, Clone)]
pub(crate) struct Field<'a> {
    map: &'a Coordinates,
    /// Coordinates q and their increments.
    pub stepper: Stepper,
    /// x at n, at the nodes; torsion is relative to the mean spin angle.
    pub x: Vec<f64>,
    /// x(n) - x(n-1) at the nodes; torsion absolute.
    pub previous: Vec<f64>,
    /// Increment d = x(n+1) - x(n), centred velocity v and acceleration a at n, at the nodes.
    pub d: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Non-linear forces on the nodes, and generalised forces on the coordinates.
    pub force: Vec<f64>,
    pub force_q: Vec<f64>,
}

impl<'a> Field<'a> {
    /// Field at rest; `mass` as for [`Stepper::new`]. `None` if the operator of the step is singular.
    pub fn new(part: &'a Part, mass: &Matrix, dt: f64) -> Option<Self> {
        let map = &part.coordinates;
        let zeros = vec![0.0; map.nodal_size()];
        Some(Self {
            map,
            stepper: Stepper::new(part, mass, dt)?,
            x: zeros.clone(),
            previous: zeros.clone(),
            d: zeros.clone(),
            v: zeros.clone(),
            a: zeros.clone(),
            force: zeros,
            force_q: vec![0.0; map.size()],
        })
    }

    /// Copies the state of another field at n; `change` is added to the increments of the previous step.
    pub fn take_over(&mut self, other: &Self, change: &[f64]) {
        self.stepper.q.copy_from_slice(&other.stepper.q);
        self.x.copy_from_slice(&other.x);
        let previous: Vec<f64> = other.stepper.previous.iter().zip(change).map(|(d, change)| d + change).collect();
        self.come_from(&previous);
    }

    /// Number of coordinates.
    pub fn size(&self) -> usize {
        self.map.size()
    }

    /// Row Phi[dof, :] of a nodal degree of freedom.
    pub fn row(&self, dof: usize) -> Vec<f64> {
        self.map.row(dof)
    }

    /// Computes increments, centred velocities and accelerations of the nodes from increments of the coordinates.
    pub fn see(&mut self, increments: &[f64]) {
        self.map.expand(increments, &mut self.d);
        let dt = self.stepper.dt;
        let (rate, square) = (0.5 / dt, 1.0 / (dt * dt));
        centred(&self.d, &self.previous, rate, square, &mut self.v, &mut self.a);
    }

    /// Projects the nodal forces on the coordinates.
    pub fn project(&mut self) {
        self.map.project(&self.force, &mut self.force_q);
    }

    /// Increments under the generalised forces.
    pub fn respond(&mut self, out: &mut [f64]) {
        self.stepper.increment(Some(&self.force_q), out);
    }

    /// Sets x at n from coordinates.
    pub fn put(&mut self, q: &[f64]) {
        self.map.expand(q, &mut self.x);
    }

    /// Sets the nodal velocities from those of the coordinates.
    pub fn speed(&mut self, v: &[f64]) {
        self.map.expand(v, &mut self.v);
    }

    /// Sets the nodal accelerations from those of the coordinates.
    pub fn accelerate(&mut self, a: &[f64]) {
        self.map.expand(a, &mut self.a);
    }

    /// Replaces the increments of the previous step.
    pub fn come_from(&mut self, previous: &[f64]) {
        self.stepper.previous.copy_from_slice(previous);
        self.map.expand(previous, &mut self.previous);
    }
}

#[inline]
fn centred(d: &[f64], previous: &[f64], rate: f64, square: f64, v: &mut [f64], a: &mut [f64]) {
    for i in 0..d.len() {
        v[i] = (d[i] + previous[i]) * rate;
        a[i] = (d[i] - previous[i]) * square;
    }
}
