//! What the whirl states are in one cell of the grid, where all of it is constant.
//!
//! Verified by `impulses_reach_the_states_and_their_outputs` and, with all that is made of it, by `tests/exponential.rs`.

use super::plane_block::PlaneBlock;
use super::quadratic_form::OutputMatrix;
use crate::linalg::Matrix;
use nalgebra::Complex;

#[derive(Debug, Clone)]
pub(crate) struct IntervalModel {
    /// At a station, or in the middle of a cell \[rad/s\].
    pub speed: f64,
    pub blocks: Vec<PlaneBlock>,
    /// A row on y for each output, and all of them.
    pub output_rows: OutputRows,
    pub output_matrix: OutputMatrix,
    /// A vector of y for each force.
    pub input_vectors: Vec<Vec<f64>>,
    /// Outputs of those of the unbalances.
    pub outputs_of_impulses: Vec<Vec<f64>>,
}

/// Lists of one length, one behind the other: a cell has some thirty.
#[derive(Debug, Clone)]
pub(crate) struct OutputRows {
    width: usize,
    all: Vec<f64>,
}

impl std::ops::Index<usize> for OutputRows {
    type Output = [f64];

    fn index(&self, row: usize) -> &[f64] {
        &self.all[row * self.width..(row + 1) * self.width]
    }
}

impl OutputRows {
    /// The rows of a matrix.
    pub fn of(rows: &Matrix) -> Self {
        Self { width: rows.ncols(), all: rows.transpose().as_slice().to_vec() }
    }
}

impl IntervalModel {
    /// Of whirl states at a speed and so many unbalances, whose pushes are the first.
    pub fn new(speed: f64, blocks: Vec<PlaneBlock>, rows: &Matrix, pushes: Vec<Vec<f64>>, unbalances: usize) -> Self {
        let outputs = OutputMatrix::new(rows);
        Self {
            speed,
            outputs_of_impulses: struck(&outputs, &pushes[..2 * unbalances]),
            output_matrix: outputs,
            output_rows: OutputRows::of(rows),
            input_vectors: pushes,
            blocks,
        }
    }

    /// The sum of two, times these, at a speed.
    pub fn between([one, other]: [&Self; 2], times: [f64; 2], speed: f64) -> Self {
        let both = |x: &f64, y: &f64| times[0] * x + times[1] * y;
        let lists = |one: &[Vec<f64>], other: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let of = |(one, other): (&Vec<f64>, &Vec<f64>)| one.iter().zip(other).map(|(x, y)| both(x, y)).collect();
            one.iter().zip(other).map(of).collect()
        };
        let (outputs, pushes) = (
            OutputMatrix::mixed([&one.output_matrix, &other.output_matrix], times),
            lists(&one.input_vectors, &other.input_vectors),
        );
        let blocks = one.blocks.iter().zip(&other.blocks);
        Self {
            speed,
            outputs_of_impulses: struck(&outputs, &pushes[..one.outputs_of_impulses.len()]),
            output_matrix: outputs,
            output_rows: OutputRows {
                width: one.output_rows.width,
                all: one.output_rows.all.iter().zip(&other.output_rows.all).map(|(x, y)| both(x, y)).collect(),
            },
            input_vectors: pushes,
            blocks: blocks.map(|(one, other)| std::array::from_fn(|i| both(&one[i], &other[i]))).collect(),
        }
    }

    /// Adds impulses of the unbalances on their nodes \[N s\] to y and its outputs, and to y what impulses at n have made, so much of two lists; inside a kernel.
    #[inline(always)]
    pub fn apply_impulses(
        &self,
        impulses: impl Iterator<Item = Complex<f64>>,
        mut made: Option<([f64; 2], &[Vec<f64>; 2])>,
        y: &mut [f64],
        seen: &mut [f64],
    ) {
        let lists = self.input_vectors.as_chunks::<2>().0.iter().zip(self.outputs_of_impulses.as_chunks::<2>().0);
        for (impulse, (pushes, struck)) in impulses.zip(lists) {
            let parts = [impulse.re, impulse.im];
            match made.take() {
                Some(made) => add_four(made, (parts, pushes), y),
                None => add_both(parts, pushes, y),
            }
            add_both(parts, struck, seen);
        }
        if let Some((parts, states)) = made {
            add_both(parts, states, y);
        }
    }
}

/// Outputs of pushes.
fn struck(outputs: &OutputMatrix, pushes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let seen = |push: &Vec<f64>| {
        let mut seen = Vec::new();
        outputs.multiply(push, &mut seen);
        seen
    };
    pushes.iter().map(seen).collect()
}

/// `sums += a x + b y`; inside a kernel.
#[inline(always)]
pub(crate) fn add_both([a, b]: [f64; 2], [x, y]: &[Vec<f64>; 2], sums: &mut [f64]) {
    let count = sums.len();
    let (x, y) = (&x[..count], &y[..count]);
    for j in 0..count {
        sums[j] = sums[j] + a * x[j] + b * y[j];
    }
}

/// The same twice, one after the other, in one pass.
#[inline(always)]
fn add_four(
    ([a, b], [x, y]): ([f64; 2], &[Vec<f64>; 2]),
    ([c, d], [u, v]): ([f64; 2], &[Vec<f64>; 2]),
    sums: &mut [f64],
) {
    let count = sums.len();
    let (x, y, u, v) = (&x[..count], &y[..count], &u[..count], &v[..count]);
    for j in 0..count {
        sums[j] = sums[j] + a * x[j] + b * y[j] + c * u[j] + d * v[j];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of every number of pairs.
    #[test]
    fn impulses_reach_the_states_and_their_outputs() {
        let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
        for pairs in [1, 3, 8, 13, 24] {
            let size = 2 * pairs;
            let blocks: Vec<PlaneBlock> = (0..pairs).map(|k| std::array::from_fn(|i| value(4 * k + i))).collect();
            let pushes: Vec<Vec<f64>> = (0..3).map(|n| (0..size).map(|i| value(300 * n + i)).collect()).collect();
            let rows = Matrix::from_fn(3, size, |i, j| value(5 * i + j));
            let local = IntervalModel::new(1.0, blocks.clone(), &rows, pushes.clone(), 1);
            let mut y: Vec<f64> = (0..size).map(|i| value(i + 77)).collect();
            let f = Complex::new(0.4, -1.3);
            let mut seen = Vec::new();
            local.output_matrix.multiply(&y, &mut seen);
            let mut struck = y.clone();
            local.apply_impulses(std::iter::once(f), None, &mut struck, &mut seen);
            let made = (0..size).map(|i| y[i] + pushes[0][i] * f.re + pushes[1][i] * f.im);
            assert!(made.zip(&struck).all(|(made, struck)| (made - struck).abs() < 1e-12));
            // with what another impulse has made, to the last bit
            let ([a, b], states) = ([0.3, -0.8], [pushes[2].clone(), pushes[1].clone()]);
            let mut at_once = y.clone();
            local.apply_impulses(std::iter::once(f), Some(([a, b], &states)), &mut at_once, &mut seen.clone());
            add_both([a, b], &states, &mut y);
            local.apply_impulses(std::iter::once(f), None, &mut y, &mut seen.clone());
            assert_eq!(at_once, y);
            y = struck;
            for (row, seen) in seen[..rows.nrows()].iter().enumerate() {
                assert!((crate::linalg::dot(&local.output_rows[row], &y) - seen).abs() < 1e-10, "{pairs}");
            }
        }
    }
}
