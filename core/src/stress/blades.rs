//! Bending stress of the diaphragm's blades.

use crate::linalg::eight::dots;
use crate::linalg::lanes::{LANES, Lane};
use crate::linalg::{Csr, Matrix};
use crate::structure::RingPart;
use bladeoff_model::machine::FlexibleStator;

/// Bending stress of the blades from the coordinates of their ring.
///
/// ```text
/// sigma = E (h/2) t,xx        t transverse displacement of the blade, h its tangential thickness
/// ```
/// evaluated at both ends of every blade element (the curvature is linear in between). Source: Euler-Bernoulli blades of the
/// paper; [`crate::stator`]. Deviation: none; the paper reports no stresses.
///
/// # Units
/// SI.
/// # Limits
/// Bending alone: the axial stress of the blade, and the stress in the ring, are not in it.
/// # Verified by
/// `a_blade_under_a_turned_ring_has_its_textbook_stress`, `tests/stresses.rs`
#[derive(Debug, Clone)]
pub struct BladeStresses {
    rows: Rows,
    /// Largest entry of all places for each coordinate: no stress exceeds the sum of these times the coordinates' sizes.
    largest: Vec<f64>,
}

/// The bound with room for the rounding of its sum.
const ROUNDED_UP: f64 = 1.0 + 1e-12;

/// Stress per unit coordinate, one row per place: a few entries over nodal freedoms, all of them over modes.
#[derive(Debug, Clone)]
enum Rows {
    Nodal(Csr),
    /// Of eight places at a time, zeros behind the last.
    Modal(Vec<Vec<Lane>>),
}

impl BladeStresses {
    /// Of a flexible stator; `None` without blades.
    #[must_use]
    pub fn new(stator: &FlexibleStator, ring: &RingPart) -> Option<Self> {
        let blades = stator.blades.filter(|blades| blades.count > 0)?;
        let l = blades.length / blades.elements as f64;
        let scale = stator.young_modulus * 0.5 * blades.thickness;
        // second derivatives of the cubic Hermite functions at both ends, on [t1, th1, t2, th2]
        let curvature =
            [[-6.0 / (l * l), -4.0 / l, 6.0 / (l * l), -2.0 / l], [6.0 / (l * l), 2.0 / l, -6.0 / (l * l), 4.0 / l]];
        let coordinates = &ring.part.coordinates;
        let places = 2 * blades.count * blades.elements;
        let mut columns = Matrix::zeros(coordinates.size(), places);
        let mut place = 0;
        for blade in 0..blades.count {
            for element in 0..blades.elements {
                for end in &curvature {
                    let column =
                        &mut columns.as_mut_slice()[place * coordinates.size()..(place + 1) * coordinates.size()];
                    for node in 0..2 {
                        let [_, transverse, slope] = ring.matrices.blade_node(&blades, blade, element + node);
                        for (freedom, factor) in [(transverse, end[2 * node]), (slope, end[2 * node + 1])] {
                            for (dof, weight) in freedom {
                                coordinates.add_row(dof, scale * factor * weight, column);
                            }
                        }
                    }
                    place += 1;
                }
            }
        }
        let largest =
            columns.row_iter().map(|row| row.iter().fold(0.0_f64, |most, value| most.max(value.abs()))).collect();
        let rows = match coordinates.shapes() {
            None => Rows::Nodal(Csr::from_dense(&columns.transpose())),
            Some(_) => Rows::Modal((0..places).step_by(LANES).map(|first| eight(&columns, first)).collect()),
        };
        Some(Self { rows, largest })
    }

    /// Largest bending stress of all blades \[Pa\], or `None` where a bound says that it does not exceed `known`.
    ///
    /// The bound also keeps a ring that has come to rest cheap: its coordinates decay to subnormal numbers, whose products
    /// are slow.
    #[must_use]
    pub fn above(&self, known: f64, q: &[f64]) -> Option<f64> {
        // a NaN ends the run anyway
        (bound(&self.largest, q) * ROUNDED_UP > known).then(|| self.largest(q))
    }

    /// Largest bending stress of all blades \[Pa\].
    #[must_use]
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
}

