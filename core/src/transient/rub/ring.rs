//! The flexible ring of a diaphragm under way.

use crate::contact::{Detector, Gap, Place};
use crate::linalg::{Matrix, axpy};
use crate::stator::Surface;
use crate::structure::{Coordinates, RingPart};
use crate::transient::stepper::Stepper;

/// The flexible ring of a diaphragm.
pub(super) struct Ring<'a> {
    pub coordinates: &'a Coordinates,
    pub stepper: Stepper,
    pub detector: Detector,
    /// Increment without contact, current increment.
    pub free: Vec<f64>,
    pub d: Vec<f64>,
    pub field: Vec<f64>,
    pub scratch: Vec<f64>,
    /// Static flexibility of the modes left out, and their nodal displacement under the forces of the step.
    pub residual: Option<&'a Matrix>,
    pub left_out: Vec<f64>,
    /// The same under the forces of the step before.
    pub left_out_before: Vec<f64>,
    /// Bound of |v| per unit of each coordinate.
    pub radial_bound: Vec<f64>,
    pub normal: RingForce,
    pub tangent: RingForce,
    pub gap_row: Vec<f64>,
    /// Something has touched it: before that its increments are exactly zero and cost nothing.
    pub moving: bool,
}

/// Generalised force of a unit force on the ring and its response A^-1.
#[derive(Default)]
pub(super) struct RingForce {
    pub force: Vec<f64>,
    pub response: Vec<f64>,
}

impl<'a> Ring<'a> {
    pub fn new(part: &'a RingPart, surface: Surface, dt: f64) -> Option<Self> {
        let coordinates = &part.part.coordinates;
        let size = coordinates.size();
        let zeros = || vec![0.0; size];
        let nodal = 4 * part.matrices.nodes;
        // |v| along an element stays below its nodal values plus the slopes' bulge of L/4 each side
        let arc = 2.0 * std::f64::consts::PI * part.matrices.mean_radius / part.matrices.nodes as f64;
        let mut radial_bound = zeros();
        for node in 0..part.matrices.nodes {
            let (value, slope) = (coordinates.row(4 * node + 2), coordinates.row(4 * node + 3));
            for k in 0..size {
                radial_bound[k] = f64::max(radial_bound[k], value[k].abs() + 0.25 * arc * slope[k].abs());
            }
        }
        Some(Self {
            coordinates,
            stepper: Stepper::new(&part.part, &part.part.mass, dt)?,
            detector: Detector::new(surface),
            free: zeros(),
            d: zeros(),
            field: vec![0.0; nodal],
            scratch: zeros(),
            residual: part.residual.as_ref(),
            left_out: vec![0.0; nodal],
            left_out_before: vec![0.0; nodal],
            radial_bound,
            normal: RingForce { force: zeros(), response: zeros() },
            tangent: RingForce { force: zeros(), response: zeros() },
            gap_row: zeros(),
            moving: false,
        })
    }

    pub fn prepare(&mut self) {
        if self.moving {
            self.stepper.prepare(None);
            self.stepper.increment(None, &mut self.free);
        }
        self.d.copy_from_slice(&self.free);
    }

    /// Nodal field of the ring at n+1 with the current increment, the modes left out included.
    pub fn refresh_field(&mut self) {
        for i in 0..self.d.len() {
            self.scratch[i] = self.stepper.q[i] + self.d[i];
        }
        self.coordinates.expand_head(&self.scratch, &mut self.field);
        self.add_left_out(false);
    }

    /// Nodal field of the ring at n, the modes left out included: under the forces that led there, of the step before.
    pub fn field_at_n(&mut self) {
        self.coordinates.expand_head(&self.stepper.q, &mut self.field);
        self.add_left_out(true);
    }

    fn add_left_out(&mut self, before: bool) {
        if self.residual.is_some() {
            let left_out = if before { &self.left_out_before } else { &self.left_out };
            axpy(1.0, left_out, &mut self.field);
        }
    }

    /// Upper bound of |v| at n+1.
    pub fn radial_reach(&self) -> f64 {
        let mut reach = 0.0;
        for i in 0..self.d.len() {
            reach += self.radial_bound[i] * (self.stepper.q[i] + self.d[i]).abs();
        }
        reach
    }

    /// Row of a unit force at a place and its response A^-1.
    pub fn load(&self, place: Place, [radial, tangential]: [f64; 2], surface: &Surface, target: &mut RingForce) {
        target.force.fill(0.0);
        for (dof, r, t) in surface.shapes(place.element, place.xi) {
            self.coordinates.add_row(dof, radial * r + tangential * t, &mut target.force);
        }
        self.stepper.compliance(&target.force, &mut target.response);
    }

    pub fn load_gap_row(&mut self, gap: &Gap, surface: &Surface) {
        self.gap_row.fill(0.0);
        let [radial, tangential] = gap.ring_gradient;
        for (dof, r, t) in surface.shapes(gap.place.element, gap.place.xi) {
            self.coordinates.add_row(dof, radial * r + tangential * t, &mut self.gap_row);
        }
    }
}
