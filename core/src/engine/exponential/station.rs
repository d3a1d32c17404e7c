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

use super::block::{Block, eigenvalues};
use super::forms::Form;
use super::local::Local;
use super::measured::{Measured, Measures};
use super::onward::onward;
use super::outputs::Outputs;
use super::system::LateralSystem;
use super::within::Within;
use super::{ExponentialError, pairs};
use crate::linalg::{Matrix, column_of, inverse, mul, mul_tn};
use crate::modal::{Damping, least_damping};
use std::sync::OnceLock;

/// Largest condition of a basis.
pub(in crate::engine) const MOST_CONDITION: f64 = 1e4;
/// Largest part of A, relative to its own size, that may be left between pairs.
const INVARIANT: f64 = 1e-8;

/// What is solved at stations.
#[derive(Debug, Clone)]
pub(super) struct Model {
    pub system: LateralSystem,
    pub outputs: Outputs,
    pub measures: Measures,
}

/// A basis at one speed, and what is read from it and pushed into it.
#[derive(Debug, Clone)]
pub(super) struct Station {
    pub right: Matrix,
    pub left: Matrix,
    pub blocks: Vec<Block>,
    /// Z.
    pub motion: Matrix,
    /// O: a row for each output.
    pub rows: Matrix,
    /// All of them as a run needs them.
    pub local: Local,
    /// N.
    pub momentum: Form,
    /// No less than the 2-norm condition of R; that itself where it is near what is allowed.
    pub condition: f64,
    /// Least damping of its pairs.
    pub least: Option<Damping>,
    measured: OnceLock<Measured>,
    within: OnceLock<Within>,
}

impl Station {
    /// At a speed \[rad/s\]; beside a neighbour its pairs are those of the neighbour, where they can be found.
    pub fn new(model: &Model, speed: f64, neighbour: Option<&Station>) -> Result<Self, ExponentialError> {
        let (system, size) = (&model.system, model.system.size);
        let Basis { right, left, blocks, condition, .. } = Basis::at(system, speed, neighbour)?;
        let motion = mul(&system.motion_of_state(speed), &right);
        let (places, velocities) = (motion.rows(0, size).into_owned(), motion.rows(size, size).into_owned());
        let momentum = mul_tn(&velocities, &mul(&system.gyroscopic, &places)) * 0.25;
        let rows = mul(&model.outputs.rows(system, speed), &motion);
        let pushes = mul(&left, &model.outputs.pushes(system));
        let pushes = (0..pushes.ncols()).map(|j| column_of(&pushes, j).to_vec()).collect();
        Ok(Self {
            least: least_damping(&blocks.iter().flat_map(eigenvalues).collect::<Vec<_>>()),
            local: Local::new(speed, blocks.clone(), &rows, pushes, model.outputs.unbalances()),
            blocks,
            rows,
            momentum: Form::new(&(&momentum + momentum.transpose())),
            motion,
            right,
            left,
            condition,
            measured: OnceLock::new(),
            within: OnceLock::new(),
        })
    }

    /// What is measured of its whirl states.
    pub fn measured(&self, model: &Model) -> &Measured {
        self.measured.get_or_init(|| model.measures.at(&self.motion))
    }

    /// What damping takes of them over contact steps of `h` \[s\], those of its grid.
    pub fn within(&self, model: &Model, h: f64) -> &Within {
        self.within
            .get_or_init(|| Within::new(&self.blocks, &model.measures.lost_of_states(&model.system, &self.motion), h))
    }
}

/// (1) and its condition.
struct Basis {
    right: Matrix,
    left: Matrix,
    blocks: Vec<Block>,
    condition: f64,
    /// `L A R`, and the largest entry between two pairs.
    generator: Matrix,
    between: f64,
}

impl Basis {
    /// At a speed: from that of the neighbour; where that does not serve, of the motions there.
    fn at(system: &LateralSystem, speed: f64, neighbour: Option<&Station>) -> Result<Self, ExponentialError> {
        let generator = system.generator(speed);
        if let Some(station) = neighbour {
            let e = mul(&station.left, &mul(&system.change(station.local.speed, speed), &station.right));
            let near = onward(&station.right, &station.blocks, &e).map(|right| Self::of(right, &generator, speed));
            if let Some(Ok(near)) = near {
                return Ok(near);
            }
        }
        let motions = system.motions(speed)?;
        let right = neighbour
            .and_then(|station| pairs::beside(&motions, &generator, &station.left))
            .or_else(|| pairs::alone(&motions, &generator));
        let first = Self::of(right.ok_or(ExponentialError::NoBasis { speed })?, &generator, speed)?;
        // what rounding of the eigenvalue problem left between pairs would stay in all stations that come from this one
        let settled = onward(&first.right, &first.blocks, &first.rest())
            .and_then(|right| Self::of(right, &generator, speed).ok())
            .filter(|settled| settled.between < first.between);
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
        let between = largest_between(&generator);
        let part = between / generator.amax();
        if part.is_nan() || part > INVARIANT {
            return Err(ExponentialError::NotInvariant { speed });
        }
        let size = right.nrows() / 2;
        let block = |k: usize| {
            let at = |i: usize, j: usize| generator[(k + i * size, k + j * size)];
            [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]
        };
        Ok(Self { blocks: (0..size).map(block).collect(), right, left, condition, generator, between })
    }

    /// What it leaves between pairs.
    fn rest(&self) -> Matrix {
        let size = self.blocks.len();
        let (rows, columns) = self.generator.shape();
        Matrix::from_fn(rows, columns, |i, j| if i % size == j % size { 0.0 } else { self.generator[(i, j)] })
    }
}

fn largest_stretch(matrix: &Matrix) -> f64 {
    matrix.singular_values().max()
}

/// Largest entry between two pairs.
fn largest_between(generator: &Matrix) -> f64 {
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
