//! Modal basis of the gyroscopic system at one speed of the grid: state vectors, blocks, input vectors and output rows in modal coordinates.
//!
//! ```text
//! x = R y,  L = R^-1,  L A R = blocks B_k of the modal planes             A: system matrix at this speed                   (1)
//! y' = L A R y + L s_p F                                                  state equation in the modal state y
//! (q, q') = Z y,   outputs o = O y,  O = Y Z                              Y: output rows on (q, q')
//! q'^T G q/2 = y^T N y                                                    gyroscopic momentum of the spin                  (2)
//! condition  = |R|_2 |L|_2
//! ```
//!
//! | symbol | quantity, for `n` lateral coordinates and n modal planes |
//! |---|---|
//! | `y` | modal state, 2n: entries k and n + k belong to plane k; scaled as the state vector x, so `|y|^2` is of the size of the energy |
//! | `R`, `L` | right vectors (columns) and left vectors (rows) of the basis, 2n x 2n |
//! | `B_k` | plane block, 2 x 2 \[1/s\] |
//! | `Z`, `O` | rows from y to the motion and to the outputs |
//! | `N` | gyroscopic momentum as a quadratic form of y \[kg m2/s\] |
//!
//! Limits: a basis is rejected above a condition of 1e4, where a state of the size of the rotor's energy is a difference of modal states 1e4 times
//! larger. A basis is also rejected if (1) leaves more than rounding between two planes, because planes that are not invariant are propagated wrongly.
//! Verified by `a_continued_basis_equals_that_of_its_eigenvalue_problem` (`continuation.rs`) and `tests/exponential/exponential.rs`.

use super::bearing_tables::TableChanges;
use super::continuation::continued_basis;
use super::dissipation::Dissipation;
use super::interval_model::IntervalModel;
use super::modal_planes;
use super::outputs::{DirectFeedthrough, Outputs};
use super::plane_block::{PlaneBlock, eigenvalues};
use super::quadratic_form::QuadraticForm;
use super::section_loads::{SectionLoadModel, SectionLoads};
use super::state_space::StateSpace;
use crate::engine::exponential::error::ExponentialError;
use crate::modal::{Damping, least_damping};
use bladeoff_numerics::linalg::{Matrix, column_of, inverse, mul, mul_tn};
use std::borrow::Cow;
use std::sync::OnceLock;

/// Largest condition number of a modal basis.
pub(in crate::engine) const MOST_CONDITION: f64 = 1e4;
/// Largest coupling between two modal planes, as a share of the largest entry of `L A R`.
const MAX_COUPLING: f64 = 1e-8;

/// Model of the lateral motion from which a modal basis is computed at any speed.
#[derive(Debug, Clone)]
pub(crate) struct LateralModel {
    /// System matrices.
    pub state_space: StateSpace,
    /// Input and output quantities of a step: unbalances, bearings, contact.
    pub outputs: Outputs,
    /// Quantities of an observation: section loads, bearing powers, stored energy.
    pub measures: SectionLoadModel,
}

/// Modal basis at one speed with its input vectors and output rows.
#[derive(Debug, Clone)]
pub(crate) struct ModalBasis {
    /// Right vectors R, one column per entry of y.
    pub right: Matrix,
    /// Left vectors L, one row per entry of y.
    pub left: Matrix,
    /// Blocks B_k of the modal planes \[1/s\].
    pub blocks: Vec<PlaneBlock>,
    /// Z: motion `(q, q')` of a modal state, 2n x 2n.
    pub motion_of_state: Matrix,
    /// O: one row on y per output.
    pub output_rows: Matrix,
    /// Speed, blocks, input vectors and output rows in the layout that a step uses.
    pub interval_model: IntervalModel,
    /// N: gyroscopic momentum as a quadratic form of y \[kg m2/s\].
    pub gyroscopic_momentum: QuadraticForm,
    /// Upper bound of the 2-norm condition number of R; exact if the bound by Frobenius norms exceeds the limit.
    pub condition: f64,
    /// Least damped oscillating mode; `None` without one.
    pub least_damping: Option<Damping>,
    /// Changes of the bearing tables at this speed; empty without tables.
    pub table_changes: TableChanges,
    /// Direct feedthrough of the loads at this speed; empty without bearing tables.
    pub feedthrough: Vec<DirectFeedthrough>,
    section_loads: OnceLock<SectionLoads>,
    dissipation: OnceLock<Dissipation>,
}

