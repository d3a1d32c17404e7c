//! A station: the basis of whirl states at one speed of the grid.
//!
//! ```text
//! x = R y,  L = R^-1,  L A R = blocks B_k on the pairs                    A at this speed                                  (1)
//! z = Z y  (q and q'),   outputs O = Y Z,   force F: y' = ... + L s_p F
//! gyroscopic momentum of the spin  q'^T G q/2 = y^T N y                                                                    (2)
//! condition  = |R|_2 |L|_2 in the coordinates in which |x|^2/2 is nearly the energy
//! ```
//! A basis is refused above a condition of 1e4 (a state of the size of the rotor's energy would be a difference of amplitudes 1e4 times larger), and
//! where what (1) leaves between pairs is more than rounding allows: pairs that are not invariant would be propagated wrongly.

use super::continuation::continued_basis;
use super::dissipation::Dissipation;
use super::interval_model::IntervalModel;
use super::modal_planes;
use super::outputs::Outputs;
use super::plane_block::{PlaneBlock, eigenvalues};
use super::quadratic_form::QuadraticForm;
use super::section_loads::{SectionLoadModel, SectionLoads};
use super::state_space::StateSpace;
use crate::engine::exponential::error::ExponentialError;
use crate::linalg::{Matrix, column_of, inverse, mul, mul_tn};
use crate::modal::{Damping, least_damping};
use std::sync::OnceLock;

/// Largest condition of a basis.
pub(in crate::engine) const MOST_CONDITION: f64 = 1e4;
/// Largest part of A, relative to its own size, that may be left between pairs.
const INVARIANT: f64 = 1e-8;

/// What is solved at stations.
#[derive(Debug, Clone)]
pub(crate) struct LateralModel {
    pub state_space: StateSpace,
    pub outputs: Outputs,
    pub measures: SectionLoadModel,
}

/// A basis at one speed, and what is read from it and pushed into it.
#[derive(Debug, Clone)]
pub(crate) struct ModalBasis {
    pub right: Matrix,
    pub left: Matrix,
    pub blocks: Vec<PlaneBlock>,
    /// Z.
    pub motion_of_state: Matrix,
    /// O: a row for each output.
    pub output_rows: Matrix,
    /// All of them as a run needs them.
    pub interval_model: IntervalModel,
    /// N.
    pub gyroscopic_momentum: QuadraticForm,
    /// No less than the 2-norm condition of R; that itself where it is near what is allowed.
    pub condition: f64,
    /// Least damping of its pairs.
    pub least_damping: Option<Damping>,
    section_loads: OnceLock<SectionLoads>,
    dissipation: OnceLock<Dissipation>,
}

impl ModalBasis {
    /// At a speed \[rad/s\]; beside a neighbour its pairs are those of the neighbour, where they can be found.
    pub fn new(model: &LateralModel, speed: f64, neighbour: Option<&ModalBasis>) -> Result<Self, ExponentialError> {
        let (system, size) = (&model.state_space, model.state_space.size);
        let CheckedBasis { right, left, blocks, condition, .. } = CheckedBasis::at(system, speed, neighbour)?;
        let motion = mul(&system.motion_of_state(speed), &right);
        let (places, velocities) = (motion.rows(0, size).into_owned(), motion.rows(size, size).into_owned());
        let momentum = mul_tn(&velocities, &mul(&system.gyroscopic, &places)) * 0.25;
        let rows = mul(&model.outputs.output_rows(system, speed), &motion);
        let pushes = mul(&left, &model.outputs.input_vectors(system));
        let pushes = (0..pushes.ncols()).map(|j| column_of(&pushes, j).to_vec()).collect();
        Ok(Self {
            least_damping: least_damping(&blocks.iter().flat_map(eigenvalues).collect::<Vec<_>>()),
            interval_model: IntervalModel::new(speed, blocks.clone(), &rows, pushes, model.outputs.unbalances()),
            blocks,
            output_rows: rows,
            gyroscopic_momentum: QuadraticForm::new(&(&momentum + momentum.transpose())),
            motion_of_state: motion,
            right,
            left,
            condition,
            section_loads: OnceLock::new(),
            dissipation: OnceLock::new(),
        })
    }

