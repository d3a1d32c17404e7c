//! Stresses at many places of a ring, as rows on its coordinates, and the largest among them.
//!
//! ```text
//! sigma_i = sum_j r_ij q_j,    |sigma_i| <= sum over pairs (j, k) of s_jk sqrt(q_j^2 + q_k^2),    s_jk = max_i sqrt(r_ij^2 + r_ik^2)     (1)
//! ```
//! The two modes of one frequency are a pair: a wave that turns around the ring has a constant amplitude. The bound (1) is then close to the stress at
//! a single load, where all waves add. A coordinate without a partner is its own pair.
//! Verified by `the_largest_size_is_found_with_its_place`, `no_stress_exceeds_its_bound`.

use crate::linalg::eight::dots;
use crate::linalg::lanes::{LANES, Lane};
use crate::linalg::{Csr, Matrix};
use crate::structure::Part;

/// The bound with room for the rounding of its sum.
const ROUNDED_UP: f64 = 1.0 + 1e-12;

/// Coordinates of a ring in pairs of one frequency; a single one is its own partner.
#[derive(Debug, Clone)]
pub(super) struct Pairs(Vec<[usize; 2]>);

impl Pairs {
    /// Of the coordinates of a part: two neighbouring modes of one frequency are a pair.
    pub fn of(part: &Part) -> Self {
        let size = part.coordinates.size();
        let square = |j: usize| part.stiffness[(j, j)];
        let (mut pairs, mut j) = (Vec::with_capacity(size), 0);
        while j < size {
            let two = part.modal && j + 1 < size && (square(j + 1) - square(j)).abs() <= 1e-9 * square(j).abs();
            pairs.push([j, j + usize::from(two)]);
            j += 1 + usize::from(two);
        }
        Self(pairs)
    }

    /// Amplitude of each pair.
    pub fn amplitudes(&self, q: &[f64], amplitudes: &mut Vec<f64>) {
        amplitudes.clear();
        amplitudes.extend(self.0.iter().map(|&[j, k]| if j == k { q[j].abs() } else { length(q[j], q[k]) }));
    }

    /// s of (1), of columns of rows: one row per coordinate, one column per place.
    fn largest(&self, columns: &Matrix) -> Vec<f64> {
        let most = |&[j, k]: &[usize; 2]| {
            let size = |i: usize| if j == k { columns[(j, i)].abs() } else { length(columns[(j, i)], columns[(k, i)]) };
            (0..columns.ncols()).map(size).fold(0.0, f64::max)
        };
        self.0.iter().map(|pair| ROUNDED_UP * most(pair)).collect()
    }
}

/// Stresses of some places.
#[derive(Debug, Clone)]
pub(super) struct Fibres {
    rows: Rows,
    /// s of (1).
    largest: Vec<f64>,
}

/// Stress per unit coordinate, one row per place: a few entries over nodal freedoms, all of them over modes.
#[derive(Debug, Clone)]
enum Rows {
    Nodal(Csr),
    /// Of eight places at a time, zeros behind the last.
    Modal(Vec<Vec<Lane>>),
}

impl Fibres {
    /// Of columns: one row per coordinate, one column per place; `modal`: coordinates are modes, all of which reach every place.
    pub fn new(columns: &Matrix, pairs: &Pairs, modal: bool) -> Self {
        let rows = if modal {
            Rows::Modal((0..columns.ncols()).step_by(LANES).map(|first| eight(columns, first)).collect())
        } else {
            Rows::Nodal(Csr::from_dense(&columns.transpose()))
        };
        Self { rows, largest: pairs.largest(columns) }
    }

    /// No size of a stress is above this \[Pa\], of amplitudes by [`Pairs::amplitudes`]; a NaN, which ends the run anyway, is passed on.
    pub fn bound(&self, amplitudes: &[f64]) -> f64 {
        let (most, sizes) = (self.largest.as_chunks::<4>(), amplitudes.as_chunks::<4>());
        let mut lanes = [0.0; 4];
        for (most, sizes) in most.0.iter().zip(sizes.0) {
            for k in 0..4 {
                lanes[k] += most[k] * sizes[k];
            }
        }
        let rest: f64 = most.1.iter().zip(sizes.1).map(|(most, size)| most * size).sum();
        ROUNDED_UP * (lanes.iter().sum::<f64>() + rest)
    }

    /// Largest size of all stresses \[Pa\].
    pub fn largest(&self, q: &[f64]) -> f64 {
        match &self.rows {
            Rows::Nodal(rows) => rows.largest_product(q),
            Rows::Modal(blocks) => {
                let mut largest = [0.0_f64; LANES];
                let mut stresses = Lane::default();
                for block in blocks {
                    dots(block, q, &mut stresses);
                    for (largest, stress) in largest.iter_mut().zip(stresses.0) {
                        let size = stress.abs();
                        *largest = if size > *largest { size } else { *largest };
                    }
                }
                largest.into_iter().fold(0.0, f64::max)
            }
        }
    }

    /// The first place whose stress has this size, which [`Fibres::largest`] has found.
    pub fn place_of(&self, largest: f64, q: &[f64]) -> usize {
        let found = match &self.rows {
            Rows::Nodal(rows) => rows.products(q).position(|stress| stress.abs() == largest),
            Rows::Modal(blocks) => {
                let mut stresses = Lane::default();
                blocks.iter().enumerate().find_map(|(at, block)| {
                    dots(block, q, &mut stresses);
                    stresses.0.iter().position(|stress| stress.abs() == largest).map(|k| LANES * at + k)
                })
            }
        };
        found.unwrap_or(0)
    }
}

/// Columns from one on, side by side, row by row.
fn eight(columns: &Matrix, first: usize) -> Vec<Lane> {
    let count = columns.ncols().min(first + LANES) - first;
    (0..columns.nrows())
        .map(|j| Lane(std::array::from_fn(|k| if k < count { columns[(j, first + k)] } else { 0.0 })))
        .collect()
}

fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}