/// Columns from one on, side by side, row by row.
fn eight(columns: &Matrix, first: usize) -> Vec<Lane> {
    let at = |row: usize, column: usize| if column < columns.ncols() { columns[(row, column)] } else { 0.0 };
    (0..columns.nrows()).map(|row| Lane(std::array::from_fn(|k| at(row, first + k)))).collect()
}

/// `sum_j largest_j |q_j|`, four at a time.
fn bound(largest: &[f64], q: &[f64]) -> f64 {
    let (most, mut lanes) = (largest.as_chunks::<4>(), [0.0; 4]);
    let sizes = q.as_chunks::<4>();
    for (most, q) in most.0.iter().zip(sizes.0) {
        for k in 0..4 {
            lanes[k] += most[k] * q[k].abs();
        }
    }
    let rest: f64 = most.1.iter().zip(sizes.1).map(|(most, q)| most * q.abs()).sum();
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stator::RingMatrices;
    use crate::structure::{Coordinates, Part};
    use bladeoff_model::machine::{Blades, Rayleigh, Ring};

    fn stator(elements: usize) -> FlexibleStator {
        FlexibleStator {
            young_modulus: 2e11,
            poisson_ratio: 0.3,
            density: 7800.0,
            ring: Ring { mean_radius: 0.4, thickness: 0.03, width: 0.05, elements: 12 },
            blades: Some(Blades { count: 4, length: 0.3, thickness: 0.02, width: 0.05, elements }),
            damping: Rayleigh::default(),
        }
    }

    fn part(matrices: &RingMatrices, coordinates: Coordinates) -> RingPart {
        let part = Part {
            coordinates,
            mass: matrices.mass.clone(),
            damping: matrices.mass.clone(),
            stiffness: matrices.stiffness.clone(),
            modal: false,
            highest: 0.0,
        };
        RingPart { matrices: matrices.clone(), part, residual: None, lags: Vec::new(), kept: Default::default() }
    }

    /// The ring turns by a small angle as a body: each blade is a cantilever whose tip is displaced by `R a` and turned by a.
    #[test]
    fn a_blade_under_a_turned_ring_has_its_textbook_stress() {
        for elements in [1, 3] {
            let stator = stator(elements);
            let matrices = RingMatrices::assemble(&stator);
            let (turn, length, radius) = (1e-3, 0.3, 0.4);
            let mut field = vec![0.0; matrices.size()];
            for node in 0..12 {
                field[4 * node] = radius * turn;
            }
            // inner nodes where statics puts them
            let free: Vec<usize> = (48..matrices.size()).collect();
            if !free.is_empty() {
                let k = Matrix::from_fn(free.len(), free.len(), |i, j| matrices.stiffness[(free[i], free[j])]);
                let f = crate::linalg::Vector::from_iterator(
                    free.len(),
                    free.iter().map(|&i| -(0..48).map(|j| matrices.stiffness[(i, j)] * field[j]).sum::<f64>()),
                );
                let solution = crate::linalg::solve(&k, &f).expect("clamped");
                for (value, &i) in solution.iter().zip(&free) {
                    field[i] = *value;
                }
            }
            // foot moment E I/L^2 (6 d + 4 L a), from slope-deflection with the casing end clamped
            let inertia = 0.05 * 0.02f64.powi(3) / 12.0;
            let moment = 2e11 * inertia / (length * length) * (6.0 * radius * turn + 4.0 * length * turn);
            let expected = moment * 0.01 / inertia;
            let ring = part(&matrices, Coordinates::nodal(matrices.size()));
            let nodal = BladeStresses::new(&stator, &ring).expect("blades");
            let stress = nodal.largest(&field);
            assert!((stress / expected - 1.0).abs() < 1e-9, "{stress} {expected}");
            assert_eq!(nodal.above(0.99 * stress, &field), Some(stress));
            assert_eq!(nodal.above(1e3 * stress, &field), None);

            let shapes = Matrix::from_fn(matrices.size(), 2, |i, j| if j == 0 { field[i] } else { 0.0 });
            let modal = BladeStresses::new(&stator, &part(&matrices, Coordinates::modal(&shapes))).expect("blades");
            assert!((modal.largest(&[2.0, 5.0]) / (2.0 * expected) - 1.0).abs() < 1e-9);
        }
    }
}