impl ModalBasis {
    /// Modal basis at a speed \[rad/s\], with the planes in the order and orientation of a neighbouring basis if one is given.
    ///
    /// # Errors
    /// [`ExponentialError`] if there is no basis, it is ill-conditioned, or its planes are not invariant.
    pub fn new(model: &LateralModel, speed: f64, neighbour: Option<&ModalBasis>) -> Result<Self, ExponentialError> {
        let (system, size) = (&model.state_space, model.state_space.size);
        let CheckedBasis { right, left, blocks, condition, .. } = CheckedBasis::at(system, speed, neighbour)?;
        let motion = mul(&system.motion_of_state(speed), &right);
        let (displacements, velocities) = (motion.rows(0, size).into_owned(), motion.rows(size, size).into_owned());
        let momentum = mul_tn(&velocities, &mul(&system.gyroscopic, &displacements)) * 0.25;
        let output_rows = mul(&model.outputs.output_rows(system, speed), &motion);
        let input_vectors = mul(&left, &model.outputs.input_vectors(system));
        let input_vectors = (0..input_vectors.ncols()).map(|j| column_of(&input_vectors, j).to_vec()).collect();
        let has_tables = !system.tables.is_empty();
        let step_blocks = blocks.clone();
        #[cfg(test)]
        let step_blocks = with_fault(step_blocks, system);
        Ok(Self {
            least_damping: least_damping(&blocks.iter().flat_map(eigenvalues).collect::<Vec<_>>()),
            interval_model: IntervalModel::new(
                speed,
                step_blocks,
                &output_rows,
                input_vectors,
                model.outputs.unbalances(),
            ),
            table_changes: system.tables.changes(speed),
            feedthrough: if has_tables { model.outputs.feedthrough(system, speed) } else { Vec::new() },
            blocks,
            output_rows,
            gyroscopic_momentum: QuadraticForm::new(&(&momentum + momentum.transpose())),
            motion_of_state: motion,
            right,
            left,
            condition,
            section_loads: OnceLock::new(),
            dissipation: OnceLock::new(),
        })
    }

    /// Rows of section loads, bearing motion and `(q, q')` on y; computed at the first call.
    pub fn section_loads(&self, model: &LateralModel) -> &SectionLoads {
        self.section_loads.get_or_init(|| model.measures.at_basis(&self.motion_of_state))
    }

    /// Dissipation over a contact step of `h` \[s\]; computed at the first call, for the one contact step of its grid.
    pub fn dissipation(&self, model: &LateralModel, h: f64) -> &Dissipation {
        self.dissipation.get_or_init(|| {
            Dissipation::new(
                &self.blocks,
                &model.measures.damping_power_matrix(
                    &model.state_space,
                    self.interval_model.speed,
                    &self.motion_of_state,
                ),
                h,
            )
        })
    }
}

/// Plane blocks of the motion, with the fault of damping that a test injects: a larger decay by a 20th.
#[cfg(test)]
fn with_fault(mut blocks: Vec<PlaneBlock>, system: &StateSpace) -> Vec<PlaneBlock> {
    if system.fault == Some(crate::engine::exponential::settings::Fault::Damping) {
        for block in &mut blocks {
            let decay = 0.5 * (block[0] + block[3]);
            block[0] += 0.05 * decay;
            block[3] += 0.05 * decay;
        }
    }
    blocks
}

/// Basis of modal planes that passed the checks of condition and invariance.
struct CheckedBasis {
    right: Matrix,
    left: Matrix,
    blocks: Vec<PlaneBlock>,
    condition: f64,
    /// `L A R`, 2n x 2n.
    modal_matrix: Matrix,
    /// Largest entry of `L A R` that couples two planes.
    largest_coupling: f64,
}

