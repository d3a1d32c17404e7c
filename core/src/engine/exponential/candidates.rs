//! Candidate places of contact: fixed angles of a ring, so close that the force may pass from one to the next.
//!
//! ```text
//! P_c = (R_i + v_c) e_r + u_c e_theta,   (v_c, u_c) = sum_j (V_cj, U_cj) q_j            g_c = |P_c - x| - R_r                  (1)
//! ```
//! With g >= 0 at all of them nothing has to be searched: no closest point, no place that jumps, no fixed point. Between two at a distance d the
//! rotor's circle comes nearer by `|x| d^2/8` (turbine, four to an element: 1 um of a gap of 8 mm).
//! Source: the conditions of docs/theory/03-contact.md at fixed angles (collocation). Verified by `tests/exponential_rub.rs`.

use super::bound::length;
use crate::linalg::{Matrix, dot};
use crate::stator::Surface;
use crate::structure::RingPart;

/// The candidates of one ring.
#[derive(Debug, Clone)]
pub(super) struct Candidates {
    /// R_i and R_r \[m\].
    radius: f64,
    rotor_radius: f64,
    /// sin and cos of their angles.
    pub angles: Vec<(f64, f64)>,
    /// V and U of each, by modes.
    shapes: Vec<[Vec<f64>; 2]>,
    /// Largest displacement of any candidate per amplitude, for each mode.
    reach: Vec<f64>,
    /// Static flexibility of the modes left out between radial and tangential displacements, candidate by candidate.
    pub left_out: Option<Matrix>,
}

/// The gap at a candidate.
#[derive(Debug, Clone, Copy)]
pub(super) struct CandidateGap {
    pub index: usize,
    pub value: f64,
    /// From the rotor to the ring, in the candidate's polar axes and in the stator's.
    pub polar: [f64; 2],
    pub normal: [f64; 2],
}

impl Candidates {
    /// So many of each element.
    pub fn new(part: &RingPart, surface: &Surface, rotor_radius: f64, per_element: usize) -> Self {
        let nodal: Vec<(usize, f64)> = (0..surface.nodes * per_element)
            .map(|c| (c / per_element, ((c % per_element) as f64 + 0.5) / per_element as f64))
            .collect();
        let shape = |&(element, xi): &(usize, f64)| {
            let mut row = [vec![0.0; part.part.coordinates.size()], vec![0.0; part.part.coordinates.size()]];
            for (dof, radial, tangential) in surface.shapes(element, xi) {
                part.part.coordinates.add_row(dof, radial, &mut row[0]);
                part.part.coordinates.add_row(dof, tangential, &mut row[1]);
            }
            row
        };
        let shapes: Vec<[Vec<f64>; 2]> = nodal.iter().map(shape).collect();
        let largest = |j: usize| shapes.iter().map(|row| length([row[0][j], row[1][j]])).fold(0.0, f64::max);
        let left_out = part.residual.as_ref().map(|flexibility| {
            let mut loads = Matrix::zeros(flexibility.nrows(), 2 * nodal.len());
            for (c, &(element, xi)) in nodal.iter().enumerate() {
                for (dof, radial, tangential) in surface.shapes(element, xi) {
                    loads[(dof, 2 * c)] += radial;
                    loads[(dof, 2 * c + 1)] += tangential;
                }
            }
            crate::linalg::project(flexibility, &loads)
        });
        Self {
            radius: surface.radius,
            rotor_radius,
            angles: nodal.iter().map(|&(element, xi)| libm::sincos(surface.angle(element, xi))).collect(),
            reach: (0..part.part.coordinates.size()).map(largest).collect(),
            shapes,
            left_out,
        }
    }

    /// Bound of every candidate's displacement \[m\], of the modes' amplitudes.
    pub fn reach(&self, amplitudes: impl Iterator<Item = f64>) -> f64 {
        self.reach.iter().zip(amplitudes).map(|(reach, amplitude)| reach * amplitude).sum()
    }

    /// Candidates that may be within the rotor at x when the ring moves by no more than `reach`.
    pub fn near(&self, x: [f64; 2], reach: f64, found: &mut Vec<usize>) {
        found.clear();
        let room = self.radius - self.rotor_radius - reach;
        // |R_i e_r - x| >= R_i - x.e_r
        found.extend((0..self.angles.len()).filter(|&c| {
            let (sin, cos) = self.angles[c];
            x[0] * cos + x[1] * sin >= room
        }));
    }

    /// Displacement of a candidate, radial and tangential.
    pub fn displacement(&self, c: usize, q: &[f64]) -> [f64; 2] {
        [dot(&self.shapes[c][0], q), dot(&self.shapes[c][1], q)]
    }

    /// Adds a polar force at a candidate to those of the modes.
    pub fn add_force(&self, c: usize, [radial, tangential]: [f64; 2], force: &mut [f64]) {
        crate::linalg::axpy(radial, &self.shapes[c][0], force);
        crate::linalg::axpy(tangential, &self.shapes[c][1], force);
    }

    /// (1).
    pub fn gap(&self, c: usize, [v, u]: [f64; 2], x: [f64; 2]) -> CandidateGap {
        let (sin, cos) = self.angles[c];
        let d = [self.radius + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])];
        let distance = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let polar = [d[0] / distance, d[1] / distance];
        let normal = [cos * polar[0] - sin * polar[1], sin * polar[0] + cos * polar[1]];
        CandidateGap { index: c, value: distance - self.rotor_radius, polar, normal }
    }

    /// Displacements per unit forces of modes of these yields, radial and tangential, candidate by candidate.
    pub fn yielding(&self, yields: &[f64]) -> Matrix {
        let count = 2 * self.shapes.len();
        let rows = Matrix::from_fn(yields.len(), count, |j, i| self.shapes[i / 2][i % 2][j]);
        let mut scaled = rows.clone();
        for (mut row, factor) in scaled.row_iter_mut().zip(yields) {
            row.scale_mut(*factor);
        }
        crate::linalg::mul_tn(&rows, &scaled)
    }
}
