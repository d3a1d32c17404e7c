//! A displacement field under way: coordinates by central differences, and the motion of the nodes that follows from them.

use super::stepper::Stepper;
use crate::structure::{Coordinates, Part};
use bladeoff_numerics::linalg::Matrix;

/// The lateral displacements, or the twist, of the shaft line.
#[derive(Debug, Clone)]
pub(crate) struct Field<'a> {
    map: &'a Coordinates,
    pub stepper: Stepper,
    /// x at n, at the nodes; the twist's is relative to the mean spin angle.
    pub x: Vec<f64>,
    /// x(n) - x(n-1), absolute.
    pub previous: Vec<f64>,
    /// Increment, centred velocity and acceleration at n, of the increments seen last.
    pub d: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Non-linear forces at the nodes, and in coordinates.
    pub force: Vec<f64>,
    pub force_q: Vec<f64>,
}

impl<'a> Field<'a> {
    /// A field at rest; `mass` as for [`Stepper::new`]. `None` if it is singular.
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

    /// Takes the place of another field at n, with a change of the increments of the step before.
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

    /// Coordinates of a nodal freedom.
    pub fn row(&self, dof: usize) -> Vec<f64> {
        self.map.row(dof)
    }

    /// Sees increments: those of the nodes, centred velocities and accelerations.
    pub fn see(&mut self, increments: &[f64]) {
        self.map.expand(increments, &mut self.d);
        let dt = self.stepper.dt;
        let (rate, square) = (0.5 / dt, 1.0 / (dt * dt));
        centred(&self.d, &self.previous, rate, square, &mut self.v, &mut self.a);
    }

    /// The nodal forces in coordinates.
    pub fn project(&mut self) {
        self.map.project(&self.force, &mut self.force_q);
    }

    /// Increments under the forces in coordinates.
    pub fn respond(&mut self, out: &mut [f64]) {
        self.stepper.increment(Some(&self.force_q), out);
    }

    /// Sets the place at n from coordinates.
    pub fn put(&mut self, q: &[f64]) {
        self.map.expand(q, &mut self.x);
    }

    /// Sets the velocities of the nodes from those of coordinates.
    pub fn speed(&mut self, v: &[f64]) {
        self.map.expand(v, &mut self.v);
    }

    /// Sets the accelerations of the nodes from those of coordinates.
    pub fn accelerate(&mut self, a: &[f64]) {
        self.map.expand(a, &mut self.a);
    }

    /// Replaces the increments of the step before.
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