impl CheckedBasis {
    /// Basis at a speed: by continuation from the neighbour, or by the eigenvalue problem at this speed if that fails.
    fn at(system: &StateSpace, speed: f64, neighbour: Option<&ModalBasis>) -> Result<Self, ExponentialError> {
        let a = system.system_matrix(speed);
        if let Some(neighbour) = neighbour {
            let mut e = mul(
                &neighbour.left,
                &mul(&system.system_matrix_change(neighbour.interval_model.speed, speed), &neighbour.right),
            );
            let mut blocks = Cow::Borrowed(&neighbour.blocks);
            if !system.tables.is_empty() {
                move_diagonal_blocks(&mut e, blocks.to_mut());
            }
            let continued = continued_basis(&neighbour.right, &blocks, &e).map(|right| Self::of(right, &a, speed));
            if let Some(Ok(continued)) = continued {
                return Ok(continued);
            }
        }
        let motions = system.eigen_motions(speed)?;
        let right = neighbour
            .and_then(|basis| modal_planes::aligned_with_neighbour(&motions, &a, &basis.left))
            .or_else(|| modal_planes::from_eigenmotions(&motions, &a));
        let solved = Self::of(right.ok_or(ExponentialError::NoBasis { speed })?, &a, speed)?;
        // one continuation at the same speed removes the coupling that rounding of the eigenvalue problem left; bases continued from this one would keep it
        let refined = continued_basis(&solved.right, &solved.blocks, &solved.off_diagonal_part())
            .and_then(|right| Self::of(right, &a, speed).ok())
            .filter(|refined| refined.largest_coupling < solved.largest_coupling);
        Ok(refined.unwrap_or(solved))
    }

    /// Checked basis with these right vectors; rejected if it is ill-conditioned or its planes are coupled.
    fn of(right: Matrix, a: &Matrix, speed: f64) -> Result<Self, ExponentialError> {
        let left = inverse(&right).ok_or(ExponentialError::NoBasis { speed })?;
        // product of Frobenius norms: an upper bound, cheap
        let mut condition = right.norm() * left.norm();
        if condition.is_nan() || condition > MOST_CONDITION {
            condition = largest_singular_value(&right) * largest_singular_value(&left);
        }
        if condition.is_nan() || condition > MOST_CONDITION {
            return Err(ExponentialError::IllConditioned { speed, condition, limit: MOST_CONDITION });
        }
        let modal_matrix = mul(&left, &mul(a, &right));
        let coupling = largest_coupling(&modal_matrix);
        let share = coupling / modal_matrix.amax();
        if share.is_nan() || share > MAX_COUPLING {
            return Err(ExponentialError::NotInvariant { speed });
        }
        let size = right.nrows() / 2;
        let block = |k: usize| {
            let at = |i: usize, j: usize| modal_matrix[(k + i * size, k + j * size)];
            [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]
        };
        Ok(Self {
            blocks: (0..size).map(block).collect(),
            right,
            left,
            condition,
            modal_matrix,
            largest_coupling: coupling,
        })
    }

    /// Entries of `L A R` that couple two planes, with zeros in the blocks.
    fn off_diagonal_part(&self) -> Matrix {
        let size = self.blocks.len();
        let (rows, columns) = self.modal_matrix.shape();
        Matrix::from_fn(rows, columns, |i, j| if i % size == j % size { 0.0 } else { self.modal_matrix[(i, j)] })
    }
}

/// Moves the parts of E that couple no planes to the blocks D; `D + E` stays the same.
///
/// A table changes the blocks of strongly damped planes by much more than it couples them. Planes that change together then keep their distance in a continuation.
fn move_diagonal_blocks(e: &mut Matrix, blocks: &mut [PlaneBlock]) {
    let size = blocks.len();
    for (k, block) in blocks.iter_mut().enumerate() {
        for (i, entry) in block.iter_mut().enumerate() {
            let place = (k + i / 2 * size, k + i % 2 * size);
            *entry += std::mem::take(&mut e[place]);
        }
    }
}

/// 2-norm of a matrix.
fn largest_singular_value(matrix: &Matrix) -> f64 {
    matrix.singular_values().max()
}

/// Largest absolute entry that couples two planes.
fn largest_coupling(modal_matrix: &Matrix) -> f64 {
    let (size, mut largest) = (modal_matrix.nrows() / 2, 0.0_f64);
    for i in 0..2 * size {
        for j in 0..2 * size {
            if i % size != j % size {
                largest = largest.max(modal_matrix[(i, j)].abs());
            }
        }
    }
    largest
}