    /// What is measured of its whirl states.
    pub fn section_loads(&self, model: &LateralModel) -> &SectionLoads {
        self.section_loads.get_or_init(|| model.measures.at_basis(&self.motion_of_state))
    }

    /// What damping takes of them over contact steps of `h` \[s\], those of its grid.
    pub fn dissipation(&self, model: &LateralModel, h: f64) -> &Dissipation {
        self.dissipation.get_or_init(|| {
            Dissipation::new(
                &self.blocks,
                &model.measures.damping_power_matrix(&model.state_space, &self.motion_of_state),
                h,
            )
        })
    }
}

/// (1) and its condition.
struct CheckedBasis {
    right: Matrix,
    left: Matrix,
    blocks: Vec<PlaneBlock>,
    condition: f64,
    /// `L A R`, and the largest entry between two pairs.
    generator: Matrix,
    largest_coupling: f64,
}

impl CheckedBasis {
    /// At a speed: from that of the neighbour; where that does not serve, of the motions there.
    fn at(system: &StateSpace, speed: f64, neighbour: Option<&ModalBasis>) -> Result<Self, ExponentialError> {
        let generator = system.system_matrix(speed);
        if let Some(station) = neighbour {
            let e = mul(
                &station.left,
                &mul(&system.system_matrix_change(station.interval_model.speed, speed), &station.right),
            );
            let near =
                continued_basis(&station.right, &station.blocks, &e).map(|right| Self::of(right, &generator, speed));
            if let Some(Ok(near)) = near {
                return Ok(near);
            }
        }
        let motions = system.eigen_motions(speed)?;
        let right = neighbour
            .and_then(|station| modal_planes::aligned_with_neighbour(&motions, &generator, &station.left))
            .or_else(|| modal_planes::from_eigenmotions(&motions, &generator));
        let first = Self::of(right.ok_or(ExponentialError::NoBasis { speed })?, &generator, speed)?;
        // what rounding of the eigenvalue problem left between pairs would stay in all stations that come from this one
        let settled = continued_basis(&first.right, &first.blocks, &first.off_diagonal_part())
            .and_then(|right| Self::of(right, &generator, speed).ok())
            .filter(|settled| settled.largest_coupling < first.largest_coupling);
        Ok(settled.unwrap_or(first))
    }

    /// Of right vectors; refused where it is ill-conditioned or leaves something between pairs.
    fn of(right: Matrix, generator: &Matrix, speed: f64) -> Result<Self, ExponentialError> {
        let left = inverse(&right).ok_or(ExponentialError::NoBasis { speed })?;
        // that of Frobenius norms is no smaller
        let mut condition = right.norm() * left.norm();
        if condition.is_nan() || condition > MOST_CONDITION {
            condition = largest_stretch(&right) * largest_stretch(&left);
        }
        if condition.is_nan() || condition > MOST_CONDITION {
            return Err(ExponentialError::IllConditioned { speed, condition, limit: MOST_CONDITION });
        }
        let generator = mul(&left, &mul(generator, &right));
        let between = largest_coupling(&generator);
        let part = between / generator.amax();
        if part.is_nan() || part > INVARIANT {
            return Err(ExponentialError::NotInvariant { speed });
        }
        let size = right.nrows() / 2;
        let block = |k: usize| {
            let at = |i: usize, j: usize| generator[(k + i * size, k + j * size)];
            [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]
        };
        Ok(Self {
            blocks: (0..size).map(block).collect(),
            right,
            left,
            condition,
            generator,
            largest_coupling: between,
        })
    }

    /// What it leaves between pairs.
    fn off_diagonal_part(&self) -> Matrix {
        let size = self.blocks.len();
        let (rows, columns) = self.generator.shape();
        Matrix::from_fn(rows, columns, |i, j| if i % size == j % size { 0.0 } else { self.generator[(i, j)] })
    }
}

fn largest_stretch(matrix: &Matrix) -> f64 {
    matrix.singular_values().max()
}

/// Largest entry between two pairs.
fn largest_coupling(generator: &Matrix) -> f64 {
    let (size, mut largest) = (generator.nrows() / 2, 0.0_f64);
    for i in 0..2 * size {
        for j in 0..2 * size {
            if i % size != j % size {
                largest = largest.max(generator[(i, j)].abs());
            }
        }
    }
    largest
}
