//! Model of the lateral motion in one speed interval: plane blocks, input vectors and output rows, all constant.
//!
//! ```text
//! y' = B y + sum_i b_i F_i,   o = O y
//! ```
//! `y`: modal state, entries k and n + k of plane k; `B`: plane blocks; `b_i`: input vector of force i; `o`: outputs (`outputs`).
//! The model is that of a modal basis, or the linear interpolation of two. Verified by `impulses_reach_the_states_and_their_outputs` and, with all
//! quantities derived from it, by `tests/exponential/exponential.rs`.

use super::plane_block::PlaneBlock;
use super::quadratic_form::OutputMatrix;
use bladeoff_numerics::linalg::Matrix;
use nalgebra::Complex;

/// Lateral motion at one speed, in modal states.
#[derive(Debug, Clone)]
pub(crate) struct IntervalModel {
    /// Speed of the modal basis, or in the middle of the speed interval \[rad/s\].
    pub speed: f64,
    /// Plane blocks B_k \[1/s\].
    pub blocks: Vec<PlaneBlock>,
    /// O: one row on y per output, for single outputs.
    pub output_rows: OutputRows,
    /// O once more, in the layout for products of all rows.
    pub output_matrix: OutputMatrix,
    /// Input vectors b_i: two per unbalance (unit forces along u and v on its node), one of the weight, two per diaphragm.
    ///
    /// An impulse \[N s\] times its input vector is the jump of the modal state.
    pub input_vectors: Vec<Vec<f64>>,
    /// Outputs `O b_i` of the input vectors of the unbalances: jump of all outputs per impulse.
    pub outputs_of_impulses: Vec<Vec<f64>>,
}

/// Output rows of equal length in one allocation.
#[derive(Debug, Clone)]
pub(crate) struct OutputRows {
    width: usize,
    entries: Vec<f64>,
}

impl std::ops::Index<usize> for OutputRows {
    type Output = [f64];

    fn index(&self, row: usize) -> &[f64] {
        &self.entries[row * self.width..(row + 1) * self.width]
    }
}

impl OutputRows {
    /// Output rows of a matrix.
    pub fn of(rows: &Matrix) -> Self {
        Self { width: rows.ncols(), entries: rows.transpose().as_slice().to_vec() }
    }
}

impl IntervalModel {
    /// Model at a speed \[rad/s\]; the input vectors of the unbalances come first.
    pub fn new(
        speed: f64,
        blocks: Vec<PlaneBlock>,
        rows: &Matrix,
        input_vectors: Vec<Vec<f64>>,
        unbalances: usize,
    ) -> Self {
        let outputs = OutputMatrix::new(rows);
        Self {
            speed,
            outputs_of_impulses: outputs_of(&outputs, &input_vectors[..2 * unbalances]),
            output_matrix: outputs,
            output_rows: OutputRows::of(rows),
            input_vectors,
            blocks,
        }
    }

    /// Linear combination of two models with the given factors, as the model at a speed \[rad/s\].
    pub fn between([lower, upper]: [&Self; 2], factors: [f64; 2], speed: f64) -> Self {
        let combine = |x: &f64, y: &f64| factors[0] * x + factors[1] * y;
        let combine_vectors = |lower: &[Vec<f64>], upper: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let combine_lists =
                |(lower, upper): (&Vec<f64>, &Vec<f64>)| lower.iter().zip(upper).map(|(x, y)| combine(x, y)).collect();
            lower.iter().zip(upper).map(combine_lists).collect()
        };
        let (outputs, input_vectors) = (
            OutputMatrix::mixed([&lower.output_matrix, &upper.output_matrix], factors),
            combine_vectors(&lower.input_vectors, &upper.input_vectors),
        );
        let blocks = lower.blocks.iter().zip(&upper.blocks);
        Self {
            speed,
            outputs_of_impulses: outputs_of(&outputs, &input_vectors[..lower.outputs_of_impulses.len()]),
            output_matrix: outputs,
            output_rows: OutputRows {
                width: lower.output_rows.width,
                entries: lower
                    .output_rows
                    .entries
                    .iter()
                    .zip(&upper.output_rows.entries)
                    .map(|(x, y)| combine(x, y))
                    .collect(),
            },
            input_vectors,
            blocks: blocks.map(|(lower, upper)| std::array::from_fn(|i| combine(&lower[i], &upper[i]))).collect(),
        }
    }

    /// Applies impulses on the nodes of the unbalances \[N s\] to the modal state and its outputs; runs inside a kernel.
    ///
    /// `contact`: contact impulse at n with the modal states at n+1 of its unit impulses; they are added to y, but not to the outputs.
    #[inline(always)]
    pub fn apply_impulses(
        &self,
        impulses: impl Iterator<Item = Complex<f64>>,
        mut contact: Option<([f64; 2], &[Vec<f64>; 2])>,
        y: &mut [f64],
        outputs: &mut [f64],
    ) {
        let lists = self.input_vectors.as_chunks::<2>().0.iter().zip(self.outputs_of_impulses.as_chunks::<2>().0);
        for (impulse, (input_vectors, impulse_outputs)) in impulses.zip(lists) {
            let components = [impulse.re, impulse.im];
            match contact.take() {
                Some(contact) => add_four(contact, (components, input_vectors), y),
                None => add_both(components, input_vectors, y),
            }
            add_both(components, impulse_outputs, outputs);
        }
        if let Some((components, states)) = contact {
            add_both(components, states, y);
        }
    }
}

