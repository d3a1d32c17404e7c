//! Quadratic forms and products of output rows with one vector, eight rows at a time, in one order of operations on every processor.
//!
//! Verified by `forms_and_products_are_those_of_their_matrix`.

use super::row_batch::Interpolate;
use crate::eight::mix;
use bladeoff_numerics::linalg::Matrix;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, kernel, rows_times_inline};

/// Quadratic form `y^T A y` of a symmetric matrix A.
#[derive(Debug, Clone, Default)]
pub(crate) struct QuadraticForm {
    size: usize,
    /// For each eight rows from i on: their entries in the columns from i on, column by column; entries to the right of the diagonal block of eight columns are doubled.
    entries: Vec<Lane>,
}

impl QuadraticForm {
    /// Form of the symmetric part of a matrix.
    pub fn new(matrix: &Matrix) -> Self {
        let size = matrix.nrows();
        let mut entries = Vec::new();
        for i in (0..size).step_by(LANES) {
            for j in i..size {
                let factors = if j < i + LANES { 0.5 } else { 1.0 };
                entries.push(Lane(std::array::from_fn(|k| {
                    if i + k < size { factors * (matrix[(i + k, j)] + matrix[(j, i + k)]) } else { 0.0 }
                })));
            }
        }
        Self { size, entries }
    }

    /// Value `y^T A y`.
    pub fn value(&self, y: &[f64]) -> f64 {
        let mut lanes = [0.0; LANES];
        value_of(&self.entries, &y[..self.size], &mut lanes);
        bladeoff_numerics::linalg::lanes::sum(lanes)
    }
}

impl Interpolate for QuadraticForm {
    fn interpolate(&mut self, forms: [&Self; 2], factors: [f64; 2]) {
        self.size = forms[0].size;
        mix(forms.map(|form| form.entries.as_slice()), factors, &mut self.entries);
    }
}

/// Matrix of output rows for products of all rows with one vector.
#[derive(Debug, Clone)]
pub(crate) struct OutputMatrix {
    columns: usize,
    /// Entries of eight rows at a time, column by column.
    entries: Vec<Lane>,
    /// Entries of the last four rows, column by column; empty if more than four rows remain after the full eights, or none.
    last_rows: Vec<HalfLane>,
}

/// Entries of four rows in one column.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(32))]
struct HalfLane([f64; LANES / 2]);

impl OutputMatrix {
    /// Output rows of a matrix.
    pub fn new(matrix: &Matrix) -> Self {
        let rows = matrix.nrows();
        let remaining = rows % LANES;
        let full_rows = if remaining > LANES / 2 { rows } else { rows - remaining };
        let at = |i: usize, j: usize| if i < rows { matrix[(i, j)] } else { 0.0 };
        let eight = |i: usize, j: usize| Lane(std::array::from_fn(|k| at(i + k, j)));
        let blocks = (0..full_rows).step_by(LANES);
        let last_rows = if full_rows < rows { 0..matrix.ncols() } else { 0..0 };
        Self {
            columns: matrix.ncols(),
            entries: blocks.flat_map(|i| (0..matrix.ncols()).map(move |j| eight(i, j))).collect(),
            last_rows: last_rows.map(|j| HalfLane(std::array::from_fn(|k| at(full_rows + k, j)))).collect(),
        }
    }

    /// Linear combination of two matrices of equal size with the given factors.
    pub fn mixed(rows: [&Self; 2], factors: [f64; 2]) -> Self {
        let [lower, upper] = rows.map(|rows| rows.last_rows.iter());
        let half = |(lower, upper): (&HalfLane, &HalfLane)| {
            HalfLane(std::array::from_fn(|k| factors[0] * lower.0[k] + factors[1] * upper.0[k]))
        };
        let mut entries = Vec::new();
        mix(rows.map(|rows| rows.entries.as_slice()), factors, &mut entries);
        Self { columns: rows[0].columns, entries, last_rows: lower.zip(upper).map(half).collect() }
    }

    /// Number of products: a multiple of four, with zeros behind those of the rows.
    pub fn rows(&self) -> usize {
        let columns = self.columns.max(1);
        self.entries.len() / columns * LANES + self.last_rows.len() / columns * (LANES / 2)
    }

    /// Products of all rows with y.
    pub fn multiply(&self, y: &[f64], products: &mut Vec<f64>) {
        products.resize(self.rows(), 0.0);
        multiply_rows(self, y, products);
    }

