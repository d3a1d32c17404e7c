//! Static flexibility of the truncated modes at the contact (`docs/theory/05-reduction.md`).
//!
//! Ring and rotor displacements at the contact are those of the kept modes plus the static displacement of the truncated modes under the normal
//! forces of the step. Place, normal and gap of a contact are computed from this total displacement. With a place from the kept modes alone, the
//! force would not be normal to the surface that it acts on, and would do work.

use super::axes::{Axes, bilinear, directions};
use crate::contact::{ContactReaction, Gap};
use crate::stator::{NodalForces, Surface};
use crate::stress::ForceAverage;
use crate::structure::{RingPart, Structure};
use bladeoff_numerics::linalg::{Matrix, axpy, column_of};

/// Static displacement of the truncated modes at one diaphragm.
pub(super) struct LeftOut<'a> {
    /// Flexibility R of the rotor at its node, in the stator's frame \[m/N\].
    rotor: [[f64; 2]; 2],
    /// Displacement of the rotor node under the forces of the step \[m\].
    pub shift: [f64; 2],
    /// Displacement of the rotor node under the forces of the previous step \[m\], which led to the position at n.
    pub shift_before: [f64; 2],
    /// Truncated modes of the ring; `None` without a flexible ring or without static correction.
    ring: Option<LeftOutOfRing<'a>>,
    /// Strain energy in this flexibility, at this step and the previous one \[J\].
    pub held: f64,
    pub held_before: f64,
}

/// Truncated modes of a flexible ring.
struct LeftOutOfRing<'a> {
    /// Flexibility of the ring's degrees of freedom (DOFs) \[m/N\].
    flexibility: &'a Matrix,
    /// Displacements of the DOFs under the forces of the step.
    shift: Vec<f64>,
    /// Displacements of the DOFs under the forces of the previous step.
    shift_before: Vec<f64>,
    /// Contact forces of the step, friction included \[N\].
    forces: NodalForces,
    /// Mean of the contact forces.
    mean: ForceAverage,
}

impl<'a> LeftOut<'a> {
    /// Truncated modes at a node and a ring; zero flexibility if no mode is truncated.
    pub fn new(structure: &'a Structure, node: usize, axes: &Axes, ring: Option<&'a RingPart>, dt: f64) -> Self {
        let of_ring = |(ring, flexibility): (&'a RingPart, &'a Matrix)| {
            let still = vec![0.0; flexibility.nrows()];
            LeftOutOfRing {
                flexibility,
                shift: still.clone(),
                shift_before: still,
                forces: NodalForces::none(),
                mean: ForceAverage::new(ring, dt),
            }
        };
        Self {
            rotor: of_rotor(structure, node, axes),
            shift: [0.0; 2],
            shift_before: [0.0; 2],
            ring: ring.and_then(|ring| Some((ring, ring.residual.as_ref()?))).map(of_ring),
            held: 0.0,
            held_before: 0.0,
        }
    }

    /// Begins a step without force.
    pub fn prepare(&mut self) {
        (self.held_before, self.held) = (self.held, 0.0);
        self.shift_before = self.shift;
        if let Some(ring) = &mut self.ring {
            std::mem::swap(&mut ring.shift, &mut ring.shift_before);
        }
        self.spring_back();
    }

    /// Returns to the beginning of the step, before another [`LeftOut::prepare`].
    pub fn begin_again(&mut self) {
        (self.held, self.shift) = (self.held_before, self.shift_before);
        if let Some(ring) = &mut self.ring {
            std::mem::swap(&mut ring.shift, &mut ring.shift_before);
        }
    }

    /// Gap at the place `at` due to a unit normal force at the place `acting` \[m/N\].
    ///
    /// This flexibility is symmetric, so the stored energy is a potential. The gap due to a friction force is neglected together with its
    /// counterpart, the slip due to a normal force. At a single point both vanish by mirror symmetry at blades and half-way between them. One without
    /// the other would supply or remove energy in every cycle of the two forces.
    pub fn between(&self, surface: &Surface, at: &Gap, acting: &Gap) -> f64 {
        let (here, _) = directions(at);
        let (there, _) = directions(acting);
        let mut sum = bilinear(&self.rotor, here, there);
        if let Some(ring) = &self.ring {
            let ([h_r, h_t], [n_r, n_t]) = (at.normal, acting.normal);
            let shapes = surface.shapes(acting.place.element, acting.place.xi);
            for (i, r_i, t_i) in surface.shapes(at.place.element, at.place.xi) {
                let row = h_r * r_i + h_t * t_i;
                for (j, r_j, t_j) in shapes {
                    sum += row * ring.flexibility[(i, j)] * (n_r * r_j + n_t * t_j);
                }
            }
        }
        sum
    }

    /// Resets displacements and forces to zero.
    pub fn spring_back(&mut self) {
        self.shift = [0.0; 2];
        if let Some(ring) = &mut self.ring {
            ring.shift.fill(0.0);
            ring.forces.clear();
        }
    }

    /// Adds a contact force at a place. The displacements follow its normal part.
    pub fn give_way(&mut self, surface: &Surface, acting: &Gap, force: &ContactReaction) {
        let ((n, _), normal) = (directions(acting), force.normal);
        for axis in 0..2 {
            self.shift[axis] -= normal * (self.rotor[axis][0] * n[0] + self.rotor[axis][1] * n[1]);
        }
        if let Some(ring) = &mut self.ring {
            let [n_r, n_t] = acting.normal;
            for (dof, r, t) in surface.shapes(acting.place.element, acting.place.xi) {
                axpy(normal * (n_r * r + n_t * t), column_of(ring.flexibility, dof), &mut ring.shift);
            }
            let parts = [normal * n_r - force.tangential * n_t, normal * n_t + force.tangential * n_r];
            ring.forces.add_at(surface, (acting.place.element, acting.place.xi), parts);
        }
    }

    /// Nodal displacement of the ring under the forces of the step; `None` without truncated modes of a ring.
    pub fn of_ring(&self) -> Option<&[f64]> {
        self.ring.as_ref().map(|ring| ring.shift.as_slice())
    }

    /// Adds the contact forces of the step, friction included, to their mean. Called once per step.
    pub fn average_forces(&mut self) {
        if let Some(ring) = &mut self.ring {
            ring.mean.take(&ring.forces);
            ring.mean.update();
        }
    }

    /// Mean of the contact forces on the ring \[N\]; `None` if no mode of the ring is truncated.
    pub fn mean_forces(&self) -> Option<&NodalForces> {
        self.ring.as_ref().map(|ring| ring.mean.mean())
    }

    /// Nodal displacement of the ring under the forces of the previous step.
    pub fn of_ring_before(&self) -> Option<&[f64]> {
        self.ring.as_ref().map(|ring| ring.shift_before.as_slice())
    }
}

/// Flexibility of the rotor at a node, in the stator's frame \[m/N\].
fn of_rotor(structure: &Structure, node: usize, axes: &Axes) -> [[f64; 2]; 2] {
    let Some(all) = &structure.lateral_residual else { return [[0.0; 2]; 2] };
    let places = structure.rotor.plane_places(node);
    let unit = axes.unit();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let mut sum = 0.0;
            for (a, &row) in places.iter().enumerate() {
                for (b, &col) in places.iter().enumerate() {
                    sum += unit[i][a] * all[(row, col)] * unit[j][b];
                }
            }
            sum
        })
    })
}