/// Outputs of each input vector.
fn outputs_of(output_matrix: &OutputMatrix, input_vectors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let outputs_of_one = |input_vector: &Vec<f64>| {
        let mut outputs = Vec::new();
        output_matrix.multiply(input_vector, &mut outputs);
        outputs
    };
    input_vectors.iter().map(outputs_of_one).collect()
}

/// `sums += a x + b y` for vectors x and y; runs inside a kernel.
#[inline(always)]
pub(crate) fn add_both([a, b]: [f64; 2], [x, y]: &[Vec<f64>; 2], sums: &mut [f64]) {
    let count = sums.len();
    let (x, y) = (&x[..count], &y[..count]);
    for j in 0..count {
        sums[j] = sums[j] + a * x[j] + b * y[j];
    }
}

/// `sums += a x + b y + c u + d v` in one pass, in the order of two calls of [`add_both`].
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

    /// Numbers of planes below, at and above multiples of a vector width.
    #[test]
    fn impulses_reach_the_states_and_their_outputs() {
        let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
        for planes in [1, 3, 8, 13, 24] {
            let size = 2 * planes;
            let blocks: Vec<PlaneBlock> = (0..planes).map(|k| std::array::from_fn(|i| value(4 * k + i))).collect();
            let input_vectors: Vec<Vec<f64>> =
                (0..3).map(|n| (0..size).map(|i| value(300 * n + i)).collect()).collect();
            let rows = Matrix::from_fn(3, size, |i, j| value(5 * i + j));
            let model = IntervalModel::new(1.0, blocks.clone(), &rows, input_vectors.clone(), 1);
            let mut y: Vec<f64> = (0..size).map(|i| value(i + 77)).collect();
            let f = Complex::new(0.4, -1.3);
            let mut outputs = Vec::new();
            model.output_matrix.multiply(&y, &mut outputs);
            let mut after = y.clone();
            model.apply_impulses(std::iter::once(f), None, &mut after, &mut outputs);
            let wanted = (0..size).map(|i| y[i] + input_vectors[0][i] * f.re + input_vectors[1][i] * f.im);
            assert!(wanted.zip(&after).all(|(wanted, after)| (wanted - after).abs() < 1e-12));
            // together with a contact impulse: the same bits as one after the other
            let ([a, b], states) = ([0.3, -0.8], [input_vectors[2].clone(), input_vectors[1].clone()]);
            let mut at_once = y.clone();
            model.apply_impulses(std::iter::once(f), Some(([a, b], &states)), &mut at_once, &mut outputs.clone());
            add_both([a, b], &states, &mut y);
            model.apply_impulses(std::iter::once(f), None, &mut y, &mut outputs.clone());
            assert_eq!(at_once, y);
            y = after;
            for (row, output) in outputs[..rows.nrows()].iter().enumerate() {
                assert!(
                    (bladeoff_numerics::linalg::dot(&model.output_rows[row], &y) - output).abs() < 1e-10,
                    "{planes}"
                );
            }
        }
    }
}