    /// Products of all rows with y, inside a kernel.
    #[inline(always)]
    pub fn multiply_inline(&self, y: &[f64], products: &mut [f64]) {
        let columns = self.columns.max(1);
        let (blocks, rest) = products.as_chunks_mut::<LANES>();
        let mut entries = self.entries.as_slice();
        for products in blocks {
            let (block, others) = entries.split_at(columns);
            entries = others;
            // the last four rows together with the last eight: y is loaded once
            if others.is_empty() && !self.last_rows.is_empty() {
                let last_rows;
                (*products, last_rows) = twelve_rows(block, &self.last_rows, y);
                rest.copy_from_slice(&last_rows);
                return;
            }
            *products = rows_times_inline(block, y);
        }
        if !self.last_rows.is_empty() {
            rest.copy_from_slice(&four_rows(&self.last_rows, y));
        }
    }
}

/// Columns that one pass of the loop multiplies.
const COLUMNS_AT_ONCE: usize = 4;

/// Products of twelve rows. Even and odd columns have separate sums, so an addition need not wait for the one before it.
#[inline(always)]
fn twelve_rows(eight: &[Lane], four: &[HalfLane], y: &[f64]) -> ([f64; LANES], [f64; LANES / 2]) {
    let (mut sums, mut halves) = ([[0.0; LANES]; 2], [[0.0; LANES / 2]; 2]);
    let (eights, eight) = eight.as_chunks::<COLUMNS_AT_ONCE>();
    let (fours, four) = four.as_chunks::<COLUMNS_AT_ONCE>();
    let (ys, y) = y.as_chunks::<COLUMNS_AT_ONCE>();
    for ((eight, four), y) in eights.iter().zip(fours).zip(ys) {
        for c in 0..COLUMNS_AT_ONCE {
            for k in 0..LANES {
                sums[c % 2][k] += eight[c].0[k] * y[c];
            }
            for k in 0..LANES / 2 {
                halves[c % 2][k] += four[c].0[k] * y[c];
            }
        }
    }
    for ((eight, four), y) in eight.iter().zip(four).zip(y) {
        for k in 0..LANES {
            sums[0][k] += eight.0[k] * y;
        }
        for k in 0..LANES / 2 {
            halves[0][k] += four.0[k] * y;
        }
    }
    (std::array::from_fn(|k| sums[0][k] + sums[1][k]), std::array::from_fn(|k| halves[0][k] + halves[1][k]))
}

/// Products of four rows.
#[inline(always)]
fn four_rows(four: &[HalfLane], y: &[f64]) -> [f64; LANES / 2] {
    let mut sums = [0.0; LANES / 2];
    for (half, y) in four.iter().zip(y) {
        for k in 0..LANES / 2 {
            sums[k] += half.0[k] * y;
        }
    }
    sums
}

kernel! {
    /// Products of all rows with y.
    fn multiply_rows(rows: &OutputMatrix, y: &[f64], products: &mut [f64]) {
        rows.multiply_inline(y, products);
    }
}

kernel! {
    /// Value of the form, lane by lane; the lanes are added outside, because a sum across lanes needs shuffles here.
    fn value_of(entries: &[Lane], y: &[f64], lanes: &mut [f64; LANES]) {
        let (mut sum, mut entries) = ([0.0; LANES], entries);
        for i in (0..y.len()).step_by(LANES) {
            let (block, rest) = entries.split_at(y.len() - i);
            let products = rows_times_inline(block, &y[i..]);
            if let Some(y_block) = y[i..].first_chunk::<LANES>() {
                for k in 0..LANES {
                    sum[k] += products[k] * y_block[k];
                }
            } else {
                for (k, y) in y[i..].iter().enumerate() {
                    sum[k] += products[k] * y;
                }
            }
            entries = rest;
        }
        *lanes = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_numerics::linalg::{Vector, mul_vec};

    #[test]
    fn forms_and_products_are_those_of_their_matrix() {
        for size in [1, 2, 4, 7, 8, 11, 12, 17, 23] {
            let matrix = Matrix::from_fn(size, size, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.0);
            let y = Vector::from_fn(size, |i, _| (i * 5 % 7) as f64 - 2.5);
            let mut wanted = vec![0.0; size];
            mul_vec(&matrix, y.as_slice(), &mut wanted);
            let form = y.dot(&Vector::from_column_slice(&wanted));
            assert!((QuadraticForm::new(&matrix).value(y.as_slice()) - form).abs() < 1e-11, "{size}");
            let rows = OutputMatrix::new(&matrix);
            let mut products = Vec::new();
            rows.multiply(y.as_slice(), &mut products);
            assert_eq!(products.len(), size.next_multiple_of(LANES / 2));
            for (i, wanted) in wanted.iter().enumerate() {
                assert!((products[i] - wanted).abs() < 1e-11, "{size}");
            }
            let mut mixed = Vec::new();
            OutputMatrix::mixed([&rows, &OutputMatrix::new(&(&matrix * 3.0))], [0.5, 0.25])
                .multiply(y.as_slice(), &mut mixed);
            assert!(mixed.iter().zip(&products).all(|(mixed, product)| (mixed - 1.25 * product).abs() < 1e-11));
        }
    }
}
