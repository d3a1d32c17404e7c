//! Candidate places of contact: fixed angles of a ring, so close that the force may pass from one to the next.
//!
//! ```text
//! P_c = (R_i + v_c) e_r + u_c e_theta,   (v_c, u_c) = sum_j (V_cj, U_cj) q_j            g_c = |P_c - x| - R_r                  (1)
//! ```
//! With g >= 0 at all of them nothing has to be searched: no closest point, no place that jumps, no fixed point. Where they are looked for is [`super::survey`].
//! Source: the conditions of docs/theory/03-contact.md at fixed angles (collocation). Verified by `tests/exponential_rub.rs`.

use super::bound::length;
use crate::linalg::{Matrix, dot};
use crate::stator::Surface;
use crate::structure::RingPart;

/// Candidates of a block: their number is a multiple of it.
pub(super) const BLOCK: usize = 4;

/// The candidates of one ring.
#[derive(Debug, Clone)]
pub(super) struct Candidates {
    /// From one to the next \[rad\].
    pub spacing: f64,
    /// sin and cos of their angles.
    pub angles: Vec<(f64, f64)>,
    /// V and then U of each, by modes.
    shapes: Vec<f64>,
    modes: usize,
    /// Largest displacement of any candidate per amplitude, for each mode; its radial part; and the most that its radial part is from the straight line
    /// between the ends of a block.
    reach: Vec<f64>,
    pub radial_reach: Vec<f64>,
    pub bend: Vec<f64>,
    /// Displacements per impulse of the modes left out between two candidates: radial and tangential, by rows; empty where none are.
    left_out: Vec<[f64; 4]>,
}

impl Candidates {
    /// So many of each element, a multiple of [`BLOCK`]; the modes left out follow impulses over `h` \[s\].
    pub fn new(part: &RingPart, surface: &Surface, per_element: usize, h: f64) -> Self {
        let places: Vec<(usize, f64)> = (0..surface.nodes * per_element)
            .map(|c| (c / per_element, ((c % per_element) as f64 + 0.5) / per_element as f64))
            .collect();
        let modes = part.part.coordinates.size();
        let count = places.len();
        let mut shapes = vec![0.0; 2 * count * modes];
        for (&(element, xi), rows) in places.iter().zip(shapes.chunks_exact_mut(2 * modes)) {
            let (v, u) = rows.split_at_mut(modes);
            for (dof, radial, tangential) in surface.shapes(element, xi) {
                part.part.coordinates.add_row(dof, radial, v);
                part.part.coordinates.add_row(dof, tangential, u);
            }
        }
        let at = |c: usize, j: usize| [shapes[2 * c * modes + j], shapes[(2 * c + 1) * modes + j]];
        let most = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..modes).map(|j| (0..count).map(|c| of(c, j)).fold(0.0, f64::max)).collect()
        };
        let bend = |c: usize, j: usize| {
            let (first, share) = (c - c % BLOCK, (c % BLOCK) as f64 / BLOCK as f64);
            let ends = [at(first, j)[0], at((first + BLOCK) % count, j)[0]];
            (at(c, j)[0] - ends[0] * (1.0 - share) - ends[1] * share).abs()
        };
        let (reach, radial_reach) = (most(&|c, j| length(at(c, j))), most(&|c, j| at(c, j)[0].abs()));
        let bend = most(&bend);
        let left_out = part.residual.as_ref().map(|flexibility| {
            let mut loads = Matrix::zeros(flexibility.nrows(), 2 * count);
            for (c, &(element, xi)) in places.iter().enumerate() {
                for (dof, radial, tangential) in surface.shapes(element, xi) {
                    loads[(dof, 2 * c)] += radial;
                    loads[(dof, 2 * c + 1)] += tangential;
                }
            }
            squares(&(crate::linalg::project(flexibility, &loads) / h))
        });
        Self {
            spacing: 2.0 * std::f64::consts::PI / count as f64,
            angles: places.iter().map(|&(element, xi)| libm::sincos(surface.angle(element, xi))).collect(),
            left_out: left_out.unwrap_or_default(),
            shapes,
            modes,
            reach,
            radial_reach,
            bend,
        }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.angles.len()
    }

    /// Bound of every candidate's displacement \[m\], of the modes' amplitudes.
    pub fn reach(&self, amplitudes: impl Iterator<Item = f64>) -> f64 {
        self.reach.iter().zip(amplitudes).map(|(reach, amplitude)| reach * amplitude).sum()
    }

    /// V and U of a candidate.
    fn rows(&self, c: usize) -> (&[f64], &[f64]) {
        self.shapes[2 * c * self.modes..2 * (c + 1) * self.modes].split_at(self.modes)
    }

    /// Radial displacement of a candidate.
    pub fn radial(&self, c: usize, q: &[f64]) -> f64 {
        dot(self.rows(c).0, q)
    }

    /// Displacement of a candidate, radial and tangential.
    pub fn displacement(&self, c: usize, q: &[f64]) -> [f64; 2] {
        let (v, u) = self.rows(c);
        [dot(v, q), dot(u, q)]
    }

    /// From the rotor at x to a candidate on this radius R_i displaced by (v, u), in the candidate's polar axes.
    pub fn distance(&self, c: usize, radius: f64, [v, u]: [f64; 2], x: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angles[c];
        [radius + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])]
    }

    /// Rows of the place `share` of a spacing beyond a candidate, along two directions of its polar axes: by the parabola through the candidate and those beside it.
    pub fn rows_at(&self, c: usize, share: f64, directions: [[f64; 2]; 2], rows: [&mut [f64]; 2]) {
        let (weights, beside) = (parabola(share), self.beside(c));
        let ([normal, tangent], [[np, nq], [tp, tq]]) = (rows, directions);
        let [(va, ua), (vb, ub), (vc, uc)] = [self.rows(beside[0]), self.rows(c), self.rows(beside[1])];
        for j in 0..self.modes {
            let v = weights[0] * va[j] + weights[1] * vb[j] + weights[2] * vc[j];
            let u = weights[0] * ua[j] + weights[1] * ub[j] + weights[2] * uc[j];
            normal[j] = np * v + nq * u;
            tangent[j] = tp * v + tq * u;
        }
    }

    /// The candidates beside one.
    pub fn beside(&self, c: usize) -> [usize; 2] {
        let count = self.count();
        [if c == 0 { count - 1 } else { c - 1 }, if c + 1 == count { 0 } else { c + 1 }]
    }

    /// Displacement of a candidate by a unit impulse at another in the modes left out, in polar axes.
    pub fn left_out(&self, at: usize, acting: usize) -> &[f64; 4] {
        self.left_out.get(at * self.count() + acting).unwrap_or(&[0.0; 4])
    }
}

/// Weights of three values at -1, 0 and 1 for the value of their parabola.
pub(super) fn parabola(share: f64) -> [f64; 3] {
    [0.5 * share * (share - 1.0), 1.0 - share * share, 0.5 * share * (share + 1.0)]
}

/// Its 2 x 2 blocks, row by row of blocks, each by rows.
fn squares(matrix: &Matrix) -> Vec<[f64; 4]> {
    let count = matrix.nrows() / 2;
    let block = |place: usize| {
        let (i, j) = (2 * (place / count), 2 * (place % count));
        [matrix[(i, j)], matrix[(i, j + 1)], matrix[(i + 1, j)], matrix[(i + 1, j + 1)]]
    };
    (0..count * count).map(block).collect()
}
